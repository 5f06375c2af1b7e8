//! Points in lines of text, as spreadsheets, measuring machines and scanners write them: a point a line, its coordinates in
//! columns.
//!
//! The first line of data shows the separator, which then holds for the file: semicolon, tab, comma, or blanks, whichever first
//! makes three numbers of it. The decimal mark is a point, or, where the separator is not the comma, a comma; the first
//! coordinate that has a mark decides. A header may name the columns x, y and z, in any order and case, with other columns beside
//! them; without one they are the first three. Lines that are blank or begin with `#` or `//` are skipped.

use super::blocks::{BlockOutcome, BlockSplitter, TextBlock};
use super::decimal::{bounded, names_no_finite_number, number, unbounded};
use super::fault::{Fault, FaultKind, Flaw, quoted};
use super::lines::{Lines, trimmed, trimmed_start};
use super::{Format, Notes, Sink, Summary};

/// What stands between columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Semicolon,
    Tab,
    Comma,
    /// Any run of spaces and tabs.
    Blanks,
}

impl Separator {
    /// In the order in which they are tried: where a line can be read with two of them, the first is meant. Decimal commas leave
    /// `1,5;2,5;3,5` to the semicolon, and `1, 2, 3` is not three numbers between blanks.
    const ALL: [Self; 4] = [Self::Semicolon, Self::Tab, Self::Comma, Self::Blanks];

    fn byte(self) -> u8 {
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

    /// Splits a field and the separator after it off `rest`; what remains is `None` at the end of the line.
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

    fn fields(self, line: &[u8]) -> impl Iterator<Item = &[u8]> {
        let mut rest = Some(line);
        std::iter::from_fn(move || {
            let (field, after) = self.split(rest?);
            rest = after;
            Some(field)
        })
    }
}

/// Where the quotation ends with which `text` begins; a doubled quotation mark does not end it.
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

/// How the lines of a file are to be understood.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    separator: Separator,
    /// The decimal mark, once a coordinate has shown it.
    mark: Option<u8>,
    /// Column and axis of the three coordinates, by rising column.
    columns: [(usize, usize); 3],
}

impl Layout {
    /// The point in `line`.
    fn point(&mut self, line: &[u8]) -> Result<[f64; 3], Flaw> {
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
        Ok(point)
    }

    /// The number at the start of `rest`, and what follows the separator after it.
    #[inline]
    fn number<'a>(&mut self, rest: &'a [u8]) -> Result<(f64, Option<&'a [u8]>), Flaw> {
        let start = match self.separator {
            Separator::Tab => rest,
            _ => trimmed_start(rest),
        };
        let mark = self.mark.unwrap_or(b'.');
        if let Some((value, length)) = number(start, mark)
            && let Some(rest) = self.after(&start[length..])
        {
            let token = &start[..length];
            if self.mark.is_none() && token.contains(&mark) {
                self.mark = Some(mark);
            }
            return Ok((bounded(value, token)?, rest));
        }
        self.odd_number(start)
    }

    /// What follows the separator at the start of `rest`; the outer `None` where no separator stands there.
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

    /// A number with a decimal comma as the first mark of the file, in quotation marks, or after blanks in a column between tabs;
    /// else the reason why it is none.
    fn odd_number<'a>(&mut self, rest: &'a [u8]) -> Result<(f64, Option<&'a [u8]>), Flaw> {
        let (field, after) = self.separator.split(rest);
        let bare = trimmed(field.strip_prefix(b"\"").and_then(|field| field.strip_suffix(b"\"")).unwrap_or(field));
        let whole = |mark| number(bare, mark).filter(|(_, length)| *length == bare.len());
        let (value, mark) = match (self.mark, self.separator) {
            (Some(mark), _) => (whole(mark), mark),
            (None, Separator::Comma) => (whole(b'.'), b'.'),
            (None, _) => whole(b'.').map_or_else(|| (whole(b','), b','), |found| (Some(found), b'.')),
        };
        match value {
            Some((value, _)) => {
                if bare.contains(&mark) {
                    self.mark = Some(mark);
                }
                Ok((bounded(value, bare)?, after))
            }
            None if names_no_finite_number(bare) => Err(unbounded(&quoted(bare))),
            None => Err(Flaw::malformed(self.expected_number(), field)),
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
        Flaw::new(FaultKind::Malformed, self.separator.name(), ["none", "one", "two"][read.min(2)])
    }
}

/// The reader of points in text.
#[derive(Debug)]
pub(super) struct Reader {
    lines: Lines,
    table: Table,
    blocks: BlockSplitter,
}

#[derive(Debug)]
struct Table {
    /// What a header has said.
    columns: Option<[(usize, usize); 3]>,
    layout: Option<Layout>,
    points: u64,
    further_columns: u64,
}

impl Reader {
    pub(super) fn new() -> Self {
        let table = Table { columns: None, layout: None, points: 0, further_columns: 0 };
        Self { lines: Lines::after(0), table, blocks: BlockSplitter::default() }
    }

    pub(super) fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        self.lines.push(chunk, |line, _| self.table.line(line, sink))
    }

    /// Takes the next bytes of a text of which all come this way. Lots are put off to `blocks` as soon as they can be: once the lines before
    /// have shown how all are to be understood.
    pub(super) fn push_in_blocks<S: Sink>(&mut self, mut chunk: &[u8], sink: &mut S, blocks: &mut Vec<TextBlock>) -> Result<(), Fault> {
        while !chunk.is_empty() {
            let Some(lines) = self.blocks.next(&mut chunk) else { continue };
            match self.table.layout {
                Some(layout) if layout.mark.is_some() => blocks.push(TextBlock::new(lines, layout)),
                _ => self.push(&lines, sink)?,
            }
        }
        Ok(())
    }

    /// Takes note of what was in the next of the blocks that were put off.
    pub(super) fn record_block(&mut self, read: BlockOutcome) -> Result<(), Fault> {
        self.table.points += read.points;
        let before = self.lines.ended();
        self.lines.skip(read.lines);
        read.result.map_err(|fault| fault.after_lines(before))
    }

    pub(super) fn finish<S: Sink>(mut self, sink: &mut S) -> Result<Summary, Fault> {
        let rest = std::mem::take(&mut self.blocks).rest();
        self.push(&rest, sink)?;
        self.lines.finish(|line, _| self.table.line(line, sink))?;
        if self.table.points == 0 {
            return Err(Flaw::new(FaultKind::Empty, "three numbers", "the end of the file").at_line(self.lines.number()));
        }
        let notes = Notes { further_columns: self.table.further_columns, ..Notes::default() };
        Ok(Summary { format: Format::Text, points: self.table.points, facets: 0, unit: None, notes })
    }
}

/// Reads lines that all are to be understood in the same way.
pub(super) fn read_block<S: Sink>(text: &[u8], layout: Layout, sink: &mut S) -> BlockOutcome {
    let mut lines = Lines::after(0);
    let mut table = Table { columns: None, layout: Some(layout), points: 0, further_columns: 0 };
    let result = lines.push(text, |line, _| table.line(line, sink));
    BlockOutcome { lines: lines.ended(), points: table.points, result }
}

impl Table {
    fn line<S: Sink>(&mut self, line: &[u8], sink: &mut S) -> Result<(), Flaw> {
        let content = trimmed_start(line);
        if content.is_empty() || content[0] == b'#' || content.starts_with(b"//") {
            return Ok(());
        }
        let point = match &mut self.layout {
            Some(layout) => layout.point(line)?,
            None => match self.first(line)? {
                Some(point) => point,
                None => return Ok(()),
            },
        };
        self.points += 1;
        sink.point(point);
        Ok(())
    }

    /// Understands a line before any data: the first of them, or the header, which has no point.
    fn first(&mut self, line: &[u8]) -> Result<Option<[f64; 3]>, Flaw> {
        let columns = self.columns.unwrap_or([(0, 0), (1, 1), (2, 2)]);
        for separator in Separator::ALL {
            let mut layout = Layout { separator, mark: None, columns };
            match layout.point(line) {
                Ok(point) => {
                    self.layout = Some(layout);
                    self.further_columns = separator.fields(line).count().saturating_sub(3) as u64;
                    return Ok(Some(point));
                }
                Err(flaw) if flaw.kind() == FaultKind::OutOfRange => return Err(flaw),
                Err(_) => {}
            }
        }
        if self.columns.is_none()
            && let Some(columns) = header(line)
        {
            self.columns = Some(columns);
            return Ok(None);
        }
        Err(self.no_point(trimmed(line)))
    }

    #[cold]
    fn no_point(&self, line: &[u8]) -> Flaw {
        let in_columns = self.columns.is_some_and(|columns| columns[2].0 > 2);
        let separator = Separator::ALL.into_iter().max_by_key(|separator| separator.fields(line).count()).unwrap_or(Separator::Blanks);
        let numbers = separator
            .fields(line)
            .take_while(|field| field.first().is_some_and(|byte| matches!(byte, b'0'..=b'9' | b'-' | b'+' | b'.')))
            .count();
        match numbers {
            _ if in_columns => Flaw::malformed("numbers in the columns that the header names x, y and z", line),
            1 => Flaw::new(FaultKind::Malformed, "three numbers", "one"),
            2 => Flaw::new(FaultKind::Malformed, "three numbers", "two"),
            _ if self.columns.is_some() => Flaw::malformed("three numbers", line),
            _ => Flaw::malformed("three numbers, or a header that names x, y and z", line),
        }
    }
}

/// The columns that a header names x, y and z, by rising column.
fn header(line: &[u8]) -> Option<[(usize, usize); 3]> {
    Separator::ALL.into_iter().find_map(|separator| {
        // Between blanks, a unit in brackets after a name is no column of its own.
        let is_name = |field: &&[u8]| separator != Separator::Blanks || !matches!(field.first(), Some(b'[' | b'('));
        let names: Vec<&[u8]> = separator.fields(line).filter(is_name).collect();
        let mut columns = [(0, 0); 3];
        for (axis, letter) in [b'x', b'y', b'z'].into_iter().enumerate() {
            let leads = |name: &&[u8]| name_words(name).next().is_some_and(|word| is_letter(word, letter));
            let contains = |name: &&[u8]| name_words(name).any(|word| is_letter(word, letter));
            let column = names.iter().position(leads).or_else(|| names.iter().position(contains))?;
            columns[axis] = (column, axis);
        }
        columns.sort_unstable();
        let distinct = columns[0].0 < columns[1].0 && columns[1].0 < columns[2].0;
        distinct.then_some(columns)
    })
}

/// The words of a column's name: `X [mm]`, `"pos_x"` and `x(mm)` all have the word x.
fn name_words(name: &[u8]) -> impl Iterator<Item = &[u8]> {
    name.split(|byte| !byte.is_ascii_alphanumeric() && byte.is_ascii()).filter(|word| !word.is_empty())
}

fn is_letter(word: &[u8], letter: u8) -> bool {
    word.eq_ignore_ascii_case(&[letter])
}
