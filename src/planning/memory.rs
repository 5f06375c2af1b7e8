//! The memory that planning takes, computed in advance so that a caller can reserve it.

use super::plan::CandidateCutter;
use crate::surface::mesh::MeshSize;
use crate::surface::{FinishFacet, Mesh};

/// Bytes for each facet and point of a mesh: corner indices and coordinates.
const MESH_FACET: usize = 12;
const MESH_POINT: usize = 24;

/// Bytes for each facet: class, piece and selection.
const CLASSES: usize = 20;

/// Bytes for each cell of a view from above: height, facet and side.
const VIEW_CELL: usize = 13;

/// Bytes while curvatures are estimated: normal, area, equations and neighbours of each facet, and the normal at each
/// point.
const CURVATURE_FACET: usize = 192;
const CURVATURE_POINT: usize = 60;

/// Bytes for each facet of a plan: corners in the order of the drop-cutter with its nodes, the copy of the mesh with the facets
/// around each point, and what is to be machined with its slope.
const PLANNED_FACET: usize = 72 + 32 + 36 + 12 + 152 + 104;

/// The bytes of places, stations, moves and their grids, whatever the size of the part.
const FIXED: usize = 48 << 20;

/// The cells along each side of the raster of maps.
pub const MAP_SIDE: usize = 256;

/// The largest number of diameters of a cutter along a surface that is counted.
pub(crate) const COARSE_DIAMETERS: usize = 42;

/// The size of a ranking, on which its memory depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RankingSize {
    /// The facets of the part.
    pub facets: usize,
    /// The candidates.
    pub candidates: usize,
    /// Not used.
    pub diameters: usize,
}

impl RankingSize {
    /// The size of a ranking of candidates on a mesh.
    pub(crate) fn of(mesh: &Mesh, candidates: &[CandidateCutter]) -> Self {
        Self { facets: mesh.size().facets, candidates: candidates.len(), diameters: 0 }
    }
}

/// The use of threads by a ranking.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parallelism {
    /// The number of threads.
    pub threads: usize,
}

/// The memory of a mesh of this size, in bytes.
#[must_use]
pub fn bytes_of_mesh(MeshSize { facets, points }: MeshSize) -> usize {
    facets * MESH_FACET + points * MESH_POINT
}

/// The memory in bytes to classify the facets of a mesh of this size, to estimate their curvatures and to compute the
/// view from above, in addition to the mesh.
#[must_use]
pub fn bytes_to_prepare(MeshSize { facets, points }: MeshSize) -> usize {
    let view = (8 * facets).clamp(1 << 12, 1 << 20) * VIEW_CELL;
    let curvatures = facets * CURVATURE_FACET + points * CURVATURE_POINT;
    facets * CLASSES + (curvatures + view).max(facets * size_of::<FinishFacet>() + MAP_SIDE * MAP_SIDE * VIEW_CELL)
}

/// The memory in bytes of a prepared mesh with this many facets, in addition to the mesh.
#[must_use]
pub fn bytes_prepared(facets: usize) -> usize {
    facets * (CLASSES + PLANNED_FACET) + MAP_SIDE * MAP_SIDE * VIEW_CELL
}

/// The memory in bytes of a ranking, in addition to the mesh.
#[must_use]
pub fn bytes_to_rank(size: RankingSize) -> usize {
    bytes_prepared(size.facets) + FIXED
}
