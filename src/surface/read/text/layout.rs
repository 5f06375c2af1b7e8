//! The layout of a text: how lines are split into columns and numbers.

use super::super::words::{bounded, names_no_finite_number, number, trimmed, trimmed_start, unbounded};
use crate::file_fault::{FileFaultKind, Flaw, quoted};

/// The separators of columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    Semicolon,
    Tab,
    Comma,
    /// Any run of spaces and tabs.
    Blanks,
}

impl Separator {
    /// The separators in the order in which they are tried; the first that fits is used. The semicolon comes before the
    /// comma because of `1,5;2,5;3,5`, and the comma before blanks because of `1, 2, 3`.
    pub(super) const ALL: [Self; 4] = [Self::Semicolon, Self::Tab, Self::Comma, Self::Blanks];

    pub(super) fn byte(self) -> u8 {
        match self {
            Self::Semicolon => b';',
            Self::Tab => b'\t',
            Self::Comma => b',',
            Self::Blanks => b' ',
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Semicolon => "three numbers between semicolons",
            Self::Tab => "three numbers between tabs",
            Self::Comma => "three numbers between commas",
            Self::Blanks => "three numbers between blanks",
        }
    }

    /// Splits `rest` into its first field and the text after the separator, which is `None` at the end of the line.
    fn split(self, rest: &[u8]) -> (&[u8], Option<&[u8]>) {
        let rest = if self == Self::Tab { rest } else { trimmed_start(rest) };
        let quotation = if rest.starts_with(b"\"") { quotation_end(rest) } else { 0 };
        let separates = |byte: &u8| *byte == self.byte() || (self == Self::Blanks && *byte == b'\t');
        match rest[quotation..].iter().position(separates) {
            None => (trimmed(rest), None),
            Some(at) => {
                let (field, rest) = (&rest[..quotation + at], &rest[quotation + at + 1..]);
                let rest = if self == Self::Blanks { trimmed_start(rest) } else { rest };
                (trimmed(field), (self != Self::Blanks || !rest.is_empty()).then_some(rest))
            }
        }
    }

    pub(super) fn fields(self, line: &[u8]) -> impl Iterator<Item = &[u8]> {
        let mut rest = Some(line);
        std::iter::from_fn(move || {
            let (field, after) = self.split(rest?);
            rest = after;
            Some(field)
        })
    }
}

/// The end of the quotation at the start of `text`; a doubled quotation mark does not end it.
fn quotation_end(text: &[u8]) -> usize {
    let mut at = 1;
    while let Some(byte) = text.get(at) {
        at += 1;
        if *byte == b'"' {
            if text.get(at) != Some(&b'"') {
                return at;
            }
            at += 1;
        }
    }
    at
}

/// The layout of the lines of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub(super) separator: Separator,
    /// The decimal mark, once a coordinate with one has been read.
    pub(super) mark: Option<u8>,
    /// Column and axis of the three coordinates, by rising column.
    pub(super) columns: [(usize, usize); 3],
    /// The number of columns, which every line must have.
    pub(super) width: usize,
    /// Whether a header names them.
    pub(super) is_named: bool,
}

impl Layout {
    /// The point in `line`.
    pub(super) fn point(&mut self, line: &[u8]) -> Result<[f64; 3], Flaw> {
        let mut point = [0.0; 3];
        let mut rest = Some(line);
        let mut column = 0;
        for (read, (wanted, axis)) in self.columns.into_iter().enumerate() {
            while column < wanted {
                rest = rest.and_then(|rest| self.separator.split(rest).1);
                column += 1;
            }
            let Some(field) = rest else { return Err(self.too_few(read)) };
            (point[axis], rest) = self.number(field)?;
            column += 1;
        }
        if rest.is_none() && column == self.width { Ok(point) } else { self.check_width(column, rest, self.width).map(|()| point) }
    }

    /// Checks that the `read` columns and those in `rest` are as many as in the header or the first line. A separator at the end of
    /// the line adds no column.
    fn check_width(&self, read: usize, rest: Option<&[u8]>, width: usize) -> Result<(), Flaw> {
        let further = match rest {
            None => 0,
            Some(rest) if trimmed(rest).is_empty() => usize::from(read < width),
            Some(rest) => {
                let (mut count, mut is_last_empty) = (0, false);
                for field in self.separator.fields(rest) {
                    count += 1;
                    is_last_empty = field.is_empty();
                }
                count - usize::from(is_last_empty && read + count > width)
            }
        };
        if read + further == width { Ok(()) } else { Err(self.unequal(read + further, width)) }
    }

    #[cold]
    fn unequal(&self, count: usize, width: usize) -> Flaw {
        let has = if self.is_named { "as the header names" } else { "as the first line has" };
        // With decimal commas, three numbers have three to six fields.
        let most = if self.is_named { 3 } else { 6 };
        if self.separator == Separator::Comma && (3..=most).contains(&width) && (3..=6).contains(&count) && self.mark != Some(b'.') {
            let found = format!("{count} fields; either {count} columns between commas, or three numbers with decimal commas");
            return Flaw::new(FileFaultKind::Ambiguous, format!("{width} columns, {has}"), found);
        }
        Flaw::new(FileFaultKind::Malformed, format!("{width} columns, {has}"), count.to_string())
    }

    /// The number at the start of `rest`, and the text after the separator that follows it.
    #[inline]
    fn number<'a>(&mut self, rest: &'a [u8]) -> Result<(f64, Option<&'a [u8]>), Flaw> {
        let start = match self.separator {
            Separator::Tab => rest,
            _ => trimmed_start(rest),
        };
        // If the comma separates columns, only a number in quotation marks can have a decimal comma.
        let mark = self.mark.filter(|_| self.separator != Separator::Comma).unwrap_or(b'.');
        if let Some((value, length)) = number(start, mark)
            && let Some(rest) = self.after(&start[length..])
        {
            let token = &start[..length];
            if self.mark != Some(mark) && token.contains(&mark) {
                if self.mark.is_some() {
                    return self.odd_number(start);
                }
                self.mark = Some(mark);
            }
            return Ok((bounded(value, token)?, rest));
        }
        self.odd_number(start)
    }

    /// The text after the separator at the start of `rest`; the outer `None` if there is no separator.
    #[inline]
    #[allow(clippy::option_option, reason = "the inner one is the end of the line, as everywhere here")]
    fn after<'a>(&self, rest: &'a [u8]) -> Option<Option<&'a [u8]>> {
        match rest.first() {
            None => Some(None),
            Some(byte) if *byte == self.separator.byte() && self.separator != Separator::Blanks => Some(Some(&rest[1..])),
            Some(b' ' | b'\t') => {
                let rest = trimmed_start(rest);
                match rest.first() {
                    None => Some(None),
                    Some(_) if self.separator == Separator::Blanks => Some(Some(rest)),
                    Some(byte) if *byte == self.separator.byte() => Some(Some(&rest[1..])),
                    Some(_) => None,
                }
            }
            Some(_) => None,
        }
    }

    /// The number in an unusual field: with a decimal comma as the first decimal mark of the file, in quotation marks,
    /// or after blanks in a line with tabs. The error is the reason why the field is not a number.
    fn odd_number<'a>(&mut self, rest: &'a [u8]) -> Result<(f64, Option<&'a [u8]>), Flaw> {
        let (field, after) = self.separator.split(rest);
        let quotation = field.strip_prefix(b"\"").and_then(|field| field.strip_suffix(b"\""));
        let bare = trimmed(quotation.unwrap_or(field));
        let whole = |mark| number(bare, mark).filter(|(_, length)| *length == bare.len());
        let (value, mark) = match self.mark {
            Some(mark) => (whole(mark), mark),
            None => whole(b'.').map_or_else(|| (whole(b','), b','), |found| (Some(found), b'.')),
        };
        if self.mark.is_none() && mark == b',' && self.separator == Separator::Comma && is_group_of_thousands(bare) {
            let found = format!("{}: either a decimal comma, or a comma between thousands", quoted(bare));
            return Err(Flaw::new(FileFaultKind::Ambiguous, "a decimal point, or a semicolon between columns", found));
        }
        match value {
            Some((value, _)) => {
                if bare.contains(&mark) {
                    self.mark = Some(mark);
                }
                Ok((bounded(value, bare)?, after))
            }
            None if names_no_finite_number(bare) => Err(unbounded(&quoted(bare))),
            None => Err(Flaw::quoting(self.expected_number(), field)),
        }
    }

    fn expected_number(&self) -> &'static str {
        match self.mark {
            Some(b',') => "a number with a decimal comma, as before",
            Some(_) if self.separator != Separator::Comma => "a number with a decimal point, as before",
            _ => "a number",
        }
    }

    #[cold]
    fn too_few(&self, read: usize) -> Flaw {
        Flaw::new(FileFaultKind::Malformed, self.separator.name(), ["none", "one", "two"][read.min(2)])
    }
}

/// Whether the comma in a number can separate thousands: one to three digits that do not begin with 0, the comma, and
/// three digits.
fn is_group_of_thousands(text: &[u8]) -> bool {
    let digits = text.strip_prefix(b"-").or_else(|| text.strip_prefix(b"+")).unwrap_or(text);
    let Some(at) = digits.iter().position(|byte| *byte == b',') else { return false };
    let (before, after) = (&digits[..at], &digits[at + 1..]);
    (1..=3).contains(&before.len()) && before[0] != b'0' && after.len() == 3 && before.iter().chain(after).all(u8::is_ascii_digit)
}
