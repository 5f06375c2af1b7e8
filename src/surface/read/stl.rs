//! Readers of STL, in text and in binary records.
//!
//! Text: `solid`, facets of three vertices each, `endsolid`; any number of solids. Keywords may have any case and words
//! may be spread over lines in any way, except that the name of a solid ends with its line. The last `endsolid` may be
//! missing, and so may one before another `solid`. A number may have a decimal comma.
//!
//! Binary: a header of 80 bytes, which is ignored, a count of 4 bytes, and a record of 50 bytes for each facet: normal
//! and corners in single precision, little-endian, and 2 bytes without a common meaning. Bytes after the last facet are
//! counted.
//!
//! Normals are ignored in both, because the corners define them: zero and NaN are accepted.

use super::input::{Input, ReadError};
use super::words::{Decimals, unbounded};
use super::{Format, LARGEST_COORDINATE, Notes, ReadSummary, Sink};
use crate::file_fault::{FileFault, FileFaultKind, Flaw};

const END: &str = "the end of the file";

/// Reads an STL in text.
pub(super) fn read_text(input: &mut Input, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
    let mut decimals = Decimals::default();
    // Inside a solid, or after a facet outside any solid.
    let (mut in_solid, mut facets) = (false, 0);
    while let Some(word) = input.word()? {
        if word.eq_ignore_ascii_case(b"facet") {
            sink.facet(read_facet(input, &mut decimals)?);
            facets += 1;
            in_solid = true;
        } else if word.eq_ignore_ascii_case(b"solid") || (in_solid && word.eq_ignore_ascii_case(b"endsolid")) {
            in_solid = word.len() == b"solid".len();
            input.skip_words();
        } else {
            let flaw = Flaw::quoting(if in_solid { "\"facet\" or \"endsolid\"" } else { "\"solid\" or \"facet\"" }, word);
            return Err(flaw.at_line(input.number()).into());
        }
    }
    if facets == 0 {
        return Err(Flaw::new(FileFaultKind::Empty, "\"facet\"", END).at_line(input.number_at_end()).into());
    }
    let notes = Notes { missing_end: in_solid, ..Notes::default() };
    Ok(ReadSummary { format: Format::StlAscii, points: 0, facets, unit: None, notes })
}

/// Reads a facet after the word `facet`.
fn read_facet(input: &mut Input, decimals: &mut Decimals) -> Result<[[f64; 3]; 3], ReadError> {
    let mut corners = [[0.0; 3]; 3];
    keyword(input, b"normal", "\"normal\"")?;
    for _ in 0..3 {
        let expected = "three numbers of the normal, then \"outer loop\"";
        read_word(input, expected, |word| if word.eq_ignore_ascii_case(b"outer") { Err(Flaw::quoting(expected, word)) } else { Ok(()) })?;
    }
    keyword(input, b"outer", "\"outer\"")?;
    keyword(input, b"loop", "\"loop\"")?;
    for corner in &mut corners {
        keyword(input, b"vertex", "\"vertex\", three for each facet")?;
        for value in corner {
            let expected = "a number, three for each vertex";
            *value = read_word(input, expected, |word| decimals.coordinate(word, expected))?;
        }
    }
    keyword(input, b"endloop", "\"endloop\" after three vertices")?;
    keyword(input, b"endfacet", "\"endfacet\"")?;
    Ok(corners)
}

fn keyword(input: &mut Input, name: &[u8], expected: &'static str) -> Result<(), ReadError> {
    read_word(input, expected, |word| if word.eq_ignore_ascii_case(name) { Ok(()) } else { Err(Flaw::quoting(expected, word)) })
}

/// The result of `read` for the next word, which may stand on a later line.
#[inline]
fn read_word<T>(input: &mut Input, expected: &'static str, read: impl FnOnce(&[u8]) -> Result<T, Flaw>) -> Result<T, ReadError> {
    match input.word()? {
        Some(word) => read(word).map_err(|flaw| flaw.at_line(input.number()).into()),
        None => Err(Flaw::new(FileFaultKind::Truncated, expected, END).at_line(input.number_at_end()).into()),
    }
}

const HEADER: usize = 80;
const START: usize = HEADER + 4;
const RECORD: usize = 50;
/// The corners follow the normal's three numbers.
const FIRST_CORNER: usize = 12;

/// Reads a binary STL.
pub(super) fn read_binary(input: &mut Input, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
    let Some(start) = input.block(START)? else {
        let length = input.peek(START)?.len();
        let expected = format!("{START} bytes of header and count of a binary STL");
        return Err(Flaw::new(FileFaultKind::Truncated, expected, length.to_string()).at_byte(length as u64).into());
    };
    let promised = start.last_chunk().map_or(0, |count| u64::from(u32::from_le_bytes(*count)));
    let mut facets = 0;
    while facets < promised {
        let (records, _) = input.peek(RECORD)?.as_chunks::<RECORD>();
        let records = &records[..records.len().min(usize::try_from(promised - facets).unwrap_or(usize::MAX))];
        if records.is_empty() {
            let expected = format!("{promised} facets, as the count at byte {HEADER} says");
            let end = input.offset() + input.peek(RECORD)?.len() as u64;
            return Err(Flaw::new(FileFaultKind::Truncated, expected, format!("{END} after {facets}")).at_byte(end).into());
        }
        for record in records {
            let corners = corners(record);
            // A comparison with NaN is false.
            if !corners.as_flattened().iter().all(|value| value.abs() <= LARGEST_COORDINATE) {
                return Err(out_of_range(&corners, START as u64 + RECORD as u64 * facets).into());
            }
            facets += 1;
            sink.facet(corners);
        }
        let bytes = records.len() * RECORD;
        input.consume(bytes);
    }
    let trailing_bytes = input.skip(u64::MAX)?;
    if promised == 0 {
        let found = format!("the count 0, and {trailing_bytes} bytes after it");
        return Err(Flaw::new(FileFaultKind::Empty, "a facet", found).at_byte(HEADER as u64).into());
    }
    let notes = Notes { trailing_bytes, ..Notes::default() };
    Ok(ReadSummary { format: Format::StlBinary, points: 0, facets, unit: None, notes })
}

/// The fault of the first coordinate out of range in the record at `offset`.
#[cold]
fn out_of_range(corners: &[[f64; 3]; 3], offset: u64) -> FileFault {
    let numbers = corners.as_flattened();
    let first = numbers.iter().position(|value| value.is_nan() || value.abs() > LARGEST_COORDINATE).unwrap_or(0);
    unbounded(&numbers[first].to_string()).at_byte(offset + (FIRST_CORNER + 4 * first) as u64)
}

#[inline]
fn corners(record: &[u8; RECORD]) -> [[f64; 3]; 3] {
    let (numbers, _) = record[FIRST_CORNER..].as_chunks::<4>();
    let coordinate = |index: usize| f64::from(f32::from_le_bytes(numbers[index]));
    let corner = |first: usize| [coordinate(first), coordinate(first + 1), coordinate(first + 2)];
    [corner(0), corner(3), corner(6)]
}
