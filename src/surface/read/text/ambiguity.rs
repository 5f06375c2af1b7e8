//! Ambiguity of tables without a header. A comma can separate columns or be a decimal comma; lines of many numbers can
//! be points or a matrix of heights; the first column can be x or the number of the point.

use super::super::words::{number, trimmed};
use super::layout::Separator;
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

/// The most columns that a point with properties has: position, normal, colour with opacity, intensity and time.
const WIDEST_POINT: usize = 12;

/// The number of columns of a table that usually has points.
const POINT: usize = 3;

/// The largest number of lines that are examined. The limit saves time, because an examined line is parsed twice.
const MOST_LINES: u64 = 10_000;

/// The smallest number of lines from which anything is concluded; fewer points are no surface.
const FEWEST_LINES: u64 = 3;

/// The largest number of rows of a matrix of heights for each column. A longer table with more than three columns can
/// be a matrix only if its columns have similar ranges.
const LONGEST_MATRIX: u64 = 50;

/// Three columns can be a matrix of heights if the numbers in each line differ by less than this share of the range of
/// all numbers. As points, they would all lie near the line x = y = z.
const LARGEST_DIFFERENCE: f64 = 0.25;

/// The statistics of a table in which every line examined has the same number of columns, at least three, and only
/// numbers.
#[derive(Debug)]
pub(super) struct TextEvidence {
    separator: Separator,
    columns: Vec<Column>,
    lines: u64,
    /// For each column after the third: whether it and the next two are a unit vector in every line.
    unit_vectors: Vec<bool>,
    /// The largest difference between two numbers of a line.
    largest_difference: f64,
    /// The difference of the first column from line to line, as long as it is constant.
    step: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Column {
    last: f64,
    least: f64,
    most: f64,
    /// Whether no number has a decimal mark or an exponent.
    is_whole: bool,
}

impl TextEvidence {
    /// The statistics of a table that begins with `line`; `None` if the line has fewer than three columns or a field that
    /// is not a number.
    pub(super) fn of(line: &[u8], separator: Separator) -> Option<Self> {
        let numbers = numbers(line, separator)?;
        let columns = numbers.map(|(value, is_whole)| Column { last: value, least: value, most: value, is_whole });
        let columns: Vec<Column> = columns.collect();
        let unit_vectors = vec![true; columns.len().checked_sub(POINT)?];
        let mut evidence = Self { separator, columns, lines: 0, unit_vectors, largest_difference: 0.0, step: None };
        evidence.count();
        Some(evidence)
    }

    /// The number of columns.
    pub(super) fn width(&self) -> usize {
        self.columns.len()
    }

    /// The largest number of lines that are examined. A table of three columns can be a matrix only if it is short.
    fn most_lines(&self) -> u64 {
        if self.width() == POINT { POINT as u64 * LONGEST_MATRIX + 1 } else { MOST_LINES }
    }

    /// Whether enough lines have been examined.
    pub(super) fn is_complete(&self) -> bool {
        self.lines == self.most_lines()
    }

    /// Adds the next line; returns false if it has another number of columns.
    pub(super) fn look_at(&mut self, line: &[u8]) -> bool {
        if self.is_complete() {
            return true;
        }
        let before = self.columns[0];
        let Some(numbers) = numbers(line, self.separator) else { return false };
        let mut width = 0;
        for (value, is_whole) in numbers {
            let Some(column) = self.columns.get_mut(width) else { return false };
            *column =
                Column { last: value, least: column.least.min(value), most: column.most.max(value), is_whole: column.is_whole && is_whole };
            width += 1;
        }
        let step = self.columns[0].last - before.last;
        self.step = if self.lines == 1 { Some(step) } else { self.step.filter(|first| first.to_bits() == step.to_bits()) };
        self.count();
        width == self.columns.len()
    }

    fn count(&mut self) {
        self.lines += 1;
        for (index, is_unit) in self.unit_vectors.iter_mut().enumerate() {
            let square: f64 = self.columns[index + POINT..].iter().take(3).map(|column| column.last * column.last).sum();
            *is_unit &= index + POINT + 3 <= self.columns.len() && (square.sqrt() - 1.0).abs() < 0.01;
        }
        let (least, most) = range(self.columns.iter().map(|column| [column.last; 2]));
        self.largest_difference = self.largest_difference.max(most - least);
    }

    /// Whether the first column can number the lines: it has whole numbers that rise by a constant amount, and three
    /// more columns follow.
    pub(super) fn is_numbered(&self) -> bool {
        self.width() > POINT && self.lines >= FEWEST_LINES && self.columns[0].is_whole && self.step.is_some_and(|step| step > 0.0)
    }

    /// Whether a table of `lines` lines can be a matrix of heights.
    pub(super) fn can_be_matrix(&self, lines: u64) -> bool {
        if lines < FEWEST_LINES {
            false
        } else if self.width() == POINT {
            self.can_be_narrow_matrix(lines)
        } else {
            self.can_be_wide_matrix(lines)
        }
    }

    /// Whether three columns can be a matrix of heights. They are nearly always points, so evidence against points is
    /// required: numbers that are nearly equal in each line.
    fn can_be_narrow_matrix(&self, lines: u64) -> bool {
        let (least, most) = range(self.columns.iter().map(|column| [column.least, column.most]));
        lines <= POINT as u64 * LONGEST_MATRIX && self.largest_difference < LARGEST_DIFFERENCE * (most - least)
    }

    /// Whether more than three columns can be a matrix of heights. They are points if a normal, a colour or whole
    /// numbers follow coordinates with decimals. They are also points if the table is far longer than wide, unless
    /// adjacent columns have similar ranges.
    fn can_be_wide_matrix(&self, lines: u64) -> bool {
        let (coordinates, further) = self.columns.split_at(POINT);
        let has_normal = self.unit_vectors.contains(&true);
        let has_decimals = !coordinates.iter().all(|column| column.is_whole);
        let is_colour = |columns: &[Column]| {
            let is_channel = |column: &Column| column.is_whole && column.least >= 0.0 && column.most <= 255.0;
            columns.iter().all(is_channel) && columns.iter().any(|column| column.most > 0.0)
        };
        let has_colour = further.windows(3).any(is_colour);
        let has_whole_numbers = further.iter().any(|column| column.is_whole && column.least < column.most);
        // Probe logs write the positions of axes that did not move.
        let is_constant = |column: &Column| column.least.to_bits() == column.most.to_bits();
        let has_no_heights = further.iter().all(is_constant) && !coordinates.iter().all(is_constant);
        let has_properties = has_normal || has_no_heights || (has_decimals && (has_colour || has_whole_numbers));
        let is_long = lines > LONGEST_MATRIX * self.width() as u64;
        !has_properties && (!is_long || self.columns.windows(2).all(|pair| are_alike(pair[0], pair[1])))
    }
}

/// The smallest and the largest number in these ranges.
fn range(ranges: impl Iterator<Item = [f64; 2]>) -> (f64, f64) {
    ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), [low, high]| (least.min(low), most.max(high)))
}

/// Whether the ranges of two columns share at least half of the wider one.
fn are_alike(one: Column, other: Column) -> bool {
    let shared = one.most.min(other.most) - one.least.max(other.least);
    shared >= 0.5 * (one.most - one.least).max(other.most - other.least)
}

/// The numbers in a line, each with whether it is written as a whole number; `None` if a field is something else.
/// Empty fields are left out: a separator may stand at the end of each line.
fn numbers(line: &[u8], separator: Separator) -> Option<impl Iterator<Item = (f64, bool)>> {
    let mut numbers = [(0.0, false); WIDEST_POINT + 1];
    let mut count = 0;
    for field in separator.fields(line).filter(|field| !field.is_empty()) {
        let number = number_in(field)?;
        // Numbers beyond the largest count are counted as one.
        numbers[count.min(WIDEST_POINT)] = number;
        count += 1;
    }
    Some(numbers.into_iter().take(count))
}

/// The number in `field`, if the field is nothing else; it may be in quotation marks and have either decimal mark. Also
/// whether it is written as a whole number.
fn number_in(field: &[u8]) -> Option<(f64, bool)> {
    let bare = field.strip_prefix(b"\"").and_then(|field| field.strip_suffix(b"\"")).unwrap_or(field);
    let whole = |mark| number(bare, mark).filter(|(_, length)| *length == bare.len());
    let (value, _) = whole(b'.').or_else(|| whole(b','))?;
    Some((value, bare.iter().all(|byte| byte.is_ascii_digit() || matches!(byte, b'-' | b'+'))))
}
