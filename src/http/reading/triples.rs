//! The fast reader of arrays of triples of numbers, such as points. It uses all cores, and needs JSON whose syntax has
//! been checked.

use crate::cancellation::CancelFlag;
use memchr::memchr;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// The number of bytes that one thread reads at a time: some thousand triples.
const BLOCK: usize = 64 * 1024;

/// The number of blocks that are read before their results are passed on. It limits the memory of the results, and the
/// time until a cancelled reading ends.
const BATCH: usize = 16;

/// A number of a triple, parsed from an item of a JSON array.
pub(crate) trait TripleNumber: Copy + Default + Send {
    /// Parses an item; `None` if it is not a number of this type in the usual notation.
    fn parse(item: &str) -> Option<Self>;
}

impl TripleNumber for f64 {
    fn parse(item: &str) -> Option<Self> {
        // The text is valid JSON, so the first byte identifies a number.
        let is_number = matches!(item.as_bytes().first(), Some(b'-' | b'0'..=b'9'));
        item.parse().ok().filter(|value: &f64| is_number && value.is_finite())
    }
}

impl TripleNumber for u32 {
    fn parse(item: &str) -> Option<Self> {
        item.parse().ok().filter(|_| item.as_bytes()[0].is_ascii_digit())
    }
}

/// Reads the array `json`, which must be the text of a JSON value. Its triples are passed to `each` in blocks, on all
/// cores, and the results of `each` to `take`, in order. Returns `None` if an item is not three finite numbers of type
/// `N`, or once `cancel` is set; `take` may have been called before.
pub(crate) fn read_triples<N: TripleNumber, T: Send>(
    json: &str,
    cancel: Option<&CancelFlag>,
    each: impl Fn(Vec<[N; 3]>) -> T + Sync,
    mut take: impl FnMut(T),
) -> Option<()> {
    let mut rest = json.trim_ascii().strip_prefix('[')?.strip_suffix(']')?.trim_ascii();
    while !rest.is_empty() {
        if cancel.is_some_and(CancelFlag::is_cancelled) {
            return None;
        }
        let mut blocks = Vec::with_capacity(BATCH);
        while blocks.len() < BATCH && !rest.is_empty() {
            let block;
            (block, rest) = next_block(rest)?;
            blocks.push(block);
        }
        let read: Vec<Option<T>> = blocks.into_par_iter().map(|block| read_block(block).map(&each)).collect();
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

fn read_block<N: TripleNumber>(block: &str) -> Option<Vec<[N; 3]>> {
    let mut triples = Vec::with_capacity(block.len() / 16);
    let mut rest = block;
    loop {
        let items = rest.strip_prefix('[')?;
        let (items, after) = items.split_at(memchr(b']', items.as_bytes())?);
        let mut triple = [N::default(); 3];
        let mut items = items.split(',');
        for number in &mut triple {
            *number = N::parse(items.next()?.trim_ascii())?;
        }
        if items.next().is_some() {
            return None;
        }
        triples.push(triple);
        rest = after[1..].trim_ascii_start();
        if rest.is_empty() {
            return Some(triples);
        }
        rest = rest.strip_prefix(',')?.trim_ascii_start();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read<N: TripleNumber>(json: &str) -> Option<Vec<[N; 3]>> {
        let mut all = Vec::new();
        read_triples(json, None, |triples| triples, |triples| all.extend(triples)).map(|()| all)
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
        assert_eq!(read_triples("[[1,2,3]]", Some(&cancel), |triples: Vec<[f64; 3]>| triples.len(), |_| ()), None);
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
