//! The simulation of all candidates on the facets of a surface, with the memory that it takes.

use super::memory::Resources;
use super::parameters::{Parameters, SELECT};
use crate::http::codes::RequestFault;
use crate::http::problem::Problem;
use crate::http::reading::{Faulted, Faults};
use crate::http::wire::PIECES_NAME;
use crate::json_text::JsonPath;
use crate::milling::Model;
use crate::planning::machined_surface::{MachinedSurface, NoMachinedSurface, Stop};
use crate::planning::memory::RankingSize;
use crate::planning::zigzag::{CandidateCutter, NoRanking, Ranking, ZigzagSettings, rank_within};
use crate::surface::{MeshError, Shape};
use crate::worker_pool::WorkerPool;
use axum::http::StatusCode;

/// Records the fault of the surface at `path`.
pub(super) fn report(reason: NoMachinedSurface, path: &JsonPath<'_>, faults: &mut Faults) -> Faulted {
    match reason {
        NoMachinedSurface::Mesh(error) => faults.add(path, mesh_code(error), error),
        NoMachinedSurface::Selection(error) => {
            let select = JsonPath::Root.member(SELECT.name);
            faults.add(&select.member(PIECES_NAME), RequestFault::OutOfRange, error)
        }
        NoMachinedSurface::NothingToMachine => {
            let detail = "no facet is selected, seen from above and at most as steep as max_slope_deg";
            faults.add(path, RequestFault::NothingToMachine, detail)
        }
    }
}

/// All candidates simulated on a surface.
pub(super) struct Simulation {
    pub(super) settings: ZigzagSettings,
    /// The candidates, each with the material it cannot reach.
    pub(super) candidates: Vec<CandidateCutter>,
    pub(super) ranking: Ranking,
}

impl Simulation {
    /// Simulates the candidates at these positions in the request, with more room if a plan needs it. Returns `None`
    /// once `stop` returns true.
    pub(super) fn run(
        machined: &MachinedSurface,
        parameters: &Parameters,
        places: &[usize],
        shape: &Shape,
        model: Model,
        resources: &mut Resources,
        stop: Stop,
    ) -> Result<Option<Self>, Problem> {
        let mut settings = parameters.settings(shape, model);
        let candidates: Vec<_> = places.iter().map(|&place| parameters.candidates[place].candidate).collect();
        let Some(candidates) = machined.with_reach(&candidates, parameters.scallop_height, stop) else { return Ok(None) };
        let evidence = machined.evidence();
        let size = RankingSize::of(&machined.mesh, &candidates);
        let ranking = loop {
            settings.candidates_at_once = resources.parallelism.candidates;
            let room = resources.room;
            let ranked =
                on_threads(resources.parallelism.threads, || rank_within(&machined.facets, &candidates, &settings, evidence, room, stop))?;
            match ranked {
                Ok(ranking) => break ranking,
                Err(NoRanking::NoRoom) => resources.enlarge(machined.mesh.size(), size, stop)?,
                Err(NoRanking::Stopped) => return Ok(None),
            }
        };
        Ok(Some(Self { settings, candidates, ranking }))
    }
}

/// Runs `work` on this many threads. A failure to start them is logged.
pub(super) fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> Result<T, Problem> {
    WorkerPool::on_threads(count, work).map_err(|error| {
        tracing::error!(%error, "no threads for a recommendation");
        Problem::of_status(StatusCode::INTERNAL_SERVER_ERROR)
    })
}

fn mesh_code(error: MeshError) -> RequestFault {
    match error {
        MeshError::CoordinateOutOfRange | MeshError::IndexOutOfRange { .. } | MeshError::PointOutOfRange { .. } => RequestFault::OutOfRange,
        MeshError::OnlyDegenerateFacets { .. } => RequestFault::OnlyDegenerateFacets,
        MeshError::NoTriangulation { .. } => RequestFault::Collinear,
        MeshError::NothingFromAbove => RequestFault::NothingToMachine,
    }
}
