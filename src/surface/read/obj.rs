//! Reader of Wavefront OBJ: vertices (`v`), and polygons (`f`) that refer to them by number. Numbers count from 1 at the start
//! of the file, or backwards from -1.
//!
//! A face may refer only to vertices before it. Weights and colours after a vertex, texture coordinates and normals of a
//! corner, groups, materials and names are ignored. Point and line elements are not part of a surface and are counted. The
//! vertices of a file without faces are points. Unknown statements are refused. Free-form curves and surfaces are refused too,
//! because their control points do not lie on the surface. A number may have a decimal comma. A comment may state the unit.

use super::faces::Faces;
use super::input::{Input, LONGEST_LINE, ReadError, too_long};
use super::words::{CommentedUnit, Decimals, Words, trimmed};
use super::{Format, Notes, ReadSummary, Sink};
use crate::file_fault::{FileFaultKind, Flaw, quoted};

/// Reads an OBJ file of at most `vertex_limit` vertices.
pub(super) fn read(input: &mut Input, vertex_limit: usize, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
    let mut content =
        Content { faces: Faces::new(vertex_limit), decimals: Decimals::default(), unit: CommentedUnit::default(), other_elements: 0 };
    // The part of a statement that a backslash continues on the next line.
    let mut begun = Vec::new();
    input.each_line(|line, _| {
        let line = trimmed(line);
        if begun.is_empty() && (line.first() == Some(&b'#') || line.last() != Some(&b'\\')) {
            // In a comment, a backslash may end a path.
            return content.statement(line, sink);
        }
        let (part, goes_on) = line.strip_suffix(b"\\").map_or((line, false), |part| (part, true));
        if begun.len() + part.len() >= LONGEST_LINE {
            return Err(too_long());
        }
        begun.extend_from_slice(part);
        begun.push(b' ');
        if goes_on {
            return Ok(());
        }
        content.statement(&begun, sink)?;
        begun.clear();
        Ok(())
    })?;
    let end = input.number_at_end();
    content.statement(&begun, sink).map_err(|flaw| flaw.at_line(end))?;
    let Content { faces, unit, other_elements, .. } = content;
    let notes = Notes { other_elements, crossed_polygons: faces.crossed(), ..Notes::default() };
    let mut summary = ReadSummary { format: Format::Obj, points: 0, facets: faces.facets(), unit: unit.unit(), notes };
    if faces.vertices().is_empty() && summary.facets == 0 {
        return Err(Flaw::new(FileFaultKind::Empty, "a vertex", "the end of the file").at_line(end).into());
    }
    if summary.facets == 0 {
        summary.points = faces.vertices().len() as u64;
        faces.vertices().iter().for_each(|vertex| sink.point(*vertex));
    }
    Ok(summary)
}

/// The statements read so far.
struct Content {
    faces: Faces,
    decimals: Decimals,
    unit: CommentedUnit,
    other_elements: u64,
}

impl Content {
    fn statement(&mut self, statement: &[u8], sink: &mut dyn Sink) -> Result<(), Flaw> {
        let mut words = Words::of(statement);
        match words.next() {
            Some(b"v") => self.vertex(words),
            Some(b"f" | b"fo") => self.face(words, sink),
            Some(b"p" | b"l") => {
                self.other_elements += 1;
                Ok(())
            }
            Some(word) if word[0] != b'#' => ignored(word),
            Some(_) => self.unit.read(statement),
            None => Ok(()),
        }
    }

    fn vertex(&mut self, mut words: Words) -> Result<(), Flaw> {
        let mut vertex = [0.0; 3];
        for (value, before) in vertex.iter_mut().zip(["none", "one", "two"]) {
            let word = words.next().ok_or_else(|| Flaw::new(FileFaultKind::Malformed, "three numbers after \"v\"", before))?;
            *value = self.decimals.coordinate(word, "a number")?;
        }
        self.faces.add_vertex(vertex)
    }

    fn face(&mut self, words: Words, sink: &mut dyn Sink) -> Result<(), Flaw> {
        for word in words.take_while(|word| word[0] != b'#') {
            let before = self.faces.vertices().len();
            let missing = || {
                let expected = format!("the number of one of the {before} vertices before this line");
                Flaw::new(FileFaultKind::OutOfRange, expected, quoted(word))
            };
            let vertex = vertex_index(word, before)?.ok_or_else(missing)?;
            self.faces.add_corner(vertex).ok_or_else(missing)??;
        }
        self.faces.close(sink)
    }
}

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 0, after `before` vertices: the file counts
/// from 1 at its start, or backwards from -1. `None` for a number that is not that of a vertex.
fn vertex_index(word: &[u8], before: usize) -> Result<Option<usize>, Flaw> {
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
        return Err(Flaw::quoting("a corner as v, v/vt, v//vn or v/vt/vn", word));
    }
    Ok(if backwards { before.checked_sub(count).filter(|_| count > 0) } else { count.checked_sub(1) })
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
        return Err(Flaw::new(FileFaultKind::Malformed, "vertices and polygons", found));
    }
    Err(Flaw::quoting("a statement of OBJ", keyword))
}
