//! Reader of Wavefront OBJ: vertices (`v`) and polygons (`f`) that refer to them by number, from 1 at the start of the
//! file or from -1 backwards.
//!
//! A face may refer only to vertices before it. Weights and colours after a vertex, texture coordinates and normals of
//! a corner, groups, materials and names are ignored. Point and line elements are not part of a surface and are
//! counted. A file without faces yields its vertices as points. Unknown statements are refused, and so are free-form
//! curves and surfaces, whose control points do not lie on them.

use super::decimal::coordinate;
use super::fault::{Fault, FaultKind, Flaw, quoted};
use super::lines::{LONGEST_LINE, Lines, Words, too_long, trimmed};
use super::mesh::Mesh;
use super::{Format, Notes, Sink, Summary};

/// The reader of OBJ.
#[derive(Debug)]
pub(super) struct Reader {
    lines: Lines,
    content: Content,
}

#[derive(Debug)]
struct Content {
    mesh: Mesh,
    /// The part of a statement that a backslash continues on the next line.
    begun: Vec<u8>,
    other_elements: u64,
}

impl Reader {
    pub(super) fn new(vertex_limit: usize) -> Self {
        Self { lines: Lines::after(0), content: Content { mesh: Mesh::new(vertex_limit), begun: Vec::new(), other_elements: 0 } }
    }

    pub(super) fn push<S: Sink>(&mut self, chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        self.lines.push(chunk, |line, _| self.content.line(line, sink))
    }

    /// The memory that the vertices take, in bytes.
    pub(super) fn held_bytes(&self) -> usize {
        self.content.mesh.vertices().held_bytes()
    }

    pub(super) fn finish<S: Sink>(mut self, sink: &mut S) -> Result<Summary, Fault> {
        let number = self.lines.number();
        self.lines.finish(|line, _| self.content.line(line, sink))?;
        self.content.end(sink).map_err(|flaw| flaw.at_line(number))?;
        let mesh = &self.content.mesh;
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

impl Content {
    /// Reads a line. A backslash at its end continues the statement on the next line, except in a comment, where it may
    /// end a path.
    fn line<S: Sink>(&mut self, line: &[u8], sink: &mut S) -> Result<(), Flaw> {
        let line = trimmed(line);
        if self.begun.is_empty() && line.first() == Some(&b'#') {
            return Ok(());
        }
        if self.begun.is_empty() && line.last() != Some(&b'\\') {
            return self.statement(line, sink);
        }
        let (part, goes_on) = line.strip_suffix(b"\\").map_or((line, false), |part| (part, true));
        if self.begun.len() + part.len() >= LONGEST_LINE {
            return Err(too_long());
        }
        self.begun.extend_from_slice(part);
        self.begun.push(b' ');
        if goes_on { Ok(()) } else { self.end(sink) }
    }

    /// Reads the statement that was joined from several lines.
    fn end<S: Sink>(&mut self, sink: &mut S) -> Result<(), Flaw> {
        let mut joined = std::mem::take(&mut self.begun);
        self.statement(&joined, sink)?;
        joined.clear();
        self.begun = joined;
        Ok(())
    }

    fn statement<S: Sink>(&mut self, statement: &[u8], sink: &mut S) -> Result<(), Flaw> {
        let mut words = Words::of(statement);
        match words.next() {
            Some(b"v") => self.vertex(words),
            Some(b"f" | b"fo") => self.face(words, sink),
            Some(b"p" | b"l") => {
                self.other_elements += 1;
                Ok(())
            }
            Some(word) if word[0] != b'#' => ignored(word),
            _ => Ok(()),
        }
    }

    fn vertex(&mut self, mut words: Words) -> Result<(), Flaw> {
        let mut vertex = [0.0; 3];
        for (value, before) in vertex.iter_mut().zip(["none", "one", "two"]) {
            let word = words.next().ok_or_else(|| Flaw::new(FaultKind::Malformed, "three numbers after \"v\"", before))?;
            *value = coordinate(word, "a number")?;
        }
        self.mesh.add_vertex(vertex)
    }

    fn face<S: Sink>(&mut self, words: Words, sink: &mut S) -> Result<(), Flaw> {
        for word in words.take_while(|word| word[0] != b'#') {
            let before = self.mesh.vertices().len();
            let missing = || {
                let expected = format!("the number of one of the {before} vertices before this line");
                Flaw::new(FaultKind::OutOfRange, expected, quoted(word))
            };
            let vertex = vertex_number(word)?.resolve(before).ok_or_else(missing)?;
            self.mesh.add_corner(vertex).ok_or_else(missing)??;
        }
        self.mesh.close_face(sink)
    }
}

/// A vertex number as a face writes it: counted from the first vertex, or backwards from the last.
#[derive(Debug, Clone, Copy)]
struct VertexNumber {
    backwards: bool,
    count: usize,
}

impl VertexNumber {
    /// The index of the vertex, counted from 0, where `before` vertices have been read.
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
        // A saturated count is out of range, as the number itself is.
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
