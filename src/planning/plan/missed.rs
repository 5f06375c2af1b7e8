//! Runs over what lines miss: triangles between lines that end at a wall, strips beside walls, ledges over which the axis
//! cannot stand, slots that leave the cutter no room, narrow tops between lines. The axes that finish the missed stations are
//! known; a run goes from one to the next.

use super::judged::MissedStation;
use super::runs::{LEVEL, Run, RunTip, highest_step};
use super::spacing::Prepared;
use super::stations::{AT_ONCE, Station};
use super::workpiece::Workpiece;
use crate::milling::Profile;
use crate::numerics::vector::{difference, dot, length, mixed};
use crate::path::{Milled, Move, MoveKind, Sampling, tips_between};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

/// What rises over the tangent plane of a place by more than this share of the distance is a wall, not the curved surface.
const WALL: f64 = 0.1;

/// The largest share of the area, without what is beside walls, that is finished by runs. More is finished by closer lines.
const MOST_OPEN: f64 = 0.02;

/// The fewest stations that are worth a run.
const FEWEST: usize = 6;

/// The share of the scallop height by which a tip leaves less than the path does where a run goes to it.
const WORTHWHILE: f64 = 0.1;

/// What each mm beside the way straight on counts against a tip ahead: along straight walls runs are straight.
const ASTRAY: f64 = 3.0;

/// Tips closer than this many mm are the same.
const SAME: f64 = 1e-9;

/// Where the cutter cannot go straight to the best tip ahead, one within this share of its distance is tried, so many times.
const NEARER: f64 = 0.6;
const MOST_TRIES: usize = 12;

/// The tips that finish what a path misses.
pub(super) struct Missed<'a> {
    workpiece: &'a Workpiece,
    /// The cutter with a flat narrower by half of the chord tolerance on all sides: it fits into a slot as wide as the cutter.
    profile: Profile,
    radius: f64,
    /// The radius of the flat in mm.
    flat: f64,
    sampling: Sampling,
    /// The scallop height in mm: the largest step of a run.
    height: f64,
    tips: Vec<RunTip>,
    /// A run passes tips up to this distance in mm beside it.
    beside: f64,
    /// The positions of tips by squares of the cutter's radius.
    cells: HashMap<[i64; 2], Vec<usize>>,
}

impl<'a> Missed<'a> {
    /// Those of missed stations that closer lines would not finish: those with a wall at the distance `beside`, in radii of the cutter,
    /// and, if they are few, the others. Scallop height and chord tolerance in mm.
    pub(super) fn of(
        workpiece: &'a Workpiece,
        prepared: &Prepared,
        stations: &[MissedStation],
        beside: f64,
        height: f64,
        chord_tolerance: f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Self {
        let radius = prepared.profile.outer_radius();
        let flat = prepared.profile.arcs()[0].point(0.0).0.max(0.0);
        let profile = prepared.profile.widened(-0.5 * chord_tolerance.min(flat));
        let beside = beside * radius;
        let is_beside = |missed: &&MissedStation| !stop() && is_beside_wall(workpiece, &prepared.profile, missed.station, beside, height);
        let (mut passed, open): (Vec<&MissedStation>, Vec<&MissedStation>) = stations.par_iter().with_max_len(16).partition(is_beside);
        if open.iter().map(|missed| missed.share).sum::<f64>() <= MOST_OPEN {
            passed.extend(open);
        }
        let tip_of = |missed: &&MissedStation| {
            let MissedStation { station, judged, .. } = missed;
            let [x, y] = station.axis;
            let touch = workpiece.drop.drop(&profile, x, y, None).filter(|touch| touch.height <= station.tip + height)?;
            // Where other facets hold the cutter up, it may leave as much over the place as the path does.
            let tip = [x, y, touch.height];
            let standing = Milled::new(&prepared.profile, &[Move { from: tip, to: tip, kind: MoveKind::Cut }], stop)?;
            let leaves = standing.left_at(station.place.point, workpiece.targets[station.place.target].normal);
            let is_worthwhile = judged.left.zip(leaves).is_none_or(|(left, leaves)| leaves.height <= left - WORTHWHILE * height);
            is_worthwhile.then_some(RunTip { tip, target: Some(station.place.target), contact: station.place.point })
        };
        let tips: Vec<RunTip> = passed.par_iter().with_max_len(AT_ONCE).filter_map(tip_of).collect();
        let fine = Sampling::fine(&profile, chord_tolerance);
        // The edge of a flat end that passes a wall's corner between two samples cuts it by step^2 / (8 R).
        let sampling = Sampling { step: fine.step.min((4.0 * radius * chord_tolerance).sqrt()), ..fine };
        let mut missed = Self { workpiece, profile, radius, flat, sampling, height, tips, beside, cells: HashMap::new() };
        for (index, tip) in missed.tips.iter().enumerate() {
            missed.cells.entry(missed.cell(tip.tip)).or_default().push(index);
        }
        missed
    }

    /// Runs that pass all tips, but for groups of a few.
    pub(super) fn runs(&self) -> Vec<Run> {
        let mut is_passed = vec![false; self.tips.len()];
        let mut runs = Vec::new();
        for start in 0..self.tips.len() {
            if !is_passed[start] {
                let (tips, passed) = self.run_through(start, &mut is_passed);
                if passed >= FEWEST {
                    runs.push(Run::along_curve(None, tips, false));
                }
            }
        }
        runs
    }

    /// The run from a tip as far as it can go, both ways, and how many tips it passes.
    fn run_through(&self, start: usize, is_passed: &mut [bool]) -> (Vec<RunTip>, usize) {
        is_passed[start] = true;
        let mut passed = 1;
        let mut tips = vec![self.tips[start]];
        // Towards the nearest tip, which is along a wall, and away from it.
        let distance = |index: &usize| length(difference(self.tips[*index].tip, tips[0].tip));
        let others = self.near(tips[0].tip).filter(|index| !is_passed[*index] && distance(index) > SAME);
        let Some(nearest) = others.min_by(|a, b| distance(a).total_cmp(&distance(b))) else { return (tips, passed) };
        let [x, y] = direction(tips[0].tip, self.tips[nearest].tip);
        for mut ahead in [[x, y], [-x, -y]] {
            let mut at = self.tips[start].tip;
            while let Some((next, way)) = self.next(at, ahead, is_passed) {
                let to = self.tips[next].tip;
                is_passed[next] = true;
                passed += 1 + self.pass(at, to, is_passed);
                ahead = direction(at, to);
                tips.extend(way);
                at = to;
            }
            passed += self.pass(at, at, is_passed);
            // What lies on the other side of the start comes before it.
            tips.reverse();
        }
        (tips, passed)
    }

    /// The best tip ahead, and the way there without its start.
    fn next(&self, at: [f64; 3], ahead: [f64; 2], is_passed: &[bool]) -> Option<(usize, Vec<RunTip>)> {
        let rated = |index: usize| {
            let to = self.tips[index].tip;
            let [x, y, _] = difference(to, at);
            let distance = x.hypot(y);
            let [forward, astray] = [x * ahead[0] + y * ahead[1], x * ahead[1] - y * ahead[0]];
            let is_ahead = distance > SAME && distance <= self.radius && forward >= distance / 2.0;
            is_ahead.then(|| (forward - ASTRAY * astray.abs(), distance, index))
        };
        let mut to: Vec<(f64, f64, usize)> = self.near(at).filter(|index| !is_passed[*index]).filter_map(rated).collect();
        for _ in 0..MOST_TRIES {
            let &(_, distance, index) = to.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
            if let Some(way) = self.way(at, &self.tips[index]) {
                return Some((index, way));
            }
            to.retain(|(_, other, _)| *other <= NEARER * distance);
        }
        None
    }

    /// The tips straight to another one, without the start; `None` over a wall.
    fn way(&self, from: [f64; 3], to: &RunTip) -> Option<Vec<RunTip>> {
        let ends = [from, to.tip].map(|[x, y, _]| [x, y]);
        let tips = tips_between(&self.workpiece.drop, &self.profile, ends[0], ends[1], &self.sampling, None);
        let points: Vec<[f64; 3]> = tips.iter().map(|tip| tip.position).collect();
        let is_whole = points.len() > 1 && highest_step(&points) <= self.height;
        is_whole.then(|| {
            let tip = |tip: [f64; 3]| RunTip { tip, ..*to };
            points.into_iter().skip(1).map(tip).collect()
        })
    }

    /// Marks the tips on the way from one to another, and beside it, and those whose level places the flat finishes from there, and
    /// counts those that were not marked.
    fn pass(&self, from: [f64; 3], to: [f64; 3], is_passed: &mut [bool]) -> usize {
        let mut passed = 0;
        for index in self.near(from).chain(self.near(to)) {
            let tip = &self.tips[index];
            let is_passed = &mut is_passed[index];
            if !*is_passed && (self.is_beside(tip.tip, from, to) || self.is_under_flat(tip, from, to)) {
                *is_passed = true;
                passed += 1;
            }
        }
        passed
    }

    fn is_beside(&self, tip: [f64; 3], from: [f64; 3], to: [f64; 3]) -> bool {
        let share = share_along(tip, from, to);
        (0.0..=1.0).contains(&share) && length(difference(tip, mixed(from, to, share))) <= self.beside
    }

    /// Whether the flat finishes a level place on the way.
    fn is_under_flat(&self, tip: &RunTip, from: [f64; 3], to: [f64; 3]) -> bool {
        let is_level = tip.target.is_some_and(|target| self.workpiece.targets[target].normal[2] > LEVEL);
        let on_way = mixed(from, to, share_along(tip.contact, from, to).clamp(0.0, 1.0));
        let [x, y, z] = difference(tip.contact, on_way);
        is_level && x.hypot(y) <= self.flat && z.abs() <= self.height && (to[2] - from[2]).abs() <= self.height
    }

    #[expect(clippy::cast_possible_truncation, reason = "places over radii are under 2^63")]
    fn cell(&self, [x, y, _]: [f64; 3]) -> [i64; 2] {
        [x, y].map(|part| (part / self.radius).floor() as i64)
    }

    /// The tips within a radius of a point, and some around them.
    fn near(&self, point: [f64; 3]) -> impl Iterator<Item = usize> {
        let [x, y] = self.cell(point);
        let cells = (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
        cells.filter_map(|cell| self.cells.get(&cell)).flatten().copied()
    }
}

/// Where a point lies on the way from one tip to another, from 0 to 1 between them.
fn share_along(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let along = difference(to, from);
    let squared = dot(along, along);
    if squared > 0.0 { dot(difference(point, from), along) / squared } else { 0.0 }
}

/// The direction from a tip to another one, seen from above.
fn direction(from: [f64; 3], to: [f64; 3]) -> [f64; 2] {
    let [x, y, _] = difference(to, from);
    let distance = x.hypot(y).max(SAME);
    [x / distance, y / distance]
}

/// Whether a wall stands at a distance beside the tip that finishes a station.
fn is_beside_wall(workpiece: &Workpiece, profile: &Profile, station: &Station, beside: f64, height: f64) -> bool {
    let [normal_x, normal_y, normal_z] = workpiece.targets[station.place.target].normal;
    (0_u8..8).any(|part| {
        let (sin, cos) = (f64::from(part) * FRAC_PI_4).sin_cos();
        let touch = workpiece.drop.drop(profile, station.axis[0] + beside * cos, station.axis[1] + beside * sin, None);
        let on_plane = station.tip - beside * (normal_x * cos + normal_y * sin) / normal_z;
        touch.is_some_and(|touch| touch.height > on_plane + height.max(WALL * beside / normal_z))
    })
}
