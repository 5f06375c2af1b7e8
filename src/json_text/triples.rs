//! The fast reader of arrays of triples of numbers, such as points. It uses all cores, and needs JSON whose syntax has
//! been checked.

use super::plain::{PlainJson, PlainValue, Unusual};
use crate::cancellation::CancelFlag;
use memchr::memchr;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// The number of bytes that one thread reads at a time: some thousand triples.
const BLOCK: usize = 64 * 1024;

/// The number of blocks that are read before their results are passed on. It limits the memory of the results, and the
/// time until a cancelled reading ends.
const BATCH: usize = 16;

/// Reads the array `json`, which must be the text of a JSON value. Its triples are passed to `each` in blocks, on all
/// cores, and the results of `each` to `take`, in order. Returns `None` if an item is not three finite numbers of type
/// `N`, or once `cancel` is set; `take` may have been called before.
pub(crate) fn read_triples<N: PlainValue + Default + Send, T: Send>(
    json: &str,
    cancel: &CancelFlag,
    each: impl Fn(Vec<[N; 3]>) -> T + Sync,
    mut take: impl FnMut(T),
) -> Option<()> {
    let mut rest = json.trim_ascii().strip_prefix('[')?.strip_suffix(']')?.trim_ascii();
    while !rest.is_empty() {
        if cancel.is_cancelled() {
            return None;
        }
        let mut blocks = Vec::with_capacity(BATCH);
        while blocks.len() < BATCH && !rest.is_empty() {
            let block;
            (block, rest) = next_block(rest)?;
            blocks.push(block);
        }
        let read: Vec<Option<T>> = blocks.into_par_iter().map(|block| read_block(block).ok().map(&each)).collect();
        for block in read {
            take(block?);
        }
    }
    Some(())
}

/// Splits `items` after the triple with which the block exceeds its size, and drops the comma.
fn next_block(items: &str) -> Option<(&str, &str)> {
    let Some(end) = items.as_bytes().get(BLOCK..).and_then(|after| memchr(b']', after)) else { return Some((items, "")) };
    // A bracket is one byte in UTF-8, so that both sides are valid text.
    let (block, rest) = items.split_at(BLOCK + end + 1);
    let rest = rest.trim_ascii_start();
    if rest.is_empty() { Some((block, rest)) } else { Some((block, rest.strip_prefix(',')?.trim_ascii_start())) }
}

fn read_block<N: PlainValue + Default>(block: &str) -> Result<Vec<[N; 3]>, Unusual> {
    let mut triples = Vec::with_capacity(block.len() / 16);
    let mut json = PlainJson::new(block.as_bytes());
    loop {
        triples.push(PlainValue::read(&mut json)?);
        if json.is_at_end() {
            return Ok(triples);
        }
        json.expect(b',')?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read<N: PlainValue + Default + Send>(json: &str) -> Option<Vec<[N; 3]>> {
        let mut all = Vec::new();
        read_triples(json, &CancelFlag::default(), |triples| triples, |triples| all.extend(triples)).map(|()| all)
    }

    #[test]
    fn arrays_of_triples_are_read() {
        for json in ["[]", " [ ] ", "[[1,2,3]]", "[[1.5,-2e-3,0] ,\n[ 0.1 ,-0,1E5 ] ]", "[[5e-324,1.7976931348623157e308,3]]"] {
            assert_eq!(read::<f64>(json), serde_json::from_str(json).ok(), "{json}");
        }
        for json in ["[]", "[[0,1,2],[4294967295, 3 ,7]]"] {
            assert_eq!(read::<u32>(json), serde_json::from_str(json).ok(), "{json}");
        }
    }

    #[test]
    fn other_arrays_are_left_to_the_general_reader() {
        for json in [
            "1",
            "{}",
            "\"[[1,2,3]]\"",
            "[1,2,3]",
            "[[1,2]]",
            "[[1,2,3,4]]",
            "[[1,2,\"3\"]]",
            "[[1,2,null]]",
            "[[1,[2],3]]",
            "[[[1,2,3]]]",
            "[[1,2,1e999]]",
            "[\"[1,2,3]\"]",
            "[[]]",
        ] {
            assert_eq!(read::<f64>(json), None, "{json}");
        }
        for json in ["[[0,1,-2]]", "[[0,1,2.0]]", "[[0,1,1e3]]", "[[0,1,4294967296]]"] {
            assert_eq!(read::<u32>(json), None, "{json}");
        }
    }

    #[test]
    fn a_cancelled_array_is_not_read() {
        let cancel = CancelFlag::default();
        cancel.cancel();
        assert_eq!(read_triples("[[1,2,3]]", &cancel, |triples: Vec<[f64; 3]>| triples.len(), |_| ()), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        /// Blocks end anywhere between triples, and every number is the same double as with the general reader.
        #[test]
        fn long_arrays_are_read_as_by_the_general_reader(
            triple in proptest::array::uniform3(proptest::num::f64::NORMAL | proptest::num::f64::ZERO),
            count in 1_usize..6000,
            blank: bool,
        ) {
            let triples: Vec<[f64; 3]> = (0..count).map(|index| triple.map(|number| if index % 3 == 0 { number } else { -number })).collect();
            let mut json = serde_json::to_string(&triples).unwrap();
            if blank {
                json = json.replace(',', " , ").replace(']', "\n]");
            }
            prop_assert_eq!(read(&json), Some(triples));
        }
    }
}
