//! The facets of a surface, and the simulation of all candidates on them.

use super::memory::Resources;
use super::parameters::Parameters;
use crate::http::codes::RequestFault;
use crate::http::problem::Problem;
use crate::http::reading::{Faulted, Faults, JsonPath};
use crate::http::wire::{PIECES_NAME, SELECT};
use crate::http::worker_pool::Work;
use crate::milling::Model;
use crate::planning::memory::{RankingSize, TRIAL_SIDE};
use crate::planning::reach::{ReachMap, Uncut};
use crate::planning::zigzag::{CandidateCutter, NoRanking, Ranking, SurfaceEvidence, ZigzagSettings, rank_within};
use crate::surface::mesh::{FacetClass, SelectionError, ViewFromAbove, Visibility};
use crate::surface::{Bounds, FinishFacet, Mesh, MeshBuilder, MeshError, Shape, Unit};
use axum::http::StatusCode;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Whether the work is cancelled.
pub(super) type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// The cells along each side of the raster for the reach of cutters and for maps.
const SIDE: usize = TRIAL_SIDE;

/// The facets of a surface, with those that are machined.
pub(super) struct Workpiece {
    pub(super) mesh: Mesh,
    pub(super) visibility: Visibility,
    pub(super) pieces: u32,
    /// The number of pieces with a machined facet.
    pub(super) machined_pieces: usize,
    /// Whether each facet of the mesh is selected and not too steep.
    machined: Vec<bool>,
    /// The facets to plan for.
    pub(super) facets: Vec<FinishFacet>,
    /// For each facet of the mesh, its index among the planned facets; `None` if it is not planned.
    places: Vec<Option<u32>>,
    pub(super) view: ViewFromAbove,
}

/// The reason why a surface has no facets to machine.
#[derive(Debug, Clone, Copy)]
pub(super) enum NoWorkpiece {
    Mesh(MeshError),
    Selection(SelectionError),
    NothingToMachine,
}

impl NoWorkpiece {
    /// Whether the surface is valid and only has no facets that are visible from above.
    pub(super) fn is_sound(self) -> bool {
        match self {
            Self::Mesh(MeshError::NoTriangulation { .. } | MeshError::NothingFromAbove | MeshError::OnlyDegenerateFacets { .. })
            | Self::NothingToMachine => true,
            Self::Mesh(_) | Self::Selection(_) => false,
        }
    }

    /// Records the fault of the surface at `path`.
    pub(super) fn report(self, path: &JsonPath<'_>, faults: &mut Faults) -> Faulted {
        match self {
            Self::Mesh(error) => faults.add(path, mesh_code(error), error),
            Self::Selection(error) => {
                let select = JsonPath::Root.member(SELECT.name);
                faults.add(&select.member(PIECES_NAME), RequestFault::OutOfRange, error)
            }
            Self::NothingToMachine => {
                let detail = "no facet is selected, seen from above and at most as steep as max_slope_deg";
                faults.add(path, RequestFault::NothingToMachine, detail)
            }
        }
    }
}

impl Workpiece {
    /// Prepares the facets of a surface.
    ///
    /// Once `stop` returns true, work ends early, and the result must be discarded.
    pub(super) fn new(mesh: MeshBuilder, unit: Unit, parameters: &Parameters, stop: Stop) -> Result<Self, NoWorkpiece> {
        let go_on = || if stop() { Err(NoWorkpiece::NothingToMachine) } else { Ok(()) };
        let mesh = mesh.finish_until(unit, parameters.facing, stop).map_err(NoWorkpiece::Mesh)?;
        go_on()?;
        let pieces = mesh.pieces_until(stop);
        go_on()?;
        let selected = mesh.selected(&parameters.selection, &pieces).map_err(NoWorkpiece::Selection)?;
        go_on()?;
        let visibility = mesh.visibility_until(parameters.max_slope, stop);
        go_on()?;
        let facets = mesh.facets_for_finishing_until(&visibility, &selected, stop);
        go_on()?;
        let mut next = 0;
        let mut machined = Vec::with_capacity(selected.len());
        let mut places = Vec::with_capacity(selected.len());
        for (class, selected) in visibility.classes().iter().zip(&selected) {
            machined.push(*selected && *class == FacetClass::Machined);
            let is_planned = *selected && matches!(class, FacetClass::Machined | FacetClass::Steep { wall: false });
            places.push(is_planned.then_some(next));
            next += u32::from(is_planned);
        }
        if !machined.contains(&true) {
            return Err(NoWorkpiece::NothingToMachine);
        }
        let of_machined = pieces.of_facets().iter().zip(&machined).filter(|(_, machined)| **machined).map(|(piece, _)| *piece);
        let machined_pieces = of_machined.collect::<BTreeSet<_>>().len();
        let view = mesh.seen_from_above_until(SIDE, stop);
        Ok(Self { mesh, visibility, pieces: pieces.count(), machined_pieces, machined, facets, places, view })
    }

    /// The index of a cell's facet among the planned facets.
    pub(super) fn facet_of_cell(&self, cell: usize) -> Option<u32> {
        self.view.facet(cell).and_then(|facet| self.places[facet])
    }

    /// The share of the visible area whose facets have the opposite orientation: up to a half.
    fn turned_area_share(&self) -> f64 {
        let seen = self.visible_area_share() * self.visibility.area();
        let from_behind = if seen > 0.0 { (self.visibility.area_from_behind() / seen).min(1.0) } else { 0.0 };
        from_behind.min(1.0 - from_behind)
    }

    /// The share of the whole area that is seen from above.
    pub(super) fn visible_area_share(&self) -> f64 {
        let shares = self.visibility.shares();
        (1.0 - shares.hidden - shares.overhanging).clamp(0.0, 1.0)
    }
}

/// All candidates simulated on a surface.
pub(super) struct Simulation {
    pub(super) settings: ZigzagSettings,
    /// The candidates, each with the material it cannot reach.
    pub(super) candidates: Vec<CandidateCutter>,
    pub(super) ranking: Ranking,
    reach: ReachMap,
}

impl Simulation {
    /// Simulates the candidates at these positions in the request, with more room if a plan needs it. Returns `None`
    /// once `stop` returns true.
    pub(super) fn run(
        workpiece: &Workpiece,
        parameters: &Parameters,
        places: &[usize],
        shape: &Shape,
        model: Model,
        resources: &mut Resources,
        stop: Stop,
    ) -> Result<Option<Self>, Problem> {
        let mut settings = parameters.settings(shape, model);
        let reach = ReachMap::new(&workpiece.mesh, &workpiece.view, &workpiece.machined);
        let mut candidates = Vec::with_capacity(places.len());
        for places in places.chunks(MOST_AT_ONCE) {
            if stop() {
                return Ok(None);
            }
            // The map of a cutter takes half a MB, so only the figures are kept.
            let tried = places.par_iter().map(|&place| {
                let candidate = parameters.candidates[place].candidate;
                if stop() {
                    return candidate;
                }
                let reach = Some((&reach.uncut_until(candidate.cutter, parameters.scallop_height, stop)).into());
                CandidateCutter { reach, ..candidate }
            });
            candidates.extend(tried.collect::<Vec<_>>());
        }
        if stop() {
            return Ok(None);
        }
        let evidence = SurfaceEvidence {
            visible_area_share: workpiece.visible_area_share(),
            pieces: workpiece.machined_pieces,
            turned_area_share: workpiece.turned_area_share(),
        };
        let size = ranking_size(&workpiece.mesh, &candidates);
        let ranking = loop {
            settings.candidates_at_once = resources.parallelism.candidates;
            let room = resources.room;
            let ranked =
                on_threads(resources.parallelism.threads, || rank_within(&workpiece.facets, &candidates, &settings, evidence, room, stop))?;
            match ranked {
                Ok(ranking) => break ranking,
                Err(NoRanking::NoRoom) => resources.enlarge(workpiece.mesh.size(), size, stop)?,
                Err(NoRanking::Stopped) => return Ok(None),
            }
        };
        Ok(Some(Self { settings, candidates, ranking, reach }))
    }

    /// The material that a candidate leaves uncut.
    pub(super) fn uncut(&self, candidate: usize) -> Uncut {
        self.reach.uncut(self.candidates[candidate].cutter, self.settings.scallop_height)
    }
}

/// The size of a ranking of candidates on a mesh.
pub(super) fn ranking_size(mesh: &Mesh, candidates: &[CandidateCutter]) -> RankingSize {
    let Bounds { min, max } = mesh.bounds();
    let longest = (max[0] - min[0]).hypot(max[1] - min[1]);
    let diameters = candidates.iter().map(|candidate| 2.0 * candidate.cutter.outer_radius().mm());
    let smallest = diameters.fold(f64::INFINITY, f64::min);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a larger quotient counts as the largest number")]
    let diameters = (longest / smallest).ceil() as usize;
    RankingSize { facets: mesh.size().facets, candidates: candidates.len(), diameters }
}

/// Runs `work` on this many threads. A failure to start them is logged.
pub(super) fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> Result<T, Problem> {
    Work::on_threads(count, work).map_err(|error| {
        tracing::error!(%error, "no threads for a recommendation");
        Problem::of_status(StatusCode::INTERNAL_SERVER_ERROR)
    })
}

/// The number of cutters between two checks for cancellation.
const MOST_AT_ONCE: usize = 8;

fn mesh_code(error: MeshError) -> RequestFault {
    match error {
        MeshError::CoordinateOutOfRange | MeshError::IndexOutOfRange { .. } | MeshError::PointOutOfRange { .. } => RequestFault::OutOfRange,
        MeshError::OnlyDegenerateFacets { .. } => RequestFault::OnlyDegenerateFacets,
        MeshError::NoTriangulation { .. } => RequestFault::Collinear,
        MeshError::NothingFromAbove => RequestFault::NothingToMachine,
    }
}
