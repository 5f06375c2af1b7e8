//! Reader of PLY: a header that describes elements and their properties, then the rows of one element after the other,
//! as text or binary in either byte order.
//!
//! Vertices need scalars x, y and z of any type; faces a list `vertex_indices` or `vertex_index` of integers. Other
//! properties and other elements are skipped; the header states their sizes. Vertices must come before faces. The
//! vertices of a file without faces are points, which are passed on and not stored. Triangle strips (`tristrips`) are
//! read as well: every vertex after the first two of a strip forms a triangle with the two before it, and -1 starts a
//! new strip. A number in text may have a decimal comma. A comment may state the unit.

use super::faces::{Faces, too_many_vertices};
use super::input::{Input, ReadError};
use super::ply_header::{self, Element, PlyKind, Property, Type};
use super::words::{Decimals, Words, unbounded, unsigned};
use super::{Format, LARGEST_COORDINATE, Notes, ReadSummary, Sink};
use crate::file_fault::{FileFaultKind, Flaw, quoted};

/// Reads a PLY file of at most `vertex_limit` vertices.
pub(super) fn read(input: &mut Input, vertex_limit: usize, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
    let header = ply_header::read(input)?;
    let count = |kind| header.elements.iter().filter(|element| element.kind == kind).map(|element| element.count).sum::<u64>();
    let vertices = count(PlyKind::Vertex);
    let stores = count(PlyKind::Face) > 0 || count(PlyKind::TriStrips) > 0;
    if vertices == 0 {
        return Err(Flaw::new(FileFaultKind::Empty, "a vertex", "0 vertices in the header").at_line(input.number()).into());
    }
    if stores && vertices > vertex_limit as u64 {
        return Err(too_many_vertices(vertex_limit).at_line(input.number()).into());
    }
    let mut surface = Surface { faces: Faces::new(vertex_limit), strip: None, stores, points: 0, sink };
    let mut notes = Notes::default();
    for element in &header.elements {
        if element.kind == PlyKind::Other {
            notes.other_elements = notes.other_elements.saturating_add(element.count);
        }
        // The rows of an element without properties are empty.
        if !element.properties.is_empty() {
            match header.format {
                Format::PlyAscii => surface.read_lines(input, element)?,
                format => surface.read_bytes(input, element, format == Format::PlyBigEndian)?,
            }
        }
    }
    notes.trailing_bytes = if header.format == Format::PlyAscii { bytes_of_lines(input)? } else { input.skip(u64::MAX)? };
    notes.crossed_polygons = surface.faces.crossed();
    let facets = surface.faces.facets();
    if stores && facets == 0 {
        return Err(Flaw::new(FileFaultKind::Empty, "a triangle in the strips", "none").at_byte(0).into());
    }
    Ok(ReadSummary { format: header.format, points: surface.points, facets, unit: header.unit, notes })
}

/// The bytes of the lines that are left, without the blanks before them.
fn bytes_of_lines(input: &mut Input) -> Result<u64, ReadError> {
    let mut bytes = 0;
    input.each_line(|line, _| {
        bytes += line.trim_ascii_start().len() as u64;
        Ok(())
    })?;
    Ok(bytes)
}

/// The fault of a file that ends after `read` rows of an element.
fn cut_off(element: &Element, read: u64) -> Flaw {
    let expected = format!("{} rows of the element {}, as the header says", element.count, element.name);
    Flaw::new(FileFaultKind::Truncated, expected, format!("the end of the file after {read}"))
}

/// The surface that the rows of either kind of body describe.
struct Surface<'a> {
    faces: Faces,
    /// The strip that is being read, if the element has triangle strips.
    strip: Option<Strip>,
    /// Whether faces or strips follow, so that vertices must be stored.
    stores: bool,
    points: u64,
    sink: &'a mut dyn Sink,
}

impl Surface<'_> {
    fn begin_row(&mut self, kind: PlyKind) {
        self.strip = (kind == PlyKind::TriStrips).then(Strip::default);
    }

    /// Adds a corner to the current face or strip. `number` is `None` if it is negative; `written` returns the text of
    /// the file, for the fault.
    #[inline]
    fn corner(&mut self, number: Option<u64>, written: impl FnOnce() -> String) -> Result<(), Flaw> {
        let number = number.and_then(|number| usize::try_from(number).ok());
        let added = match &mut self.strip {
            Some(strip) => strip.add(number, &mut self.faces, self.sink).map(Ok),
            None => number.and_then(|number| self.faces.add_corner(number)),
        };
        added.unwrap_or_else(|| {
            let expected = format!("the number of one of {} vertices, from 0", self.faces.vertices().len());
            Err(Flaw::new(FileFaultKind::OutOfRange, expected, written()))
        })
    }

    fn end_row(&mut self, kind: PlyKind, vertex: [f64; 3]) -> Result<(), Flaw> {
        match kind {
            PlyKind::Vertex if self.stores => self.faces.add_vertex(vertex),
            PlyKind::Vertex => {
                self.points += 1;
                self.sink.point(vertex);
                Ok(())
            }
            PlyKind::Face => self.faces.close(self.sink),
            PlyKind::TriStrips | PlyKind::Other => Ok(()),
        }
    }

    /// Reads the rows of an element in text, one in each line that is not blank.
    fn read_lines(&mut self, input: &mut Input, element: &Element) -> Result<(), ReadError> {
        let mut decimals = Decimals::default();
        let mut read = 0;
        while read < element.count {
            let Some(line) = input.line()? else {
                return Err(cut_off(element, read).at_line(input.number_at_end()).into());
            };
            let mut words = Words::of(line).peekable();
            if words.peek().is_some() {
                self.read_row(words, element, &mut decimals).map_err(|flaw| flaw.at_line(input.number()))?;
                read += 1;
            }
        }
        Ok(())
    }

    fn read_row<'a>(&mut self, mut words: impl Iterator<Item = &'a [u8]>, element: &Element, decimals: &mut Decimals) -> Result<(), Flaw> {
        self.begin_row(element.kind);
        let missing = || {
            let expected = format!("as many numbers as a row of the element {} has", element.name);
            Flaw::new(FileFaultKind::Malformed, expected, "the end of the line")
        };
        let mut vertex = [0.0; 3];
        for property in &element.properties {
            let word = words.next().ok_or_else(missing)?;
            match *property {
                Property::Scalar { axis: Some(axis), .. } => vertex[axis] = decimals.coordinate(word, "a number")?,
                Property::Scalar { axis: None, .. } => {}
                Property::List { corners, .. } => {
                    let count = unsigned(word).ok_or_else(|| Flaw::quoting("the length of a list", word))?;
                    for _ in 0..count {
                        let item = words.next().ok_or_else(missing)?;
                        if corners {
                            let number = unsigned(item);
                            if number.is_none() && unsigned(item.strip_prefix(b"-").unwrap_or(item)).is_none() {
                                return Err(Flaw::quoting("the number of a vertex", item));
                            }
                            self.corner(number, || quoted(item))?;
                        }
                    }
                }
            }
        }
        match words.next() {
            Some(word) => Err(Flaw::quoting(format!("the end of a row of the element {}", element.name), word)),
            None => self.end_row(element.kind, vertex),
        }
    }

    /// Reads the rows of an element in binary.
    fn read_bytes(&mut self, input: &mut Input, element: &Element, is_big: bool) -> Result<(), ReadError> {
        let steps = steps_of(element);
        for row in 0..element.count {
            self.begin_row(element.kind);
            let mut vertex = [0.0; 3];
            for step in &steps {
                let is_whole = match step {
                    Step::Scalars { size, coordinates } => read_scalars(input, *size, coordinates, is_big, &mut vertex)?,
                    Step::List { count, item, corners } => self.read_list(input, (*count, *item, *corners), is_big)?,
                };
                if !is_whole {
                    let end = input.offset() + input.peek(1)?.len() as u64;
                    return Err(cut_off(element, row).at_byte(end).into());
                }
            }
            self.end_row(element.kind, vertex).map_err(|flaw| flaw.at_byte(input.offset()))?;
        }
        Ok(())
    }

    /// Reads a list, and returns whether it is whole.
    fn read_list(&mut self, input: &mut Input, (count, item, corners): (Type, Type, bool), is_big: bool) -> Result<bool, ReadError> {
        let start = input.offset();
        let Some(bytes) = input.block(count.size())? else { return Ok(false) };
        let length = whole_number(count, is_big, bytes);
        let Ok(length) = u64::try_from(length) else {
            return Err(Flaw::new(FileFaultKind::OutOfRange, "the length of a list", length.to_string()).at_byte(start).into());
        };
        if !corners {
            let bytes = length * item.size() as u64;
            return Ok(input.skip(bytes)? == bytes);
        }
        for _ in 0..length {
            let start = input.offset();
            let Some(bytes) = input.block(item.size())? else { return Ok(false) };
            let number = whole_number(item, is_big, bytes);
            self.corner(u64::try_from(number).ok(), || number.to_string()).map_err(|flaw| flaw.at_byte(start))?;
        }
        Ok(true)
    }
}

/// A part of a row in binary.
enum Step {
    /// A run of scalars: its length in bytes, and the coordinates in it.
    Scalars { size: usize, coordinates: Vec<Coordinate> },
    /// A list: the types of its count and its items, and whether these are corners.
    List { count: Type, item: Type, corners: bool },
}

struct Coordinate {
    at: usize,
    number: Type,
    axis: usize,
}

fn steps_of(element: &Element) -> Vec<Step> {
    let mut steps = Vec::new();
    for property in &element.properties {
        match *property {
            Property::List { count, item, corners } => steps.push(Step::List { count, item, corners }),
            Property::Scalar { number, axis } => {
                if !matches!(steps.last(), Some(Step::Scalars { .. })) {
                    steps.push(Step::Scalars { size: 0, coordinates: Vec::new() });
                }
                if let Some(Step::Scalars { size, coordinates }) = steps.last_mut() {
                    coordinates.extend(axis.map(|axis| Coordinate { at: *size, number, axis }));
                    *size += number.size();
                }
            }
        }
    }
    steps
}

/// Reads scalars, and returns whether they are whole.
fn read_scalars(
    input: &mut Input,
    size: usize,
    coordinates: &[Coordinate],
    is_big: bool,
    vertex: &mut [f64; 3],
) -> Result<bool, ReadError> {
    let start = input.offset();
    let Some(bytes) = input.block(size)? else { return Ok(false) };
    for Coordinate { at, number, axis } in coordinates {
        let value = real(*number, is_big, &bytes[*at..]);
        if value.is_nan() || value.abs() > LARGEST_COORDINATE {
            return Err(unbounded(&value.to_string()).at_byte(start + *at as u64).into());
        }
        vertex[*axis] = value;
    }
    Ok(true)
}

/// The first `N` of `bytes` in little-endian order, whatever the file's order.
fn lowest_first<const N: usize>(is_big: bool, bytes: &[u8]) -> [u8; N] {
    let mut number = [0; N];
    number.copy_from_slice(&bytes[..N]);
    if is_big {
        number.reverse();
    }
    number
}

/// A number of any type.
#[inline]
fn real(number: Type, is_big: bool, bytes: &[u8]) -> f64 {
    match number {
        Type::F32 => f64::from(f32::from_le_bytes(lowest_first(is_big, bytes))),
        Type::F64 => f64::from_le_bytes(lowest_first(is_big, bytes)),
        #[allow(clippy::cast_precision_loss, reason = "of at most 32 bits")]
        _ => whole_number(number, is_big, bytes) as f64,
    }
}

/// A whole number. Reading the header has refused other types for counts and corners.
#[inline]
fn whole_number(number: Type, is_big: bool, bytes: &[u8]) -> i64 {
    match number {
        Type::I8 => i64::from(i8::from_le_bytes(lowest_first(is_big, bytes))),
        Type::U8 => i64::from(u8::from_le_bytes(lowest_first(is_big, bytes))),
        Type::I16 => i64::from(i16::from_le_bytes(lowest_first(is_big, bytes))),
        Type::U16 => i64::from(u16::from_le_bytes(lowest_first(is_big, bytes))),
        Type::I32 => i64::from(i32::from_le_bytes(lowest_first(is_big, bytes))),
        Type::U32 => i64::from(u32::from_le_bytes(lowest_first(is_big, bytes))),
        Type::F32 | Type::F64 => unreachable!("the header allows no list to be counted or numbered by these"),
    }
}

/// A triangle strip that is being read.
#[derive(Default)]
struct Strip {
    /// The last two vertices, or fewer at the start of a strip.
    last: [Option<usize>; 2],
    /// Whether the next triangle has the opposite orientation, as every second one has.
    is_odd: bool,
}

impl Strip {
    /// Adds a vertex by its number, and passes the triangle that it completes to the sink; `None` starts a new strip.
    /// Returns `None` if the vertex is missing.
    fn add(&mut self, vertex: Option<usize>, faces: &mut Faces, sink: &mut dyn Sink) -> Option<()> {
        let Some(vertex) = vertex else {
            *self = Self::default();
            return Some(());
        };
        faces.vertices().get(vertex)?;
        if let [Some(first), Some(second)] = self.last {
            let corners = if self.is_odd { [second, first, vertex] } else { [first, second, vertex] };
            faces.add_triangle(corners, sink)?;
            self.is_odd = !self.is_odd;
        }
        self.last = [self.last[1], Some(vertex)];
        Some(())
    }
}
