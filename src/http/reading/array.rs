//! Reads JSON arrays item by item, without building a tree of values.

use super::object::describe;
use super::{Faulted, Faults, JsonPath};
use crate::cancellation::CancelFlag;
use crate::http::codes::RequestFault;
use crate::json_text::{JsonText, Unread};
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// The number of items between two checks for cancellation.
const TURN: usize = 256;

/// Passes every item of the array `raw` to `take`. Ends at the first item that is not a `T`, or if the reading is
/// cancelled by the flag of `faults`.
pub(crate) fn each<'a, T: Deserialize<'a>>(raw: JsonText<'a>, faults: &Faults, take: impl FnMut(T)) -> serde_json::Result<()> {
    each_until(raw, faults.cancel_flag(), take)
}

fn each_until<'a, T: Deserialize<'a>>(raw: JsonText<'a>, cancel: Option<CancelFlag>, take: impl FnMut(T)) -> serde_json::Result<()> {
    struct Each<T, F>(F, Option<CancelFlag>, PhantomData<T>);
    impl<'de, T: Deserialize<'de>, F: FnMut(T)> Visitor<'de> for Each<T, F> {
        type Value = ();
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an array")
        }
        fn visit_seq<A: SeqAccess<'de>>(mut self, mut items: A) -> Result<(), A::Error> {
            let mut count = 0_usize;
            while let Some(item) = items.next_element()? {
                (self.0)(item);
                count += 1;
                if count.is_multiple_of(TURN) && self.1.as_ref().is_some_and(CancelFlag::is_cancelled) {
                    return Err(A::Error::custom("cancelled"));
                }
            }
            Ok(())
        }
    }
    serde_json::Deserializer::from_str(raw.get()).deserialize_seq(Each(take, cancel, PhantomData))
}

/// Passes every item of the array `raw` to `take` in order, without parsing it.
pub(crate) fn each_raw<'a>(
    raw: JsonText<'a>,
    path: JsonPath<'_>,
    faults: &mut Faults,
    mut take: impl FnMut(JsonText<'a>, &mut Faults),
) -> Result<(), Faulted> {
    let cancel = faults.cancel_flag();
    let stop = || cancel.as_ref().is_some_and(CancelFlag::is_cancelled);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cancelled_array_is_not_read_to_its_end() {
        let cancel = CancelFlag::default();
        cancel.cancel();
        let json = format!("[{}0]", "0,".repeat(10 * TURN));
        let raw = JsonText::known(&json);
        let mut count = 0;
        assert!(each(raw, &Faults::until(&cancel), |_: u32| count += 1).is_err());
        assert_eq!(count, TURN);
        assert!(each(raw, &Faults::default(), |_: u32| count += 1).is_ok());
        assert_eq!(count, 11 * TURN + 1);
    }
}
