//! The body of ASCII PLY: one row in each line.

use super::super::Format;
use super::super::blocks::{Block, Unit};
use super::super::decimal::coordinate;
use super::super::fault::{Fault, FaultKind, Flaw, quoted};
use super::super::lines::{Lines, Words, trimmed_start};
use super::super::splitter::{BlockSplitter, any_line};
use super::header::{Kind, Property, integer};
use super::{Rows, Run, Sink, Surface, Target, Whole};

#[derive(Debug)]
pub(super) struct Body {
    lines: Lines,
    rows: Rows,
    splitter: BlockSplitter,
    /// The position after the blocks so far, assuming that each of their lines is a row.
    ahead: Rows,
}

impl Body {
    pub(super) fn new(rows: Rows, lines_before: u64, block: usize) -> Self {
        Self { lines: Lines::after(lines_before), ahead: rows.clone(), rows, splitter: BlockSplitter::new(block, any_line) }
    }

    pub(super) fn push<S: Sink>(&mut self, chunk: &[u8], surface: &mut Surface, sink: &mut S) -> Result<(), Fault> {
        let mut target = Whole { surface, sink };
        self.lines.push(chunk, |line, _| self.rows.line(line, &mut target))
    }

    pub(super) fn rows(&self) -> &Rows {
        &self.rows
    }

    /// Continues after rows that were read as a block.
    pub(super) fn skip(&mut self, rows: Rows, lines: u64) {
        self.rows = rows;
        self.lines.skip(lines);
    }

    /// The next block. A file with strips has none: its rows depend on each other and are read in order.
    pub(super) fn next_unit<'a>(&mut self, chunk: &mut &'a [u8]) -> Option<Unit<'a, super::Job>> {
        if self.rows.have_strips() {
            return (!chunk.is_empty()).then(|| Unit::Serial(std::mem::take(chunk).into()));
        }
        let bytes = self.splitter.next(chunk)?;
        let start = self.ahead.clone();
        // Old Macintosh files end lines with CR alone.
        let lines = [b'\n', b'\r'].map(|end| memchr::memchr_iter(end, &bytes).count()).into_iter().find(|count| *count > 0).unwrap_or(0);
        self.ahead.skip(lines as u64);
        Some(Unit::Block(Block { bytes, job: super::Job::Ascii(Job { start }) }))
    }

    pub(super) fn rest(&mut self) -> Vec<u8> {
        self.splitter.rest()
    }

    pub(super) fn finish<S: Sink>(mut self, surface: &mut Surface, sink: &mut S) -> Result<Format, Fault> {
        let mut target = Whole { surface, sink };
        self.lines.finish(|line, _| self.rows.line(line, &mut target))?;
        self.rows.missing().map_or(Ok(Format::PlyAscii), |flaw| Err(flaw.at_line(self.lines.number())))
    }
}

/// The assumption about a block: its first row.
#[derive(Debug)]
pub(in super::super) struct Job {
    start: Rows,
}

/// Parses a block; `None` if it has a fault.
pub(super) fn parse(bytes: &[u8], Job { start }: Job) -> Option<Run> {
    let (mut lines, mut rows, mut run) = (Lines::after(0), start.clone(), Run::of_bytes(bytes.len(), start));
    lines.push(bytes, |line, _| rows.line(line, &mut run)).ok()?;
    (run.lines, run.end) = (lines.ended(), rows);
    Some(run)
}

impl Rows {
    fn line(&mut self, line: &[u8], target: &mut impl Target) -> Result<(), Flaw> {
        let content = trimmed_start(line);
        if content.is_empty() {
            return Ok(());
        }
        let Some(element) = self.element() else {
            target.trail(content.len() as u64);
            return Ok(());
        };
        let kind = element.kind;
        target.begin_row(kind);
        let mut words = Words::of(content);
        let mut vertex = [0.0; 3];
        for property in &element.properties {
            match *property {
                Property::Scalar { axis: Some(axis), .. } => vertex[axis] = coordinate(word(&mut words, &element.name)?, "a number")?,
                Property::Scalar { axis: None, .. } => {
                    word(&mut words, &element.name)?;
                }
                Property::List { corners, .. } => {
                    let count = word(&mut words, &element.name)?;
                    let count = integer(count).ok_or_else(|| Flaw::malformed("the length of a list", count))?;
                    for _ in 0..count {
                        let item = word(&mut words, &element.name)?;
                        if corners {
                            add_corner(item, target)?;
                        }
                    }
                }
            }
        }
        if let Some(word) = words.next() {
            return Err(Flaw::malformed(format!("the end of a row of the element {}", element.name), word));
        }
        match kind {
            Kind::Vertex => target.vertex(vertex)?,
            Kind::Face => target.close_face()?,
            Kind::TriStrips | Kind::Other => {}
        }
        self.advance();
        Ok(())
    }
}

fn word<'a>(words: &mut Words<'a>, element: &str) -> Result<&'a [u8], Flaw> {
    words.next().ok_or_else(|| {
        let expected = format!("as many numbers as a row of the element {element} has");
        Flaw::new(FaultKind::Malformed, expected, "the end of the line")
    })
}

fn add_corner(word: &[u8], target: &mut impl Target) -> Result<(), Flaw> {
    let number = integer(word);
    if number.is_none() && integer(word.strip_prefix(b"-").unwrap_or(word)).is_none() {
        return Err(Flaw::malformed("the number of a vertex", word));
    }
    target.corner(number, &|| quoted(word))
}
