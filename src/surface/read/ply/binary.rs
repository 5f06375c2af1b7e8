//! The body of binary PLY: rows without separators, in either byte order.

use super::super::decimal::unbounded;
use super::super::fault::{Fault, FaultKind, Flaw};
use super::super::{Format, LARGEST_COORDINATE};
use super::header::{Element, Kind, Property, Type};
use super::{Rows, Sink, Surface};

#[derive(Debug)]
pub(super) struct Body {
    rows: Rows,
    format: Format,
    /// The steps that read a row of the current element.
    steps: Vec<Step>,
    /// The index of the next step.
    step: usize,
    /// The rest of the current list: a number of items where they are corners, else a number of bytes.
    left: Option<u64>,
    vertex: [f64; 3],
    input: Input,
}

/// A part of a row.
#[derive(Debug)]
enum Step {
    /// A run of scalars: its length in bytes, and the coordinates in it.
    Scalars { size: usize, coordinates: Vec<Coordinate> },
    /// A list: its count and its items.
    List { count: Type, item: Type, corners: bool },
}

#[derive(Debug, Clone, Copy)]
struct Coordinate {
    at: usize,
    number: Type,
    axis: usize,
}

impl Body {
    pub(super) fn new(rows: Rows, format: Format, offset: u64) -> Self {
        let steps = rows.element().map(steps).unwrap_or_default();
        let input = Input { begun: Vec::new(), used: false, offset };
        Self { rows, format, steps, step: 0, left: None, vertex: [0.0; 3], input }
    }

    pub(super) fn push<S: Sink>(&mut self, mut chunk: &[u8], surface: &mut Surface, sink: &mut S) -> Result<(), Fault> {
        while let Some(kind) = self.rows.element().map(|element| element.kind) {
            if self.step == 0 && self.left.is_none() {
                surface.begin_row(kind);
            }
            while self.step < self.steps.len() {
                if !self.read_step(&mut chunk, surface, sink)? {
                    return Ok(());
                }
                self.step += 1;
            }
            let ended = match kind {
                Kind::Vertex => surface.vertex(self.vertex, sink),
                Kind::Face => surface.mesh.close_face(sink),
                Kind::TriStrips | Kind::Other => Ok(()),
            };
            ended.map_err(|flaw| flaw.at_byte(self.input.offset))?;
            self.rows.advance();
            self.step = 0;
            if self.rows.read == 0 {
                self.steps = self.rows.element().map(steps).unwrap_or_default();
            }
        }
        surface.trailing_bytes += chunk.len() as u64;
        Ok(())
    }

    pub(super) fn finish(self) -> Result<Format, Fault> {
        let end = self.input.offset + if self.input.used { 0 } else { self.input.begun.len() as u64 };
        self.rows.missing().map_or(Ok(self.format), |flaw| Err(flaw.at_byte(end)))
    }

    /// Reads the next step as far as it has arrived, and returns whether it is complete.
    #[inline]
    fn read_step<S: Sink>(&mut self, chunk: &mut &[u8], surface: &mut Surface, sink: &mut S) -> Result<bool, Fault> {
        let start = self.input.offset;
        match &self.steps[self.step] {
            Step::Scalars { size, coordinates } => {
                let Some(bytes) = self.input.take(chunk, *size) else { return Ok(false) };
                for coordinate in coordinates {
                    let value = real(coordinate.number, self.format, &bytes[coordinate.at..]);
                    if value.is_nan() || value.abs() > LARGEST_COORDINATE {
                        return Err(unbounded(&value.to_string()).at_byte(start + coordinate.at as u64));
                    }
                    self.vertex[coordinate.axis] = value;
                }
                Ok(true)
            }
            Step::List { count, item, corners } => {
                let (count, item, corners) = (*count, *item, *corners);
                self.read_list((count, item, corners), chunk, surface, sink)
            }
        }
    }

    fn read_list<S: Sink>(
        &mut self,
        list: (Type, Type, bool),
        chunk: &mut &[u8],
        surface: &mut Surface,
        sink: &mut S,
    ) -> Result<bool, Fault> {
        let (count, item, corners) = list;
        let mut left = if let Some(left) = self.left {
            left
        } else {
            let start = self.input.offset;
            let Some(bytes) = self.input.take(chunk, count.size()) else { return Ok(false) };
            let length = integer(count, self.format, bytes);
            let Ok(length) = u64::try_from(length) else {
                return Err(Flaw::new(FaultKind::OutOfRange, "the length of a list", length.to_string()).at_byte(start));
            };
            if corners { length } else { length * item.size() as u64 }
        };
        if corners {
            while left > 0 {
                let start = self.input.offset;
                let Some(bytes) = self.input.take(chunk, item.size()) else { break };
                let number = integer(item, self.format, bytes);
                surface.corner(u64::try_from(number).ok(), &|| number.to_string(), sink).map_err(|flaw| flaw.at_byte(start))?;
                left -= 1;
            }
        } else {
            left -= self.input.skip(chunk, left);
        }
        self.left = (left > 0).then_some(left);
        Ok(left == 0)
    }
}

fn steps(element: &Element) -> Vec<Step> {
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

/// Pieces of known size joined from chunks that end anywhere.
#[derive(Debug)]
struct Input {
    /// The incomplete piece at the end of the last chunk.
    begun: Vec<u8>,
    /// The piece was completed and used.
    used: bool,
    /// Bytes of the file before the next piece.
    offset: u64,
}

impl Input {
    /// The next `size` bytes, once they have arrived.
    #[inline]
    fn take<'a, 'b: 'a>(&'a mut self, chunk: &mut &'b [u8], size: usize) -> Option<&'a [u8]> {
        if self.used {
            self.begun.clear();
            self.used = false;
        }
        if self.begun.is_empty()
            && let Some((whole, rest)) = chunk.split_at_checked(size)
        {
            *chunk = rest;
            self.offset += size as u64;
            return Some(whole);
        }
        self.join(chunk, size)
    }

    fn join<'a>(&'a mut self, chunk: &mut &[u8], size: usize) -> Option<&'a [u8]> {
        let (part, rest) = chunk.split_at(chunk.len().min(size - self.begun.len()));
        self.begun.extend_from_slice(part);
        *chunk = rest;
        self.used = self.begun.len() == size;
        self.offset += if self.used { size as u64 } else { 0 };
        self.used.then_some(&self.begun)
    }

    /// Skips up to `bytes` bytes, and returns how many have arrived.
    fn skip(&mut self, chunk: &mut &[u8], bytes: u64) -> u64 {
        let passed = usize::try_from(bytes).unwrap_or(usize::MAX).min(chunk.len());
        *chunk = &chunk[passed..];
        self.offset += passed as u64;
        passed as u64
    }
}

/// The first `N` of `bytes` in little-endian order, whatever the format's order.
fn lowest_first<const N: usize>(format: Format, bytes: &[u8]) -> [u8; N] {
    let mut number = [0; N];
    number.copy_from_slice(&bytes[..N]);
    if format == Format::PlyBigEndian {
        number.reverse();
    }
    number
}

/// A number of any type.
#[inline]
fn real(number: Type, format: Format, bytes: &[u8]) -> f64 {
    match number {
        Type::F32 => f64::from(f32::from_le_bytes(lowest_first(format, bytes))),
        Type::F64 => f64::from_le_bytes(lowest_first(format, bytes)),
        #[allow(clippy::cast_precision_loss, reason = "of at most 32 bits")]
        _ => integer(number, format, bytes) as f64,
    }
}

/// A whole number; the header has refused other types for counts and corners.
#[inline]
fn integer(number: Type, format: Format, bytes: &[u8]) -> i64 {
    match number {
        Type::I8 => i64::from(i8::from_le_bytes(lowest_first(format, bytes))),
        Type::U8 => i64::from(u8::from_le_bytes(lowest_first(format, bytes))),
        Type::I16 => i64::from(i16::from_le_bytes(lowest_first(format, bytes))),
        Type::U16 => i64::from(u16::from_le_bytes(lowest_first(format, bytes))),
        Type::I32 => i64::from(i32::from_le_bytes(lowest_first(format, bytes))),
        Type::U32 => i64::from(u32::from_le_bytes(lowest_first(format, bytes))),
        Type::F32 | Type::F64 => unreachable!("the header allows no list to be counted or numbered by these"),
    }
}
