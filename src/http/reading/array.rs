//! Reads JSON arrays item by item, without building a tree of values.

use super::object::describe;
use super::{Faulted, Faults, JsonPath};
use crate::http::codes::RequestFault;
use crate::json_text::{JsonText, Unread};

/// Passes every item of the array `raw` to `take` in order, without parsing it.
pub(crate) fn each_raw<'a>(
    raw: JsonText<'a>,
    path: JsonPath<'_>,
    faults: &mut Faults,
    mut take: impl FnMut(JsonText<'a>, &mut Faults),
) -> Result<(), Faulted> {
    let cancel = faults.cancel_flag().clone();
    let stop = || cancel.is_cancelled();
    raw.items(&stop, |item| take(item, faults)).map_err(|unread| match unread {
        // The faults of a cancelled reading are discarded.
        Unread::Cancelled => Faulted,
        _ => faults.add(&path, RequestFault::WrongType, format_args!("expected an array, found {}", describe(raw))),
    })
}

/// The unparsed items of the array `raw`. More than `most` items are a fault; further items are counted, not stored.
pub(crate) fn items<'a>(raw: JsonText<'a>, most: usize, path: JsonPath<'_>, faults: &mut Faults) -> Result<Vec<JsonText<'a>>, Faulted> {
    let (mut count, mut items) = (0, Vec::new());
    each_raw(raw, path, faults, |item, _| {
        count += 1;
        if count <= most {
            items.push(item);
        }
    })?;
    if count > most {
        return Err(faults.add(&path, RequestFault::TooManyItems, format_args!("must have at most {most} items, found {count}")));
    }
    Ok(items)
}
