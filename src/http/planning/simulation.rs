//! The plans of all candidates on a part.

use super::parameters::{AVOID, Parameters, SELECT};
use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, JsonPath};
use crate::http::wire::{FACETS_NAME, PIECES_NAME};
use crate::milling::Model;
use crate::planning::machined_surface::{MachinedSurface, NoMachinedSurface, Stop};
use crate::planning::plan::{PlanSettings, Ranking, rank};
use crate::surface::{MeshError, Shape};

/// Records the fault of the surface at `path`.
pub(super) fn report(reason: NoMachinedSurface, path: &JsonPath<'_>, faults: &mut Faults) -> Faulted {
    match reason {
        NoMachinedSurface::Mesh(error) => faults.add(path, mesh_code(error), error),
        NoMachinedSurface::Avoided(error) => faults.add(&JsonPath::Root.member(AVOID.name), mesh_code(error), error),
        NoMachinedSurface::Selection(error) => {
            let select = JsonPath::Root.member(SELECT.name);
            let member = if error.is_about_facets() { FACETS_NAME } else { PIECES_NAME };
            faults.add(&select.member(member), RequestFault::OutOfRange, error)
        }
        NoMachinedSurface::NothingToMachine => {
            let detail = "no facet is selected, seen from above and at most as steep as max_slope_deg";
            faults.add(path, RequestFault::NothingToMachine, detail)
        }
    }
}

/// All candidates planned on a part.
pub(super) struct Simulation {
    pub(super) settings: PlanSettings,
    pub(super) ranking: Ranking,
}

impl Simulation {
    /// Plans the candidates at these positions in the request. Returns `None` once `stop` returns true.
    pub(super) fn run(
        machined: &MachinedSurface,
        parameters: &Parameters,
        places: &[usize],
        shape: &Shape,
        model: Model,
        stop: Stop,
    ) -> Option<Self> {
        let settings = parameters.settings(shape, model);
        let candidates: Vec<_> = places.iter().map(|&place| parameters.candidates[place].candidate).collect();
        let ranking = rank(&machined.workpiece, &candidates, &settings, machined.facets.evidence(), stop)?;
        Some(Self { settings, ranking })
    }
}

fn mesh_code(error: MeshError) -> RequestFault {
    match error {
        MeshError::CoordinateOutOfRange | MeshError::IndexOutOfRange { .. } | MeshError::PointOutOfRange { .. } => RequestFault::OutOfRange,
        MeshError::OnlyDegenerateFacets { .. } => RequestFault::OnlyDegenerateFacets,
        MeshError::NoTriangulation { .. } => RequestFault::Collinear,
        MeshError::NothingFromAbove => RequestFault::NothingToMachine,
    }
}
