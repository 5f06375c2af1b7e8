//! The body of ASCII PLY: one row in each line.

use super::super::Format;
use super::super::decimal::coordinate;
use super::super::fault::{Fault, FaultKind, Flaw, quoted};
use super::super::lines::{Lines, Words, trimmed_start};
use super::header::{Kind, Property, integer};
use super::{Rows, Sink, Surface};

#[derive(Debug)]
pub(super) struct Body {
    lines: Lines,
    rows: Rows,
}

impl Body {
    pub(super) fn new(rows: Rows, lines_before: u64) -> Self {
        Self { lines: Lines::after(lines_before), rows }
    }

    pub(super) fn push<S: Sink>(&mut self, chunk: &[u8], surface: &mut Surface, sink: &mut S) -> Result<(), Fault> {
        self.lines.push(chunk, |line, _| self.rows.line(line, surface, sink))
    }

    pub(super) fn finish<S: Sink>(mut self, surface: &mut Surface, sink: &mut S) -> Result<Format, Fault> {
        self.lines.finish(|line, _| self.rows.line(line, surface, sink))?;
        self.rows.missing().map_or(Ok(Format::PlyAscii), |flaw| Err(flaw.at_line(self.lines.number())))
    }
}

impl Rows {
    fn line<S: Sink>(&mut self, line: &[u8], surface: &mut Surface, sink: &mut S) -> Result<(), Flaw> {
        let content = trimmed_start(line);
        if content.is_empty() {
            return Ok(());
        }
        let Some(element) = self.element() else {
            surface.trailing_bytes += content.len() as u64;
            return Ok(());
        };
        let kind = element.kind;
        surface.begin_row(kind);
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
                            add_corner(item, surface, sink)?;
                        }
                    }
                }
            }
        }
        if let Some(word) = words.next() {
            return Err(Flaw::malformed(format!("the end of a row of the element {}", element.name), word));
        }
        match kind {
            Kind::Vertex => surface.vertex(vertex, sink)?,
            Kind::Face => surface.mesh.close_face(sink)?,
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

fn add_corner<S: Sink>(word: &[u8], surface: &mut Surface, sink: &mut S) -> Result<(), Flaw> {
    let number = integer(word);
    if number.is_none() && integer(word.strip_prefix(b"-").unwrap_or(word)).is_none() {
        return Err(Flaw::malformed("the number of a vertex", word));
    }
    surface.corner(number, &|| quoted(word), sink)
}
