//! What OBJ and PLY have in common: vertices that are kept, because faces name them by number.

use super::Sink;
use super::fault::{FaultKind, Flaw};
use super::polygon::{Cut, Polygon};
use super::vertices::Vertices;

/// The vertices so far, and the face that is being read.
#[derive(Debug)]
pub(super) struct Mesh {
    vertices: Vertices,
    limit: usize,
    face: Polygon,
    facets: u64,
    crossed: u64,
}

impl Mesh {
    /// No vertices, with room for `limit`; memory is taken as they come.
    pub(super) fn new(limit: usize) -> Self {
        Self { vertices: Vertices::default(), limit, face: Polygon::default(), facets: 0, crossed: 0 }
    }

    pub(super) fn limit(&self) -> usize {
        self.limit
    }

    pub(super) fn vertices(&self) -> &Vertices {
        &self.vertices
    }

    /// Facets handed to the sink.
    pub(super) fn facets(&self) -> u64 {
        self.facets
    }

    /// Polygons that no cut into triangles represents.
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

    /// Adds the vertex of this number, counted from 0, to the face that is being read.
    pub(super) fn add_corner(&mut self, vertex: usize) -> Option<Result<(), Flaw>> {
        self.vertices.get(vertex).map(|corner| self.face.add(*corner))
    }

    /// Hands the face that has been read to the sink, in triangles, and begins another.
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

#[cold]
pub(super) fn too_many_vertices(limit: usize) -> Flaw {
    Flaw::new(FaultKind::TooLarge, format!("at most {limit} vertices"), "more")
}
