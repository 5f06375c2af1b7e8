//! The runs of planes in one direction: where they touch what is to be machined, with the tips of the cutter along them.

use super::family::{Heading, Spread};
use super::spacing::Prepared;
use super::stations::Region;
use super::travel;
use super::workpiece::Workpiece;
use crate::milling::Profile;
use crate::motion::Machine;
use crate::path::{DropCutter, Move, MoveKind, Sampling, Touch, tips_between};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A tip of a run. `target` is the one that the cutter finishes there; `None` on the way over a gap and beyond a border.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunTip {
    pub(super) tip: [f64; 3],
    pub(super) target: Option<usize>,
    pub(super) contact: [f64; 3],
}

/// A run: tips from one end to the other along a line, or over what lines miss.
#[derive(Debug, Clone)]
pub(super) struct Run {
    /// The position of its line; runs over what lines miss have none.
    pub(super) line: Option<usize>,
    pub(super) tips: Vec<RunTip>,
    /// Whether the last tip is joined to the first, which is not repeated.
    pub(super) closed: bool,
    /// For each end, whether the surface ends there without a wall.
    open: [bool; 2],
}

impl Run {
    /// A run along a curve, which is not lengthened.
    pub(super) fn along_curve(line: Option<usize>, tips: Vec<RunTip>, closed: bool) -> Self {
        Self { line, tips, closed, open: [false; 2] }
    }

    /// The first or the last tip.
    pub(super) fn end(&self, last: bool) -> [f64; 3] {
        let tip = if last { self.tips.last() } else { self.tips.first() };
        tip.map_or([0.0; 3], |tip| tip.tip)
    }

    /// Its moves, from the first tip to the last.
    pub(super) fn moves(&self) -> impl Iterator<Item = Move> {
        self.tips.windows(2).map(|pair| Move { from: pair[0].tip, to: pair[1].tip, kind: MoveKind::Cut })
    }
}

/// What the runs of planes in one direction are made from.
#[derive(Clone, Copy)]
pub(super) struct RunMaker<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) prepared: &'a Prepared,
    pub(super) region: &'a Region,
    pub(super) machine: &'a Machine,
    pub(super) heading: &'a Heading,
    pub(super) spread: &'a Spread,
    pub(super) sampling: Sampling,
    /// The height in mm at which rapid moves cross the part.
    pub(super) clearance: f64,
    pub(super) stop: &'a (dyn Fn() -> bool + Sync),
}

/// The cosine of the slope under which a contact is level: a rounding error.
pub(super) const LEVEL: f64 = 1.0 - 1e-12;

/// The target that a tip with its axis at a point finishes. Under the flat of a cutter every place of a level facet is touched
/// at once: it counts as touched where the axis is over it.
pub(super) fn target_under(workpiece: &Workpiece, prepared: &Prepared, axis: [f64; 2], touch: &Touch, tolerance: f64) -> Option<usize> {
    let flat = prepared.profile.arcs()[0].point(0.0).0;
    if flat > 0.0 && touch.normal.z > LEVEL {
        let (under, height) = workpiece.drop.facet_over(axis[0], axis[1])?;
        return (touch.height - height <= tolerance).then(|| workpiece.target_of(under)).flatten();
    }
    workpiece.finished_by(touch)
}

/// The most tips of a path: of some 500 m on a curved part. It bounds the memory of a plan, some 400 MB.
pub(super) const MOST_TIPS: usize = 800_000;

/// The width in mm to which the end of a run is narrowed down.
const END: f64 = 1e-3;

/// The largest step, in radii of the cutter, that a run passes at the feed rate. Down a higher wall the cutter would plunge.
pub(super) const STEP_IN_RADII: f64 = 0.25;

/// A move steeper than this tangent is part of a step.
const STEEP: f64 = 4.0;

/// The largest height in mm of consecutive steep moves in one sense.
pub(super) fn highest_step(points: &[[f64; 3]]) -> f64 {
    let (mut highest, mut step) = (0.0_f64, 0.0_f64);
    for pair in points.windows(2) {
        let rise = pair[1][2] - pair[0][2];
        let is_steep = rise.abs() > STEEP * (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        step = if is_steep && step * rise >= 0.0 {
            step + rise
        } else if is_steep {
            rise
        } else {
            0.0
        };
        highest = highest.max(step.abs());
    }
    highest
}

/// Where a level facet is looked for beside a line, in shares of what the line has to finish.
const BESIDE: [f64; 3] = [1.0, 0.7, 0.4];

/// A line across the part.
#[derive(Debug, Clone, Copy)]
struct Line {
    across: f64,
    /// Half of the distances in mm to the neighbouring lines, on the right and on the left: what this line has to finish.
    half: [f64; 2],
}

/// A tip of a line, before it is divided into runs.
#[derive(Debug, Clone, Copy)]
struct LineTip {
    along: f64,
    height: f64,
    touch: Option<Touch>,
    target: Option<usize>,
}

impl RunMaker<'_> {
    /// The runs of all lines, sorted by line and then along it; `None` if they have more than `MOST_TIPS` tips.
    pub(super) fn runs(&self, lines: &[f64]) -> Option<Vec<Run>> {
        let tips = AtomicUsize::new(0);
        let of_line = |line: usize| {
            if (self.stop)() || tips.load(Ordering::Relaxed) > MOST_TIPS {
                return Vec::new();
            }
            let runs = self.runs_of_line(line, lines);
            tips.fetch_add(runs.iter().map(|run| run.tips.len()).sum(), Ordering::Relaxed);
            runs
        };
        let mut runs: Vec<Run> = (0..lines.len()).into_par_iter().with_max_len(1).flat_map_iter(of_line).collect();
        if tips.into_inner() > MOST_TIPS {
            return None;
        }
        self.extend_beyond_borders(&mut runs, lines);
        Some(runs)
    }

    /// About how many samples the lines take: it bounds the time of a plan before it begins.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    pub(super) fn samples(&self, lines: &[f64]) -> usize {
        let length: f64 = (0..lines.len()).filter_map(|position| self.line(position, lines)).map(|(_, [first, last])| last - first).sum();
        (length / self.sampling.step) as usize
    }

    /// A line, and the first and the last station along it between its neighbours; `None` if there are none.
    fn line(&self, position: usize, lines: &[f64]) -> Option<(Line, [f64; 2])> {
        let across = lines[position];
        let radius = self.prepared.profile.outer_radius();
        let distance = |other: Option<usize>| other.and_then(|other| lines.get(other)).map(|other| (other - across).abs());
        let (before, after) = (distance(position.checked_sub(1)), distance(position.checked_add(1)));
        // A line at the border is as far from it as half its other spacing.
        let [before, after] = [before.or(after).unwrap_or(radius), after.or(before).unwrap_or(radius)];
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        for seen in self.spread.between(across - before, across + after) {
            (first, last) = (first.min(seen.along), last.max(seen.along));
        }
        (first <= last).then_some((Line { across, half: [before / 2.0, after / 2.0] }, [first, last]))
    }

    fn runs_of_line(&self, position: usize, lines: &[f64]) -> Vec<Run> {
        let Some((line, [first, last])) = self.line(position, lines) else { return Vec::new() };
        let (across, radius) = (line.across, self.prepared.profile.outer_radius());
        let ends = [self.beyond_targets(first, -1.0, &line), self.beyond_targets(last, 1.0, &line)];
        let ends = ends.map(|along| self.heading.point([along, across]));
        let floor = self.workpiece.bounds[0][2] - 2.0 * radius;
        let tips = tips_between(&self.workpiece.drop, &self.prepared.profile, ends[0], ends[1], &self.sampling, Some(floor));
        let tips = tips.into_iter().map(|tip| {
            let [along, _] = self.heading.of_point([tip.position[0], tip.position[1]]);
            self.line_tip(along, &line, tip.position[2], tip.touch)
        });
        let tips = self.with_ends_of_targets(tips.collect(), &line);
        self.divided(position, across, &tips)
    }

    /// A place of the line beyond all that it finishes, from the outermost station: a diameter beyond the last target on the way.
    /// Stations are samples: on a large part the border is several diameters farther out, and beyond it the tip still touches its edge.
    fn beyond_targets(&self, station: f64, sense: f64, line: &Line) -> f64 {
        const STEPS: u32 = 16;
        let step = sense * 2.0 * self.prepared.profile.outer_radius() / f64::from(STEPS);
        let mut guess = None;
        let mut beyond = station + step;
        let (mut along, mut without_target) = (station, 0);
        while without_target < STEPS {
            along += step;
            let tip = self.dropped(along, line, guess);
            without_target += 1;
            if tip.target.is_some() {
                beyond = along + step;
                without_target = 0;
            }
            guess = tip.touch;
        }
        beyond
    }

    fn line_tip(&self, along: f64, line: &Line, height: f64, touch: Option<Touch>) -> LineTip {
        let target = touch.as_ref().and_then(|touch| {
            let axis = self.heading.point([along, line.across]);
            target_under(self.workpiece, self.prepared, axis, touch, self.sampling.chord_tolerance)
                .or_else(|| self.target_beside(along, line, touch))
                .filter(|target| self.region.includes(*target, axis))
        });
        LineTip { along, height, touch, target }
    }

    /// The level target beside a line that the flat of the cutter finishes although the axis is not over it.
    fn target_beside(&self, along: f64, line: &Line, touch: &Touch) -> Option<usize> {
        if touch.normal.z <= LEVEL {
            return None;
        }
        let flat = self.prepared.profile.arcs()[0].point(0.0).0;
        let [right, left] = line.half.map(|half| 0.98 * half.min(flat));
        // A narrow facet may lie between the line and the end of what the line has to finish.
        BESIDE.iter().flat_map(|share| [line.across - share * right, line.across + share * left]).find_map(|across| {
            let [x, y] = self.heading.point([along, across]);
            let (under, height) = self.workpiece.drop.facet_over(x, y)?;
            ((touch.height - height).abs() <= self.sampling.chord_tolerance).then(|| self.workpiece.target_of(under)).flatten()
        })
    }

    fn dropped(&self, along: f64, line: &Line, guess: Option<Touch>) -> LineTip {
        let [x, y] = self.heading.point([along, line.across]);
        let touch = self.workpiece.drop.drop(&self.prepared.profile, x, y, guess.map(|touch| touch.facet));
        let height = touch.as_ref().map_or(f64::NEG_INFINITY, |touch| touch.height);
        self.line_tip(along, line, height, touch)
    }

    /// The tips of a line with further ones on both sides of each place at which a target begins or ends.
    fn with_ends_of_targets(&self, tips: Vec<LineTip>, line: &Line) -> Vec<LineTip> {
        let step = (self.prepared.profile.outer_radius() / 4.0).max(self.sampling.chord_tolerance);
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
                        self.dropped(at, line, near.touch)
                    };
                    if near.target.is_some() != far.target.is_some() {
                        self.push_border(&mut all, near, far, line);
                    }
                    near = far;
                }
            }
            all.push(tip);
        }
        all
    }

    /// Adds the two tips between which a target begins or ends.
    fn push_border(&self, all: &mut Vec<LineTip>, mut near: LineTip, mut far: LineTip, line: &Line) {
        while far.along - near.along > END {
            let middle = self.dropped(f64::midpoint(near.along, far.along), line, near.touch.or(far.touch));
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
                    && highest_step(&gap) <= STEP_IN_RADII * diameter / 2.0
                    && travel::length_of(gap.iter()) / self.prepared.link_rate < over
                {
                    before[1] = last;
                    continue;
                }
            }
            joined.push([first, last]);
        }
        let run = |[first, last]: [usize; 2]| {
            let falls = |end: usize, beyond: Option<usize>| {
                beyond.and_then(|beyond| tips.get(beyond)).is_none_or(|next| next.height < tips[end].height + self.sampling.chord_tolerance)
            };
            // Where the flat finishes a level border, the half strips beside the line are finished already.
            let flat = self.prepared.profile.arcs()[0].point(0.0).0;
            let is_level = |end: usize| flat > 0.0 && tips[end].touch.is_some_and(|touch| touch.normal.z > LEVEL);
            let open = [falls(first, first.checked_sub(1)) && !is_level(first), falls(last, Some(last + 1)) && !is_level(last)];
            let tips = tips[first..=last].iter().map(|tip| {
                let contact = tip.touch.map_or([0.0; 3], |touch| touch.contact.into());
                RunTip { tip: point(tip), target: tip.target, contact }
            });
            Run { line: Some(line), tips: tips.collect(), closed: false, open }
        };
        joined.into_iter().map(run).collect()
    }

    /// Lengthens runs over borders that are oblique to them, so that the corner between two lines is cut: a run goes half as
    /// far as its neighbour goes farther, at most a spacing, straight on where the part lets it and not up another facet.
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
                    for ((further, end), _) in further[index].iter_mut().zip(ends).zip(run.open).filter(|(_, is_open)| *is_open) {
                        *further = further.max((end / 2.0).clamp(0.0, spacing));
                    }
                }
            }
        }
        for (run, further) in runs.iter_mut().zip(further) {
            for (is_last, length) in [false, true].into_iter().zip(further) {
                if length > END {
                    self.extend(run, is_last, length);
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
        let further = [0, 1].map(|axis| sense * length * self.heading.along[axis]);
        let further =
            straight_on(&self.workpiece.drop, &self.prepared.profile, end.tip, [further[0], further[1], slope * length], &self.sampling);
        let further = further.unwrap_or_default();
        // The runs of long paths take many megabytes: without spare capacity, half of it.
        run.tips.reserve_exact(further.len());
        let further = further.into_iter().map(|tip| RunTip { tip, target: None, ..end });
        if last {
            run.tips.extend(further);
        } else {
            run.tips.splice(0..0, further.rev());
        }
    }
}

/// The tips straight on from one by a step, or on a ledge that holds the cutter up on the way; `None` where the part rises over both.
fn straight_on(drop: &DropCutter, profile: &Profile, from: [f64; 3], step: [f64; 3], sampling: &Sampling) -> Option<Vec<[f64; 3]>> {
    let slope = step[2] / step[0].hypot(step[1]);
    let tolerance = sampling.chord_tolerance;
    let lowest = from[2] + step[2].min(0.0) - tolerance;
    let tips = tips_between(drop, profile, [from[0], from[1]], [from[0] + step[0], from[1] + step[1]], sampling, Some(lowest));
    let mut further = Vec::new();
    for (number, tip) in tips.iter().enumerate().skip(1) {
        let [x, y, height] = tip.position;
        let straight = from[2] + slope * (x - from[0]).hypot(y - from[1]);
        if height > straight.max(from[2]) + tolerance {
            return None;
        }
        if height > straight - tolerance || number + 1 == tips.len() {
            further.push([x, y, height.max(straight)]);
        }
    }
    Some(further)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_lengthened_over_a_ledge_and_not_up_a_wall() {
        let step_at = |x: f64, z: f64| [[[x, -9.0, z], [x - 9.0, -9.0, z], [x, 9.0, z]]];
        let profile = Profile::torus(3.0, 0.0);
        let sampling = Sampling::fine(&profile, 0.001);
        let lengthened =
            |facets: &[[[f64; 3]; 3]]| straight_on(&DropCutter::new(facets, &|| false), &profile, [0.0; 3], [0.8, 0.0, -0.4], &sampling);
        // Nothing is there, a ledge ends under the flat's edge after 0.1 mm, and a wall stands before the end.
        assert_eq!(lengthened(&step_at(-5.0, -1.0)), Some(vec![[0.8, 0.0, -0.4]]));
        let over_ledge = lengthened(&step_at(-2.9, -0.01)).unwrap();
        assert!(over_ledge.iter().any(|[x, _, z]| (x - 0.1).abs() < 1e-3 && (z + 0.01).abs() < 1e-9), "{over_ledge:?}");
        assert_eq!(over_ledge.last(), Some(&[0.8, 0.0, -0.4]));
        assert_eq!(lengthened(&[[[3.5, -9.0, 1.0], [9.0, 0.0, 1.0], [3.5, 9.0, 1.0]]]), None);
    }
}
