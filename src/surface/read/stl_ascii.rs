//! Reader of ASCII STL: `solid`, facets of three vertices each, `endsolid`; any number of solids.
//!
//! Keywords may have any case and words may be spread over lines in any way, except that the name of a solid ends with
//! its line. Normals are ignored, because the corners define them: zero and NaN are accepted. The last `endsolid` may
//! be missing, and so may one before another `solid`.

use super::blocks::{Block, BlockReader, Emitted, Unit};
use super::decimal::{coordinate, number};
use super::fault::{Fault, FaultKind, Flaw};
use super::lines::{Lines, Words, trimmed_start};
use super::splitter::{BlockSplitter, ends_with_word};
use super::{Format, LARGEST_COORDINATE, Notes, Sink, Summary};

/// The position in the words of a facet: what the next word must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// Between facets.
    Between,
    Normal,
    /// A number of the normal; the field is the count of those before it.
    Direction(u8),
    Outer,
    Loop,
    /// The keyword of a corner; the field is the count of those before it.
    Vertex(u8),
    /// A coordinate of a corner; the fields are the corner and the axis.
    Coordinate(u8, u8),
    EndLoop,
    EndFacet,
}

/// The reader of STL in text.
#[derive(Debug)]
pub(super) struct Reader {
    lines: Lines,
    state: State,
    splitter: BlockSplitter,
    /// Whether a block has been split off.
    is_divided: bool,
}

#[derive(Debug, Clone)]
struct State {
    step: Step,
    /// Inside a solid, or after a facet outside any solid.
    in_solid: bool,
    corners: [[f64; 3]; 3],
    facets: u64,
}

impl Reader {
    pub(super) fn new(block: usize) -> Self {
        let splitter = BlockSplitter::new(block, |line| ends_with_word(line, b"endfacet"));
        Self { lines: Lines::after(0), state: State::at_start(false), splitter, is_divided: false }
    }

    pub(super) fn finish<S: Sink>(mut self, sink: &mut S) -> Result<Summary, Fault> {
        self.lines.finish(|line, _| self.state.line(line, sink))?;
        let State { step, in_solid, facets, .. } = self.state;
        let end = "the end of the file";
        if step != Step::Between {
            return Err(Flaw::new(FaultKind::Truncated, step.expected(), end).at_line(self.lines.number()));
        }
        if facets == 0 {
            return Err(Flaw::new(FaultKind::Empty, step.expected(), end).at_line(self.lines.number()));
        }
        let notes = Notes { missing_end: in_solid, ..Notes::default() };
        Ok(Summary { format: Format::StlAscii, points: 0, facets, unit: None, notes })
    }
}

impl BlockReader for Reader {
    type Job = Job;
    type Run = Run;

    /// The next block, which begins between facets in nearly all files.
    fn next_unit<'a>(&mut self, chunk: &mut &'a [u8]) -> Result<Option<Unit<'a, Job>>, Fault> {
        let Some(bytes) = self.splitter.next(chunk) else { return Ok(None) };
        let in_solid = std::mem::replace(&mut self.is_divided, true);
        Ok(Some(Unit::Block(Block { bytes, job: Job { in_solid } })))
    }

    fn rest(&mut self) -> Vec<u8> {
        self.splitter.rest()
    }

    /// Adds the facets of a block, if the block begins between facets as was assumed.
    fn link(&mut self, run: &mut Run, _: &[u8]) -> bool {
        if self.state.step != Step::Between || self.state.in_solid != run.began_in_solid {
            return false;
        }
        self.state = State { facets: self.state.facets + run.end.facets, ..run.end.clone() };
        self.lines.skip(run.lines);
        true
    }

    fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        self.lines.push(chunk, |line, _| self.state.line(line, sink))
    }

    fn parse(bytes: &[u8], Job { in_solid }: Job) -> Option<Run> {
        struct Facets(Vec<[[f64; 3]; 3]>);
        impl Sink for Facets {
            fn point(&mut self, _: [f64; 3]) {}
            fn facet(&mut self, corners: [[f64; 3]; 3]) {
                self.0.push(corners);
            }
        }
        let (mut lines, mut state) = (Lines::after(0), State::at_start(in_solid));
        let mut facets = Facets(Vec::with_capacity(bytes.len() / 128));
        lines.push(bytes, |line, _| state.line(line, &mut facets)).ok()?;
        Some(Run { lines: lines.ended(), began_in_solid: in_solid, facets: facets.0, end: state })
    }

    fn emit<S: Sink>(&self, run: &Run, _: &[u8], sink: &mut S) -> Emitted {
        for facet in &run.facets {
            sink.facet(*facet);
        }
        Emitted::default()
    }
}

/// The assumption about the start of a block.
#[derive(Debug)]
pub(super) struct Job {
    in_solid: bool,
}

/// The facets of a block.
#[derive(Debug)]
pub(super) struct Run {
    lines: u64,
    began_in_solid: bool,
    facets: Vec<[[f64; 3]; 3]>,
    end: State,
}

impl Step {
    fn expected(self) -> &'static str {
        match self {
            Self::Between => "\"facet\"",
            Self::Normal => "\"normal\"",
            Self::Direction(_) => "three numbers of the normal, then \"outer loop\"",
            Self::Outer => "\"outer\"",
            Self::Loop => "\"loop\"",
            Self::Vertex(_) => "\"vertex\", three for each facet",
            Self::Coordinate(..) => "a number, three for each vertex",
            Self::EndLoop => "\"endloop\" after three vertices",
            Self::EndFacet => "\"endfacet\"",
        }
    }
}

impl State {
    fn at_start(in_solid: bool) -> Self {
        Self { step: Step::Between, in_solid, corners: [[0.0; 3]; 3], facets: 0 }
    }

    fn line<S: Sink>(&mut self, line: &[u8], sink: &mut S) -> Result<(), Flaw> {
        if let Step::Vertex(corner) = self.step
            && let Some(point) = vertex_line(line)
        {
            self.corners[usize::from(corner)] = point;
            self.step = after_corner(corner);
            return Ok(());
        }
        for word in Words::of(line) {
            if self.step == Step::Between {
                if self.between(word)? {
                    return Ok(());
                }
            } else {
                self.in_facet(word, sink)?;
            }
        }
        Ok(())
    }

    /// Reads a word between facets, and returns whether the rest of its line is a solid's name.
    fn between(&mut self, word: &[u8]) -> Result<bool, Flaw> {
        if word.eq_ignore_ascii_case(b"facet") {
            self.step = Step::Normal;
            self.in_solid = true;
            return Ok(false);
        }
        if word.eq_ignore_ascii_case(b"solid") {
            self.in_solid = true;
            return Ok(true);
        }
        if word.eq_ignore_ascii_case(b"endsolid") && self.in_solid {
            self.in_solid = false;
            return Ok(true);
        }
        Err(Flaw::malformed(if self.in_solid { "\"facet\" or \"endsolid\"" } else { "\"solid\" or \"facet\"" }, word))
    }

    fn in_facet<S: Sink>(&mut self, word: &[u8], sink: &mut S) -> Result<(), Flaw> {
        let keyword =
            |name: &[u8], next| if word.eq_ignore_ascii_case(name) { Ok(next) } else { Err(Flaw::malformed(self.step.expected(), word)) };
        self.step = match self.step {
            Step::Between => unreachable!("the caller handles words between facets"),
            Step::Normal => keyword(b"normal", Step::Direction(0))?,
            Step::Direction(_) if word.eq_ignore_ascii_case(b"outer") => return Err(Flaw::malformed(self.step.expected(), word)),
            Step::Direction(2) => Step::Outer,
            Step::Direction(before) => Step::Direction(before + 1),
            Step::Outer => keyword(b"outer", Step::Loop)?,
            Step::Loop => keyword(b"loop", Step::Vertex(0))?,
            Step::Vertex(corner) => keyword(b"vertex", Step::Coordinate(corner, 0))?,
            Step::Coordinate(corner, axis) => {
                self.corners[usize::from(corner)][usize::from(axis)] = coordinate(word, self.step.expected())?;
                if axis < 2 { Step::Coordinate(corner, axis + 1) } else { after_corner(corner) }
            }
            Step::EndLoop => keyword(b"endloop", Step::EndFacet)?,
            Step::EndFacet => {
                let next = keyword(b"endfacet", Step::Between)?;
                self.facets += 1;
                sink.facet(self.corners);
                next
            }
        };
        Ok(())
    }
}

fn after_corner(corner: u8) -> Step {
    if corner < 2 { Step::Vertex(corner + 1) } else { Step::EndLoop }
}

/// The point of a line that has exactly one vertex. Nearly all lines of coordinates have; others are read word by word.
fn vertex_line(line: &[u8]) -> Option<[f64; 3]> {
    let line = trimmed_start(line);
    let (keyword, mut rest) = line.split_at_checked(6)?;
    if !keyword.eq_ignore_ascii_case(b"vertex") {
        return None;
    }
    let mut point = [0.0; 3];
    for value in &mut point {
        let start = trimmed_start(rest);
        if start.len() == rest.len() {
            return None;
        }
        let (read, length) = number(start, b'.')?;
        if read.abs() > LARGEST_COORDINATE {
            return None;
        }
        *value = read;
        rest = &start[length..];
    }
    trimmed_start(rest).is_empty().then_some(point)
}
