//! The fast reader of arrays of numbers and nulls. It uses all cores, and needs JSON whose syntax has been checked.

use memchr::{memchr, memchr_iter};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// The number of bytes that one thread reads at a time: some thousand numbers.
const BLOCK: usize = 32 * 1024;

/// The items of the array `json`, null as `None`. `None` if there are more than `most`, an item is of another type, or
/// a number is beyond double precision; the general reader then finds the faults. `json` must be the text of a JSON
/// value.
pub(super) fn read_numbers(json: &str, most: usize) -> Option<Vec<Option<f64>>> {
    let items = json.trim_ascii().strip_prefix('[')?.strip_suffix(']')?;
    if items.trim_ascii().is_empty() {
        return Some(Vec::new());
    }
    let blocks = blocks(items);
    // Items without brackets and quotation marks contain no commas; `read_item` refuses all others.
    let counts: Vec<usize> = blocks.iter().map(|block| memchr_iter(b',', block.as_bytes()).count() + 1).collect();
    let count = counts.iter().sum();
    if count > most {
        return None;
    }
    let mut values = vec![None; count];
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
fn blocks(items: &str) -> Vec<&str> {
    let mut blocks = Vec::with_capacity(items.len() / BLOCK + 1);
    let mut rest = items;
    while let Some(comma) = rest.as_bytes().get(BLOCK..).and_then(|after| memchr(b',', after)) {
        // A comma is one byte in UTF-8, so that both sides are valid text.
        blocks.push(&rest[..BLOCK + comma]);
        rest = &rest[BLOCK + comma + 1..];
    }
    blocks.push(rest);
    blocks
}

/// An item that is neither null nor a finite double.
struct Unusual;

fn read_block(block: &str, place: &mut [Option<f64>]) -> Result<(), Unusual> {
    for (item, value) in block.split(',').zip(place) {
        *value = read_item(item.trim_ascii())?;
    }
    Ok(())
}

fn read_item(item: &str) -> Result<Option<f64>, Unusual> {
    match item.as_bytes().first() {
        // The text is valid JSON, so the first byte identifies a number.
        Some(b'-' | b'0'..=b'9') => item.parse().ok().filter(|value: &f64| value.is_finite()).map(Some).ok_or(Unusual),
        Some(b'n') => Ok(None),
        _ => Err(Unusual),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The result of the general reader.
    fn expected(json: &str) -> Option<Vec<Option<f64>>> {
        serde_json::from_str(json).ok()
    }

    #[test]
    fn arrays_of_numbers_and_nulls_are_read() {
        for json in ["[]", " [ ] ", "[1]", "[1.5,null,-2e-3]", "[ 1 ,\n2\t, null ]", "[0.1,-0,1E5]", "[5e-324,1.7976931348623157e308]"] {
            assert_eq!(read_numbers(json, 10), expected(json), "{json}");
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
        ] {
            assert!(serde_json::from_str::<serde_json::Value>(json).is_ok() || json.contains("e999") || json.contains("e400"), "{json}");
            assert_eq!(read_numbers(json, 10), None, "{json}");
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
            prop_assert_eq!(read_numbers(&json, values.len() - 1), None);
            prop_assert_eq!(read_numbers(&json, values.len()), Some(values));
        }
    }
}
