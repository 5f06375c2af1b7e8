//! Reads JSON arrays item by item, so that no array is stored as a whole.

use super::{Faulted, Faults, JsonPath, describe};
use crate::http::codes::RequestFault;
use crate::json::each;
use serde_json::value::RawValue;

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
