//! Reads JSON arrays item by item, without building a tree of values.

use super::{Faulted, Faults, describe};
use crate::http::codes::RequestFault;
use crate::json_text::{JsonPath, JsonText, Unread};

/// Passes every item of the array `raw` to `take` in order, with its index and without parsing it. Returns their number.
/// `expected` describes the array in the fault of another value.
pub(crate) fn each_raw<'a>(
    raw: JsonText<'a>,
    expected: &str,
    path: JsonPath<'_>,
    faults: &mut Faults,
    mut take: impl FnMut(usize, JsonText<'a>, &mut Faults),
) -> Result<usize, Faulted> {
    let mut count = 0;
    let cancel = faults.cancel_flag().clone();
    let stop = || cancel.is_cancelled();
    let take_next = |item| {
        take(count, item, faults);
        count += 1;
    };
    raw.items(&stop, take_next).map(|()| count).map_err(|unread| match unread {
        // The faults of a cancelled reading are discarded.
        Unread::Cancelled => Faulted,
        _ => faults.add(&path, RequestFault::WrongType, format_args!("expected {expected}, found {}", describe(raw))),
    })
}

/// The unparsed items of the array `raw`. More than `most` items are a fault; further items are counted, not stored.
pub(crate) fn items<'a>(
    raw: JsonText<'a>,
    expected: &str,
    most: usize,
    path: JsonPath<'_>,
    faults: &mut Faults,
) -> Result<Vec<JsonText<'a>>, Faulted> {
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
