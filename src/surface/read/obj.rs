//! Reader of Wavefront OBJ: vertices (`v`), and polygons (`f`) that refer to them by number. Numbers count from 1 at
//! the start of the file, or backwards from -1.
//!
//! A face may refer only to vertices before it. Weights and colours after a vertex, texture coordinates and normals of
//! a corner, groups, materials and names are ignored. Point and line elements are not part of a surface and are
//! counted. The vertices of a file without faces are points. Unknown statements are refused. Free-form curves and
//! surfaces are refused too, because their control points do not lie on the surface.

use super::blocks::{Block, BlockReader, Emitted, Unit};
use super::decimal::coordinate;
use super::fault::{Fault, FaultKind, Flaw, quoted};
use super::lines::{LONGEST_LINE, Lines, Words, too_long, trimmed};
use super::mesh::{self, Mesh};
use super::splitter::BlockSplitter;
use super::{Format, Notes, Sink, Summary};

/// The reader of OBJ.
#[derive(Debug)]
pub(super) struct Reader {
    lines: Lines,
    mesh: Mesh,
    content: Content,
    splitter: BlockSplitter,
}

/// The statements read so far.
#[derive(Debug, Default)]
struct Content {
    /// The part of a statement that a backslash continues on the next line.
    begun: Vec<u8>,
    other_elements: u64,
}

/// The receiver of vertices and faces: the mesh of the whole file, or that of a block.
trait Target {
    fn vertex(&mut self, vertex: [f64; 3]) -> Result<(), Flaw>;
    /// Adds a corner. `word` is the text of the file, for the fault.
    fn corner(&mut self, vertex: VertexNumber, word: &[u8]) -> Result<(), Flaw>;
    fn close_face(&mut self) -> Result<(), Flaw>;
}

/// The mesh of the whole file, and the sink for its facets.
struct Whole<'a, S> {
    mesh: &'a mut Mesh,
    sink: &'a mut S,
}

impl<S: Sink> Target for Whole<'_, S> {
    fn vertex(&mut self, vertex: [f64; 3]) -> Result<(), Flaw> {
        self.mesh.add_vertex(vertex)
    }

    fn corner(&mut self, vertex: VertexNumber, word: &[u8]) -> Result<(), Flaw> {
        let before = self.mesh.vertices().len();
        let missing = || {
            let expected = format!("the number of one of the {before} vertices before this line");
            Flaw::new(FaultKind::OutOfRange, expected, quoted(word))
        };
        let vertex = vertex.resolve(before).ok_or_else(missing)?;
        self.mesh.add_corner(vertex).ok_or_else(missing)?
    }

    fn close_face(&mut self) -> Result<(), Flaw> {
        self.mesh.close_face(self.sink)
    }
}

/// The vertices and faces of a block.
#[derive(Debug)]
pub(super) struct Run {
    lines: u64,
    mesh: mesh::Run,
    content: Content,
}

/// The flaw of a block that must be read in order; it is never reported.
fn unclear() -> Flaw {
    Flaw::new(FaultKind::Malformed, "", "")
}

impl Target for mesh::Run {
    fn vertex(&mut self, vertex: [f64; 3]) -> Result<(), Flaw> {
        self.add_vertex(vertex);
        Ok(())
    }

    fn corner(&mut self, vertex: VertexNumber, _: &[u8]) -> Result<(), Flaw> {
        let added = if vertex.backwards {
            self.add_corner_backwards(vertex.count)
        } else {
            vertex.count.checked_sub(1).and_then(|number| self.add_corner(number))
        };
        added.ok_or_else(unclear)
    }

    fn close_face(&mut self) -> Result<(), Flaw> {
        mesh::Run::close_face(self).ok_or_else(unclear)
    }
}

impl Reader {
    pub(super) fn new(vertex_limit: usize, block: usize) -> Self {
        // A statement that continues on the next line is not divided.
        let splitter = BlockSplitter::new(block, |line| trimmed(line).last() != Some(&b'\\'));
        Self { lines: Lines::after(0), mesh: Mesh::new(vertex_limit), content: Content::default(), splitter }
    }

    /// The memory that the vertices take, in bytes.
    pub(super) fn held_bytes(&self) -> usize {
        self.mesh.vertices().held_bytes()
    }

    pub(super) fn finish<S: Sink>(mut self, sink: &mut S) -> Result<Summary, Fault> {
        let number = self.lines.number();
        let mut target = Whole { mesh: &mut self.mesh, sink: &mut *sink };
        self.lines.finish(|line, _| self.content.line(line, &mut target))?;
        self.content.end(&mut target).map_err(|flaw| flaw.at_line(number))?;
        let mesh = &self.mesh;
        let notes = Notes { other_elements: self.content.other_elements, crossed_polygons: mesh.crossed(), ..Notes::default() };
        if mesh.facets() > 0 {
            return Ok(Summary { format: Format::Obj, points: 0, facets: mesh.facets(), unit: None, notes });
        }
        if mesh.vertices().is_empty() {
            return Err(Flaw::new(FaultKind::Empty, "a vertex", "the end of the file").at_line(number));
        }
        for vertex in mesh.vertices().iter() {
            sink.point(*vertex);
        }
        Ok(Summary { format: Format::Obj, points: mesh.vertices().len() as u64, facets: 0, unit: None, notes })
    }
}

impl BlockReader for Reader {
    type Job = ();
    type Run = Run;

    fn next_unit<'a>(&mut self, chunk: &mut &'a [u8]) -> Result<Option<Unit<'a, ()>>, Fault> {
        Ok(self.splitter.next(chunk).map(|bytes| Unit::Block(Block { bytes, job: () })))
    }

    fn rest(&mut self) -> Vec<u8> {
        self.splitter.rest()
    }

    /// Adds the content of a block, unless a statement continues in it or it refers to a missing vertex.
    fn link(&mut self, run: &mut Run, _: &[u8]) -> bool {
        if !self.content.begun.is_empty() || !self.mesh.link(&mut run.mesh) {
            return false;
        }
        self.content.other_elements += run.content.other_elements;
        self.lines.skip(run.lines);
        true
    }

    fn emit<S: Sink>(&self, run: &Run, _: &[u8], sink: &mut S) -> Emitted {
        self.mesh.emit(&run.mesh, sink)
    }

    /// `None` also if a block refers to vertices whose numbers cannot be determined without the file before it.
    fn parse(bytes: &[u8], (): ()) -> Option<Run> {
        let (mut lines, mut content, mut mesh) = (Lines::after(0), Content::default(), mesh::Run::of_bytes(bytes.len()));
        lines.push(bytes, |line, _| content.line(line, &mut mesh)).ok()?;
        content.begun.is_empty().then_some(Run { lines: lines.ended(), mesh, content })
    }

    fn count(&mut self, emitted: Emitted) {
        self.mesh.count(emitted);
    }

    fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        let mut target = Whole { mesh: &mut self.mesh, sink };
        self.lines.push(chunk, |line, _| self.content.line(line, &mut target))
    }
}

impl Content {
    /// Reads a line. A backslash at its end continues the statement on the next line, except in a comment, where it may
    /// end a path.
    fn line(&mut self, line: &[u8], target: &mut impl Target) -> Result<(), Flaw> {
        let line = trimmed(line);
        if self.begun.is_empty() && line.first() == Some(&b'#') {
            return Ok(());
        }
        if self.begun.is_empty() && line.last() != Some(&b'\\') {
            return self.statement(line, target);
        }
        let (part, goes_on) = line.strip_suffix(b"\\").map_or((line, false), |part| (part, true));
        if self.begun.len() + part.len() >= LONGEST_LINE {
            return Err(too_long());
        }
        self.begun.extend_from_slice(part);
        self.begun.push(b' ');
        if goes_on { Ok(()) } else { self.end(target) }
    }

    /// Reads the statement that was joined from several lines.
    fn end(&mut self, target: &mut impl Target) -> Result<(), Flaw> {
        let mut joined = std::mem::take(&mut self.begun);
        self.statement(&joined, target)?;
        joined.clear();
        self.begun = joined;
        Ok(())
    }

    fn statement(&mut self, statement: &[u8], target: &mut impl Target) -> Result<(), Flaw> {
        let mut words = Words::of(statement);
        match words.next() {
            Some(b"v") => vertex(words, target),
            Some(b"f" | b"fo") => face(words, target),
            Some(b"p" | b"l") => {
                self.other_elements += 1;
                Ok(())
            }
            Some(word) if word[0] != b'#' => ignored(word),
            _ => Ok(()),
        }
    }
}

fn vertex(mut words: Words, target: &mut impl Target) -> Result<(), Flaw> {
    let mut vertex = [0.0; 3];
    for (value, before) in vertex.iter_mut().zip(["none", "one", "two"]) {
        let word = words.next().ok_or_else(|| Flaw::new(FaultKind::Malformed, "three numbers after \"v\"", before))?;
        *value = coordinate(word, "a number")?;
    }
    target.vertex(vertex)
}

fn face(words: Words, target: &mut impl Target) -> Result<(), Flaw> {
    for word in words.take_while(|word| word[0] != b'#') {
        target.corner(vertex_number(word)?, word)?;
    }
    target.close_face()
}

/// A vertex number as a face writes it: counted from the first vertex, or backwards from the last.
#[derive(Debug, Clone, Copy)]
struct VertexNumber {
    backwards: bool,
    count: usize,
}

impl VertexNumber {
    /// The index of the vertex, counted from 0, if `before` vertices have been read.
    fn resolve(self, before: usize) -> Option<usize> {
        if self.backwards { before.checked_sub(self.count).filter(|_| self.count > 0) } else { self.count.checked_sub(1) }
    }
}

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn vertex_number(word: &[u8]) -> Result<VertexNumber, Flaw> {
    let backwards = word[0] == b'-';
    let start = usize::from(backwards);
    let mut at = start;
    let mut count: usize = 0;
    while let Some(digit) = word.get(at).map(|byte| byte.wrapping_sub(b'0')).filter(|digit| *digit < 10) {
        // If the count saturates, it is out of range like the number itself.
        count = count.saturating_mul(10).saturating_add(usize::from(digit));
        at += 1;
    }
    let others = &word[at..];
    let well_formed = others.is_empty()
        || (others[0] == b'/'
            && others.split(|byte| *byte == b'/').count() <= 3
            && others.iter().all(|byte| matches!(byte, b'/' | b'-' | b'0'..=b'9')));
    if at == start || !well_formed {
        return Err(Flaw::malformed("a corner as v, v/vt, v//vn or v/vt/vn", word));
    }
    Ok(VertexNumber { backwards, count })
}

/// Accepts statements that do not affect the shape, and refuses the others.
fn ignored(keyword: &[u8]) -> Result<(), Flaw> {
    const WITHOUT_SHAPE: [&[u8]; 22] = [
        b"vt",
        b"vn",
        b"g",
        b"o",
        b"s",
        b"mg",
        b"usemtl",
        b"mtllib",
        b"usemap",
        b"maplib",
        b"bevel",
        b"c_interp",
        b"d_interp",
        b"lod",
        b"shadow_obj",
        b"trace_obj",
        b"call",
        b"csh",
        b"ctech",
        b"stech",
        b"usemat",
        b"matlib",
    ];
    const FREE_FORM: [&[u8]; 19] = [
        b"vp", b"cstype", b"deg", b"bmat", b"step", b"curv", b"curv2", b"surf", b"parm", b"trim", b"hole", b"scrv", b"sp", b"end", b"con",
        b"bsp", b"bzp", b"cdc", b"cdp",
    ];
    if WITHOUT_SHAPE.contains(&keyword) {
        return Ok(());
    }
    if FREE_FORM.contains(&keyword) {
        let found = format!("the free-form statement {}; export the surface as a mesh", quoted(keyword));
        return Err(Flaw::new(FaultKind::Malformed, "vertices and polygons", found));
    }
    Err(Flaw::malformed("a statement of OBJ", keyword))
}
