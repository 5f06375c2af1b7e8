//! Lines as words; words as decimal numbers, with a decimal comma and Fortran's exponents too, and as names of units of length.

use super::LARGEST_COORDINATE;
use crate::file_fault::{FileFaultKind, Flaw, quoted};
use crate::surface::Unit;

/// The position of the first CR or LF.
pub(super) fn line_end(bytes: &[u8]) -> Option<usize> {
    memchr::memchr2(b'\n', b'\r', bytes)
}

/// Whether `byte` separates words inside a line.
pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c)
}

/// `line` without the blanks before it.
pub(super) fn trimmed_start(mut line: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = line
        && is_blank(*first)
    {
        line = rest;
    }
    line
}

/// `line` without the blanks on both sides.
pub(super) fn trimmed(line: &[u8]) -> &[u8] {
    let mut line = trimmed_start(line);
    while let [rest @ .., last] = line
        && is_blank(*last)
    {
        line = rest;
    }
    line
}

/// The words of a line.
#[derive(Debug, Clone)]
pub(super) struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    pub(super) fn of(line: &'a [u8]) -> Self {
        Self(line)
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let line = trimmed_start(self.0);
        let end = line.iter().position(|byte| is_blank(*byte)).unwrap_or(line.len());
        let (word, rest) = line.split_at(end);
        self.0 = rest;
        (!word.is_empty()).then_some(word)
    }
}

/// A whole number of at most 18 digits, so that sums of the counts in a header do not overflow.
pub(super) fn unsigned(word: &[u8]) -> Option<u64> {
    let fits = !word.is_empty() && word.len() <= 18;
    fits.then(|| word.iter().try_fold(0, |value, byte| byte.is_ascii_digit().then(|| value * 10 + u64::from(byte - b'0'))))?
}

/// Whether `text` starts with a number.
pub(super) fn starts_number(text: &[u8]) -> bool {
    matches!(text, [b'0'..=b'9', ..] | [b'+' | b'-' | b'.', b'0'..=b'9' | b'.', ..])
}

/// The lines that are not blank, trimmed.
pub(super) fn statements(mut text: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        while !text.is_empty() {
            let end = line_end(text).unwrap_or(text.len());
            let line = trimmed(&text[..end]);
            text = text.get(end + 1..).unwrap_or_default();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    })
}

/// Whether the first word of the line is `word`, in either case.
pub(super) fn is_word(line: &[u8], word: &[u8]) -> bool {
    Words::of(line).next().is_some_and(|first| first.eq_ignore_ascii_case(word))
}

/// The number at the start of `text` and its length in bytes, or `None` if no number starts. `mark` is the decimal
/// mark, point or comma.
///
/// A number is `[+-] digits [mark digits] [e [+-] digits]`, with digits on at least one side of the mark; `E` and
/// Fortran's `d` and `D` mean the same as `e`. The value is the double nearest to the written number, infinite if that
/// is beyond the largest double.
pub(super) fn number(text: &[u8], mark: u8) -> Option<(f64, usize)> {
    let after_sign = |at: usize| at + usize::from(matches!(text.get(at), Some(b'+' | b'-')));
    let after_digits = |at: usize| at + text[at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let start = after_sign(0);
    let mut end = after_digits(start);
    let mut digits = end - start;
    if text.get(end) == Some(&mark) {
        let end_of_decimals = after_digits(end + 1);
        digits += end_of_decimals - (end + 1);
        end = if digits > 0 { end_of_decimals } else { end };
    }
    if digits == 0 {
        return None;
    }
    if let Some(b'e' | b'E' | b'd' | b'D') = text.get(end) {
        let start_of_power = after_sign(end + 1);
        let end_of_power = after_digits(start_of_power);
        end = if end_of_power > start_of_power { end_of_power } else { end };
    }
    Some((parsed(&text[..end], mark)?, end))
}

/// Parses with the standard library, which accepts neither a comma nor Fortran's `d`.
fn parsed(token: &[u8], mark: u8) -> Option<f64> {
    let token = std::str::from_utf8(token).ok()?;
    if mark == b'.' && !token.contains(['d', 'D']) {
        return token.parse().ok();
    }
    token.replace(',', ".").replace(['d', 'D'], "e").parse().ok()
}

/// `value` if it can be a coordinate; `token` is its text, for the fault.
pub(super) fn bounded(value: f64, token: &[u8]) -> Result<f64, Flaw> {
    if value.abs() <= LARGEST_COORDINATE { Ok(value) } else { Err(unbounded(&quoted(token))) }
}

/// The flaw of a number that cannot be a coordinate.
#[cold]
pub(super) fn unbounded(found: &str) -> Flaw {
    Flaw::new(FileFaultKind::OutOfRange, format!("a finite coordinate of at most {LARGEST_COORDINATE:e} in magnitude"), found.to_owned())
}

/// The coordinates of a file whose words are separated by blanks, so that a comma in a number can only be a decimal
/// comma. The first number with a decimal mark determines that of the file.
#[derive(Debug, Default)]
pub(super) struct Decimals {
    mark: Option<u8>,
}

impl Decimals {
    /// Parses the whole of `word`; `expected` describes it in a fault.
    #[inline]
    pub(super) fn coordinate(&mut self, word: &[u8], expected: &'static str) -> Result<f64, Flaw> {
        let mark = self.mark.unwrap_or(b'.');
        match number(word, mark) {
            Some((value, length)) if length == word.len() => {
                if self.mark.is_none() && word.contains(&mark) {
                    self.mark = Some(mark);
                }
                bounded(value, word)
            }
            _ => self.odd(word, expected),
        }
    }

    #[cold]
    fn odd(&mut self, word: &[u8], expected: &'static str) -> Result<f64, Flaw> {
        let other = if self.mark == Some(b',') { b'.' } else { b',' };
        match number(word, other) {
            Some((value, length)) if length == word.len() && self.mark.is_none() => {
                self.mark = Some(other);
                bounded(value, word)
            }
            Some((_, length)) if length == word.len() && other == b'.' => {
                Err(Flaw::quoting("a number with a decimal comma, as before", word))
            }
            _ => Err(no_coordinate(word, expected)),
        }
    }
}

/// Parses the whole of `word` as a coordinate with a decimal point; `expected` describes it in a fault.
pub(super) fn coordinate(word: &[u8], expected: &'static str) -> Result<f64, Flaw> {
    match number(word, b'.') {
        Some((value, length)) if length == word.len() => bounded(value, word),
        _ => Err(no_coordinate(word, expected)),
    }
}

#[cold]
fn no_coordinate(word: &[u8], expected: &'static str) -> Flaw {
    let has_decimal_comma = number(word, b',').is_some_and(|(_, length)| length == word.len());
    if names_no_finite_number(word) {
        unbounded(&quoted(word))
    } else if has_decimal_comma {
        Flaw::new(FileFaultKind::Malformed, "a number with a decimal point", format!("{}, with a decimal comma", quoted(word)))
    } else {
        Flaw::quoting(expected, word)
    }
}

/// Whether `word` is one of the spellings that programs write for infinity and NaN.
pub(super) fn names_no_finite_number(word: &[u8]) -> bool {
    let word = word.strip_prefix(b"-").or_else(|| word.strip_prefix(b"+")).unwrap_or(word);
    let starts = |name: &[u8]| word.get(..name.len()).is_some_and(|head| head.eq_ignore_ascii_case(name));
    let is = |name: &[u8]| word.eq_ignore_ascii_case(name);
    is(b"nan") || starts(b"nan(") || is(b"inf") || is(b"infinity") || starts(b"1.#")
}

/// The unit of length of this name in lower case; an error for a unit that is not supported.
pub(super) fn length_unit(word: &[u8]) -> Option<Result<Unit, Flaw>> {
    Some(Ok(match word {
        b"um" | b"micron" | b"microns" | b"micrometer" | b"micrometre" | b"\xb5m" | b"\xc2\xb5m" | b"\xce\xbcm" => Unit::Micrometre,
        b"mm" | b"millimeter" | b"millimeters" | b"millimetre" | b"millimetres" => Unit::Millimetre,
        b"cm" | b"centimeter" | b"centimeters" | b"centimetre" | b"centimetres" => Unit::Centimetre,
        b"m" | b"meter" | b"meters" | b"metre" | b"metres" => Unit::Metre,
        b"in" | b"inch" | b"inches" => Unit::Inch,
        b"ft" | b"foot" | b"feet" => Unit::Foot,
        b"nm" | b"dm" | b"km" | b"mil" | b"thou" | b"yd" | b"yards" => {
            return Some(Err(Flaw::quoting("coordinates in micrometres, mm, cm, m, inches or feet", word)));
        }
        _ => return None,
    }))
}

/// The unit that comments of a file state. Other comments are prose.
#[derive(Debug, Default)]
pub(super) struct CommentedUnit(Option<Unit>);

impl CommentedUnit {
    /// Reads a comment such as `units: mm`, `File units = inches` or `units are in metres`: the word unit, and after it
    /// a unit and nothing else.
    pub(super) fn read(&mut self, comment: &[u8]) -> Result<(), Flaw> {
        // Comments are many in some files, and the word is rare.
        if memchr::memchr2(b'u', b'U', comment).is_none() {
            return Ok(());
        }
        let lower = comment.to_ascii_lowercase();
        let words: Vec<&[u8]> =
            lower.split(|byte| byte.is_ascii() && !byte.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
        let Some(at) = words.iter().position(|word| matches!(*word, b"unit" | b"units")) else { return Ok(()) };
        let Some((name, between)) = words[at + 1..].split_last() else { return Ok(()) };
        let are_fillers = between.iter().all(|word| matches!(*word, b"is" | b"are" | b"in" | b"of" | b"length"));
        let Some(unit) = length_unit(name).filter(|_| are_fillers) else { return Ok(()) };
        let unit = unit?;
        match self.0.replace(unit) {
            Some(before) if before != unit => Err(Flaw::new(FileFaultKind::Ambiguous, "one unit in the comments", "different ones")),
            _ => Ok(()),
        }
    }

    pub(super) fn unit(&self) -> Option<Unit> {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn words_are_separated_by_blanks() {
        let words: Vec<&[u8]> = Words::of(b" \t one  two\x0cthree ").collect();
        assert_eq!(words, [&b"one"[..], b"two", b"three"]);
        assert_eq!(trimmed(b" \t a b \t"), b"a b");
    }

    #[test]
    fn every_notation_of_a_number_is_read() {
        for (text, value) in [
            ("0", 0.0),
            ("-0", -0.0),
            ("+1", 1.0),
            ("1.", 1.0),
            (".5", 0.5),
            ("-.5e1", -5.0),
            ("1.25E+02", 125.0),
            ("1.25d-02", 0.0125),
            ("123456789012345678901234567890", 123_456_789_012_345_678_901_234_567_890.0),
            ("9007199254740993", 9_007_199_254_740_993.0),
            ("0.1234567890123456789D0", 0.123_456_789_012_345_68),
            ("1e-400", 0.0),
            ("1e99999999999999999999", f64::INFINITY),
        ] {
            assert_eq!(number(text.as_bytes(), b'.'), Some((value, text.len())), "{text}");
            let comma = text.replace('.', ",");
            assert_eq!(number(comma.as_bytes(), b','), Some((value, text.len())), "{comma}");
        }
        assert!(number(b"-0", b'.').unwrap().0.is_sign_negative());
    }

    #[test]
    fn a_number_ends_at_the_first_byte_that_cannot_continue_it() {
        for (text, length) in [("1e", 1), ("1e+", 1), ("1.5.2", 3), ("1,5", 1), ("2x", 1), ("1.e5", 4), ("3-4", 1)] {
            assert_eq!(number(text.as_bytes(), b'.').map(|found| found.1), Some(length), "{text}");
        }
        for text in ["", ".", "-", "+.", "e5", "nan", "inf", "--1", " 1", "-.e1"] {
            assert_eq!(number(text.as_bytes(), b'.'), None, "{text}");
        }
    }

    #[test]
    fn coordinates_are_finite_and_bounded() {
        assert_eq!(coordinate(b"-1e12", "a number"), Ok(-1e12));
        for word in ["1.0000001e12", "1e400", "nan", "-NaN", "inf", "-Infinity", "1.#QNAN"] {
            assert_eq!(coordinate(word.as_bytes(), "a number"), Err(unbounded(&quoted(word.as_bytes()))), "{word}");
        }
        assert_eq!(coordinate(b"1.2.3", "a number"), Err(Flaw::quoting("a number", b"1.2.3")));
    }

    #[test]
    fn the_first_decimal_mark_is_that_of_the_file() {
        let mut decimals = Decimals::default();
        let mut read = |word: &str| decimals.coordinate(word.as_bytes(), "a number");
        assert_eq!([read("7"), read("-0,5e1"), read("2,5"), read("3")], [Ok(7.0), Ok(-5.0), Ok(2.5), Ok(3.0)]);
        assert_eq!(read("1.5"), Err(Flaw::quoting("a number with a decimal comma, as before", b"1.5")));
        let mut decimals = Decimals::default();
        assert_eq!(decimals.coordinate(b"1.5", "a number"), Ok(1.5));
        let flaw = decimals.coordinate(b"1,5", "a number").unwrap_err().at_line(1).to_string();
        assert_eq!(flaw, "line 1: expected a number with a decimal point, found \"1,5\", with a decimal comma");
        assert_eq!(Decimals::default().coordinate(b"1,2,3", "a number"), Err(Flaw::quoting("a number", b"1,2,3")));
    }

    proptest! {
        #[test]
        fn agrees_with_the_standard_library_to_the_bit(text in "[+-]?([0-9]{1,24}(\\.[0-9]{0,24})?|\\.[0-9]{1,24})([eE][+-]?[0-9]{1,3})?") {
            let (value, length) = number(text.as_bytes(), b'.').unwrap();
            prop_assert_eq!(length, text.len());
            prop_assert_eq!(value.to_bits(), text.parse::<f64>().unwrap().to_bits());
        }

        #[test]
        fn a_double_survives_writing_and_reading(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            let text = format!("{value:e}");
            prop_assert_eq!(number(text.as_bytes(), b'.').unwrap().0.to_bits(), bits);
        }
    }

    #[test]
    fn comments_state_a_unit_or_are_prose() {
        for (comment, unit) in [
            ("# Units: mm", Some(Unit::Millimetre)),
            ("#units=inches", Some(Unit::Inch)),
            ("# File units = meters", Some(Unit::Metre)),
            ("# units are in centimetres", Some(Unit::Centimetre)),
            ("comment unit of length: ft", Some(Unit::Foot)),
            ("obj_info UNITS MM", Some(Unit::Millimetre)),
            ("# 1 unit = 25.4 mm", None),
            ("# unit cube", None),
            ("# units: see the manual in mm", None),
            ("# measured with unit 7", None),
            ("# unit", None),
            ("# mm", None),
        ] {
            let mut commented = CommentedUnit::default();
            commented.read(comment.as_bytes()).unwrap();
            assert_eq!(commented.unit(), unit, "{comment}");
        }
    }

    #[test]
    fn two_units_and_an_unsupported_one_are_refused() {
        let mut commented = CommentedUnit::default();
        commented.read(b"# units: mm").unwrap();
        commented.read(b"# units: mm").unwrap();
        assert_eq!(commented.read(b"# units: inches").unwrap_err().kind(), FileFaultKind::Ambiguous);
        assert_eq!(CommentedUnit::default().read(b"# units: km").unwrap_err().kind(), FileFaultKind::Malformed);
    }
}
