//! The memory that planning takes, stated beforehand so that a caller can reserve it. `cargo bench --bench memory` measures it.

use crate::surface::mesh::MeshSize;

/// Of each facet and point of a mesh: corner numbers and coordinates.
const MESH_FACET: usize = 12;
const MESH_POINT: usize = 24;

/// Of each facet: its class, its piece, whether it is selected, and its place among those that are planned.
const CLASSES: usize = 20;

/// Of each cell of a view from above: height, facet and side.
const VIEW_CELL: usize = 13;

/// While curvatures are estimated: normal, area, equations and neighbours of each facet, and the normal at each point.
const CURVATURE_FACET: usize = 192;
const CURVATURE_POINT: usize = 60;

/// Of each facet that is planned: [`FinishFacet`](crate::surface::FinishFacet), and what the simulation prepares of it.
const PLANNED_FACET: usize = 152 + 168;

/// For each candidate in work: a facet in the order of its direction, and while it is between two planes, which all facets may be at once.
const ORDERED_FACET: usize = 128 + 80;

/// For each candidate in work: 50,000 planes, those of the check before, the cells of a plane, and 65,536 runs with their order.
const PLANES: usize = 28 << 20;

/// For each direction in work: the planes, the cells of a plane and the runs.
const PLANES_OF_SEARCH: usize = 23 << 20;

/// The most facets that the search over directions samples, some more than it draws, and what is held of each.
const SAMPLED: usize = 7_000;
const SAMPLED_FACET: usize = 176;

/// Of each candidate: tables of spacings and feeds, and times by direction.
const CANDIDATE: usize = 64 << 10;

/// The trial of eight cutters on a view of 256 x 256 cells, and what else does not grow.
const FIXED: usize = 12 << 20;

/// How a ranking uses threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parallelism {
    /// How many threads there are.
    pub threads: usize,
    /// How many candidates are planned at once.
    pub candidates: usize,
}

/// The memory of a mesh of this size, in bytes.
#[must_use]
pub fn bytes_of_mesh(MeshSize { facets, points }: MeshSize) -> usize {
    facets * MESH_FACET + points * MESH_POINT
}

/// The memory that it takes to class the facets of a mesh of this size and to estimate their curvatures, in bytes, beside the mesh.
#[must_use]
pub fn bytes_to_prepare(MeshSize { facets, points }: MeshSize) -> usize {
    let view = (8 * facets).clamp(1 << 12, 1 << 20) * VIEW_CELL;
    facets * (CLASSES + CURVATURE_FACET) + points * CURVATURE_POINT + view
}

/// The memory that it takes to rank `candidates` on a mesh with `facets` facets, in bytes, beside the mesh.
#[must_use]
pub fn bytes_to_rank(facets: usize, candidates: usize, parallelism: Parallelism) -> usize {
    let sampled = facets.min(SAMPLED);
    let search = sampled * SAMPLED_FACET + parallelism.threads * (sampled * ORDERED_FACET + PLANES_OF_SEARCH);
    let plans = parallelism.candidates.min(candidates) * (facets * ORDERED_FACET + PLANES);
    facets * (CLASSES + PLANNED_FACET) + search.max(plans) + candidates * CANDIDATE + FIXED
}

/// The most threads and candidates at once, of at most `threads`, with which ranking takes at most `most` bytes, and these bytes; one of each where none
/// fits.
#[must_use]
pub fn fitting(facets: usize, candidates: usize, threads: usize, most: usize) -> (Parallelism, usize) {
    let ways = (1..=threads).rev().flat_map(|threads| (1..=threads).rev().map(move |candidates| Parallelism { threads, candidates }));
    let with_bytes = |way| (way, bytes_to_rank(facets, candidates, way));
    let fits = ways.map(with_bytes).find(|&(_, bytes)| bytes <= most);
    fits.unwrap_or_else(|| with_bytes(Parallelism { threads: 1, candidates: 1 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_threads_and_candidates_as_fit_are_used() {
        let whole = bytes_to_rank(500_000, 10, Parallelism { threads: 8, candidates: 8 });
        assert_eq!(fitting(500_000, 10, 8, whole).0, Parallelism { threads: 8, candidates: 8 });
        let (way, bytes) = fitting(500_000, 10, 8, whole - 1);
        assert_eq!((way, bytes < whole), (Parallelism { threads: 8, candidates: 7 }, true));
        assert_eq!(fitting(500_000, 10, 8, 0).0, Parallelism { threads: 1, candidates: 1 });
        // Few facets need few bytes, whatever the threads.
        assert!(bytes_to_rank(2, 2, Parallelism { threads: 2, candidates: 2 }) < 80 << 20);
    }
}
