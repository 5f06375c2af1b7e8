//! The memory that planning takes, computed in advance so that a caller can reserve it.

use super::zigzag::{CandidateCutter, PlanRoom};
use crate::surface::mesh::MeshSize;
use crate::surface::{Bounds, FinishFacet, Mesh};

/// Bytes for each facet and point of a mesh: corner indices and coordinates.
const MESH_FACET: usize = 12;
const MESH_POINT: usize = 24;

/// Bytes for each facet: class, piece, selection, and position among the planned facets.
const CLASSES: usize = 20;

/// Bytes for each cell of a view from above: height, facet and side.
const VIEW_CELL: usize = 13;

/// Bytes while curvatures are estimated: normal, area, equations and neighbours of each facet, and the normal at each
/// point.
const CURVATURE_FACET: usize = 192;
const CURVATURE_POINT: usize = 60;

/// Bytes for each planned facet: [`FinishFacet`](crate::surface::FinishFacet), and the simulation's data.
const PLANNED_FACET: usize = 152 + 180;

/// Bytes for each facet and each candidate or direction in progress: the facet in the order of its direction, and its
/// entries while it is between two planes, as all facets may be at once.
const ORDERED_FACET: usize = 136 + 88;

/// Bytes for each candidate or direction in progress. For each plane: the plane, that of the previous check and that of
/// the best direction so far, factors, heights and the checked facets, in vectors that double when they grow. For each
/// run: the run with its order. For each cell of a plane: the cell.
const PLANE: usize = 210 + 2 * 56 + 64;
const RUN: usize = 200;
const CELL: usize = 56;

/// The most cells of a plane.
const MOST_CELLS: usize = 100_000;

/// The largest number of facets that the search samples for the directions around the best, with a reserve, and the
/// bytes for each. For all directions it samples half as many.
const SAMPLED: usize = 7_000;
const SAMPLED_FACET: usize = 176;

/// Bytes for each candidate: tables of spacings and feeds, and times by direction.
const CANDIDATE: usize = 64 << 10;

/// The number of cells along each side of the raster for the reach of cutters, and the bytes for each cell: height and
/// facet of the view, height and area of the map.
pub const TRIAL_SIDE: usize = 256;
const TRIAL_CELL: usize = 20;

/// Bytes for each thread while the reach of a cutter is computed: three rasters with a border, and three figures of
/// each cell.
const TRIAL: usize = 1_400_000 + 20 * TRIAL_SIDE * TRIAL_SIDE;

/// The largest number of diameters of a cutter along a surface for which a raster of [`TRIAL_SIDE`] cells has three cells for
/// its radius. Smaller cutters have rasters of two or four times as many.
pub(crate) const COARSE_DIAMETERS: usize = TRIAL_SIDE / 6;

/// Bytes for each cell of a finer raster and each thread: three rasters of the heights, and those left. Cutters for which it
/// is used reach up to a fourth of this many cells beyond the surface.
const FINE_TRIAL_CELL: usize = 16;
const FINE_BORDER: usize = 64;

/// Bytes of all other constant memory.
const FIXED: usize = 1 << 18;

/// The size of a ranking, on which its memory depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RankingSize {
    /// The facets that are planned.
    pub facets: usize,
    /// The candidates.
    pub candidates: usize,
    /// The longest extent of the surface, in diameters of the smallest candidate.
    pub diameters: usize,
}

impl RankingSize {
    /// The size of a ranking of candidates on a mesh.
    pub(crate) fn of(mesh: &Mesh, candidates: &[CandidateCutter]) -> Self {
        let Bounds { min, max } = mesh.bounds();
        let longest = (max[0] - min[0]).hypot(max[1] - min[1]);
        let diameters = candidates.iter().map(|candidate| 2.0 * candidate.cutter.outer_radius().mm());
        let smallest = diameters.fold(f64::INFINITY, f64::min);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a larger quotient counts as the largest number")]
        let diameters = (longest / smallest).ceil() as usize;
        Self { facets: mesh.size().facets, candidates: candidates.len(), diameters }
    }

    /// The number of cells along each side of the raster on which the reach of the smallest candidate is computed.
    #[must_use]
    pub fn reach_side(&self) -> usize {
        let factor = match self.diameters.div_ceil(COARSE_DIAMETERS) {
            0 | 1 => 1,
            2 => 2,
            _ => 4,
        };
        factor * TRIAL_SIDE
    }

    /// The memory in bytes of that raster if it is finer than [`TRIAL_SIDE`], and of the trials on it.
    #[must_use]
    pub fn bytes_of_fine_reach(&self, threads: usize) -> usize {
        let side = self.reach_side();
        if side == TRIAL_SIDE {
            return 0;
        }
        let cells = |side: usize| side * side;
        cells(side) * TRIAL_CELL + (threads * cells(side + FINE_BORDER) * FINE_TRIAL_CELL).max(cells(side) * VIEW_CELL)
    }
}

/// The use of threads by a ranking.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parallelism {
    /// The number of threads.
    pub threads: usize,
    /// The number of candidates that are planned at once.
    pub candidates: usize,
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
    facets * CLASSES + (curvatures + view).max(facets * size_of::<FinishFacet>() + TRIAL_SIDE * TRIAL_SIDE * VIEW_CELL)
}

/// The memory in bytes of a prepared mesh with this many facets, in addition to the mesh.
#[must_use]
pub fn bytes_prepared(facets: usize) -> usize {
    facets * (CLASSES + size_of::<FinishFacet>()) + TRIAL_SIDE * TRIAL_SIDE * VIEW_CELL
}

/// The memory in bytes to compute the reach of cutters on this many threads.
#[must_use]
pub fn bytes_to_try(threads: usize) -> usize {
    threads * TRIAL
}

/// The memory in bytes of a ranking, in addition to the mesh.
#[must_use]
pub fn bytes_to_rank(size: RankingSize, parallelism: Parallelism, room: PlanRoom) -> usize {
    let RankingSize { facets, candidates, diameters } = size;
    let sampled = facets.min(SAMPLED);
    let plan = room.planes * PLANE + room.runs * RUN + diameters.saturating_add(2).min(MOST_CELLS) * CELL;
    let threads = parallelism.threads.min(candidates);
    let trial = bytes_to_try(threads) + size.bytes_of_fine_reach(threads);
    let search = (sampled + sampled / 2) * SAMPLED_FACET + parallelism.threads * (sampled * ORDERED_FACET + plan);
    let plans = parallelism.candidates.min(candidates) * (facets * ORDERED_FACET + plan);
    let held = facets * (CLASSES + PLANNED_FACET) + candidates * CANDIDATE + TRIAL_SIDE * TRIAL_SIDE * TRIAL_CELL;
    held + search.max(plans).max(trial) + FIXED
}

/// The largest number of threads, at most `threads`, and of candidates at once with which a ranking takes at most
/// `most` bytes; and the bytes that it takes. If nothing fits, one of each.
#[must_use]
pub fn fitting(size: RankingSize, threads: usize, room: PlanRoom, most: usize) -> (Parallelism, usize) {
    let ways = (1..=threads).rev().flat_map(|threads| (1..=threads).rev().map(move |candidates| Parallelism { threads, candidates }));
    let with_bytes = |way| (way, bytes_to_rank(size, way, room));
    let fits = ways.map(with_bytes).find(|&(_, bytes)| bytes <= most);
    fits.unwrap_or_else(|| with_bytes(Parallelism { threads: 1, candidates: 1 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: Parallelism = Parallelism { threads: 2, candidates: 2 };

    fn size(facets: usize, candidates: usize) -> RankingSize {
        RankingSize { facets, candidates, diameters: 20 }
    }

    #[test]
    fn as_many_threads_and_candidates_as_fit_are_used() {
        let (size, room) = (size(500_000, 10), PlanRoom::LARGEST);
        let whole = bytes_to_rank(size, Parallelism { threads: 8, candidates: 8 }, room);
        assert_eq!(fitting(size, 8, room, whole).0, Parallelism { threads: 8, candidates: 8 });
        let (way, bytes) = fitting(size, 8, room, whole - 1);
        assert_eq!((way, bytes < whole), (Parallelism { threads: 8, candidates: 7 }, true));
        assert_eq!(fitting(size, 8, room, 0).0, Parallelism { threads: 1, candidates: 1 });
    }

    #[test]
    fn small_cutters_have_finer_rasters_and_memory_for_them() {
        let of = |diameters| RankingSize { diameters, ..size(200, 2) };
        let sides = [1, COARSE_DIAMETERS, COARSE_DIAMETERS + 1, 2 * COARSE_DIAMETERS, 2 * COARSE_DIAMETERS + 1, usize::MAX];
        assert_eq!(sides.map(|diameters| of(diameters).reach_side()), [256, 256, 512, 512, 1024, 1024]);
        let bytes = [40, 80, 200].map(|diameters| bytes_to_rank(of(diameters), TWO, PlanRoom::USUAL));
        assert!(bytes[0] < bytes[1] && bytes[1] < bytes[2] && bytes[2] < 80 << 20, "{bytes:?}");
    }

    #[test]
    fn few_facets_need_few_megabytes() {
        let few = bytes_to_rank(size(200, 2), TWO, PlanRoom::USUAL);
        assert!(few < 8 << 20, "{few}");
        // The largest plans of few facets.
        assert!(bytes_to_rank(size(200, 2), TWO, PlanRoom::LARGEST) < 64 << 20);
    }
}
