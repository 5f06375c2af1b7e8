//! Readers of the files in which surfaces come: text with points, STL, OBJ and PLY.
//!
//! A [`Reader`] is given a file in chunks, cut anywhere, and hands points and facets to a [`Sink`] as it understands them. Where
//! a file has facets the sink gets these, otherwise its points. Text and STL pass through without being held; OBJ and PLY, whose
//! facets name vertices by number, hold their vertices and nothing else. A count that a file states is believed only as its
//! data arrive.
//!
//! What a reader does not understand it refuses with a [`Fault`] that names line or byte; what it leaves out on purpose it
//! counts in the [`Summary`]. What the surface's moments are is no concern of this module, nor is the unit of the coordinates.

mod blocks;
mod decimal;
mod fault;
mod format;
mod lines;
mod mesh;
mod obj;
mod ply;
mod polygon;
mod stl_ascii;
mod stl_binary;
mod text;

pub use blocks::{BlockOutcome, TextBlock};
pub use fault::{Fault, FaultKind, FileLocation};
pub use format::{Format, FormatHint};

use super::{LARGEST_COORDINATE, Sink};
use format::{Found, HEAD};

/// The vertices that an OBJ or PLY file may have unless [`Reader::with_vertex_limit`] says otherwise: 480 MB of coordinates.
pub const DEFAULT_VERTEX_LIMIT: usize = 20_000_000;

/// What was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Summary {
    /// The format, as the content showed it.
    pub format: Format,
    /// Points handed to the sink.
    pub points: u64,
    /// Facets handed to the sink, a polygon of n corners counting n - 2.
    pub facets: u64,
    /// What was left out on purpose, or taken although it looks odd.
    pub notes: Notes,
}

/// What a reader left out on purpose, or took although it looks odd; all zero for a clean file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Notes {
    /// Text: columns beside x, y and z, as the first line of data has them.
    pub further_columns: u64,
    /// Binary STL and PLY: bytes after the end that the file's counts give.
    pub trailing_bytes: u64,
    /// OBJ: point and line elements. PLY: rows of elements other than vertices and faces. They are no part of a surface.
    pub other_elements: u64,
    /// OBJ and PLY: polygons whose outline crosses itself or doubles back, so that no cut into triangles gives their area.
    pub crossed_polygons: u64,
    /// ASCII STL: the file ends inside a solid, at the end of a facet. It may have been cut off.
    pub missing_end: bool,
}

/// Reads one file, whatever its format.
///
/// Push the file's bytes in chunks of any size, then finish. What comes out, and what the sink gets, does not depend on where
/// the chunks are cut. The format comes from the first 64 KiB, helped by the [`FormatHint`] where they leave it open.
#[derive(Debug)]
pub struct Reader {
    hint: FormatHint,
    vertex_limit: usize,
    stage: Stage,
}

#[derive(Debug)]
enum Stage {
    /// The format is not known; what has arrived of the head is kept.
    Head(Vec<u8>),
    Body(Box<Body>),
    Refused(Fault),
}

#[derive(Debug)]
enum Body {
    Text(text::Reader),
    StlAscii(stl_ascii::Reader),
    StlBinary(stl_binary::Reader),
    Obj(obj::Reader),
    Ply(ply::Reader),
}

impl Reader {
    /// A reader for one file, of which the caller knows what `hint` says.
    #[must_use]
    pub fn new(hint: FormatHint) -> Self {
        Self { hint, vertex_limit: DEFAULT_VERTEX_LIMIT, stage: Stage::Head(Vec::new()) }
    }

    /// The same with room for `vertices` vertices of an OBJ or PLY file, 24 bytes each.
    #[must_use]
    pub fn with_vertex_limit(self, vertices: usize) -> Self {
        Self { vertex_limit: vertices, ..self }
    }

    /// Takes the next bytes of the file.
    ///
    /// # Errors
    /// The first [`Fault`] of the file; from then on that one again.
    pub fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        let result = self.advance(chunk, sink, None);
        self.remember(result)
    }

    /// Takes the next bytes of a file of which all come this way, for a caller with several threads. Of long texts with points whole blocks
    /// are put off to `blocks` instead of being handed to `sink`. The caller reads them where and when it likes, but tells the reader of
    /// each by [`Reader::record_block`], in their order, before it pushes more; the points of a block come after all that `sink` has by then.
    ///
    /// # Errors
    /// As [`Reader::push`].
    pub fn push_in_blocks<S: Sink>(&mut self, chunk: &[u8], sink: &mut S, blocks: &mut Vec<TextBlock>) -> Result<(), Fault> {
        let result = self.advance(chunk, sink, Some(blocks));
        self.remember(result)
    }

    /// Takes note of what was in the next of the blocks that were put off.
    ///
    /// # Errors
    /// The block's first [`Fault`], with its line counted from the start of the file; from then on that one again.
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

    /// Takes note that the file has ended.
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
                Body::StlAscii(reader) => reader.finish(sink),
                Body::StlBinary(reader) => reader.finish(),
                Body::Obj(reader) => reader.finish(sink),
                Body::Ply(reader) => reader.finish(sink),
            },
            Stage::Refused(fault) => Err(fault),
            Stage::Head(_) => unreachable!("a head is opened above"),
        }
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
            Stage::Body(body) => body.push(chunk, sink, blocks),
            Stage::Refused(fault) => Err(fault.clone()),
        }
    }

    /// Chooses the format by the first bytes of the file and has them read.
    fn open<S: Sink>(&mut self, start: &[u8], sink: &mut S, blocks: Option<&mut Vec<TextBlock>>) -> Result<(), Fault> {
        let Found { format, mark } = format::find(&start[..start.len().min(HEAD)], self.hint)?;
        let mut body = Box::new(match format {
            format::Family::Text => Body::Text(text::Reader::new()),
            format::Family::StlAscii => Body::StlAscii(stl_ascii::Reader::new()),
            format::Family::StlBinary => Body::StlBinary(stl_binary::Reader::new()),
            format::Family::Obj => Body::Obj(obj::Reader::new(self.vertex_limit)),
            format::Family::Ply => Body::Ply(ply::Reader::new(self.vertex_limit, mark as u64)),
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
            Self::StlAscii(reader) => reader.push(chunk, sink),
            Self::StlBinary(reader) => reader.push(chunk, sink),
            Self::Obj(reader) => reader.push(chunk, sink),
            Self::Ply(reader) => reader.push(chunk, sink),
        }
    }
}
