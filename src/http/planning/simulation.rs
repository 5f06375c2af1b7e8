//! A surface seen as facets, and the simulation of all candidates on it.

use super::parameters::Parameters;
use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, JsonPath};
use crate::http::wire::{PIECES_NAME, SELECT};
use crate::milling::Model;
use crate::planning::memory::Parallelism;
use crate::planning::reach::{ReachMap, Uncut};
use crate::planning::zigzag::{CandidateCutter, Ranking, ReachFigures, SurfaceEvidence, ZigzagSettings, rank};
use crate::surface::mesh::{FacetClass, ViewFromAbove, Visibility};
use crate::surface::{FinishFacet, Mesh, MeshBuilder, MeshError, Shape, Unit};

/// The side of the raster on which cutters are tried and maps are drawn.
const SIDE: usize = 256;

/// The facets of a surface, with those that are machined.
pub(super) struct Workpiece {
    pub(super) mesh: Mesh,
    pub(super) visibility: Visibility,
    pub(super) pieces: u32,
    /// Whether each facet of the mesh is selected and not too steep.
    machined: Vec<bool>,
    /// The facets that a plan is made for.
    pub(super) facets: Vec<FinishFacet>,
    /// Where each of the mesh's facets stands among those.
    places: Vec<Option<u32>>,
    pub(super) view: ViewFromAbove,
}

impl Workpiece {
    /// The facets that a surface at `path` has.
    pub(super) fn new(
        mesh: MeshBuilder,
        unit: Unit,
        parameters: &Parameters,
        path: &JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<Self, Faulted> {
        let mesh = mesh.finish(unit, parameters.facing).map_err(|error| faults.add(path, mesh_code(error), error))?;
        let pieces = mesh.pieces();
        let selected = mesh.selected(&parameters.selection, &pieces).map_err(|error| {
            let select = JsonPath::Root.member(SELECT.name);
            faults.add(&select.member(PIECES_NAME), RequestFault::OutOfRange, error)
        })?;
        let visibility = mesh.visibility(parameters.max_slope);
        let facets = mesh.facets_for_finishing(&visibility, &selected);
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
            let detail = "no facet is selected, seen from above and at most as steep as max_slope_deg";
            return Err(faults.add(path, RequestFault::NothingToMachine, detail));
        }
        let view = mesh.seen_from_above(SIDE);
        Ok(Self { mesh, visibility, pieces: pieces.count(), machined, facets, places, view })
    }

    /// Where the facet that a cell shows stands among those of the plan.
    pub(super) fn facet_of_cell(&self, cell: usize) -> Option<u32> {
        self.view.facet(cell).and_then(|facet| self.places[facet])
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
    /// The candidates with what they cannot reach.
    pub(super) candidates: Vec<CandidateCutter>,
    pub(super) ranking: Ranking,
    reach: ReachMap,
}

impl Simulation {
    /// Simulates the candidates; `None` as soon as `stop` says that nobody waits for the result.
    pub(super) fn run(
        workpiece: &Workpiece,
        parameters: &Parameters,
        shape: &Shape,
        model: Model,
        parallelism: Parallelism,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let settings = ZigzagSettings { candidates_at_once: parallelism.candidates, ..parameters.settings(shape, model) };
        let reach = ReachMap::new(&workpiece.mesh, &workpiece.view, &workpiece.machined);
        let cutters: Vec<_> = parameters.candidates.iter().map(|named| named.candidate.cutter).collect();
        let mut candidates = Vec::with_capacity(cutters.len());
        // A map of each cutter takes a quarter of a MB, so that only the figures are kept.
        for (named, cutters) in parameters.candidates.chunks(MOST_AT_ONCE).zip(cutters.chunks(MOST_AT_ONCE)) {
            if stop() {
                return None;
            }
            let uncut = reach.uncut_of_each(cutters, parameters.scallop_height);
            candidates.extend(named.iter().zip(uncut).map(|(named, uncut)| CandidateCutter {
                reach: Some(ReachFigures { uncut_share: uncut.share, uncut_height: uncut.height }),
                ..named.candidate
            }));
        }
        if stop() {
            return None;
        }
        let evidence = SurfaceEvidence { visible_area_share: workpiece.visible_area_share(), pieces: workpiece.pieces as usize };
        let ranking = rank(&workpiece.facets, &candidates, &settings, evidence, stop)?;
        Some(Self { settings, candidates, ranking, reach })
    }

    /// What a candidate leaves uncut.
    pub(super) fn uncut(&self, candidate: usize) -> Uncut {
        self.reach.uncut(self.candidates[candidate].cutter, self.settings.scallop_height)
    }
}

/// How many cutters are tried between two looks at whether anybody waits.
const MOST_AT_ONCE: usize = 8;

fn mesh_code(error: MeshError) -> RequestFault {
    match error {
        MeshError::CoordinateOutOfRange | MeshError::IndexOutOfRange { .. } | MeshError::PointOutOfRange { .. } => RequestFault::OutOfRange,
        MeshError::OnlyDegenerateFacets { .. } => RequestFault::OnlyDegenerateFacets,
        MeshError::NoTriangulation { .. } => RequestFault::Collinear,
        MeshError::NothingFromAbove => RequestFault::NothingToMachine,
    }
}
