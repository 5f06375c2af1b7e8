//! The simulation of one cutter in one direction over a workpiece.

use super::links::Links;
use super::march::{Fit, Met, NoPlanes, Plane, march};
use super::room::{Room, SLIVERS_OF_A_RUN};
use super::runs::RunFinder;
use super::settings::Pattern;
use super::slivers::Sliver;
use super::spaced::Spaced;
use super::spacing::FeedLaw;
use super::tour::TourFigures;
use crate::motion::Machine;

/// The data that all directions of a cutter share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Operation<'a> {
    pub(super) machine: &'a Machine,
    pub(super) pattern: Pattern,
    pub(super) feeds: &'a FeedLaw,
    /// The feed rate of links on the surface, in mm/s.
    pub(super) link_rate: f64,
    pub(super) room: &'a Room,
}

impl Operation<'_> {
    /// The rules for links on a workpiece.
    pub(super) fn links(&self, spaced: &Spaced) -> Links {
        Links::new(self.machine, self.pattern, self.link_rate, spaced.widest, spaced.workpiece.top)
    }
}

/// A zigzag in one direction.
#[derive(Debug, Clone)]
pub(super) struct Simulated {
    pub(super) figures: TourFigures,
    pub(super) planes: Vec<Plane>,
    /// The parts of facets beside planes over which passes continue.
    pub(super) slivers: Vec<Sliver>,
}

/// Simulates the zigzag over facets with their spacings, fitted to the strips by `fit`.
///
/// # Errors
/// [`NoPlanes`]
pub(super) fn simulate(
    spaced: &Spaced,
    operation: Operation,
    fit: Option<&Fit>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Simulated, NoPlanes> {
    let mut finder = RunFinder::new(spaced, operation.feeds);
    let mut planes = Vec::new();
    march(spaced, fit, stop, |met| {
        match met {
            Met::Plane(plane, cut) => {
                finder.find(cut, planes.len(), plane);
                planes.push(plane);
            }
            Met::Strip(ends, facets) => finder.look_for_slivers(ends, facets),
        }
        // All runs stay in memory until their order is known.
        operation.room.check(planes.len(), finder.runs.len() + finder.slivers.len() / SLIVERS_OF_A_RUN)
    })?;
    finder.cut_slivers();
    let figures = TourFigures::of(&finder.runs, operation.machine, operation.pattern, &operation.links(spaced));
    Ok(Simulated { figures, planes, slivers: finder.slivers })
}

/// The planes of the same zigzag, without its runs.
///
/// # Errors
/// [`NoPlanes`]
pub(super) fn planes_of(spaced: &Spaced, room: &Room, stop: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Plane>, NoPlanes> {
    let mut planes = Vec::new();
    march(spaced, None, stop, |met| {
        if let Met::Plane(plane, _) = met {
            planes.push(plane);
        }
        room.check(planes.len(), 0)
    })?;
    Ok(planes)
}
