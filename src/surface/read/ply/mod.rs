//! Reader of PLY: a header that describes elements and their properties, then the rows of one element after the other,
//! as text or binary in either byte order.
//!
//! Vertices need scalars x, y and z of any type; faces a list `vertex_indices` or `vertex_index` of integers. Other
//! properties and other elements are skipped; the header states their sizes. Vertices must come before faces. The
//! vertices of a file without faces are points, which are passed on and not stored. Triangle strips (`tristrips`) are
//! read as well: every vertex after the first two of a strip forms a triangle with the two before it, and -1 starts a
//! new strip.

mod ascii;
mod binary;
mod header;
mod strip;

use super::blocks::{BlockReader, Emitted, Unit};
use super::fault::{Fault, FaultKind, Flaw};
use super::mesh::{self, Mesh, too_many_vertices};
use super::{Format, Notes, Sink, Summary};
use header::{Element, Header, HeaderLines, Kind, Property};
use std::sync::Arc;
use strip::Strip;

/// The reader of PLY.
#[derive(Debug)]
pub(super) struct Reader {
    stage: Stage,
    surface: Surface,
    /// The size of blocks.
    block: usize,
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
    /// The strip that is being read, if the element has triangle strips.
    strip: Option<Strip>,
    /// Whether faces or strips follow, so that vertices must be stored.
    keeps: bool,
    points: u64,
    other_elements: u64,
    trailing_bytes: u64,
}

/// The position in the rows of a file: its elements, and the number of rows read.
#[derive(Debug, Clone)]
struct Rows {
    elements: Arc<[Element]>,
    /// The index of the element whose row comes next.
    at: usize,
    /// The rows of this element that have been read.
    read: u64,
}

/// The receiver of the rows of a body: the surface of the whole file, or that of a block.
trait Target {
    /// Starts to read a row of this kind.
    fn begin_row(&mut self, kind: Kind);
    fn vertex(&mut self, vertex: [f64; 3]) -> Result<(), Flaw>;
    /// A corner of the current face or strip; `None` for a negative number. `written` returns the text of the file, for
    /// the fault.
    fn corner(&mut self, vertex: Option<u64>, written: &dyn Fn() -> String) -> Result<(), Flaw>;
    fn close_face(&mut self) -> Result<(), Flaw>;
    /// Counts bytes after the last row.
    fn trail(&mut self, bytes: u64);
}

/// The surface of the whole file, and the sink for its points or facets.
struct Whole<'a, S> {
    surface: &'a mut Surface,
    sink: &'a mut S,
}

/// The assumption about the start of a block: the row with which it begins.
#[derive(Debug)]
pub(super) enum Job {
    Ascii(ascii::Job),
    Binary(binary::Job),
}

/// The rows of a block.
#[derive(Debug)]
pub(super) struct Run {
    lines: u64,
    start: Rows,
    end: Rows,
    mesh: mesh::Run,
    trailing_bytes: u64,
}

impl Reader {
    /// A reader of a file whose header begins after `skipped` bytes.
    pub(super) fn new(vertex_limit: usize, skipped: u64, block: usize) -> Self {
        let surface = Surface { mesh: Mesh::new(vertex_limit), strip: None, keeps: false, points: 0, other_elements: 0, trailing_bytes: 0 };
        Self { stage: Stage::Header(HeaderLines::after(skipped)), surface, block }
    }

    /// The fewest bytes that a facet takes in the body: a polygon or strip has a corner more for each facet more.
    pub(super) fn fewest_bytes_of_a_facet(&self) -> usize {
        match &self.stage {
            Stage::Header(_) => 1,
            // A digit and a blank.
            Stage::Ascii(_) => 2,
            Stage::Binary(body) => body.rows().fewest_bytes_of_a_corner(),
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

impl BlockReader for Reader {
    type Job = Job;
    type Run = Run;

    /// A piece of the body. The header is read here.
    fn next_unit<'a>(&mut self, chunk: &mut &'a [u8]) -> Result<Option<Unit<'a, Job>>, Fault> {
        if let Stage::Header(lines) = &mut self.stage {
            let Some(header) = lines.push(chunk)? else { return Ok(None) };
            self.stage = self.surface.begin(header, lines, self.block)?;
        }
        Ok(match &mut self.stage {
            Stage::Header(_) => None,
            Stage::Ascii(body) => body.next_unit(chunk),
            Stage::Binary(body) => body.next_unit(chunk),
        })
    }

    fn rest(&mut self) -> Vec<u8> {
        match &mut self.stage {
            Stage::Header(_) => Vec::new(),
            Stage::Ascii(body) => body.rest(),
            Stage::Binary(body) => body.rest(),
        }
    }

    /// Adds the rows of a block, unless other rows were expected or a face refers to a missing
    /// vertex.
    fn link(&mut self, run: &mut Run, bytes: &[u8]) -> bool {
        let rows = match &self.stage {
            Stage::Header(_) => return false,
            Stage::Ascii(body) => body.rows(),
            Stage::Binary(body) => body.rows(),
        };
        if !rows.is_at(&run.start) || (self.surface.keeps && !self.surface.mesh.link(&mut run.mesh)) {
            return false;
        }
        if !self.surface.keeps {
            self.surface.points += run.mesh.vertices().len() as u64;
        }
        self.surface.trailing_bytes += run.trailing_bytes;
        match &mut self.stage {
            Stage::Header(_) => {}
            Stage::Ascii(body) => body.skip(run.end.clone(), run.lines),
            Stage::Binary(body) => body.skip(run.end.clone(), bytes.len()),
        }
        true
    }

    fn emit<S: Sink>(&self, run: &Run, _: &[u8], sink: &mut S) -> Emitted {
        if self.surface.keeps {
            return self.surface.mesh.emit(&run.mesh, sink);
        }
        for vertex in run.mesh.vertices() {
            sink.point(*vertex);
        }
        Emitted::default()
    }

    fn parse(bytes: &[u8], job: Job) -> Option<Run> {
        match job {
            Job::Ascii(job) => ascii::parse(bytes, job),
            Job::Binary(job) => binary::parse(bytes, job),
        }
    }

    fn count(&mut self, emitted: Emitted) {
        self.surface.mesh.count(emitted);
    }

    fn push<S: Sink>(&mut self, mut chunk: &[u8], sink: &mut S) -> Result<(), Fault> {
        if let Stage::Header(lines) = &mut self.stage {
            let Some(header) = lines.push(&mut chunk)? else { return Ok(()) };
            self.stage = self.surface.begin(header, lines, self.block)?;
        }
        match &mut self.stage {
            Stage::Header(_) => Ok(()),
            Stage::Ascii(body) => body.push(chunk, &mut self.surface, sink),
            Stage::Binary(body) => body.push(chunk, &mut self.surface, sink),
        }
    }
}

impl Surface {
    fn begin(&mut self, header: Header, lines: &HeaderLines, block: usize) -> Result<Stage, Fault> {
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
        let mut rows = Rows { elements: header.elements.into(), at: 0, read: 0 };
        rows.settle();
        Ok(match header.format {
            Format::PlyAscii => Stage::Ascii(ascii::Body::new(rows, lines.ended(), block)),
            format => Stage::Binary(binary::Body::new(rows, format, lines.bytes(), block)),
        })
    }
}

impl<S: Sink> Target for Whole<'_, S> {
    fn begin_row(&mut self, kind: Kind) {
        self.surface.strip = (kind == Kind::TriStrips).then(Strip::default);
    }

    fn vertex(&mut self, vertex: [f64; 3]) -> Result<(), Flaw> {
        if self.surface.keeps {
            return self.surface.mesh.add_vertex(vertex);
        }
        self.surface.points += 1;
        self.sink.point(vertex);
        Ok(())
    }

    fn corner(&mut self, vertex: Option<u64>, written: &dyn Fn() -> String) -> Result<(), Flaw> {
        let number = vertex.and_then(|vertex| usize::try_from(vertex).ok());
        let Surface { mesh, strip, .. } = &mut *self.surface;
        let added = match strip {
            Some(strip) => strip.add(number, mesh, self.sink).map(Ok),
            None => number.and_then(|number| mesh.add_corner(number)),
        };
        added.unwrap_or_else(|| {
            let expected = format!("the number of one of {} vertices, from 0", mesh.vertices().len());
            Err(Flaw::new(FaultKind::OutOfRange, expected, written()))
        })
    }

    fn close_face(&mut self) -> Result<(), Flaw> {
        self.surface.mesh.close_face(self.sink)
    }

    fn trail(&mut self, bytes: u64) {
        self.surface.trailing_bytes += bytes;
    }
}

/// The flaw of a block that must be read in order; it is never reported.
fn unclear() -> Flaw {
    Flaw::new(FaultKind::Malformed, "", "")
}

impl Run {
    /// An empty run that begins at these rows, with room for the rows of a block of `bytes` bytes.
    fn of_bytes(bytes: usize, start: Rows) -> Self {
        Self { lines: 0, end: start.clone(), start, mesh: mesh::Run::of_bytes(bytes), trailing_bytes: 0 }
    }
}

impl Target for Run {
    // Files with strips are not divided into blocks.
    fn begin_row(&mut self, _: Kind) {}

    fn vertex(&mut self, vertex: [f64; 3]) -> Result<(), Flaw> {
        self.mesh.add_vertex(vertex);
        Ok(())
    }

    fn corner(&mut self, vertex: Option<u64>, _: &dyn Fn() -> String) -> Result<(), Flaw> {
        vertex.and_then(|vertex| usize::try_from(vertex).ok()).and_then(|number| self.mesh.add_corner(number)).ok_or_else(unclear)
    }

    fn close_face(&mut self) -> Result<(), Flaw> {
        self.mesh.close_face().ok_or_else(unclear)
    }

    fn trail(&mut self, bytes: u64) {
        self.trailing_bytes += bytes;
    }
}

impl Rows {
    /// The element whose row comes next.
    fn element(&self) -> Option<&Element> {
        self.elements.get(self.at)
    }

    /// Whether `other` is at the same row of the same file.
    fn is_at(&self, other: &Self) -> bool {
        (self.at, self.read) == (other.at, other.read)
    }

    /// Whether any element with rows has triangle strips.
    fn have_strips(&self) -> bool {
        self.elements.iter().any(|element| element.kind == Kind::TriStrips && element.count > 0)
    }

    /// The fewest bytes of a corner in the lists of faces and strips; 1 without such lists.
    fn fewest_bytes_of_a_corner(&self) -> usize {
        let sizes = self.elements.iter().flat_map(|element| &element.properties).filter_map(|property| match property {
            Property::List { item, corners: true, .. } => Some(item.size()),
            _ => None,
        });
        sizes.min().unwrap_or(1)
    }

    /// Counts a row that has been read.
    fn advance(&mut self) {
        self.read += 1;
        self.settle();
    }

    /// Counts this many rows.
    fn skip(&mut self, mut rows: u64) {
        while let Some(element) = self.element().filter(|_| rows > 0) {
            let some = rows.min(element.count - self.read);
            self.read += some;
            rows -= some;
            self.settle();
        }
    }

    /// Skips elements without further rows, and elements without properties, whose rows are empty.
    fn settle(&mut self) {
        while self.element().is_some_and(|element| element.properties.is_empty() || self.read >= element.count) {
            self.at += 1;
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
