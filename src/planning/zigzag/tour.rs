//! The time and length of a zigzag: its runs one after the other, and the links between them.

use super::runs::Run;
use crate::motion::{Machine, MachineLimits, travel_time};
use crate::quantity::{Length, Speed};

/// How passes follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pattern {
    /// Passes alternate in sense.
    #[default]
    Zigzag,
    /// All passes have one sense; the cutter returns at the rapid rate over the clearance height.
    OneWay,
}

/// What a zigzag takes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TourFigures {
    /// The time of all runs and links, in s.
    pub seconds: f64,
    /// How many runs there are.
    pub runs: usize,
    /// The length of all runs, in mm.
    pub run_length: f64,
    /// How many links there are.
    pub links: usize,
    /// The length of all links, in mm.
    pub link_length: f64,
    /// How many links go over the clearance height.
    pub lifts: usize,
    /// The time of these links, in s.
    pub lift_seconds: f64,
    /// The time that the runs would take without stops, in s.
    pub cutting_seconds: f64,
}

/// The end of a run.
#[derive(Debug, Clone, Copy)]
struct End {
    /// Along the passes, across them, height.
    place: [f64; 3],
    /// The stretch of the run along the passes.
    stretch: [f64; 2],
    /// Which pass the run is part of.
    pass: usize,
}

/// A zigzag as it grows, pass by pass.
#[derive(Debug, Clone)]
pub(super) struct Tour<'a> {
    machine: &'a Machine,
    rapid: MachineLimits,
    pattern: Pattern,
    /// The feed rate of links on the surface, in mm/s.
    link_rate: f64,
    /// The longest link on the surface.
    longest_link: f64,
    clearance: f64,
    forward: bool,
    /// The number of planes so far.
    passes: usize,
    /// Where the last run ended.
    end: Option<End>,
    pub(super) figures: TourFigures,
}

impl<'a> Tour<'a> {
    /// No passes yet. `top` is the highest point of the surface.
    pub(super) fn new(machine: &'a Machine, pattern: Pattern, link_rate: f64, longest_link: f64, top: f64) -> Self {
        Self {
            machine,
            rapid: machine.rapid_limits(),
            pattern,
            link_rate,
            longest_link,
            clearance: top + machine.clearance_height.mm(),
            forward: true,
            passes: 0,
            end: None,
            figures: TourFigures::default(),
        }
    }

    /// Adds the runs of the plane at `at`, in the order along it.
    pub(super) fn pass(&mut self, runs: &[Run], at: f64) {
        self.passes += 1;
        if runs.is_empty() {
            return;
        }
        if self.forward {
            for run in runs {
                self.run(run, run.ends[0], run.ends[1], at);
            }
        } else {
            for run in runs.iter().rev() {
                self.run(run, run.ends[1], run.ends[0], at);
            }
        }
        if self.pattern == Pattern::Zigzag {
            self.forward = !self.forward;
        }
    }

    fn run(&mut self, run: &Run, from: [f64; 2], to: [f64; 2], at: f64) {
        let stretch = [run.ends[0][0], run.ends[1][0]];
        if let Some(end) = self.end {
            self.link(end, [from[0], at, from[1]], stretch);
        }
        self.figures.seconds += run_time(run.length, run.seconds, self.machine);
        self.figures.cutting_seconds += run.seconds;
        self.figures.runs += 1;
        self.figures.run_length += run.length;
        self.end = Some(End { place: [to[0], at, to[1]], stretch, pass: self.passes });
    }

    /// A link stays on the surface between neighbouring passes whose runs lie beside each other, so that the strip between them connects
    /// both ends however far they are apart, and to any place nearer than the gaps over which runs are joined.
    fn link(&mut self, end: End, to: [f64; 3], stretch: [f64; 2]) {
        let from = end.place;
        let across = (to[0] - from[0]).hypot(to[1] - from[1]);
        let is_next = self.passes == end.pass + 1 && (to[1] - from[1]).abs() <= self.longest_link;
        let is_beside = is_next && stretch[0] < end.stretch[1] && end.stretch[0] < stretch[1];
        self.figures.links += 1;
        if self.pattern == Pattern::Zigzag && (is_beside || across <= self.longest_link) {
            let length = across.hypot(to[2] - from[2]);
            self.figures.link_length += length;
            self.figures.seconds += straight(length, MachineLimits { feed_rate: Speed::computed(self.link_rate), ..self.machine.limits });
        } else {
            let (up, down) = (self.clearance - from[2], self.clearance - to[2]);
            self.figures.lifts += 1;
            self.figures.link_length += up + across + down;
            let seconds: f64 = [up, across, down].into_iter().map(|length| straight(length, self.rapid)).sum();
            self.figures.lift_seconds += seconds;
            self.figures.seconds += seconds;
        }
    }
}

/// The time of a run from rest to rest with its mean speed.
pub(super) fn run_time(length: f64, seconds: f64, machine: &Machine) -> f64 {
    straight(length, MachineLimits { feed_rate: Speed::computed(length / seconds), ..machine.limits })
}

fn straight(length: f64, limits: MachineLimits) -> f64 {
    travel_time(Length::computed(length), limits).seconds()
}
