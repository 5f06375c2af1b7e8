//! The body of binary PLY: rows without separators, in either byte order.

use super::super::blocks::{Block, Unit};
use super::super::decimal::unbounded;
use super::super::fault::{Fault, FaultKind, Flaw};
use super::super::{Format, LARGEST_COORDINATE};
use super::header::{Element, Kind, Property, Type};
use super::{Rows, Run, Sink, Surface, Target, Whole};
use std::sync::Arc;

#[derive(Debug)]
pub(super) struct Body {
    rows: Rows,
    format: Format,
    /// The steps that read a row of the current element.
    steps: Arc<[Step]>,
    /// The index of the next step.
    step: usize,
    /// The rest of the current list: the number of items if they are corners, otherwise the number of bytes.
    left: Option<u64>,
    vertex: [f64; 3],
    input: Input,
    divider: Divider,
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
    pub(super) fn new(rows: Rows, format: Format, offset: u64, block: usize) -> Self {
        let steps = steps(&rows);
        let input = Input { begun: Vec::new(), used: false, offset };
        let divider = Divider::new(rows.clone(), format, block);
        Self { rows, format, steps, step: 0, left: None, vertex: [0.0; 3], input, divider }
    }

    pub(super) fn rows(&self) -> &Rows {
        &self.rows
    }

    /// Continues after rows that were read as a block.
    pub(super) fn skip(&mut self, rows: Rows, bytes: usize) {
        self.rows = rows;
        self.steps = steps(&self.rows);
        self.input.offset += bytes as u64;
    }

    pub(super) fn next_unit<'a>(&mut self, chunk: &mut &'a [u8]) -> Option<Unit<'a, super::Job>> {
        self.divider.next_unit(chunk)
    }

    pub(super) fn rest(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.divider.begun)
    }

    pub(super) fn push<S: Sink>(&mut self, mut chunk: &[u8], surface: &mut Surface, sink: &mut S) -> Result<(), Fault> {
        while let Some(kind) = self.rows.element().map(|element| element.kind) {
            if self.step == 0 && self.left.is_none() {
                Whole { surface: &mut *surface, sink: &mut *sink }.begin_row(kind);
            }
            while self.step < self.steps.len() {
                if !self.read_step(&mut chunk, surface, sink)? {
                    return Ok(());
                }
                self.step += 1;
            }
            let mut target = Whole { surface: &mut *surface, sink: &mut *sink };
            let ended = match kind {
                Kind::Vertex => target.vertex(self.vertex),
                Kind::Face => target.close_face(),
                Kind::TriStrips | Kind::Other => Ok(()),
            };
            ended.map_err(|flaw| flaw.at_byte(self.input.offset))?;
            self.rows.advance();
            self.step = 0;
            if self.rows.read == 0 {
                self.steps = steps(&self.rows);
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
                let mut target = Whole { surface: &mut *surface, sink: &mut *sink };
                target.corner(u64::try_from(number).ok(), &|| number.to_string()).map_err(|flaw| flaw.at_byte(start))?;
                left -= 1;
            }
        } else {
            left -= self.input.skip(chunk, left);
        }
        self.left = (left > 0).then_some(left);
        Ok(left == 0)
    }
}

/// The steps that read a row of the element whose row comes next.
fn steps(rows: &Rows) -> Arc<[Step]> {
    rows.element().map(steps_of).unwrap_or_default().into()
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

/// The longest row of a block, in bytes; longer ones are read as they arrive.
const LONGEST_ROW: usize = 1 << 16;

/// Divides a body into blocks of whole rows of vertices or faces.
#[derive(Debug)]
struct Divider {
    size: usize,
    format: Format,
    /// The row at the end of the rows that are complete.
    ahead: Rows,
    steps: Arc<[Step]>,
    /// The row at the start of the block.
    start: Rows,
    begun: Vec<u8>,
    /// The bytes of the block's complete rows, and their number.
    complete: usize,
    rows: u64,
    /// Whether the rest of the file is read in order.
    is_over: bool,
}

/// The state of the next row of a block.
enum NextRow {
    /// The row is complete; the field is its length in bytes.
    Whole(usize),
    /// A part of the row has not arrived yet.
    Incomplete,
    TooLong,
}

/// The rows of a block: all of one element.
#[derive(Debug)]
pub(in super::super) struct Job {
    format: Format,
    start: Rows,
    steps: Arc<[Step]>,
    rows: u64,
}

impl Divider {
    fn new(rows: Rows, format: Format, size: usize) -> Self {
        let (start, steps, is_over) = (rows.clone(), steps(&rows), rows.have_strips());
        Self { size, format, ahead: rows, steps, start, begun: Vec::new(), complete: 0, rows: 0, is_over }
    }

    fn next_unit<'a>(&mut self, chunk: &mut &'a [u8]) -> Option<Unit<'a, super::Job>> {
        while !self.is_over {
            let is_surface = self.ahead.element().is_some_and(|element| matches!(element.kind, Kind::Vertex | Kind::Face));
            let next = if is_surface { next_row(&self.steps, self.format, &self.begun[self.complete..]) } else { NextRow::TooLong };
            match next {
                NextRow::Whole(length) => {
                    self.complete += length;
                    self.rows += 1;
                    self.ahead.advance();
                    if self.complete >= self.size || self.ahead.read == 0 {
                        return Some(self.block());
                    }
                }
                NextRow::Incomplete if chunk.is_empty() => return None,
                NextRow::Incomplete => {
                    // There is room for a whole row, so that each iteration completes a row or consumes the whole
                    // chunk.
                    let (part, rest) = chunk.split_at(chunk.len().min((self.size + LONGEST_ROW).saturating_sub(self.begun.len()).max(1)));
                    self.begun.extend_from_slice(part);
                    *chunk = rest;
                }
                NextRow::TooLong => {
                    self.is_over = true;
                    if self.rows > 0 {
                        return Some(self.block());
                    }
                }
            }
        }
        let bytes = if self.begun.is_empty() { std::mem::take(chunk).into() } else { std::mem::take(&mut self.begun).into() };
        let bytes: std::borrow::Cow<'a, [u8]> = bytes;
        (!bytes.is_empty()).then_some(Unit::Serial(bytes))
    }

    /// The complete rows as a block.
    fn block(&mut self) -> Unit<'static, super::Job> {
        let rest = self.begun.split_off(self.complete);
        let bytes = std::mem::replace(&mut self.begun, rest);
        let job = Job { format: self.format, start: self.start.clone(), steps: Arc::clone(&self.steps), rows: self.rows };
        (self.complete, self.rows, self.start) = (0, 0, self.ahead.clone());
        if self.ahead.read == 0 {
            self.steps = steps(&self.ahead);
        }
        Unit::Block(Block { bytes, job: super::Job::Binary(job) })
    }
}

/// The length of the row at the start of `bytes`.
fn next_row(steps: &[Step], format: Format, bytes: &[u8]) -> NextRow {
    let mut length = 0;
    for step in steps {
        match step {
            Step::Scalars { size, .. } => length += size,
            Step::List { count, item, .. } => {
                let Some(counted) = bytes.get(length..length + count.size()) else { return NextRow::Incomplete };
                let Ok(items) = usize::try_from(integer(*count, format, counted)) else { return NextRow::TooLong };
                length = length.saturating_add(count.size()).saturating_add(items.saturating_mul(item.size()));
            }
        }
        if length > LONGEST_ROW {
            return NextRow::TooLong;
        }
    }
    if length > bytes.len() { NextRow::Incomplete } else { NextRow::Whole(length) }
}

/// Parses a block; `None` if it has a fault.
pub(super) fn parse(bytes: &[u8], job: Job) -> Option<Run> {
    let Job { format, start, steps, rows } = job;
    let kind = start.element()?.kind;
    let mut run = Run::of_bytes(bytes.len(), start);
    let (mut vertex, mut at) = ([0.0; 3], 0);
    for _ in 0..rows {
        for step in &*steps {
            match step {
                Step::Scalars { size, coordinates } => {
                    for coordinate in coordinates {
                        let value = real(coordinate.number, format, &bytes[at + coordinate.at..]);
                        if value.is_nan() || value.abs() > LARGEST_COORDINATE {
                            return None;
                        }
                        vertex[coordinate.axis] = value;
                    }
                    at += size;
                }
                Step::List { count, item, corners } => {
                    let items = usize::try_from(integer(*count, format, &bytes[at..])).ok()?;
                    at += count.size();
                    let size = item.size();
                    if *corners {
                        for index in 0..items {
                            run.mesh.add_corner(usize::try_from(integer(*item, format, &bytes[at + index * size..])).ok()?)?;
                        }
                    }
                    at += items * size;
                }
            }
        }
        match kind {
            Kind::Vertex => run.mesh.add_vertex(vertex),
            Kind::Face => run.mesh.close_face()?,
            Kind::TriStrips | Kind::Other => return None,
        }
    }
    run.end.skip(rows);
    Some(run)
}

/// Pieces of known size joined from chunks that end anywhere.
#[derive(Debug)]
struct Input {
    /// The incomplete piece at the end of the last chunk.
    begun: Vec<u8>,
    /// Whether the piece in `begun` was completed and used.
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

/// A whole number. Reading the header has refused other types for counts and corners.
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
