//! The runs of a direction: where its lines touch what is to be machined, with the tips of the cutter along them.

use super::prepared::Prepared;
use super::spread::{Heading, Spread};
use super::travel;
use super::workpiece::Workpiece;
use crate::motion::Machine;
use crate::path::{Touch, tips_between};
use rayon::prelude::*;

/// A tip of a run. `target` is the one that the cutter finishes there; `None` on the way over a gap and beyond a border.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunTip {
    pub(super) tip: [f64; 3],
    pub(super) target: Option<usize>,
    pub(super) contact: [f64; 3],
    pub(super) normal: [f64; 3],
}

/// A run: tips from one end to the other along a line, or along a border.
#[derive(Debug, Clone)]
pub(super) struct Run {
    /// The position of its line; runs along borders have none.
    pub(super) line: Option<usize>,
    pub(super) tips: Vec<RunTip>,
    /// For each end, whether the surface ends there without a wall.
    open: [bool; 2],
}

impl Run {
    pub(super) fn along_border(tips: Vec<RunTip>) -> Self {
        Self { line: None, tips, open: [false; 2] }
    }

    /// The first or the last tip.
    pub(super) fn end(&self, last: bool) -> [f64; 3] {
        let tip = if last { self.tips.last() } else { self.tips.first() };
        tip.map_or([0.0; 3], |tip| tip.tip)
    }
}

/// What the runs of one direction are made from.
#[derive(Clone, Copy)]
pub(super) struct RunMaker<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) prepared: &'a Prepared,
    pub(super) machine: &'a Machine,
    pub(super) heading: &'a Heading,
    pub(super) spread: &'a Spread,
    /// The largest distance in mm of chords from the tips' surface.
    pub(super) chord_tolerance: f64,
    /// The height in mm at which rapid moves cross the part.
    pub(super) clearance: f64,
    pub(super) stop: &'a (dyn Fn() -> bool + Sync),
}

/// The width in mm to which the end of a run is narrowed down.
const END: f64 = 1e-3;

/// A tip of a line, before it is divided into runs.
#[derive(Debug, Clone, Copy)]
struct LineTip {
    along: f64,
    height: f64,
    touch: Option<Touch>,
    target: Option<usize>,
}

impl RunMaker<'_> {
    /// The runs of all lines, sorted by line and then along it.
    pub(super) fn runs(&self, lines: &[f64]) -> Vec<Run> {
        let of_line = |(line, &across): (usize, &f64)| if (self.stop)() { Vec::new() } else { self.runs_of_line(line, across, lines) };
        let mut runs: Vec<Run> = lines.par_iter().enumerate().flat_map_iter(of_line).collect();
        self.extend_beyond_borders(&mut runs, lines);
        runs
    }

    fn runs_of_line(&self, line: usize, across: f64, lines: &[f64]) -> Vec<Run> {
        let radius = self.prepared.profile.outer_radius();
        let neighbour = |other: Option<&f64>| other.map_or(radius, |other| (other - across).abs());
        let strip = self.spread.between(
            across - neighbour(line.checked_sub(1).and_then(|before| lines.get(before))),
            across + neighbour(lines.get(line + 1)),
        );
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        for seen in strip {
            (first, last) = (first.min(seen.along), last.max(seen.along));
        }
        if first > last {
            return Vec::new();
        }
        // Stations are samples: the border is farther out, and beyond it the tip still touches its edge.
        let beyond = 2.0 * radius;
        let ends = [self.heading.point([first - beyond, across]), self.heading.point([last + beyond, across])];
        let floor = self.workpiece.bounds[0][2] - 2.0 * radius;
        let tips = tips_between(&self.workpiece.drop, &self.prepared.profile, ends[0], ends[1], self.chord_tolerance, Some(floor));
        let tips = tips.into_iter().map(|tip| {
            let [along, _] = self.heading.of_point([tip.position[0], tip.position[1]]);
            self.line_tip(along, across, tip.position[2], tip.touch)
        });
        let tips = self.with_ends_of_targets(tips.collect(), across);
        self.divided(line, across, &tips)
    }

    fn line_tip(&self, along: f64, across: f64, height: f64, touch: Option<Touch>) -> LineTip {
        let target = touch.as_ref().and_then(|touch| self.target_under(self.heading.point([along, across]), touch));
        LineTip { along, height, touch, target }
    }

    /// The target that a tip with its axis at a point finishes. Under the flat of a cutter every place of a level facet is
    /// touched at once: it counts as touched where the axis is over it.
    pub(super) fn target_under(&self, axis: [f64; 2], touch: &Touch) -> Option<usize> {
        let flat = self.prepared.profile.arcs()[0].point(0.0).0;
        if flat > 0.0 && touch.normal.z > 1.0 - 1e-12 {
            let under = self.workpiece.facet_under(axis)?;
            return (touch.height - under.height <= self.chord_tolerance).then(|| self.workpiece.target_of(under.facet)).flatten();
        }
        self.workpiece.finished_by(touch)
    }

    fn dropped(&self, along: f64, across: f64, guess: Option<Touch>) -> LineTip {
        let [x, y] = self.heading.point([along, across]);
        let touch = self.workpiece.drop.drop(&self.prepared.profile, x, y, guess.map(|touch| touch.facet));
        let height = touch.as_ref().map_or(f64::NEG_INFINITY, |touch| touch.height);
        self.line_tip(along, across, height, touch)
    }

    /// The tips of a line with further ones on both sides of each place at which a target begins or ends.
    fn with_ends_of_targets(&self, tips: Vec<LineTip>, across: f64) -> Vec<LineTip> {
        let step = (self.prepared.profile.outer_radius() / 4.0).max(self.chord_tolerance);
        let mut all: Vec<LineTip> = Vec::with_capacity(tips.len() + 16);
        for tip in tips {
            if let Some(&before) = all.last() {
                let length = tip.along - before.along;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of steps")]
                let steps = ((length / step).ceil().max(1.0)) as u32;
                let mut near = before;
                for part in 1..=steps {
                    let far = if part == steps {
                        tip
                    } else {
                        let at = before.along + length * f64::from(part) / f64::from(steps);
                        self.dropped(at, across, near.touch)
                    };
                    if near.target.is_some() != far.target.is_some() {
                        self.push_border(&mut all, near, far, across);
                    }
                    near = far;
                }
            }
            all.push(tip);
        }
        all
    }

    /// Adds the two tips between which a target begins or ends.
    fn push_border(&self, all: &mut Vec<LineTip>, mut near: LineTip, mut far: LineTip, across: f64) {
        while far.along - near.along > END {
            let middle = self.dropped(f64::midpoint(near.along, far.along), across, near.touch.or(far.touch));
            if middle.target.is_some() == near.target.is_some() { near = middle } else { far = middle }
        }
        for tip in [near, far] {
            if tip.height.is_finite() && all.last().is_none_or(|last| tip.along > last.along) {
                all.push(tip);
            }
        }
    }

    /// The stretches with a target, joined over gaps up to the cutter's diameter that are passed sooner on the surface than
    /// over the clearance height.
    fn divided(&self, line: usize, across: f64, tips: &[LineTip]) -> Vec<Run> {
        let diameter = 2.0 * self.prepared.profile.outer_radius();
        let mut stretches: Vec<[usize; 2]> = Vec::new();
        let mut begin: Option<usize> = None;
        for (index, tip) in tips.iter().enumerate() {
            match (begin, tip.target) {
                (None, Some(_)) => begin = Some(index),
                (Some(first), None) => {
                    stretches.push([first, index - 1]);
                    begin = None;
                }
                _ => {}
            }
        }
        stretches.extend(begin.map(|first| [first, tips.len() - 1]));
        let point = |tip: &LineTip| {
            let [x, y] = self.heading.point([tip.along, across]);
            [x, y, tip.height]
        };
        let mut joined: Vec<[usize; 2]> = Vec::new();
        for [first, last] in stretches {
            if let Some(before) = joined.last_mut() {
                let gap: Vec<[f64; 3]> = tips[before[1]..=first].iter().map(point).collect();
                let over = travel::lift(gap[0], gap[gap.len() - 1], self.clearance, self.prepared.link_rate, self.machine);
                if tips[first].along - tips[before[1]].along <= diameter
                    && travel::length_of(gap.iter()) / self.prepared.link_rate < over
                {
                    before[1] = last;
                    continue;
                }
            }
            joined.push([first, last]);
        }
        let run = |[first, last]: [usize; 2]| {
            let falls = |end: usize, beyond: Option<usize>| beyond.and_then(|beyond| tips.get(beyond)).is_none_or(|next| next.height < tips[end].height + self.chord_tolerance);
            let open = [falls(first, first.checked_sub(1)), falls(last, Some(last + 1))];
            let tips = tips[first..=last].iter().map(|tip| {
                let (contact, normal) = tip.touch.map_or(([0.0; 3], [0.0, 0.0, 1.0]), |touch| (touch.contact.into(), touch.normal.into()));
                RunTip { tip: point(tip), target: tip.target, contact, normal }
            });
            Run { line: Some(line), tips: tips.collect(), open }
        };
        joined.into_iter().map(run).collect()
    }

    /// Lengthens runs over borders that are oblique to them, so that the corner between two lines is cut: a run goes half as
    /// far as its neighbour goes farther, at most a spacing, straight on and not into other facets.
    fn extend_beyond_borders(&self, runs: &mut [Run], lines: &[f64]) {
        let mut first_of_line = vec![0; lines.len() + 1];
        for run in runs.iter() {
            if let Some(line) = run.line {
                first_of_line[line + 1] += 1;
            }
        }
        for line in 0..lines.len() {
            first_of_line[line + 1] += first_of_line[line];
        }
        let along = |tip: [f64; 3]| self.heading.of_point([tip[0], tip[1]])[0];
        let spans: Vec<[f64; 2]> = runs.iter().map(|run| [along(run.end(false)), along(run.end(true))]).collect();
        let mut further: Vec<[f64; 2]> = vec![[0.0; 2]; runs.len()];
        for (index, run) in runs.iter().enumerate() {
            let Some(line) = run.line else { continue };
            for neighbour in [line.checked_sub(1), Some(line + 1).filter(|next| *next < lines.len())].into_iter().flatten() {
                let spacing = (lines[neighbour] - lines[line]).abs();
                let overlapping = (first_of_line[neighbour]..first_of_line[neighbour + 1])
                    .filter(|other| spans[*other][0] < spans[index][1] && spans[*other][1] > spans[index][0]);
                for other in overlapping {
                    let ends = [spans[index][0] - spans[other][0], spans[other][1] - spans[index][1]];
                    for side in 0..2 {
                        if run.open[side] {
                            further[index][side] = further[index][side].max((ends[side] / 2.0).clamp(0.0, spacing));
                        }
                    }
                }
            }
        }
        for (run, further) in runs.iter_mut().zip(further) {
            for side in 0..2 {
                if further[side] > END {
                    self.extend(run, side == 1, further[side]);
                }
            }
        }
    }

    fn extend(&self, run: &mut Run, last: bool, length: f64) {
        let count = run.tips.len();
        let (end, before) = if last { (count - 1, count.checked_sub(2)) } else { (0, (count > 1).then_some(1)) };
        let (end, before) = (run.tips[end], before.map(|before| run.tips[before]));
        let sense = if last { 1.0 } else { -1.0 };
        let slope = before.map_or(0.0, |before| {
            let across = (end.tip[0] - before.tip[0]).hypot(end.tip[1] - before.tip[1]);
            if across > END { ((end.tip[2] - before.tip[2]) / across).clamp(-2.0, 2.0) } else { 0.0 }
        });
        let at = |part: f64| {
            let [x, y] = [0, 1].map(|axis| end.tip[axis] + sense * part * length * self.heading.along[axis]);
            [x, y, end.tip[2] + slope * part * length]
        };
        let is_free = |point: [f64; 3]| {
            self.workpiece.drop.drop(&self.prepared.profile, point[0], point[1], None).is_none_or(|touch| touch.height <= point[2] + self.chord_tolerance)
        };
        if [0.25, 0.5, 0.75, 1.0].into_iter().all(|part| is_free(at(part))) {
            let tip = RunTip { tip: at(1.0), target: None, ..end };
            if last { run.tips.push(tip) } else { run.tips.insert(0, tip) }
        }
    }
}
