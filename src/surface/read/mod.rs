//! Readers of surface files: points in text, ASCII PCD, STL, OBJ, PLY and 3MF.
//!
//! A [`Reader`] takes a file in chunks that end anywhere, and passes points and facets to a [`Sink`]. The sink gets the
//! facets of a file that has them, otherwise its points. Text, PCD and STL are not held; OBJ and PLY, whose facets
//! refer to vertices by number, hold the vertices; 3MF, whose directory stands at its end, holds the compressed file
//! and its meshes. Memory grows with the data that arrive, not with the counts that a file states.
//!
//! A file that cannot be read, or can be read in two ways, is refused with a [`Fault`] that names line or byte. Data
//! that the reader leaves out are counted in the [`Summary`]. Coordinates are passed on in the file's unit, which is in
//! the summary if the file states it.

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
mod stl_ascii;
mod stl_binary;
mod text;
mod three_mf;
mod utf_16;
mod vertices;

pub use fault::{Fault, FaultKind, FileLocation};
pub use format::{Format, FormatHint};
pub use text::{BlockOutcome, TextBlock};
pub use three_mf::DEFAULT_ARCHIVE_LIMIT;

use super::{LARGEST_COORDINATE, Sink, Unit};
use crate::cancellation::CancelFlag;
use format::{Detected, HEAD};
use utf_16::Utf16;

/// The default limit on the vertices of an OBJ, PLY or 3MF file ([`Reader::with_vertex_limit`] changes it): 480 MB of
/// coordinates.
pub const DEFAULT_VERTEX_LIMIT: usize = 20_000_000;

/// The result of reading a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Summary {
    /// The format, by the content.
    pub format: Format,
    /// Points passed to the sink.
    pub points: u64,
    /// Facets passed to the sink; a polygon of n corners counts n - 2.
    pub facets: u64,
    /// The unit of the coordinates, where the file states one: 3MF always does, text may in its header. A caller must
    /// not assume another.
    pub unit: Option<Unit>,
    /// Data that were left out, or accepted although they are unusual.
    pub notes: Notes,
}

/// Counts of data that a reader left out, or accepted although they are unusual; 0 for a regular file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Notes {
    /// Text and PCD: columns other than x, y and z, in the first line of data.
    pub further_columns: u64,
    /// Binary STL and PLY: bytes after the end that the file's counts give.
    pub trailing_bytes: u64,
    /// OBJ: point and line elements. PLY: rows of elements other than vertices, faces and triangle strips. 3MF: placed
    /// objects of the types `support` and `other`. They are not part of a surface.
    pub other_elements: u64,
    /// OBJ and PLY: polygons whose outline crosses itself or doubles back, so that no cut into triangles gives their
    /// area.
    pub crossed_polygons: u64,
    /// PCD: points without coordinates (`nan`), which stand for measurements without an echo.
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
    /// Ends the reading of a 3MF file.
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

impl Reader {
    /// A reader for one file.
    #[must_use]
    pub fn new(hint: FormatHint) -> Self {
        let stage = Stage::Head(Vec::new());
        let package_vertex_limit = DEFAULT_VERTEX_LIMIT;
        Self {
            hint,
            vertex_limit: DEFAULT_VERTEX_LIMIT,
            package_vertex_limit,
            archive_limit: DEFAULT_ARCHIVE_LIMIT,
            cancel: CancelFlag::default(),
            utf_16: None,
            stage,
        }
    }

    /// The same reader, whose [`Reader::finish`] of a 3MF file ends early with any result once `cancel` is set.
    #[must_use]
    pub fn with_cancel_flag(self, cancel: &CancelFlag) -> Self {
        Self { cancel: cancel.clone(), ..self }
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

    /// The same for 3MF files only, which take 48 bytes a vertex at their end; to be called after
    /// [`Reader::with_vertex_limit`].
    #[must_use]
    pub fn with_package_vertex_limit(self, vertices: usize) -> Self {
        Self { package_vertex_limit: vertices, ..self }
    }

    /// Takes the next bytes of the file.
    ///
    /// # Errors
    /// The first [`Fault`] of the file, and the same one at every later call.
    pub fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        let result = self.advance(chunk, sink, None);
        self.remember(result)
    }

    /// Takes the next bytes of a file, for a caller with several threads, which must pass the whole file by this
    /// method. Blocks of lines of long texts are appended to `blocks` instead of being read. The caller reads them on
    /// any thread, and calls [`Reader::record_block`] for each, in their order, before it pushes more. The points of a
    /// block follow all points that `sink` has by then.
    ///
    /// # Errors
    /// As [`Reader::push`].
    pub fn push_in_blocks<S: Sink>(&mut self, chunk: &[u8], sink: &mut S, blocks: &mut Vec<TextBlock>) -> Result<(), Fault> {
        let result = self.advance(chunk, sink, Some(blocks));
        self.remember(result)
    }

    /// Records the result of reading the next of the blocks.
    ///
    /// # Errors
    /// The block's first [`Fault`], with its line counted from the start of the file, and the same one at every later
    /// call.
    pub fn record_block(&mut self, read: BlockOutcome) -> Result<(), Fault> {
        let result = match &mut self.stage {
            Stage::Body(body) => match &mut **body {
                Body::Text(reader) => reader.record_block(read),
                _ => Ok(()),
            },
            Stage::Head(_) => Ok(()),
            Stage::Refused(fault) => Err(fault.clone()),
        };
        self.remember(result)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// The first [`Fault`] of the file, which may be that it ends here.
    pub fn finish<S: Sink>(mut self, sink: &mut S) -> Result<Summary, Fault> {
        if let Stage::Head(head) = &mut self.stage {
            let head = std::mem::take(head);
            let opened = self.open(&head, sink, None);
            self.remember(opened)?;
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

    fn advance<S: Sink>(&mut self, chunk: &[u8], sink: &mut S, mut blocks: Option<&mut Vec<TextBlock>>) -> Result<(), Fault> {
        match &mut self.stage {
            Stage::Head(head) if head.is_empty() && chunk.len() >= HEAD => self.open(chunk, sink, blocks),
            Stage::Head(head) => {
                let (part, rest) = chunk.split_at(chunk.len().min(HEAD - head.len()));
                head.extend_from_slice(part);
                if head.len() < HEAD {
                    return Ok(());
                }
                let head = std::mem::take(head);
                self.open(&head, sink, blocks.as_deref_mut())?;
                self.advance(rest, sink, blocks)
            }
            Stage::Body(body) => match &mut self.utf_16 {
                Some(decoder) => body.push(&decoder.decode(chunk), sink, blocks),
                None => body.push(chunk, sink, blocks),
            },
            Stage::Refused(fault) => Err(fault.clone()),
        }
    }

    /// Detects the format by the first bytes of the file and starts to read it.
    fn open<S: Sink>(&mut self, start: &[u8], sink: &mut S, blocks: Option<&mut Vec<TextBlock>>) -> Result<(), Fault> {
        let decoded;
        let (start, head) = match Utf16::by_mark(start) {
            Some(mut decoder) => {
                // The head ends at the same byte of the file, wherever the chunks end.
                let (head, rest) = start.split_at(start.len().min(HEAD));
                let head = decoder.decode(head);
                decoded = [head.as_slice(), &decoder.decode(rest)].concat();
                self.utf_16 = Some(decoder);
                (decoded.as_slice(), head.len())
            }
            None => (start, start.len().min(HEAD)),
        };
        let Detected { format, mark } = format::detect(&start[..head], self.hint, self.utf_16.is_some())?;
        let mut body = Box::new(match format {
            format::Family::Text => Body::Text(text::Reader::new()),
            format::Family::Pcd => Body::Pcd(pcd::Reader::new()),
            format::Family::StlAscii => Body::StlAscii(stl_ascii::Reader::new()),
            format::Family::StlBinary => Body::StlBinary(stl_binary::Reader::new()),
            format::Family::Obj => Body::Obj(obj::Reader::new(self.vertex_limit)),
            format::Family::Ply => Body::Ply(ply::Reader::new(self.vertex_limit, mark as u64)),
            format::Family::ThreeMf => Body::ThreeMf(three_mf::Reader::new(self.archive_limit, self.package_vertex_limit)),
        });
        body.push(&start[mark..], sink, blocks)?;
        self.stage = Stage::Body(body);
        Ok(())
    }
}

impl Body {
    fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S, blocks: Option<&mut Vec<TextBlock>>) -> Result<(), Fault> {
        match self {
            Self::Text(reader) => match blocks {
                Some(blocks) => reader.push_in_blocks(chunk, sink, blocks),
                None => reader.push(chunk, sink),
            },
            Self::Pcd(reader) => reader.push(chunk, sink),
            Self::StlAscii(reader) => reader.push(chunk, sink),
            Self::StlBinary(reader) => reader.push(chunk, sink),
            Self::Obj(reader) => reader.push(chunk, sink),
            Self::Ply(reader) => reader.push(chunk, sink),
            Self::ThreeMf(reader) => reader.push(chunk),
        }
    }
}
