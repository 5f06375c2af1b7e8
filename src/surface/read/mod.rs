//! Readers of surface files: points in text, ASCII PCD, STL, OBJ, PLY and 3MF.
//!
//! A [`Reader`] takes a file in chunks that may end anywhere, and passes points and facets to a [`Sink`]: the facets if
//! the file has any, otherwise the points. Text, PCD and STL are not stored. For OBJ and PLY, whose facets refer to
//! vertices by number, the vertices are stored. For 3MF, whose directory is at its end, the compressed file and its
//! meshes are stored. Memory grows with the data that arrive, not with the counts that a file states.
//!
//! A file that cannot be read, or is ambiguous, is refused with a [`Fault`] that names the line or byte. Data that the
//! reader leaves out are counted in the [`Summary`]. Coordinates are passed on in the file's unit, which is in the
//! summary if the file states it.

mod blocks;
mod decimal;
mod fault;
mod format;
mod known;
mod lines;
mod mesh;
mod obj;
mod pcd;
mod ply;
mod polygon;
mod splitter;
mod stl_ascii;
mod stl_binary;
mod text;
mod three_mf;
mod utf_16;
mod vertices;

pub use fault::{Fault, FaultKind, FileLocation};
pub use format::{Format, FormatHint};
pub use three_mf::DEFAULT_ARCHIVE_LIMIT;

use super::{LARGEST_COORDINATE, PartedSink, Sink, Unit};
use crate::cancellation::CancelFlag;
use blocks::BlockReader;
use format::{Detected, HEAD};
use std::borrow::Cow;
use utf_16::Utf16;

/// The default limit on the vertices of an OBJ, PLY or 3MF file, 480 MB of coordinates. [`Reader::with_vertex_limit`]
/// changes it.
pub const DEFAULT_VERTEX_LIMIT: usize = 20_000_000;

/// The result of reading a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Summary {
    /// The format, detected by the content.
    pub format: Format,
    /// Points passed to the sink.
    pub points: u64,
    /// Facets passed to the sink; a polygon of n corners counts n - 2.
    pub facets: u64,
    /// The unit of the coordinates, if the file states one: 3MF always does, text may in its header. A caller must use
    /// this unit.
    pub unit: Option<Unit>,
    /// The data that were left out, or accepted although they are unusual.
    pub notes: Notes,
}

/// Counts of data that a reader left out, or accepted although they are unusual; 0 for a regular file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Notes {
    /// Text and PCD: the columns other than x, y and z in the first line of data.
    pub further_columns: u64,
    /// Binary STL and PLY: bytes after the end that the file's counts give.
    pub trailing_bytes: u64,
    /// OBJ: point and line elements. PLY: rows of elements other than vertices, faces and triangle strips. 3MF: placed
    /// objects of the types `support` and `other`. They are not part of a surface.
    pub other_elements: u64,
    /// OBJ and PLY: polygons whose outline crosses itself or doubles back, so that no triangulation has their area.
    pub crossed_polygons: u64,
    /// PCD: points without coordinates (`nan`), which scanners write if there was no echo.
    pub missing_points: u64,
    /// ASCII STL: the file ends inside a solid, at the end of a facet. It may have been cut off.
    pub missing_end: bool,
}

/// Reads one file, whatever its format.
///
/// Push the file's bytes in chunks of any size, then finish. The result does not depend on where the chunks end. The
/// format is detected from the first 64 KiB, and from the [`FormatHint`] if they are ambiguous. Text in UTF-16 with a
/// byte-order mark is converted.
#[derive(Debug)]
pub struct Reader {
    hint: FormatHint,
    vertex_limit: usize,
    /// The limit for a 3MF file.
    package_vertex_limit: usize,
    archive_limit: usize,
    /// The size of blocks.
    block: usize,
    /// Cancels the reading of a 3MF file.
    cancel: CancelFlag,
    /// The decoder of a file in UTF-16.
    utf_16: Option<Utf16>,
    stage: Stage,
}

#[derive(Debug)]
enum Stage {
    /// The format is not detected yet; the first bytes are held.
    Head(Vec<u8>),
    Body(Box<Body>),
    Refused(Fault),
}

#[derive(Debug)]
enum Body {
    Text(text::Reader),
    Pcd(pcd::Reader),
    StlAscii(stl_ascii::Reader),
    StlBinary(stl_binary::Reader),
    Obj(obj::Reader),
    Ply(ply::Reader),
    ThreeMf(three_mf::Reader),
}

/// The largest amounts of data that a part of a file becomes while [`Reader::push_in_parallel`] reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MostOfPush {
    /// Facets, or points of a file without facets.
    pub facets: usize,
    /// Corners of facets.
    pub corners: usize,
    /// The memory in bytes of the parts that are read, until they are added to the sink.
    pub held: usize,
}

impl MostOfPush {
    /// The amounts for a file in any format. In nearly every format a facet takes at least 4 bytes and a vertex at
    /// least 6. A byte of the file takes the byte itself; the index of a vertex at a corner, 4 bytes for each 2; and
    /// for each facet, which has at least 4 bytes in binary PLY, 12 bytes for its corners and 36 for its own points and
    /// their table.
    fn of_any(bytes: usize) -> Self {
        Self { facets: bytes / 4, corners: bytes / 6, held: 40 * bytes }
    }
}

impl Reader {
    /// A reader for one file.
    #[must_use]
    pub fn new(hint: FormatHint) -> Self {
        let stage = Stage::Head(Vec::new());
        let package_vertex_limit = DEFAULT_VERTEX_LIMIT;
        let (vertex_limit, archive_limit, block) = (DEFAULT_VERTEX_LIMIT, DEFAULT_ARCHIVE_LIMIT, splitter::BLOCK);
        let cancel = CancelFlag::default();
        Self { hint, vertex_limit, package_vertex_limit, archive_limit, block, cancel, utf_16: None, stage }
    }

    /// The same reader with a cancel flag: once `cancel` is set, [`Reader::finish`] of a 3MF file returns early, with
    /// any result.
    #[must_use]
    pub fn with_cancel_flag(self, cancel: &CancelFlag) -> Self {
        Self { cancel: cancel.clone(), ..self }
    }

    /// The same reader with blocks of `bytes` bytes, at least 1, for [`Reader::push_in_parallel`]. The default is 128
    /// KiB.
    #[must_use]
    pub fn with_block_size(self, bytes: usize) -> Self {
        Self { block: bytes.max(1), ..self }
    }

    /// The same reader with a limit of `bytes` compressed bytes for a 3MF file.
    #[must_use]
    pub fn with_archive_limit(self, bytes: usize) -> Self {
        Self { archive_limit: bytes, ..self }
    }

    /// The same reader with a limit of `vertices` vertices for an OBJ, PLY or 3MF file, 24 bytes each; a 3MF file may
    /// have twice as many triangles, 12 bytes each, and place four times as many.
    #[must_use]
    pub fn with_vertex_limit(self, vertices: usize) -> Self {
        Self { vertex_limit: vertices, package_vertex_limit: vertices, ..self }
    }

    /// The same reader with another limit for 3MF files, which take 48 bytes for each vertex when they end. Call it
    /// after [`Reader::with_vertex_limit`].
    #[must_use]
    pub fn with_package_vertex_limit(self, vertices: usize) -> Self {
        Self { package_vertex_limit: vertices, ..self }
    }

    /// Takes the next bytes of the file.
    ///
    /// # Errors
    /// The first [`Fault`] of the file, and the same one at every later call.
    pub fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        let result = self.advance(chunk, sink);
        self.remember(result)
    }

    /// Takes the next bytes of a file, in several chunks, and reads blocks of them on the threads of the current pool
    /// of rayon. The whole file must be passed by this method. Points, facets and faults are the same as with
    /// [`Reader::push`]; the parts of the sink depend on the file alone, not on the chunks or the threads.
    ///
    /// A call takes some 40 bytes of memory for each byte of the chunks, until it returns.
    ///
    /// # Errors
    /// As [`Reader::push`].
    pub fn push_in_parallel<'a, S: PartedSink>(&mut self, chunks: impl IntoIterator<Item = &'a [u8]>, sink: &mut S) -> Result<(), Fault> {
        let result = self.advance_in_parallel(chunks, sink);
        self.remember(result)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// The first [`Fault`] of the file, which may be that it ends too early.
    pub fn finish<S: Sink>(mut self, sink: &mut S) -> Result<Summary, Fault> {
        if let Stage::Head(head) = &mut self.stage {
            let head = std::mem::take(head);
            let pushed = self.open(head.into()).and_then(|bytes| self.push_to_body(&bytes, sink));
            self.remember(pushed)?;
        }
        if let Stage::Body(body) = &mut self.stage {
            let rest = body.rest();
            body.push(&rest, sink)?;
        }
        match self.stage {
            Stage::Body(body) => match *body {
                Body::Text(reader) => reader.finish(sink),
                Body::Pcd(reader) => reader.finish(sink),
                Body::StlAscii(reader) => reader.finish(sink),
                Body::StlBinary(reader) => reader.finish(),
                Body::Obj(reader) => reader.finish(sink),
                Body::Ply(reader) => reader.finish(sink),
                Body::ThreeMf(reader) => reader.finish(sink, &self.cancel),
            },
            Stage::Refused(fault) => Err(fault),
            Stage::Head(_) => unreachable!("a head is opened above"),
        }
    }

    /// The memory of the reader beyond a fixed amount, in bytes: the vertices of an OBJ or PLY file, or the received
    /// part of a 3MF file. Each push adds at most a few times the length of its chunk.
    #[must_use]
    pub fn held_bytes(&self) -> usize {
        let Stage::Body(body) = &self.stage else { return 0 };
        match &**body {
            Body::Obj(reader) => reader.held_bytes(),
            Body::Ply(reader) => reader.held_bytes(),
            Body::ThreeMf(reader) => reader.held_bytes(),
            Body::Text(_) | Body::Pcd(_) | Body::StlAscii(_) | Body::StlBinary(_) => 0,
        }
    }

    /// The largest amounts that a push of `bytes` bytes adds, in addition to the vertices of [`Reader::held_bytes`].
    #[must_use]
    pub fn most_of_push(&self, bytes: usize) -> MostOfPush {
        match &self.stage {
            Stage::Body(body) => match **body {
                // A facet has 50 bytes in the file and three corners. In vectors that double when they grow, it takes
                // 36 bytes for its indices, 216 for its points, 52 for their tables, and its bytes themselves.
                Body::StlBinary(_) => MostOfPush { facets: bytes / 50, corners: 3 * bytes / 50, held: 8 * bytes },
                // Three lines `vertex 0 0 0` have 39 bytes.
                Body::StlAscii(_) => MostOfPush { facets: bytes / 39, corners: 3 * bytes / 39, held: 10 * bytes },
                // A point takes 6 bytes, `0 0 0` with a line's end: 72 bytes in such a vector, and its text.
                Body::Text(_) | Body::Pcd(_) => MostOfPush { facets: bytes / 6, corners: 0, held: 16 * bytes },
                // For a facet of a polygon, 86 bytes were counted.
                Body::Ply(ref reader) => {
                    let facets = bytes / reader.fewest_bytes_of_a_facet();
                    MostOfPush { held: 10 * bytes + 86 * facets, ..MostOfPush::of_any(bytes) }
                }
                Body::Obj(_) | Body::ThreeMf(_) => MostOfPush::of_any(bytes),
            },
            // As PLY with one byte for each facet.
            Stage::Head(_) | Stage::Refused(_) => MostOfPush { held: 96 * bytes, ..MostOfPush::of_any(bytes) },
        }
    }

    /// Whether the file is a 3MF package, which is parsed at its end and then takes more memory.
    #[must_use]
    pub fn is_archive(&self) -> bool {
        matches!(&self.stage, Stage::Body(body) if matches!(**body, Body::ThreeMf(_)))
    }

    fn remember(&mut self, result: Result<(), Fault>) -> Result<(), Fault> {
        if let Err(fault) = &result {
            self.stage = Stage::Refused(fault.clone());
        }
        result
    }

    fn advance<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        for bytes in self.take(chunk)? {
            self.push_to_body(&bytes, sink)?;
        }
        Ok(())
    }

    fn advance_in_parallel<'a, S: PartedSink>(&mut self, chunks: impl IntoIterator<Item = &'a [u8]>, sink: &mut S) -> Result<(), Fault> {
        let mut pieces = Vec::new();
        for chunk in chunks {
            pieces.extend(self.take(chunk)?);
        }
        let Stage::Body(body) = &mut self.stage else { return Ok(()) };
        match &mut **body {
            Body::Text(reader) => blocks::push(reader, &pieces, sink),
            Body::StlAscii(reader) => blocks::push(reader, &pieces, sink),
            Body::StlBinary(reader) => blocks::push(reader, &pieces, sink),
            Body::Obj(reader) => blocks::push(reader, &pieces, sink),
            Body::Ply(reader) => blocks::push(reader, &pieces, sink),
            Body::Pcd(_) | Body::ThreeMf(_) => pieces.iter().try_for_each(|piece| body.push(piece, sink)),
        }
    }

    fn push_to_body<S: Sink>(&mut self, bytes: &[u8], sink: &mut S) -> Result<(), Fault> {
        match &mut self.stage {
            Stage::Body(body) => body.push(bytes, sink),
            Stage::Head(_) | Stage::Refused(_) => Ok(()),
        }
    }

    /// The bytes to pass to the body: none while the format is unknown, and then the head and the bytes after it.
    fn take<'a>(&mut self, chunk: &'a [u8]) -> Result<[Cow<'a, [u8]>; 2], Fault> {
        let none = || Cow::Borrowed([].as_slice());
        match &mut self.stage {
            Stage::Head(head) if head.is_empty() && chunk.len() >= HEAD => Ok([self.open(chunk.into())?, none()]),
            Stage::Head(head) => {
                let (part, rest) = chunk.split_at(chunk.len().min(HEAD - head.len()));
                head.extend_from_slice(part);
                if head.len() < HEAD {
                    return Ok([none(), none()]);
                }
                let head = std::mem::take(head);
                Ok([self.open(head.into())?, self.decoded(rest)])
            }
            Stage::Body(_) => Ok([self.decoded(chunk), none()]),
            Stage::Refused(fault) => Err(fault.clone()),
        }
    }

    fn decoded<'a>(&mut self, chunk: &'a [u8]) -> Cow<'a, [u8]> {
        match &mut self.utf_16 {
            Some(decoder) => decoder.decode(chunk).into(),
            None => chunk.into(),
        }
    }

    /// Detects the format by the first bytes of the file, and returns those that the body takes.
    fn open<'a>(&mut self, start: Cow<'a, [u8]>) -> Result<Cow<'a, [u8]>, Fault> {
        let mut head = start.len().min(HEAD);
        let mut start = start;
        if let Some(mut decoder) = Utf16::by_mark(&start) {
            // The head ends at a fixed byte of the file, so that the result does not depend on the chunks.
            let (first, rest) = start.split_at(head);
            let first = decoder.decode(first);
            head = first.len();
            start = [first.as_slice(), &decoder.decode(rest)].concat().into();
            self.utf_16 = Some(decoder);
        }
        let Detected { format, mark } = format::detect(&start[..head], self.hint, self.utf_16.is_some())?;
        self.stage = Stage::Body(Box::new(match format {
            format::Family::Text => Body::Text(text::Reader::new(self.block)),
            format::Family::Pcd => Body::Pcd(pcd::Reader::new()),
            format::Family::StlAscii => Body::StlAscii(stl_ascii::Reader::new(self.block)),
            format::Family::StlBinary => Body::StlBinary(stl_binary::Reader::new(self.block)),
            format::Family::Obj => Body::Obj(obj::Reader::new(self.vertex_limit, self.block)),
            format::Family::Ply => Body::Ply(ply::Reader::new(self.vertex_limit, mark as u64, self.block)),
            format::Family::ThreeMf => Body::ThreeMf(three_mf::Reader::new(self.archive_limit, self.package_vertex_limit)),
        }));
        Ok(match start {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[mark..]),
            Cow::Owned(mut bytes) => {
                bytes.drain(..mark);
                Cow::Owned(bytes)
            }
        })
    }
}

impl Body {
    fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        match self {
            Self::Text(reader) => reader.push(chunk, sink),
            Self::Pcd(reader) => reader.push(chunk, sink),
            Self::StlAscii(reader) => reader.push(chunk, sink),
            Self::StlBinary(reader) => reader.push(chunk, sink),
            Self::Obj(reader) => reader.push(chunk, sink),
            Self::Ply(reader) => reader.push(chunk, sink),
            Self::ThreeMf(reader) => reader.push(chunk),
        }
    }

    /// The bytes after the last block.
    fn rest(&mut self) -> Vec<u8> {
        match self {
            Self::Text(reader) => reader.rest(),
            Self::StlAscii(reader) => reader.rest(),
            Self::StlBinary(reader) => reader.rest(),
            Self::Obj(reader) => reader.rest(),
            Self::Ply(reader) => reader.rest(),
            Self::Pcd(_) | Self::ThreeMf(_) => Vec::new(),
        }
    }
}
