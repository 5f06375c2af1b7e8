//! The time and length of a zigzag: the sums over its runs and the links between them.

use super::links::{Links, straight};
use super::regions::{Stretch, in_order};
use super::runs::Run;
use super::settings::Pattern;
use crate::motion::{Machine, MachineLimits};
use crate::quantity::Speed;

/// Times, lengths and counts of a zigzag.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TourFigures {
    /// The time of all runs and links, in s.
    pub seconds: f64,
    /// The number of runs.
    pub runs: usize,
    /// The length of all runs, in mm.
    pub run_length: f64,
    /// The number of links.
    pub links: usize,
    /// The length of all links, in mm.
    pub link_length: f64,
    /// The number of links over the clearance height.
    pub lifts: usize,
    /// The time of the lifts, in s.
    pub lift_seconds: f64,
    /// The time that the runs would take without stops, in s.
    pub cutting_seconds: f64,
}

impl TourFigures {
    /// The figures of a zigzag. `runs` are sorted by plane, and within a plane along it.
    pub(super) fn of(runs: &[Run], machine: &Machine, pattern: Pattern, links: &Links) -> Self {
        let stretches: Vec<Stretch> = runs.iter().map(|run| run.stretch).collect();
        let mut figures = Self::default();
        let mut last = None;
        for leg in in_order(&stretches, pattern, links) {
            let run = &runs[leg.run];
            if let Some(last) = last {
                let link = links.between(last, run.stretch.end(usize::from(!leg.forward)));
                figures.links += 1;
                figures.link_length += link.length;
                figures.seconds += link.seconds;
                if link.is_lift {
                    figures.lifts += 1;
                    figures.lift_seconds += link.seconds;
                }
            }
            figures.seconds += run_time(run.length, run.seconds, machine);
            figures.cutting_seconds += run.seconds;
            figures.runs += 1;
            figures.run_length += run.length;
            last = Some(run.stretch.end(usize::from(leg.forward)));
        }
        figures
    }
}

/// The time of a run from rest to rest at its mean speed.
pub(super) fn run_time(length: f64, seconds: f64, machine: &Machine) -> f64 {
    straight(length, MachineLimits { feed_rate: Speed::computed(length / seconds), ..machine.limits })
}
