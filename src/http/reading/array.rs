//! Reads JSON arrays item by item, without building them up.

use super::object::describe;
use super::{Faulted, Faults, JsonPath};
use crate::http::codes::RequestFault;
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::fmt;

/// The items of the array that `raw` is, unread. More than `most` are a fault and are counted, not kept.
pub(crate) fn items<'a>(raw: &'a RawValue, most: usize, path: JsonPath<'_>, faults: &mut Faults) -> Result<Vec<&'a RawValue>, Faulted> {
    let mut all = Vec::new();
    for_runs_of_items(raw, most, most, path, faults, |_, items| all = items)?;
    Ok(all)
}

/// Passes the items of an array to `take` in runs of `run`, each with the index of its first item, and returns the number of items. That
/// there are more than `most`, or that `raw` is no array, may be found after some were passed.
pub(crate) fn for_runs_of_items<'a>(
    raw: &'a RawValue,
    most: usize,
    run: usize,
    path: JsonPath<'_>,
    faults: &mut Faults,
    take: impl FnMut(usize, Vec<&'a RawValue>),
) -> Result<usize, Faulted> {
    let count = Items { most, run, take }.deserialize(&mut serde_json::Deserializer::from_str(raw.get()));
    let count =
        count.map_err(|_| faults.add(&path, RequestFault::WrongType, format_args!("expected an array, found {}", describe(raw))))?;
    if count > most {
        return Err(faults.add(&path, RequestFault::TooManyItems, format_args!("must have at most {most} items, found {count}")));
    }
    Ok(count)
}

/// Passes on the first items of an array and counts all.
struct Items<F> {
    most: usize,
    run: usize,
    take: F,
}

impl<'de, F: FnMut(usize, Vec<&'de RawValue>)> DeserializeSeed<'de> for Items<F> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, F: FnMut(usize, Vec<&'de RawValue>)> Visitor<'de> for Items<F> {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut sequence: A) -> Result<usize, A::Error> {
        let (mut count, mut items) = (0, Vec::new());
        while count < self.most
            && let Some(item) = sequence.next_element()?
        {
            items.push(item);
            count += 1;
            if items.len() == self.run {
                (self.take)(count - items.len(), std::mem::take(&mut items));
            }
        }
        if !items.is_empty() {
            (self.take)(count - items.len(), items);
        }
        while sequence.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        Ok(count)
    }
}
