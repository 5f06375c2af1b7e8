//! The plans of all candidates on a part.

use super::parameters::Parameters;
use crate::milling::Model;
use crate::planning::machined_surface::{MachinedSurface, Stop};
use crate::planning::plan::{PlanSettings, Ranking, rank};
use crate::surface::Shape;

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
