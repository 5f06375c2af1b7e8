//! Ambiguity of tables without a header. A comma can separate columns or be a decimal comma; lines of many numbers can
//! be points or a matrix of heights; the first column can be x or the number of the point.

use super::super::words::trimmed;
use super::layout::Separator;
use super::text_evidence::{TextEvidence, WIDEST_POINT};
use crate::file_fault::{FileFaultKind, Flaw, quoted};

/// The interpretations that are still possible after the lines so far.
#[derive(Debug)]
pub(super) struct Ambiguity {
    first_line: u64,
    first: String,
    /// The smallest and the largest number of fields of a line; `None` once a line cannot have decimal commas.
    commas: Option<(usize, usize)>,
    /// The statistics of the columns; `None` once a line has another number of columns, or fewer than three numbers.
    columns: Option<Box<TextEvidence>>,
}

impl Ambiguity {
    /// The possible interpretations of a table whose first line of data is `line`.
    ///
    /// # Errors
    /// The line has too many numbers for a point.
    pub(super) fn about(line: &[u8], separator: Separator, number: u64) -> Result<Self, Flaw> {
        let columns = TextEvidence::of(line, separator).map(Box::new);
        if columns.as_ref().is_some_and(|columns| columns.width() > WIDEST_POINT) {
            let found = format!(
                "more of them; either a row of a matrix of heights, or a point and its properties, which a header would name; {AS_POINTS}"
            );
            return Err(Flaw::new(FileFaultKind::Ambiguous, format!("at most {WIDEST_POINT} numbers in a line without a header"), found));
        }
        let commas = (separator == Separator::Comma).then_some((usize::MAX, 0));
        let mut ambiguity = Self { first_line: number, first: quoted(trimmed(line)), commas, columns };
        ambiguity.look_at_commas(line);
        Ok(ambiguity)
    }

    /// Adds a line of data after the first.
    pub(super) fn look_at(&mut self, line: &[u8]) {
        self.look_at_commas(line);
        if self.columns.as_mut().is_some_and(|columns| !columns.look_at(line)) {
            self.columns = None;
        }
    }

    fn look_at_commas(&mut self, line: &[u8]) {
        if let Some((least, most)) = self.commas {
            self.commas = decimal_comma_fields(line).map(|count| (least.min(count), most.max(count)));
        }
    }

    /// The flaw of a table of `points` lines that is ambiguous, and the line to report. `has_mark` states that a number
    /// had a decimal point, so that commas separate columns.
    pub(super) fn flaw(&self, points: u64, has_mark: bool) -> Option<(Flaw, u64)> {
        if let Some((least, most)) = self.commas.filter(|_| !has_mark)
            && (least == 6 || least != most)
        {
            let found = format!("{}: either {most} columns between commas, or three numbers with decimal commas", self.first);
            let expected = "a semicolon, tab or blank between numbers with decimal commas, or a decimal point";
            return Some((Flaw::new(FileFaultKind::Ambiguous, expected, found), self.first_line));
        }
        let columns = self.columns.as_ref()?;
        let width = columns.width();
        let found = if columns.is_numbered() {
            format!("{points} lines of {width} numbers, the first of which counts up: either x, or a number before x, y and z")
        } else if columns.can_be_matrix(points) && width == 3 {
            format!("{points} lines of three nearly equal numbers: either a matrix of heights, or points along x = y = z; {AS_POINTS}")
        } else if columns.can_be_matrix(points) {
            format!("{points} lines of {width} numbers: either a matrix of heights, or points and their properties; {AS_POINTS}")
        } else {
            return None;
        };
        Some((Flaw::new(FileFaultKind::Ambiguous, "a header that names x, y and z", found), self.first_line))
    }
}

/// The remedy if the table is a matrix of heights.
const AS_POINTS: &str = "send heights as points x, y, z";

/// The number of fields in a line that can also be three numbers with decimal commas, separated by commas. Such a line
/// has three to six whole numbers; of six, the second, fourth and sixth have no sign and no blank.
fn decimal_comma_fields(line: &[u8]) -> Option<usize> {
    let fields: Vec<&[u8]> = trimmed(line).split(|byte| *byte == b',').take(7).collect();
    let is_possible = |(index, field): (usize, &&[u8])| {
        let is_fraction = fields.len() == 6 && index % 2 == 1;
        let digits = if is_fraction { field } else { trimmed(field) };
        let digits = if is_fraction { digits } else { digits.strip_prefix(b"-").or(digits.strip_prefix(b"+")).unwrap_or(digits) };
        !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
    };
    ((3..=6).contains(&fields.len()) && fields.iter().enumerate().all(is_possible)).then_some(fields.len())
}
