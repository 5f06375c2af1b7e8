//! Vertices and faces of an indexed mesh, for the readers of OBJ and PLY: those of a whole file, or those of a block
//! that is parsed independently.

use super::Sink;
use super::blocks::Emitted;
use super::fault::{FaultKind, Flaw};
use super::polygon::{Cut, MOST_CORNERS_BY_EARS, Polygon};
use super::vertices::Vertices;

/// The vertices read so far, and the face that is being read.
#[derive(Debug)]
pub(super) struct Mesh {
    vertices: Vertices,
    limit: usize,
    face: Polygon,
    facets: u64,
    crossed: u64,
}

impl Mesh {
    /// An empty mesh of at most `limit` vertices; memory grows with the vertices that arrive.
    pub(super) fn new(limit: usize) -> Self {
        Self { vertices: Vertices::default(), limit, face: Polygon::default(), facets: 0, crossed: 0 }
    }

    pub(super) fn limit(&self) -> usize {
        self.limit
    }

    pub(super) fn vertices(&self) -> &Vertices {
        &self.vertices
    }

    /// The number of facets passed to the sink.
    pub(super) fn facets(&self) -> u64 {
        self.facets
    }

    /// The number of polygons whose outline crosses itself.
    pub(super) fn crossed(&self) -> u64 {
        self.crossed
    }

    pub(super) fn add_vertex(&mut self, vertex: [f64; 3]) -> Result<(), Flaw> {
        if self.vertices.len() >= self.limit {
            return Err(too_many_vertices(self.limit));
        }
        self.vertices.push(vertex);
        Ok(())
    }

    /// Adds the vertex with this number, counted from 0, to the face that is being read.
    pub(super) fn add_corner(&mut self, vertex: usize) -> Option<Result<(), Flaw>> {
        self.vertices.get(vertex).map(|corner| self.face.add(*corner))
    }

    /// Passes a triangle of the vertices with these numbers to the sink, unless a number occurs twice; `None` if a
    /// vertex is missing.
    pub(super) fn add_triangle<S: Sink>(&mut self, vertices: [usize; 3], sink: &mut S) -> Option<()> {
        let [a, b, c] = vertices;
        let corners = [*self.vertices.get(a)?, *self.vertices.get(b)?, *self.vertices.get(c)?];
        if a != b && b != c && c != a {
            self.facets += 1;
            sink.facet(corners);
        }
        Some(())
    }

    /// Passes the current face to the sink as triangles, and starts the next.
    pub(super) fn close_face<S: Sink>(&mut self, sink: &mut S) -> Result<(), Flaw> {
        let corners = self.face.corners().len();
        if corners < 3 {
            let found = ["none", "one", "two"][corners];
            return Err(Flaw::new(FaultKind::Malformed, "a face with three corners at least", found));
        }
        let cut = self.face.cut(|corners| sink.facet(corners))?;
        self.facets += (corners - 2) as u64;
        self.crossed += u64::from(cut == Cut::Crossed);
        self.face.clear();
        Ok(())
    }
}

/// The mark of a vertex number that counts backwards. The other bits are the distance from the run's first vertex, plus
/// [`ORIGIN`].
const BACKWARDS: u32 = 1 << 31;
const ORIGIN: i64 = 1 << 30;

/// Vertices and faces of a block, parsed without the file before it. Methods return `None` if the block must be read in
/// order.
#[derive(Debug, Default)]
pub(super) struct Run {
    vertices: Vec<[f64; 3]>,
    /// The numbers of the vertices at all corners.
    corners: Vec<u32>,
    /// The end of each face in `corners`.
    ends: Vec<u32>,
    /// The number of vertices that must precede the run so that every corner has a vertex.
    required: i64,
    /// The number of vertices that precede the run.
    before: i64,
}

impl Run {
    /// An empty run, with room for the vertices and faces that `bytes` bytes usually contain.
    pub(super) fn of_bytes(bytes: usize) -> Self {
        Self { corners: Vec::with_capacity(bytes / 8), ends: Vec::with_capacity(bytes / 24), ..Self::default() }
    }

    pub(super) fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    pub(super) fn add_vertex(&mut self, vertex: [f64; 3]) {
        self.vertices.push(vertex);
    }

    /// Adds a corner at the vertex with this number, counted from 0 at the start of the file.
    pub(super) fn add_corner(&mut self, number: usize) -> Option<()> {
        let number = u32::try_from(number).ok().filter(|number| *number < BACKWARDS)?;
        self.require(i64::from(number) + 1 - self.length()?);
        self.corners.push(number);
        Some(())
    }

    /// Adds a corner at a vertex counted backwards: 1 is the last.
    pub(super) fn add_corner_backwards(&mut self, count: usize) -> Option<()> {
        let count = i64::try_from(count).ok().filter(|count| (1..ORIGIN).contains(count))?;
        let from_first = self.length()? - count;
        self.require(-from_first);
        self.corners.push(BACKWARDS | u32::try_from(from_first + ORIGIN).ok()?);
        Some(())
    }

    /// Ends a face. Faces that may be faulty are left to the sequential reader.
    pub(super) fn close_face(&mut self) -> Option<()> {
        let corners = self.corners.len() - self.ends.last().map_or(0, |end| *end as usize);
        self.ends.push(u32::try_from(self.corners.len()).ok()?);
        (3..=MOST_CORNERS_BY_EARS).contains(&corners).then_some(())
    }

    fn length(&self) -> Option<i64> {
        i64::try_from(self.vertices.len()).ok().filter(|length| *length < ORIGIN)
    }

    fn require(&mut self, vertices: i64) {
        self.required = self.required.max(vertices);
    }

    /// The index of a corner's vertex in the file.
    fn index(&self, corner: u32) -> Option<usize> {
        if corner < BACKWARDS {
            return usize::try_from(corner).ok();
        }
        usize::try_from(self.before + i64::from(corner - BACKWARDS) - ORIGIN).ok()
    }
}

impl Mesh {
    /// Adds the vertices of a run, unless they are too many or the run refers to a missing one.
    pub(super) fn link(&mut self, run: &mut Run) -> bool {
        let Ok(before) = i64::try_from(self.vertices.len()) else { return false };
        if self.vertices.len() + run.vertices.len() > self.limit || run.required > before {
            return false;
        }
        run.before = before;
        for vertex in std::mem::take(&mut run.vertices) {
            self.vertices.push(vertex);
        }
        true
    }

    /// Passes the faces of a run that was linked to `sink` as triangles.
    pub(super) fn emit<S: Sink>(&self, run: &Run, sink: &mut S) -> Emitted {
        let vertex = |corner: u32| {
            let found = run.index(corner).and_then(|index| self.vertices.get(index));
            *found.unwrap_or_else(|| unreachable!("the numbers were checked when the run was linked"))
        };
        let (mut polygon, mut start, mut emitted) = (Polygon::default(), 0, Emitted::default());
        for &end in &run.ends {
            let corners = &run.corners[start..end as usize];
            start = end as usize;
            emitted.facets += corners.len() as u64 - 2;
            if let &[a, b, c] = corners {
                sink.facet([vertex(a), vertex(b), vertex(c)]);
                continue;
            }
            polygon.clear();
            let added = corners.iter().try_for_each(|corner| polygon.add(vertex(*corner)));
            let cut = added.and_then(|()| polygon.cut(|corners| sink.facet(corners)));
            emitted.crossed += u64::from(cut.unwrap_or_else(|_| unreachable!("runs have no faces of many corners")) == Cut::Crossed);
        }
        emitted
    }

    /// Counts the facets that runs passed to the sink.
    pub(super) fn count(&mut self, emitted: Emitted) {
        self.facets += emitted.facets;
        self.crossed += emitted.crossed;
    }
}

#[cold]
pub(super) fn too_many_vertices(limit: usize) -> Flaw {
    Flaw::new(FaultKind::TooLarge, format!("at most {limit} vertices"), "more")
}
