//! JSON arrays, read item by item, so that no array is stored as a whole, and members that are arrays of values of one kind.

use super::object::description;
use super::{Components, Faulted, Faults, JsonPath, Kind, describe};
use crate::http::codes::RequestFault;
use crate::json::each;
use serde_json::value::RawValue;
use utoipa::openapi::schema::ArrayBuilder;
use utoipa::openapi::{RefOr, Schema};

/// Passes every item of the array `raw` to `take` in order, with its index and without parsing it. Returns their number.
/// `expected` describes the array in the fault of another value.
pub(crate) fn each_raw<'a>(
    raw: &'a RawValue,
    expected: &str,
    path: JsonPath<'_>,
    faults: &mut Faults,
    mut take: impl FnMut(usize, &'a RawValue, &mut Faults),
) -> Result<usize, Faulted> {
    let mut count = 0;
    let read = each(raw, |item| {
        take(count, item, faults);
        count += 1;
    });
    match read {
        Ok(()) => Ok(count),
        Err(_) => Err(faults.add(&path, RequestFault::WrongType, format_args!("expected {expected}, found {}", describe(raw)))),
    }
}

/// The unparsed items of the array `raw`. More than `most` items are a fault; further items are counted, not stored.
pub(crate) fn items<'a>(
    raw: &'a RawValue,
    expected: &str,
    most: usize,
    path: JsonPath<'_>,
    faults: &mut Faults,
) -> Result<Vec<&'a RawValue>, Faulted> {
    let mut items = Vec::new();
    let count = each_raw(raw, expected, path, faults, |index, item, _| {
        if index < most {
            items.push(item);
        }
    })?;
    if count > most {
        return Err(faults.add(&path, RequestFault::TooManyItems, format_args!("must have at most {most} items, found {count}")));
    }
    Ok(items)
}

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
