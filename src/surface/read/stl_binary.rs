//! Reader of binary STL. The file has a header of 80 bytes, which is ignored, a count of 4 bytes, and a record of 50
//! bytes for each facet: normal and corners in single precision, little-endian, and 2 bytes without a common meaning.
//!
//! Normals are ignored, because the corners define them. Bytes after the last facet are counted.

use super::blocks::{Block, BlockReader, Emitted, Unit};
use super::decimal::unbounded;
use super::fault::{Fault, FaultKind, Flaw};
use super::{Format, LARGEST_COORDINATE, Notes, Sink, Summary};

const HEADER: usize = 80;
const START: usize = HEADER + 4;
const RECORD: usize = 50;
/// The corners follow the normal's three numbers.
const FIRST_CORNER: usize = 12;

/// The reader of binary STL.
#[derive(Debug)]
pub(super) struct Reader {
    /// The incomplete header or record at the end of the last chunk.
    begun: [u8; START],
    length: usize,
    /// The count in the header, once it has arrived.
    promised: Option<u64>,
    facets: u64,
    trailing_bytes: u64,
    /// The numbers of bytes of the header, the records and the current block that were passed on in blocks.
    header: usize,
    divided: u64,
    block: Vec<u8>,
    /// The bytes of a block.
    size: usize,
}

impl Reader {
    pub(super) fn new(block: usize) -> Self {
        let size = block.div_ceil(RECORD) * RECORD;
        Self { begun: [0; START], length: 0, promised: None, facets: 0, trailing_bytes: 0, header: 0, divided: 0, block: Vec::new(), size }
    }

    /// Moves bytes from `chunk` to the incomplete header or record until it has `size` bytes, and returns whether it is
    /// complete.
    fn complete(&mut self, chunk: &mut &[u8], size: usize) -> bool {
        let (part, rest) = chunk.split_at(chunk.len().min(size - self.length));
        self.begun[self.length..self.length + part.len()].copy_from_slice(part);
        self.length += part.len();
        *chunk = rest;
        if self.length < size {
            return false;
        }
        self.length = 0;
        true
    }

    fn records<S: Sink>(&mut self, records: &[[u8; RECORD]], sink: &mut S) -> Result<(), Fault> {
        for record in records {
            let corners = corners(record);
            if !corners.iter().flatten().fold(true, |fine, value| fine & (value.abs() <= LARGEST_COORDINATE)) {
                return Err(self.unbounded(&corners));
            }
            self.facets += 1;
            sink.facet(corners);
        }
        Ok(())
    }

    /// The fault of a coordinate out of range in the next record.
    #[cold]
    fn unbounded(&self, corners: &[[f64; 3]; 3]) -> Fault {
        let numbers = corners.as_flattened();
        let first = numbers.iter().position(|value| value.is_nan() || value.abs() > LARGEST_COORDINATE).unwrap_or(0);
        let offset = START as u64 + RECORD as u64 * self.facets + (FIRST_CORNER + 4 * first) as u64;
        unbounded(&numbers[first].to_string()).at_byte(offset)
    }

    pub(super) fn finish(self) -> Result<Summary, Fault> {
        let Some(promised) = self.promised else {
            let expected = format!("{START} bytes of header and count of a binary STL");
            return Err(Flaw::new(FaultKind::Truncated, expected, self.length.to_string()).at_byte(self.length as u64));
        };
        let end = START as u64 + RECORD as u64 * self.facets + self.length as u64;
        if self.facets < promised {
            let expected = format!("{promised} facets, as the count at byte {HEADER} says");
            return Err(Flaw::new(FaultKind::Truncated, expected, format!("the end of the file after {}", self.facets)).at_byte(end));
        }
        if promised == 0 {
            let found = format!("the count 0, and {} bytes after it", self.trailing_bytes);
            return Err(Flaw::new(FaultKind::Empty, "a facet", found).at_byte(HEADER as u64));
        }
        let notes = Notes { trailing_bytes: self.trailing_bytes, ..Notes::default() };
        Ok(Summary { format: Format::StlBinary, points: 0, facets: self.facets, unit: None, notes })
    }
}

impl BlockReader for Reader {
    type Job = ();
    type Run = Run;

    /// The header, a block of records, or the bytes after the records.
    fn next_unit<'a>(&mut self, chunk: &mut &'a [u8]) -> Result<Option<Unit<'a, ()>>, Fault> {
        let mut take = |length: usize| {
            let (part, rest) = chunk.split_at(chunk.len().min(length));
            *chunk = rest;
            part
        };
        if self.header < START {
            let part = take(START - self.header);
            self.header += part.len();
            return Ok((!part.is_empty()).then(|| Unit::Serial(part.into())));
        }
        let records = usize::try_from(self.promised.unwrap_or(0) - self.divided).unwrap_or(usize::MAX);
        if records == 0 {
            let rest = take(usize::MAX);
            return Ok((!rest.is_empty()).then(|| Unit::Serial(rest.into())));
        }
        let size = self.size.min(records.saturating_mul(RECORD));
        self.block.reserve_exact(size - self.block.len());
        self.block.extend_from_slice(take(size - self.block.len()));
        Ok((self.block.len() == size).then(|| {
            self.divided += (size / RECORD) as u64;
            Unit::Block(Block { bytes: std::mem::take(&mut self.block), job: () })
        }))
    }

    fn parse(bytes: &[u8], (): ()) -> Option<Run> {
        let (records, _) = bytes.as_chunks::<RECORD>();
        let is_bounded = |record| corners(record).iter().flatten().fold(true, |fine, value| fine & (value.abs() <= LARGEST_COORDINATE));
        records.iter().all(is_bounded).then_some(Run { facets: records.len() as u64 })
    }

    fn link(&mut self, run: &mut Run, _: &[u8]) -> bool {
        self.facets += run.facets;
        true
    }

    fn emit<S: Sink>(&self, _: &Run, bytes: &[u8], sink: &mut S) -> Emitted {
        for record in bytes.as_chunks::<RECORD>().0 {
            sink.facet(corners(record));
        }
        Emitted::default()
    }

    fn push<S: Sink>(&mut self, mut chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        let promised = if let Some(promised) = self.promised {
            promised
        } else {
            if !self.complete(&mut chunk, START) {
                return Ok(());
            }
            let [.., a, b, c, d] = self.begun;
            let promised = u64::from(u32::from_le_bytes([a, b, c, d]));
            self.promised = Some(promised);
            promised
        };
        if self.length > 0 && self.complete(&mut chunk, RECORD) {
            let record = self.begun;
            self.records(&[*record.first_chunk().expect("84 bytes hold 50")], sink)?;
        }
        let (records, _) = chunk.as_chunks::<RECORD>();
        let left = usize::try_from(promised - self.facets).unwrap_or(usize::MAX);
        let records = &records[..records.len().min(left)];
        self.records(records, sink)?;
        let rest = &chunk[records.len() * RECORD..];
        if self.facets == promised {
            self.trailing_bytes += rest.len() as u64;
        } else {
            self.begun[self.length..self.length + rest.len()].copy_from_slice(rest);
            self.length += rest.len();
        }
        Ok(())
    }

    fn rest(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.block)
    }
}

/// The number of facets in a block. They are decoded when they are passed to the sink.
#[derive(Debug)]
pub(super) struct Run {
    facets: u64,
}

#[inline]
fn corners(record: &[u8; RECORD]) -> [[f64; 3]; 3] {
    let (numbers, _) = record[FIRST_CORNER..].as_chunks::<4>();
    let coordinate = |index: usize| f64::from(f32::from_le_bytes(numbers[index]));
    let corner = |first: usize| [coordinate(first), coordinate(first + 1), coordinate(first + 2)];
    [corner(0), corner(3), corner(6)]
}
