//! Reader of points in text, as spreadsheets, measuring machines and scanners write them: a point in each line, with
//! its coordinates in columns.
//!
//! The first line of data determines the separator of the file: the first of semicolon, tab, comma and blanks that
//! yields three numbers. A line `sep=;` states it. The decimal mark is a point, or a comma if the comma does not
//! separate columns; the first coordinate with a mark determines it. A header may name the columns x, y and z, in any
//! order and case, and their unit. It may be a comment, and a row of units may follow it. Without a header, x, y and z
//! are the first three columns. Every line must have as many columns as the header or the first line. A line with one
//! whole number before the points is their count, as in PTS. Lines that are blank or begin with `#` or `//` are
//! comments.
//!
//! A table that can be read in two ways is refused with [`FileFaultKind::Ambiguous`].

mod ambiguity;
mod layout;
mod probe;
mod table_header;

use super::extremes::CoordinateRange;
use super::input::{Input, ReadError};
use super::words::{trimmed, trimmed_start, unsigned};
use super::{Format, Notes, ReadSummary, Sink};
use crate::file_fault::{FileFaultKind, Flaw};
use crate::surface;
use ambiguity::Ambiguity;
use layout::{Layout, Separator};
use probe::{Probe, Verdict};
use std::borrow::Cow;
use table_header::TableHeader;

/// Reads points in text.
pub(super) fn read(input: &mut Input, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
    let mut table = Table::default();
    input.each_line(|line, number| table.line(line, number, sink))?;
    table.probe.flush(&mut table.points, &mut table.extremes, sink);
    if let Some(flaw) = table.probe.flaw(table.points) {
        return Err(flaw.into());
    }
    if table.points == 0 {
        return Err(Flaw::new(FileFaultKind::Empty, "three numbers", "the end of the file").at_line(input.number_at_end()).into());
    }
    if let Some((count, line)) = table.count.filter(|(count, _)| *count != table.points) {
        let found = format!("{} lines of data; either points are missing or too many, or the line is no count", table.points);
        return Err(Flaw::new(FileFaultKind::Ambiguous, format!("{count} points, as this line counts them"), found).at_line(line).into());
    }
    let has_mark = table.layout.is_some_and(|layout| layout.mark.is_some());
    if let Some((flaw, line)) = table.ambiguity.as_ref().and_then(|ambiguity| ambiguity.flaw(table.points, has_mark)) {
        return Err(flaw.at_line(line).into());
    }
    let notes = Notes { further_columns: table.further_columns, far_outside: table.extremes.far_outside(), ..Notes::default() };
    Ok(ReadSummary { format: Format::Text, points: table.points, facets: 0, unit: table.unit, notes })
}

#[derive(Debug, Default)]
struct Table {
    /// The separator that a line `sep=` states.
    stated: Option<Separator>,
    header: Option<TableHeader>,
    /// The last comment that can be a header.
    comment: Option<TableHeader>,
    unit: Option<surface::Unit>,
    /// The count of points that a line before them states, and the number of that line.
    count: Option<(u64, u64)>,
    layout: Option<Layout>,
    ambiguity: Option<Ambiguity>,
    probe: Probe,
    extremes: CoordinateRange,
    points: u64,
    further_columns: u64,
}

impl Table {
    fn line(&mut self, line: &[u8], number: u64, sink: &mut dyn Sink) -> Result<(), Flaw> {
        let content = trimmed_start(line);
        if content.is_empty() {
            self.probe.blank();
            return Ok(());
        }
        if content[0] == b'#' || content.starts_with(b"//") {
            if self.layout.is_none() {
                self.comment(content);
            }
            return Ok(());
        }
        let point = if let Some(layout) = &mut self.layout {
            match layout.point(line) {
                Ok(point) => point,
                Err(flaw) => point_between_hard_blanks(layout, line).unwrap_or(Err(flaw))?,
            }
        } else {
            let cleaned = without_hard_blanks(line);
            let Some(point) = self.first(&cleaned, number)? else { return Ok(()) };
            if matches!(cleaned, Cow::Owned(_)) && self.layout.is_some_and(|layout| layout.separator == Separator::Blanks) {
                refuse_mixed_blanks(line)?;
            }
            self.pass(point, line, number, sink)?;
            return Ok(());
        };
        if let Some(ambiguity) = &mut self.ambiguity {
            ambiguity.look_at(&without_hard_blanks(line));
        }
        self.pass(point, line, number, sink)
    }

    /// Passes the point of a line on, unless it may be a line before a grid.
    fn pass(&mut self, point: [f64; 3], line: &[u8], number: u64, sink: &mut dyn Sink) -> Result<(), Flaw> {
        if self.probe.is_open() && self.header.is_none() && self.count.is_none() {
            match self.probe.add(point, number) {
                Verdict::Held => return Ok(()),
                Verdict::Points => self.probe.flush(&mut self.points, &mut self.extremes, sink),
                Verdict::Grid => {
                    // Only the lines after the header show what the columns are.
                    let layout = self.layout.unwrap_or_else(|| unreachable!("the first point has set it"));
                    self.ambiguity = Some(Ambiguity::about(line, layout.separator, number)?);
                }
            }
        }
        self.points += 1;
        self.extremes.add(point, number);
        sink.point(point);
        Ok(())
    }

    /// Stores a comment before the data if it can be a header.
    fn comment(&mut self, comment: &[u8]) {
        let content = without_hard_blanks(comment);
        let content = trimmed_start(content.strip_prefix(b"//").unwrap_or_else(|| &content[1..]));
        if let Ok(Some(header)) = TableHeader::read(content, self.separators()) {
            self.comment = Some(header);
        }
    }

    fn separators(&self) -> &'static [Separator] {
        let all = &Separator::ALL;
        self.stated.and_then(|stated| all.iter().position(|separator| *separator == stated)).map_or(all, |at| &all[at..=at])
    }

    /// Reads a line before the second line of data: a header, a row of units, a count, a separator, or the first data.
    /// Returns a point for data only.
    fn first(&mut self, line: &[u8], number: u64) -> Result<Option<[f64; 3]>, Flaw> {
        if self.header.is_none()
            && let Some(separator) = stated_separator(line)
        {
            self.stated = Some(separator?);
            return Ok(None);
        }
        for separator in self.separators() {
            let fields = separator.fields(line).count();
            let header = self.header.or_else(|| self.comment.filter(|comment| comment.width == fields || comment.width == 3));
            let columns = header.map_or([(0, 0), (1, 1), (2, 2)], |header| header.columns);
            let is_last_empty = fields > 3 && separator.fields(line).last().is_some_and(<[u8]>::is_empty);
            let width = self.header.map_or(fields - usize::from(is_last_empty), |header| header.width);
            let mut layout = Layout { separator: *separator, mark: None, columns, width, is_named: self.header.is_some() };
            match layout.point(line) {
                Ok(point) => {
                    if header.is_none() && self.count.is_none() {
                        self.ambiguity = Some(Ambiguity::about(line, *separator, number)?);
                    }
                    self.unit = self.unit.or(header.and_then(|header| header.unit));
                    self.layout = Some(layout);
                    self.further_columns = fields.saturating_sub(3) as u64;
                    return Ok(Some(point));
                }
                Err(flaw) if matches!(flaw.kind(), FileFaultKind::OutOfRange | FileFaultKind::Ambiguous) => return Err(flaw),
                Err(_) => {}
            }
        }
        if let Some(header) = &self.header {
            if let Some(unit) = header.units_row(line, self.separators())?.filter(|_| self.unit.is_none()) {
                self.unit = Some(unit);
                return Ok(None);
            }
        } else if let Some(header) = TableHeader::read(line, self.separators())? {
            self.header = Some(header);
            return Ok(None);
        } else if self.count.is_none()
            && let Some(count) = unsigned(trimmed(line))
        {
            self.count = Some((count, number));
            return Ok(None);
        }
        Err(self.no_point(trimmed(line)))
    }

    #[cold]
    fn no_point(&self, line: &[u8]) -> Flaw {
        let separator = Separator::ALL.into_iter().max_by_key(|separator| separator.fields(line).count()).unwrap_or(Separator::Blanks);
        let fields = separator.fields(line).count();
        let numbers = separator
            .fields(line)
            .take_while(|field| field.first().is_some_and(|byte| matches!(byte, b'0'..=b'9' | b'-' | b'+' | b'.')))
            .count();
        match (&self.header, numbers) {
            (Some(header), _) if numbers >= 3 && fields != header.width => {
                Flaw::new(FileFaultKind::Malformed, format!("{} columns, as the header names", header.width), fields.to_string())
            }
            (Some(header), _) if header.columns[2].0 > 2 => Flaw::quoting("numbers in the columns that the header names x, y and z", line),
            (_, 1) => Flaw::new(FileFaultKind::Malformed, "three numbers", "one"),
            (_, 2) => Flaw::new(FileFaultKind::Malformed, "three numbers", "two"),
            (Some(_), _) => Flaw::quoting("three numbers", line),
            (None, _) => Flaw::quoting("three numbers, or a header that names x, y and z", line),
        }
    }
}

/// The separator that a line such as `sep=;` states, as Excel reads and writes it.
fn stated_separator(line: &[u8]) -> Option<Result<Separator, Flaw>> {
    let line = trimmed_start(line);
    let stated = line.get(4..).filter(|_| line[..4].eq_ignore_ascii_case(b"sep="))?;
    Some(match stated {
        b";" => Ok(Separator::Semicolon),
        b"," => Ok(Separator::Comma),
        b"\t" => Ok(Separator::Tab),
        b" " => Ok(Separator::Blanks),
        other => Err(Flaw::quoting("a semicolon, comma, tab or blank after sep=", other)),
    })
}

/// `line` with ordinary blanks in place of no-break spaces, in UTF-8 and in Latin-1.
fn without_hard_blanks(line: &[u8]) -> Cow<'_, [u8]> {
    if memchr::memchr2(0xa0, 0xaf, line).is_none() {
        return Cow::Borrowed(line);
    }
    let mut cleaned = Vec::with_capacity(line.len());
    let mut rest = line;
    while let Some((&byte, after)) = rest.split_first() {
        // A no-break space, a narrow one, and one in Latin-1 that is not a part of a longer UTF-8 character.
        let skipped = match rest {
            [0xc2, 0xa0, ..] => 2,
            [0xe2, 0x80, 0xaf, ..] => 3,
            [0xa0, ..] if cleaned.last().is_none_or(u8::is_ascii) => 1,
            _ => 0,
        };
        if skipped > 0 {
            cleaned.push(b' ');
            rest = &rest[skipped..];
        } else {
            cleaned.push(byte);
            rest = after;
        }
    }
    Cow::Owned(cleaned)
}

/// The point of a line with no-break spaces; `None` if it has none.
#[cold]
fn point_between_hard_blanks(layout: &mut Layout, line: &[u8]) -> Option<Result<[f64; 3], Flaw>> {
    let Cow::Owned(cleaned) = without_hard_blanks(line) else { return None };
    if layout.separator == Separator::Blanks
        && let Err(flaw) = refuse_mixed_blanks(line)
    {
        return Some(Err(flaw));
    }
    Some(layout.point(&cleaned))
}

/// Refuses a line with both ordinary and no-break spaces, because the latter could separate thousands.
fn refuse_mixed_blanks(line: &[u8]) -> Result<(), Flaw> {
    let is_mixed = trimmed(line).iter().any(|byte| matches!(byte, b' ' | b'\t'));
    let found = "ordinary and no-break spaces; either all separate numbers, or the no-break ones separate thousands";
    if is_mixed { Err(Flaw::new(FileFaultKind::Ambiguous, "one kind of space between numbers", found)) } else { Ok(()) }
}
