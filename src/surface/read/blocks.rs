//! Reading on several threads: a file is divided into blocks, the blocks are parsed independently, and their results
//! are joined in order.
//!
//! A block is parsed with an assumption about its start, for instance that it begins with a whole facet. Its result is
//! used if the assumption is true and the block has no fault. Otherwise the sequential reader reads the block again.
//! Points, facets and faults are therefore the same as when the file is read on one thread.

use super::fault::Fault;
use crate::surface::{PartedSink, Sink};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::borrow::Cow;

/// A reader of files that can be divided into blocks.
pub(super) trait BlockReader: Sync {
    /// The assumption about the start of a block.
    type Job: Send;
    /// The parsed content of a block.
    type Run: Send;

    /// Takes the next piece of the file from `rest`; `None` if `rest` is used up.
    fn next_unit<'a>(&mut self, rest: &mut &'a [u8]) -> Result<Option<Unit<'a, Self::Job>>, Fault>;

    /// Parses a block; `None` if it must be read in order.
    fn parse(bytes: &[u8], job: Self::Job) -> Option<Self::Run>;

    /// Adds the content of a block, and returns whether the assumption about its start was true.
    fn link(&mut self, run: &mut Self::Run, bytes: &[u8]) -> bool;

    /// Passes the points or facets of a block that was added to `sink`.
    fn emit<S: Sink>(&self, run: &Self::Run, bytes: &[u8], sink: &mut S) -> Emitted;

    /// Adds the counts of a block. Formats that count when a block is added have nothing to do.
    fn count(&mut self, _: Emitted) {}

    /// Reads the next bytes of the file in order.
    fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault>;

    /// The bytes after the last block.
    fn rest(&mut self) -> Vec<u8>;
}

/// The next piece of a file.
#[derive(Debug)]
pub(super) enum Unit<'a, J> {
    /// Bytes for the sequential reader.
    Serial(Cow<'a, [u8]>),
    Block(Block<J>),
}

/// Bytes that can be parsed independently.
#[derive(Debug)]
pub(super) struct Block<J> {
    pub(super) bytes: Vec<u8>,
    pub(super) job: J,
}

/// The counts of what a block passed to the sink.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Emitted {
    pub(super) facets: u64,
    pub(super) crossed: u64,
}

/// A parsed block.
struct Parsed<R> {
    bytes: Vec<u8>,
    /// `None` if the block must be read in order.
    run: Option<R>,
}

/// Divides consecutive bytes of a file into blocks, and reads the blocks on the threads of the current pool.
pub(super) fn push<R: BlockReader, S: PartedSink>(reader: &mut R, pieces: &[Cow<'_, [u8]>], sink: &mut S) -> Result<(), Fault> {
    let mut waiting = Vec::new();
    for piece in pieces {
        let mut rest = &**piece;
        while let Some(unit) = reader.next_unit(&mut rest)? {
            match unit {
                Unit::Block(block) => waiting.push(block),
                Unit::Serial(bytes) => {
                    read(reader, std::mem::take(&mut waiting), sink)?;
                    reader.push(&bytes, sink)?;
                }
            }
        }
    }
    read(reader, waiting, sink)
}

/// Reads consecutive blocks. Each block is a part of its own in the sink, whether it was parsed independently or not.
fn read<R: BlockReader, S: PartedSink>(reader: &mut R, blocks: Vec<Block<R::Job>>, sink: &mut S) -> Result<(), Fault> {
    let parse = |Block { bytes, job }| {
        let run = R::parse(&bytes, job);
        Parsed { bytes, run }
    };
    let parsed: Vec<Parsed<R::Run>> = blocks.into_par_iter().map(parse).collect();
    let mut parsed = parsed.into_iter();
    loop {
        let (mut linked, mut serial) = (Vec::new(), None);
        for Parsed { bytes, mut run } in parsed.by_ref() {
            let is_linked = run.as_mut().is_some_and(|run| reader.link(run, &bytes));
            let Some(run) = run.filter(|_| is_linked) else {
                serial = Some(bytes);
                break;
            };
            linked.push((run, bytes, sink.part()));
        }
        let shared: &R = reader;
        let emit = |(run, bytes, mut part): (R::Run, Vec<u8>, S::Part)| {
            let emitted = shared.emit(&run, &bytes, &mut part);
            (part, emitted)
        };
        let parts: Vec<(S::Part, Emitted)> = linked.into_par_iter().map(emit).collect();
        for (part, emitted) in parts {
            sink.append(part);
            reader.count(emitted);
        }
        let Some(bytes) = serial else { return Ok(()) };
        let mut part = sink.part();
        let result = reader.push(&bytes, &mut part);
        sink.append(part);
        result?;
    }
}
