//! The fast reader of arrays of numbers and nulls. It uses all cores; the syntax need not have been checked.

use super::plain::{PlainJson, Unusual};
use memchr::{memchr, memchr_iter};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// The number of bytes that one thread reads at a time: some thousand numbers.
const BLOCK: usize = 32 * 1024;

/// The items of an array, given as the text between its brackets, with NaN for null. `None` if there are more than
/// `most`, an item is neither null nor a finite double, or the text is no list of items; the general reader then finds
/// the faults.
pub(crate) fn read_numbers(items: &[u8], most: usize) -> Option<Vec<f64>> {
    if items.trim_ascii().is_empty() {
        return Some(Vec::new());
    }
    let blocks = blocks(items);
    // Items without brackets and quotation marks contain no commas; `number_or_null` refuses all others.
    let counts: Vec<usize> = blocks.iter().map(|block| memchr_iter(b',', block).count() + 1).collect();
    let count = counts.iter().sum();
    if count > most {
        return None;
    }
    let mut values = vec![0.0; count];
    let mut rest = &mut values[..];
    let mut places = Vec::with_capacity(blocks.len());
    for count in counts {
        let (place, after) = rest.split_at_mut(count);
        places.push(place);
        rest = after;
    }
    blocks.into_par_iter().zip(places).try_for_each(|(block, place)| read_block(block, place)).ok()?;
    Some(values)
}

/// Divides `items` into blocks that end between items.
fn blocks(items: &[u8]) -> Vec<&[u8]> {
    let mut blocks = Vec::with_capacity(items.len() / BLOCK + 1);
    let mut rest = items;
    while let Some(comma) = rest.get(BLOCK..).and_then(|after| memchr(b',', after)) {
        blocks.push(&rest[..BLOCK + comma]);
        rest = &rest[BLOCK + comma + 1..];
    }
    blocks.push(rest);
    blocks
}

fn read_block(block: &[u8], place: &mut [f64]) -> Result<(), Unusual> {
    let mut json = PlainJson::new(block);
    let (last, others) = place.split_last_mut().ok_or(Unusual)?;
    for value in others {
        *value = number_or_null(&mut json)?;
        json.expect(b',')?;
    }
    *last = number_or_null(&mut json)?;
    if json.is_at_end() { Ok(()) } else { Err(Unusual) }
}

#[inline]
fn number_or_null(json: &mut PlainJson<'_>) -> Result<f64, Unusual> {
    if json.takes_null() { Ok(f64::NAN) } else { json.number() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The result of the general reader.
    fn expected(json: &str) -> Option<Vec<Option<f64>>> {
        serde_json::from_str(json).ok()
    }

    fn read(json: &str, most: usize) -> Option<Vec<Option<f64>>> {
        let items = json.trim_ascii().strip_prefix('[')?.strip_suffix(']')?;
        Some(read_numbers(items.as_bytes(), most)?.into_iter().map(|value| (!value.is_nan()).then_some(value)).collect())
    }

    #[test]
    fn arrays_of_numbers_and_nulls_are_read() {
        for json in ["[]", " [ ] ", "[1]", "[1.5,null,-2e-3]", "[ 1 ,\n2\t, null ]", "[0.1,-0,1E5]", "[5e-324,1.7976931348623157e308]"] {
            assert_eq!(read(json, 10), expected(json), "{json}");
        }
    }

    #[test]
    fn other_arrays_are_left_to_the_general_reader() {
        for json in [
            "1",
            "{}",
            "\"[1,2]\"",
            "[true]",
            "[\"1\"]",
            "[1,\"2,3\"]",
            "[[1,2]]",
            "[1,[2]]",
            "[{\"a\":1,\"b\":2}]",
            "[1e999]",
            "[1,-1e400]",
            "[\"]\"]",
            "[1,]",
            "[,1]",
            "[1,,2]",
            "[1 2]",
            "[01]",
            "[nul]",
            "[nullx]",
        ] {
            assert_eq!(read(json, 10), None, "{json}");
        }
    }

    proptest! {
        /// Blocks may end between any two items; every number must be the same double as with the general reader.
        #[test]
        fn long_arrays_are_read_as_by_the_general_reader(
            values in proptest::collection::vec(proptest::option::of(proptest::num::f64::NORMAL | proptest::num::f64::ZERO), 1..6000),
            blank in proptest::bool::ANY,
        ) {
            let mut json = serde_json::to_string(&values).unwrap();
            if blank {
                json = json.replace(',', " , ");
            }
            prop_assert_eq!(read(&json, values.len() - 1), None);
            prop_assert_eq!(read(&json, values.len()), Some(values));
        }
    }
}
