//! Reads JSON arrays item by item, without holding them as a tree.

use super::object::describe;
use super::{Faulted, Faults, JsonPath};
use crate::http::codes::RequestFault;
use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::fmt;
use std::marker::PhantomData;

/// Passes every item of the array `raw` to `take`, until one is not a `T`.
pub(crate) fn each<'a, T: Deserialize<'a>>(raw: &'a RawValue, take: impl FnMut(T)) -> serde_json::Result<()> {
    struct Each<T, F>(F, PhantomData<T>);
    impl<'de, T: Deserialize<'de>, F: FnMut(T)> Visitor<'de> for Each<T, F> {
        type Value = ();
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an array")
        }
        fn visit_seq<A: SeqAccess<'de>>(mut self, mut items: A) -> Result<(), A::Error> {
            while let Some(item) = items.next_element()? {
                (self.0)(item);
            }
            Ok(())
        }
    }
    serde_json::Deserializer::from_str(raw.get()).deserialize_seq(Each(take, PhantomData))
}

/// Passes every item of the array `raw` to `take` unread, in order.
pub(crate) fn each_raw<'a>(
    raw: &'a RawValue,
    path: JsonPath<'_>,
    faults: &mut Faults,
    mut take: impl FnMut(&'a RawValue, &mut Faults),
) -> Result<(), Faulted> {
    each(raw, |item: &'a RawValue| take(item, faults))
        .map_err(|_| faults.add(&path, RequestFault::WrongType, format_args!("expected an array, found {}", describe(raw))))
}

/// The items of the array that `raw` is, unread. More than `most` are a fault and are counted, not kept.
pub(crate) fn items<'a>(raw: &'a RawValue, most: usize, path: JsonPath<'_>, faults: &mut Faults) -> Result<Vec<&'a RawValue>, Faulted> {
    let mut all = Vec::new();
    for_runs_of_items(raw, most, most, path, faults, |_, items| all = items)?;
    Ok(all)
}

/// Passes the items of an array to `take` in runs of `run`, each with the index of its first item, and returns the number of items. Some
/// may be passed before the fault is found that there are more than `most` or that `raw` is not an array.
pub(crate) fn for_runs_of_items<'a>(
    raw: &'a RawValue,
    most: usize,
    run: usize,
    path: JsonPath<'_>,
    faults: &mut Faults,
    mut take: impl FnMut(usize, Vec<&'a RawValue>),
) -> Result<usize, Faulted> {
    let (mut count, mut items) = (0, Vec::new());
    each_raw(raw, path, faults, |item, _| {
        count += 1;
        if count <= most {
            items.push(item);
            if items.len() == run {
                take(count - run, std::mem::take(&mut items));
            }
        }
    })?;
    if count > most {
        return Err(faults.add(&path, RequestFault::TooManyItems, format_args!("must have at most {most} items, found {count}")));
    }
    if !items.is_empty() {
        take(count - items.len(), items);
    }
    Ok(count)
}
