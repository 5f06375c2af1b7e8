//! Reader of PCD, the format of the Point Cloud Library, with data in text: a header that names the fields, then a
//! point in each line.
//!
//! The fields `x`, `y` and `z` are read, wherever they stand. Points with the coordinates `nan` are directions without
//! a measurement; they are counted and left out. Binary data are refused.

use super::extremes::CoordinateRange;
use super::input::{Input, ReadError};
use super::words::{Decimals, Words, names_no_finite_number, trimmed, unsigned};
use super::{Format, Notes, ReadSummary, Sink};
use crate::file_fault::{FileFaultKind, Flaw, quoted};

/// The largest number of fields of a point.
const MOST_FIELDS: usize = 1000;

/// Reads a PCD file.
pub(super) fn read(input: &mut Input, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
    let mut content = Content::default();
    input.each_line(|line, number| content.line(line, number, sink))?;
    let number = input.number_at_end();
    let Content { data, stated, extremes, points, missing, trailing_bytes, .. } = content;
    let end = "the end of the file";
    let flaw = match data {
        None => Flaw::new(FileFaultKind::Truncated, "a header that ends with DATA", end),
        Some(_) if stated.is_some_and(|stated| stated != points + missing) => {
            let expected = format!("{} points, as the header states", stated.unwrap_or(0));
            Flaw::new(FileFaultKind::Truncated, expected, format!("{end} after {}", points + missing))
        }
        Some(_) if points == 0 => Flaw::new(FileFaultKind::Empty, "a point", end),
        Some(Data { width, .. }) => {
            let far_outside = extremes.far_outside();
            let notes =
                Notes { further_columns: (width - 3) as u64, missing_points: missing, trailing_bytes, far_outside, ..Notes::default() };
            return Ok(ReadSummary { format: Format::Pcd, points, facets: 0, unit: None, notes });
        }
    };
    Err(flaw.at_line(number).into())
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
    decimals: Decimals,
    extremes: CoordinateRange,
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

impl Content {
    fn line(&mut self, line: &[u8], number: u64, sink: &mut dyn Sink) -> Result<(), Flaw> {
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
            return Err(Flaw::new(FileFaultKind::Malformed, format!("{} numbers, as the header states", data.width), count.to_string()));
        };
        if [x, y, z].into_iter().any(names_no_finite_number) {
            self.missing += 1;
            return Ok(());
        }
        let mut coordinate = |word| self.decimals.coordinate(word, "a number");
        let point = [coordinate(x)?, coordinate(y)?, coordinate(z)?];
        self.points += 1;
        self.extremes.add(point, number);
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
                    .map(|word| unsigned(word).filter(|count| *count <= MOST_FIELDS as u64))
                    .map(|count| {
                        count
                            .and_then(|count| usize::try_from(count).ok())
                            .ok_or_else(|| Flaw::quoting("the column counts of the fields", line))
                    })
                    .collect::<Result<_, _>>()?;
                Ok(())
            }
            b"POINTS" => {
                let count = words.next().unwrap_or_default();
                self.stated = Some(unsigned(count).ok_or_else(|| Flaw::quoting("the number of points", count))?);
                Ok(())
            }
            b"DATA" => self.begin(words.next().unwrap_or_default()),
            other => Err(Flaw::quoting("VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS or DATA", other)),
        }
    }

    fn begin(&mut self, encoding: &[u8]) -> Result<(), Flaw> {
        if encoding != b"ascii" {
            let found = format!("PCD with the data {}; save it with the data ascii", quoted(encoding));
            return Err(Flaw::new(FileFaultKind::UnknownFormat, "PCD with the data ascii", found));
        }
        let mut columns = [None; 3];
        let mut width = 0;
        for (index, name) in self.fields.iter().enumerate() {
            let axis = [b"x", b"y", b"z"].into_iter().position(|axis| axis == name.as_slice());
            if let Some(axis) = axis
                && columns[axis].replace(width).is_some()
            {
                return Err(Flaw::new(FileFaultKind::Ambiguous, "one field of each name", format!("a second field {}", quoted(name))));
            }
            width += self.counts.get(index).copied().unwrap_or(1);
        }
        let [Some(x), Some(y), Some(z)] = columns else {
            return Err(Flaw::new(FileFaultKind::Malformed, "the fields x, y and z", "a header without one of them"));
        };
        self.data = Some(Data { columns: [x, y, z], width });
        Ok(())
    }
}
