//! Reader of PCD, the format of the Point Cloud Library, with data in text: a header that names the fields, then a
//! point in each line.
//!
//! The fields `x`, `y` and `z` are read, wherever they stand. Points with the coordinates `nan` are directions without
//! a measurement; they are counted and left out. Binary data are refused.

use super::decimal::{coordinate, names_no_finite_number};
use super::fault::{Fault, FaultKind, Flaw, quoted};
use super::lines::{Lines, Words, trimmed};
use super::{Format, Notes, Sink, Summary};

/// The largest number of fields of a point.
const MOST_FIELDS: usize = 1000;

/// The reader of PCD.
#[derive(Debug)]
pub(super) struct Reader {
    lines: Lines,
    content: Content,
}

#[derive(Debug, Default)]
struct Content {
    /// The names of the fields, while the header is read.
    fields: Vec<Vec<u8>>,
    /// The number of columns of each field.
    counts: Vec<usize>,
    /// The number of points in the header.
    stated: Option<u64>,
    data: Option<Data>,
    points: u64,
    missing: u64,
    trailing_bytes: u64,
}

#[derive(Debug)]
struct Data {
    /// The columns of x, y and z.
    columns: [usize; 3],
    /// The columns of a line.
    width: usize,
}

impl Reader {
    pub(super) fn new() -> Self {
        Self { lines: Lines::after(0), content: Content::default() }
    }

    pub(super) fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        self.lines.push(chunk, |line, _| self.content.line(line, sink))
    }

    pub(super) fn finish<S: Sink>(mut self, sink: &mut S) -> Result<Summary, Fault> {
        self.lines.finish(|line, _| self.content.line(line, sink))?;
        let number = self.lines.number();
        let Content { data, stated, points, missing, trailing_bytes, .. } = self.content;
        let end = "the end of the file";
        let Some(Data { width, .. }) = data else {
            return Err(Flaw::new(FaultKind::Truncated, "a header that ends with DATA", end).at_line(number));
        };
        let read = points + missing;
        if let Some(stated) = stated.filter(|stated| *stated != read) {
            let expected = format!("{stated} points, as the header states");
            return Err(Flaw::new(FaultKind::Truncated, expected, format!("{end} after {read}")).at_line(number));
        }
        if points == 0 {
            return Err(Flaw::new(FaultKind::Empty, "a point", end).at_line(number));
        }
        let notes = Notes { further_columns: (width - 3) as u64, missing_points: missing, trailing_bytes, ..Notes::default() };
        Ok(Summary { format: Format::Pcd, points, facets: 0, unit: None, notes })
    }
}

impl Content {
    fn line<S: Sink>(&mut self, line: &[u8], sink: &mut S) -> Result<(), Flaw> {
        let line = trimmed(line);
        if line.is_empty() || line[0] == b'#' {
            return Ok(());
        }
        let Some(data) = &self.data else { return self.header(line) };
        if self.stated.is_some_and(|stated| self.points + self.missing >= stated) {
            self.trailing_bytes += line.len() as u64;
            return Ok(());
        }
        let mut point = [None; 3];
        let mut count = 0;
        for word in Words::of(line) {
            if let Some(axis) = data.columns.iter().position(|column| *column == count) {
                point[axis] = Some(word);
            }
            count += 1;
        }
        let (Some(x), Some(y), Some(z), true) = (point[0], point[1], point[2], count == data.width) else {
            return Err(Flaw::new(FaultKind::Malformed, format!("{} numbers, as the header states", data.width), count.to_string()));
        };
        if [x, y, z].into_iter().any(names_no_finite_number) {
            self.missing += 1;
            return Ok(());
        }
        let number = |word| coordinate(word, "a number");
        let point = [number(x)?, number(y)?, number(z)?];
        self.points += 1;
        sink.point(point);
        Ok(())
    }

    fn header(&mut self, line: &[u8]) -> Result<(), Flaw> {
        let mut words = Words::of(line);
        match words.next().unwrap_or_default() {
            b"VERSION" | b"SIZE" | b"TYPE" | b"WIDTH" | b"HEIGHT" | b"VIEWPOINT" => Ok(()),
            b"FIELDS" | b"COLUMNS" => {
                self.fields = words.take(MOST_FIELDS).map(<[u8]>::to_vec).collect();
                Ok(())
            }
            b"COUNT" => {
                self.counts = words
                    .take(MOST_FIELDS)
                    .map(|word| whole(word).filter(|count| *count <= MOST_FIELDS as u64))
                    .map(|count| {
                        count
                            .and_then(|count| usize::try_from(count).ok())
                            .ok_or_else(|| Flaw::malformed("the column counts of the fields", line))
                    })
                    .collect::<Result<_, _>>()?;
                Ok(())
            }
            b"POINTS" => {
                let count = words.next().unwrap_or_default();
                self.stated = Some(whole(count).ok_or_else(|| Flaw::malformed("the number of points", count))?);
                Ok(())
            }
            b"DATA" => self.begin(words.next().unwrap_or_default()),
            other => Err(Flaw::malformed("VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS or DATA", other)),
        }
    }

    fn begin(&mut self, encoding: &[u8]) -> Result<(), Flaw> {
        if encoding != b"ascii" {
            let found = format!("PCD with the data {}; save it with the data ascii", quoted(encoding));
            return Err(Flaw::new(FaultKind::UnknownFormat, "PCD with the data ascii", found));
        }
        let mut columns = [None; 3];
        let mut width = 0;
        for (index, name) in self.fields.iter().enumerate() {
            let axis = [b"x", b"y", b"z"].into_iter().position(|axis| axis == name.as_slice());
            if let Some(axis) = axis
                && columns[axis].replace(width).is_some()
            {
                return Err(Flaw::new(FaultKind::Ambiguous, "one field of each name", format!("a second field {}", quoted(name))));
            }
            width += self.counts.get(index).copied().unwrap_or(1);
        }
        let [Some(x), Some(y), Some(z)] = columns else {
            return Err(Flaw::new(FaultKind::Malformed, "the fields x, y and z", "a header without one of them"));
        };
        self.data = Some(Data { columns: [x, y, z], width });
        Ok(())
    }
}

/// A whole number of at most 18 digits.
fn whole(word: &[u8]) -> Option<u64> {
    if word.len() > 18 { None } else { std::str::from_utf8(word).ok()?.parse().ok() }
}
