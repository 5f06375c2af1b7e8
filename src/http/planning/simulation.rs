//! The facets of a surface, and the simulation of all candidates on them.

use super::parameters::Parameters;
use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, JsonPath};
use crate::http::wire::{PIECES_NAME, SELECT};
use crate::milling::Model;
use crate::planning::memory::Parallelism;
use crate::planning::reach::{ReachMap, Uncut};
use crate::planning::zigzag::{CandidateCutter, Ranking, SurfaceEvidence, ZigzagSettings, rank};
use crate::surface::mesh::{FacetClass, SelectionError, ViewFromAbove, Visibility};
use crate::surface::{FinishFacet, Mesh, MeshBuilder, MeshError, Shape, Unit};
use std::collections::BTreeSet;

/// The cells along each side of the raster for the reach of cutters and for maps.
const SIDE: usize = 256;

/// The facets of a surface, with those that are machined.
pub(super) struct Workpiece {
    pub(super) mesh: Mesh,
    pub(super) visibility: Visibility,
    pub(super) pieces: u32,
    /// The number of pieces with a machined facet.
    pub(super) machined_pieces: usize,
    /// Whether each facet of the mesh is selected and not too steep.
    machined: Vec<bool>,
    /// The facets that a plan is made for.
    pub(super) facets: Vec<FinishFacet>,
    /// The position of each facet of the mesh among those of the plan.
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
    pub(super) fn new(mesh: MeshBuilder, unit: Unit, parameters: &Parameters) -> Result<Self, NoWorkpiece> {
        let mesh = mesh.finish(unit, parameters.facing).map_err(NoWorkpiece::Mesh)?;
        let pieces = mesh.pieces();
        let selected = mesh.selected(&parameters.selection, &pieces).map_err(NoWorkpiece::Selection)?;
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
            return Err(NoWorkpiece::NothingToMachine);
        }
        let of_machined = pieces.of_facets().iter().zip(&machined).filter(|(_, machined)| **machined).map(|(piece, _)| *piece);
        let machined_pieces = of_machined.collect::<BTreeSet<_>>().len();
        let view = mesh.seen_from_above(SIDE);
        Ok(Self { mesh, visibility, pieces: pieces.count(), machined_pieces, machined, facets, places, view })
    }

    /// The position of a cell's facet among those of the plan.
    pub(super) fn facet_of_cell(&self, cell: usize) -> Option<u32> {
        self.view.facet(cell).and_then(|facet| self.places[facet])
    }

    /// The share of the seen area whose facets face the other way than the rest: up to a half.
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
    /// Simulates the candidates at these positions in the request; `None` as soon as `stop` returns true.
    pub(super) fn run(
        workpiece: &Workpiece,
        parameters: &Parameters,
        places: &[usize],
        shape: &Shape,
        model: Model,
        parallelism: Parallelism,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let settings = ZigzagSettings { candidates_at_once: parallelism.candidates, ..parameters.settings(shape, model) };
        let reach = ReachMap::new(&workpiece.mesh, &workpiece.view, &workpiece.machined);
        let mut candidates = Vec::with_capacity(places.len());
        // The map of a cutter takes a quarter of a MB, so only the figures are kept.
        for places in places.chunks(MOST_AT_ONCE) {
            if stop() {
                return None;
            }
            let cutters: Vec<_> = places.iter().map(|&place| parameters.candidates[place].candidate.cutter).collect();
            let uncut = reach.uncut_of_each(&cutters, parameters.scallop_height);
            candidates.extend(
                places
                    .iter()
                    .zip(uncut)
                    .map(|(&place, uncut)| CandidateCutter { reach: Some((&uncut).into()), ..parameters.candidates[place].candidate }),
            );
        }
        if stop() {
            return None;
        }
        let evidence = SurfaceEvidence {
            visible_area_share: workpiece.visible_area_share(),
            pieces: workpiece.machined_pieces,
            turned_area_share: workpiece.turned_area_share(),
        };
        let ranking = rank(&workpiece.facets, &candidates, &settings, evidence, stop)?;
        Some(Self { settings, candidates, ranking, reach })
    }

    /// What a candidate leaves uncut.
    pub(super) fn uncut(&self, candidate: usize) -> Uncut {
        self.reach.uncut(self.candidates[candidate].cutter, self.settings.scallop_height)
    }
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
