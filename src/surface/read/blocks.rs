//! Reading on several threads: a file is divided into blocks, the blocks are parsed independently, and their results
//! are joined in order.
//!
//! A block is parsed with an assumption about its start, for instance that it begins with a whole facet. Its result is
//! used if the assumption is true and the block has no fault. Otherwise the sequential reader reads the block again.
//! Points, facets and faults are therefore the same as when the file is read on one thread.

use super::fault::Fault;
use super::{Body, Sink, mesh, obj, ply, stl_ascii, stl_binary, text};
use crate::surface::PartedSink;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::borrow::Cow;

/// The next piece of a file.
#[derive(Debug)]
pub(super) enum Unit<'a> {
    /// Bytes for the sequential reader.
    Serial(Cow<'a, [u8]>),
    Block(Block),
}

/// Bytes that can be parsed independently.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) bytes: Vec<u8>,
    pub(super) job: Job,
}

/// The assumption about the start of a block, for the parser of each format.
#[derive(Debug)]
pub(super) enum Job {
    Text(text::Job),
    StlAscii(stl_ascii::Job),
    StlBinary,
    Obj,
    PlyAscii(ply::AsciiJob),
    PlyBinary(ply::BinaryJob),
}

/// The parsed content of a block.
#[derive(Debug)]
pub(super) enum Run {
    Text(text::Run),
    StlAscii(stl_ascii::Run),
    StlBinary(stl_binary::Run),
    Obj(obj::Run),
    Ply(ply::Run),
}

/// The counts of what a block passed to the sink.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Emitted {
    pub(super) facets: u64,
    pub(super) crossed: u64,
}

/// A parsed block.
struct Parsed {
    bytes: Vec<u8>,
    /// `None` if the block must be read in order.
    run: Option<Run>,
}

impl Block {
    fn parse(self) -> Parsed {
        let Self { bytes, job } = self;
        let run = match job {
            Job::Text(job) => text::parse(&bytes, job).map(Run::Text),
            Job::StlAscii(job) => stl_ascii::parse(&bytes, job).map(Run::StlAscii),
            Job::StlBinary => stl_binary::parse(&bytes).map(Run::StlBinary),
            Job::Obj => obj::parse(&bytes).map(Run::Obj),
            Job::PlyAscii(job) => ply::parse_ascii(&bytes, job).map(Run::Ply),
            Job::PlyBinary(job) => ply::parse_binary(&bytes, job).map(Run::Ply),
        };
        Parsed { bytes, run }
    }
}

/// Reads consecutive blocks on the threads of the current pool. Each block is a part of its own in the sink, whether it
/// was parsed independently or not.
pub(super) fn read<S: PartedSink>(body: &mut Body, blocks: Vec<Block>, sink: &mut S) -> Result<(), Fault> {
    let parsed: Vec<Parsed> = blocks.into_par_iter().map(Block::parse).collect();
    let mut parsed = parsed.into_iter();
    loop {
        let (mut linked, mut serial) = (Vec::new(), None);
        for Parsed { bytes, mut run } in parsed.by_ref() {
            let is_linked = run.as_mut().is_some_and(|run| body.link(run, &bytes));
            let Some(run) = run.filter(|_| is_linked) else {
                serial = Some(bytes);
                break;
            };
            linked.push((run, bytes, sink.part()));
        }
        let read: &Body = body;
        let emit = |(run, bytes, mut part): (Run, Vec<u8>, S::Part)| {
            let emitted = read.emit(&run, &bytes, &mut part);
            (part, emitted)
        };
        let parts: Vec<(S::Part, Emitted)> = linked.into_par_iter().map(emit).collect();
        for (part, emitted) in parts {
            sink.append(part);
            body.count(emitted);
        }
        let Some(bytes) = serial else { return Ok(()) };
        let mut part = sink.part();
        let result = body.push(&bytes, &mut part);
        sink.append(part);
        result?;
    }
}

impl Body {
    /// Takes the next piece of the file from `rest`; `None` if `rest` is used up.
    pub(super) fn next_unit<'a>(&mut self, rest: &mut &'a [u8]) -> Result<Option<Unit<'a>>, Fault> {
        match self {
            Self::Text(reader) => Ok(reader.next_unit(rest)),
            Self::StlAscii(reader) => Ok(reader.next_unit(rest)),
            Self::StlBinary(reader) => Ok(reader.next_unit(rest)),
            Self::Obj(reader) => Ok(reader.next_unit(rest)),
            Self::Ply(reader) => reader.next_unit(rest),
            Self::Pcd(_) | Self::ThreeMf(_) => Ok((!rest.is_empty()).then(|| Unit::Serial(std::mem::take(rest).into()))),
        }
    }

    /// The bytes after the last block.
    pub(super) fn rest(&mut self) -> Vec<u8> {
        match self {
            Self::Text(reader) => reader.rest(),
            Self::StlAscii(reader) => reader.rest(),
            Self::StlBinary(reader) => reader.rest(),
            Self::Obj(reader) => reader.rest(),
            Self::Ply(reader) => reader.rest(),
            Self::Pcd(_) | Self::ThreeMf(_) => Vec::new(),
        }
    }

    /// Adds the content of a block, and returns whether the assumption about its start was true.
    fn link(&mut self, run: &mut Run, bytes: &[u8]) -> bool {
        match (self, run) {
            (Self::Text(reader), Run::Text(run)) => reader.link(run),
            (Self::StlAscii(reader), Run::StlAscii(run)) => reader.link(run),
            (Self::StlBinary(reader), Run::StlBinary(run)) => reader.link(run),
            (Self::Obj(reader), Run::Obj(run)) => reader.link(run),
            (Self::Ply(reader), Run::Ply(run)) => reader.link(run, bytes.len()),
            _ => unreachable!("a reader makes blocks of its own kind"),
        }
    }

    /// Passes the points or facets of a block that was added to `sink`.
    fn emit<S: Sink>(&self, run: &Run, bytes: &[u8], sink: &mut S) -> Emitted {
        match (self, run) {
            (_, Run::Text(run)) => run.emit(sink),
            (_, Run::StlAscii(run)) => run.emit(sink),
            (_, Run::StlBinary(_)) => stl_binary::emit(bytes, sink),
            (Self::Obj(reader), Run::Obj(run)) => reader.emit(run, sink),
            (Self::Ply(reader), Run::Ply(run)) => reader.emit(run, sink),
            _ => unreachable!("a reader makes blocks of its own kind"),
        }
    }

    fn count(&mut self, emitted: Emitted) {
        let mesh: &mut mesh::Mesh = match self {
            Self::Obj(reader) => reader.mesh(),
            Self::Ply(reader) => reader.mesh(),
            // These formats count when a block is added.
            Self::Text(_) | Self::Pcd(_) | Self::StlAscii(_) | Self::StlBinary(_) | Self::ThreeMf(_) => return,
        };
        mesh.count(emitted);
    }
}
