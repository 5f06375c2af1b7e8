//! Reader of PLY: a header that describes elements and their properties, then the rows of one element after the other,
//! as text or binary in either byte order.
//!
//! Vertices need scalars x, y and z of any type; faces a list `vertex_indices` or `vertex_index` of integers. Other
//! properties and other elements are skipped by their description in the header. Vertices must come before faces. A
//! file without faces yields its vertices as points, which are not held. Triangle strips (`tristrips`) are read as
//! well: every vertex after the first two of a strip forms a triangle with the two before it, and -1 starts another
//! strip.

mod ascii;
mod binary;
mod header;
mod strip;

use super::fault::{Fault, FaultKind, Flaw};
use super::mesh::{Mesh, too_many_vertices};
use super::{Format, Notes, Sink, Summary};
use header::{Element, Header, HeaderLines, Kind};
use std::collections::VecDeque;
use strip::Strip;

/// The reader of PLY.
#[derive(Debug)]
pub(super) struct Reader {
    stage: Stage,
    surface: Surface,
}

#[derive(Debug)]
enum Stage {
    Header(HeaderLines),
    Ascii(ascii::Body),
    Binary(binary::Body),
}

/// The surface that the rows of either kind of body describe.
#[derive(Debug)]
struct Surface {
    mesh: Mesh,
    /// The strip that is being read, where the element is triangle strips.
    strip: Option<Strip>,
    /// Faces or strips follow, so that vertices must be held.
    keeps: bool,
    points: u64,
    other_elements: u64,
    trailing_bytes: u64,
}

/// The elements with rows that are still to be read.
#[derive(Debug)]
struct Rows {
    elements: VecDeque<Element>,
    /// Rows of the first of them that have been read.
    read: u64,
}

impl Reader {
    /// `skipped` bytes of the file precede the header.
    pub(super) fn new(vertex_limit: usize, skipped: u64) -> Self {
        let surface = Surface { mesh: Mesh::new(vertex_limit), strip: None, keeps: false, points: 0, other_elements: 0, trailing_bytes: 0 };
        Self { stage: Stage::Header(HeaderLines::after(skipped)), surface }
    }

    pub(super) fn push<S: Sink>(&mut self, mut chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        if let Stage::Header(lines) = &mut self.stage {
            let Some(header) = lines.push(&mut chunk)? else { return Ok(()) };
            self.stage = self.surface.begin(header, lines)?;
        }
        match &mut self.stage {
            Stage::Header(_) => Ok(()),
            Stage::Ascii(body) => body.push(chunk, &mut self.surface, sink),
            Stage::Binary(body) => body.push(chunk, &mut self.surface, sink),
        }
    }

    /// The memory that the vertices take, in bytes.
    pub(super) fn held_bytes(&self) -> usize {
        self.surface.mesh.vertices().held_bytes()
    }

    pub(super) fn finish<S: Sink>(mut self, sink: &mut S) -> Result<Summary, Fault> {
        let format = match self.stage {
            Stage::Header(lines) => return Err(lines.cut_off()),
            Stage::Ascii(body) => body.finish(&mut self.surface, sink)?,
            Stage::Binary(body) => body.finish()?,
        };
        let mesh = &self.surface.mesh;
        if self.surface.keeps && mesh.facets() == 0 {
            return Err(Flaw::new(FaultKind::Empty, "a triangle in the strips", "none").at_byte(0));
        }
        let notes = Notes {
            trailing_bytes: self.surface.trailing_bytes,
            other_elements: self.surface.other_elements,
            crossed_polygons: mesh.crossed(),
            ..Notes::default()
        };
        Ok(Summary { format, points: self.surface.points, facets: mesh.facets(), unit: None, notes })
    }
}

impl Surface {
    fn begin(&mut self, header: Header, lines: &HeaderLines) -> Result<Stage, Fault> {
        let count = |kind| header.elements.iter().filter(|element| element.kind == kind).map(|element| element.count).sum::<u64>();
        self.keeps = count(Kind::Face) > 0 || count(Kind::TriStrips) > 0;
        self.other_elements = header
            .elements
            .iter()
            .filter(|element| element.kind == Kind::Other)
            .fold(0, |sum: u64, element| sum.saturating_add(element.count));
        let vertices = count(Kind::Vertex);
        if vertices == 0 {
            return Err(lines.fault(Flaw::new(FaultKind::Empty, "a vertex", "0 vertices in the header")));
        }
        if self.keeps && vertices > self.mesh.limit() as u64 {
            return Err(lines.fault(too_many_vertices(self.mesh.limit())));
        }
        let mut rows = Rows { elements: header.elements.into(), read: 0 };
        rows.settle();
        Ok(match header.format {
            Format::PlyAscii => Stage::Ascii(ascii::Body::new(rows, lines.ended())),
            format => Stage::Binary(binary::Body::new(rows, format, lines.bytes())),
        })
    }

    fn vertex<S: Sink>(&mut self, vertex: [f64; 3], sink: &mut S) -> Result<(), Flaw> {
        if self.keeps {
            return self.mesh.add_vertex(vertex);
        }
        self.points += 1;
        sink.point(vertex);
        Ok(())
    }

    /// Starts to read a row of this kind.
    fn begin_row(&mut self, kind: Kind) {
        self.strip = (kind == Kind::TriStrips).then(Strip::default);
    }

    /// A corner of the current face or strip; `None` stands for a negative number.
    fn corner<S: Sink>(&mut self, vertex: Option<u64>, written: &dyn Fn() -> String, sink: &mut S) -> Result<(), Flaw> {
        let number = vertex.and_then(|vertex| usize::try_from(vertex).ok());
        let added = match &mut self.strip {
            Some(strip) => strip.add(number, &mut self.mesh, sink).map(Ok),
            None => number.and_then(|number| self.mesh.add_corner(number)),
        };
        added.unwrap_or_else(|| {
            let expected = format!("the number of one of {} vertices, from 0", self.mesh.vertices().len());
            Err(Flaw::new(FaultKind::OutOfRange, expected, written()))
        })
    }
}

impl Rows {
    /// The element whose row comes next.
    fn element(&self) -> Option<&Element> {
        self.elements.front()
    }

    /// Counts a row that has been read.
    fn advance(&mut self) {
        self.read += 1;
        self.settle();
    }

    /// Drops elements without further rows, and those without properties, whose rows are empty.
    fn settle(&mut self) {
        while self.element().is_some_and(|element| element.properties.is_empty() || self.read >= element.count) {
            self.elements.pop_front();
            self.read = 0;
        }
    }

    /// The fault of a file that ends here, unless all rows have been read.
    fn missing(&self) -> Option<Flaw> {
        let element = self.element()?;
        let expected = format!("{} rows of the element {}, as the header says", element.count, element.name);
        Some(Flaw::new(FaultKind::Truncated, expected, format!("the end of the file after {}", self.read)))
    }
}
