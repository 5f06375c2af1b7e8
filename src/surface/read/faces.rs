//! Vertices and faces of an indexed mesh, for the readers of OBJ and PLY.

use super::Sink;
use super::polygon::{Cut, Polygon};
use super::vertices::Vertices;
use crate::file_fault::{FileFaultKind, Flaw};

/// The vertices read so far, and the face that is being read.
#[derive(Debug)]
pub(super) struct Faces {
    vertices: Vertices,
    limit: usize,
    face: Polygon,
    facets: u64,
    crossed: u64,
}

impl Faces {
    /// No faces, for at most `limit` vertices; memory grows with the vertices that arrive.
    pub(super) fn new(limit: usize) -> Self {
        Self { vertices: Vertices::default(), limit, face: Polygon::default(), facets: 0, crossed: 0 }
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
    pub(super) fn add_triangle(&mut self, vertices: [usize; 3], sink: &mut dyn Sink) -> Option<()> {
        let [a, b, c] = vertices;
        let corners = [*self.vertices.get(a)?, *self.vertices.get(b)?, *self.vertices.get(c)?];
        if a != b && b != c && c != a {
            self.facets += 1;
            sink.facet(corners);
        }
        Some(())
    }

    /// Passes the current face to the sink as triangles, and starts the next.
    pub(super) fn close(&mut self, sink: &mut dyn Sink) -> Result<(), Flaw> {
        let corners = self.face.corners().len();
        if corners < 3 {
            let found = ["none", "one", "two"][corners];
            return Err(Flaw::new(FileFaultKind::Malformed, "a face with three corners at least", found));
        }
        let cut = self.face.cut(|corners| sink.facet(corners))?;
        self.facets += (corners - 2) as u64;
        self.crossed += u64::from(cut == Cut::Crossed);
        self.face.clear();
        Ok(())
    }
}

#[cold]
pub(super) fn too_many_vertices(limit: usize) -> Flaw {
    Flaw::new(FileFaultKind::TooLarge, format!("at most {limit} vertices"), "more")
}
