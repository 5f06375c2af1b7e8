//! One cutter in one direction over a workpiece.

use super::march::{Plane, Spaced, TooManyPlanes, march};
use super::runs::RunFinder;
use super::spacing::FeedLaw;
use super::tour::{Pattern, Tour, TourFigures};
use crate::motion::Machine;

/// What is the same for every direction of a cutter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Operation<'a> {
    pub(super) machine: &'a Machine,
    pub(super) pattern: Pattern,
    pub(super) feeds: &'a FeedLaw,
    /// The feed rate of links on the surface, in mm/s.
    pub(super) link_rate: f64,
}

/// A zigzag in one direction.
#[derive(Debug, Clone)]
pub(super) struct Simulated {
    pub(super) figures: TourFigures,
    pub(super) planes: Vec<Plane>,
}

/// Simulates the zigzag over facets with their spacings.
///
/// # Errors
/// [`TooManyPlanes`]
pub(super) fn simulate(spaced: &Spaced, operation: Operation) -> Result<Simulated, TooManyPlanes> {
    let Operation { machine, pattern, feeds, link_rate } = operation;
    let mut finder = RunFinder::new(spaced, spaced.widest.max(spaced.workpiece.sampling_gap));
    let mut tour = Tour::new(machine, pattern, link_rate, spaced.widest, spaced.workpiece.top);
    let mut planes = Vec::new();
    march(spaced, |plane, reached| {
        finder.find(spaced, reached, plane.at, plane.spacing(), feeds);
        tour.pass(&finder.runs, plane.at);
        planes.push(plane);
    })?;
    Ok(Simulated { figures: tour.figures, planes })
}
