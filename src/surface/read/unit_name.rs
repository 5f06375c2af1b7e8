//! Names of units of length, in headers of tables and in comments.

use crate::file_fault::{FileFaultKind, Flaw};
use crate::surface::Unit;

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
