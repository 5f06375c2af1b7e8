//! Tables without a header that can be read in two ways: as columns between commas or numbers with decimal commas, as
//! points or as a matrix of heights.

use super::super::decimal::number;
use super::super::fault::{FaultKind, Flaw, quoted};
use super::super::lines::trimmed;
use super::layout::Separator;

/// The largest number of numbers in a line that are taken for a point with properties: position, normal, colour with
/// opacity, intensity and time.
const WIDEST_POINT: usize = 12;

/// The readings that the lines so far leave open.
#[derive(Debug)]
pub(super) struct Doubt {
    first_line: u64,
    first: String,
    /// The smallest and the largest number of fields, while every line can be read with decimal commas.
    commas: Option<(usize, usize)>,
    /// The numbers in the first line, where it has nothing else and more than three.
    width: Option<usize>,
}

impl Doubt {
    /// The possible readings of a table whose first line of data is `line`.
    ///
    /// # Errors
    /// The line has too many numbers for a point.
    pub(super) fn about(line: &[u8], separator: Separator, number: u64) -> Result<Self, Flaw> {
        let fields = separator.fields(line).filter(|field| !field.is_empty());
        let is_number = |field: &[u8]| [b'.', b','].into_iter().any(|mark| is_whole(field, mark));
        let mut width = Some(0);
        for field in fields {
            width = width.filter(|_| is_number(field)).map(|width| width + 1);
        }
        if let Some(count) = width.filter(|width| *width > WIDEST_POINT) {
            let found =
                format!("{count} numbers; either a row of a matrix of heights, or a point and its properties, which a header would name");
            return Err(Flaw::new(FaultKind::Ambiguous, format!("at most {WIDEST_POINT} numbers in a line without a header"), found));
        }
        let commas = (separator == Separator::Comma).then_some((usize::MAX, 0));
        Ok(Self { first_line: number, first: quoted(trimmed(line)), commas, width: width.filter(|width| *width > 3) })
    }

    /// Adds a line of data, including the first one.
    pub(super) fn look_at(&mut self, line: &[u8]) {
        if let Some((least, most)) = self.commas {
            self.commas = decimal_comma_fields(line).map(|count| (least.min(count), most.max(count)));
        }
    }

    /// The flaw, with its line, of a table of `points` lines that can be read in two ways. With `has_mark`, a decimal
    /// point has shown that commas separate columns.
    pub(super) fn flaw(&self, points: u64, has_mark: bool) -> Option<(Flaw, u64)> {
        if let Some((least, most)) = self.commas.filter(|_| !has_mark)
            && (least == 6 || least != most)
        {
            let found = format!("{}: either {most} columns between commas, or three numbers with decimal commas", self.first);
            let expected = "a semicolon, tab or blank between numbers with decimal commas, or a decimal point";
            return Some((Flaw::new(FaultKind::Ambiguous, expected, found), self.first_line));
        }
        let width = self.width.filter(|width| *width as u64 == points)?;
        let found = format!("{width} lines of {width} numbers: either a square matrix of heights, or points and their properties");
        Some((Flaw::new(FaultKind::Ambiguous, "a header that names x, y and z", found), self.first_line))
    }
}

/// Whether the whole of `field` is a number.
fn is_whole(field: &[u8], mark: u8) -> bool {
    number(field, mark).is_some_and(|(_, length)| length == field.len())
}

/// The number of fields between commas in a line that can also be read as three numbers with decimal commas between
/// commas: three to six whole numbers, of which the second, fourth and sixth of six have no sign and no blank before
/// them.
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
