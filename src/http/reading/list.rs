//! Members that are arrays of values of one kind.

use super::array::items;
use super::components::description;
use super::{Components, Faulted, Faults, JsonPath, Kind};
use crate::http::codes::RequestFault;
use serde_json::value::RawValue;
use utoipa::openapi::schema::ArrayBuilder;
use utoipa::openapi::{RefOr, Schema};

/// An array of values, each of the kind `item`.
pub(crate) struct List<K> {
    pub(crate) item: K,
    /// The description of an item in the OpenAPI document.
    pub(crate) about_item: &'static str,
    pub(crate) fewest: usize,
    pub(crate) most: usize,
}

impl<K: Kind> Kind for List<K> {
    type Value = Vec<K::Value>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted> {
        let items = items(raw, "an array", self.most, path, faults)?;
        if items.len() < self.fewest {
            let detail = format_args!("must have at least {} items, found {}", self.fewest, items.len());
            return Err(faults.add(&path, RequestFault::WrongCount, detail));
        }
        // Every item is read, so that all faults are listed.
        let values: Vec<_> = items.iter().enumerate().map(|(index, raw)| self.item.read(raw, path.item(index), faults)).collect();
        values.into_iter().collect()
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let item = self.item.schema(self.about_item, components);
        ArrayBuilder::new().items(item).min_items(Some(self.fewest)).max_items(Some(self.most)).description(description(about)).into()
    }
}
