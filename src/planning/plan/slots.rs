//! Runs in slots that leave the cutter hardly any room. Lines across such a slot do not enter it, and a border of where the tip may be is
//! not found in it, as no node of the raster is there. But the axis stands in it when the cutter finishes its floor: runs join these places.

use super::prepared::Prepared;
use super::runs::{Run, RunTip, highest_step};
use super::stations::Station;
use super::workpiece::Workpiece;
use crate::milling::Profile;
use crate::numerics::vector::{difference, dot, length};
use crate::path::{Sampling, tips_between};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

/// The distance from the axis, in radii of the cutter, at which the cutter meets both walls of a slot that counts as narrow.
const ROOM: f64 = 0.25;

/// The fewest stations that are worth a run.
const FEWEST: usize = 6;

/// A run finishes stations up to this distance beside it, in radii of the cutter.
const BESIDE: f64 = 0.5;

/// What a place ahead loses for each mm beside the way straight on: along straight walls runs are straight.
const ASTRAY: f64 = 3.0;

/// Where the cutter cannot go straight to the best place ahead, one within this share of its distance is tried, so many times.
const NEARER: f64 = 0.6;
const MOST_TRIES: usize = 12;

/// Narrow slots whose floor a path leaves standing.
pub(super) struct Slots<'a> {
    workpiece: &'a Workpiece,
    /// The cutter less the chord tolerance on all sides, so that it fits where the walls touch the cutter.
    profile: Profile,
    radius: f64,
    sampling: Sampling,
    /// The scallop height in mm: the largest step on the floor.
    height: f64,
    /// The tips that finish the stations.
    stands: Vec<RunTip>,
    /// The places of the tips by squares of the cutter's radius.
    cells: HashMap<[i32; 2], Vec<usize>>,
}

impl<'a> Slots<'a> {
    /// The slots around `standing`, stations that the cutter can reach; scallop height and chord tolerance in mm.
    pub(super) fn around(
        workpiece: &'a Workpiece,
        prepared: &Prepared,
        standing: &[&Station],
        height: f64,
        chord_tolerance: f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Self {
        let radius = prepared.profile.outer_radius();
        let profile = prepared.profile.widened(-chord_tolerance.min(radius / 2.0));
        let stand = |station: &&Station| {
            if stop() || !is_in_slot(workpiece, &prepared.profile, station, height) {
                return None;
            }
            let [x, y] = station.axis;
            let touch = workpiece.drop.drop(&profile, x, y, None).filter(|touch| touch.height <= station.tip + height)?;
            Some(RunTip { tip: [x, y, touch.height], target: Some(station.place.target), contact: station.place.point })
        };
        let stands: Vec<RunTip> = standing.par_iter().filter_map(stand).collect();
        let sampling = Sampling::fine(&profile, chord_tolerance);
        let mut slots = Self { workpiece, profile, radius, sampling, height, stands, cells: HashMap::new() };
        for (index, stand) in slots.stands.iter().enumerate() {
            slots.cells.entry(slots.cell(stand.tip)).or_default().push(index);
        }
        slots
    }

    /// Runs that pass all places, but for groups of a few.
    pub(super) fn runs(&self) -> Vec<Run> {
        let mut is_passed = vec![false; self.stands.len()];
        let mut runs = Vec::new();
        for start in 0..self.stands.len() {
            if !is_passed[start] {
                let before = count(&is_passed);
                let tips = self.run_through(start, &mut is_passed);
                if count(&is_passed) - before >= FEWEST {
                    runs.push(Run::along_curve(None, tips, false));
                }
            }
        }
        runs
    }

    /// The tips from one end of a slot to the other.
    fn run_through(&self, start: usize, is_passed: &mut [bool]) -> Vec<RunTip> {
        is_passed[start] = true;
        let mut tips = vec![self.stands[start]];
        let mut begins = None;
        for _ in 0..2 {
            let mut at = self.stands[start].tip;
            let mut ahead: Option<[f64; 2]> = begins.map(|[x, y]: [f64; 2]| [-x, -y]);
            while let Some(way) = self.next(at, ahead, is_passed) {
                let to = way[way.len() - 1].tip;
                self.pass(at, to, is_passed);
                ahead = direction(at, to);
                begins = begins.or(ahead);
                tips.extend(way);
                at = to;
            }
            self.pass(at, at, is_passed);
            // What lies on the other side of the start comes before it.
            tips.reverse();
        }
        tips
    }

    /// The tips on the way to the best place ahead, without the first.
    fn next(&self, at: [f64; 3], ahead: Option<[f64; 2]>, is_passed: &[bool]) -> Option<Vec<RunTip>> {
        let rated = |index: usize| {
            let to = self.stands[index].tip;
            let [x, y, _] = difference(to, at);
            let distance = x.hypot(y);
            let [forward, astray] =
                ahead.map_or([distance, 0.0], |[along_x, along_y]| [x * along_x + y * along_y, x * along_y - y * along_x]);
            let is_ahead = distance > 0.0 && distance <= self.radius && forward >= distance / 2.0;
            is_ahead.then(|| (forward - ASTRAY * astray.abs(), distance, index))
        };
        let mut places: Vec<(f64, f64, usize)> = self.near(at).filter(|index| !is_passed[*index]).filter_map(rated).collect();
        for _ in 0..MOST_TRIES {
            let &(_, distance, index) = places.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
            let way = self.way(at, &self.stands[index]);
            if way.is_some() {
                return way;
            }
            places.retain(|place| place.1 <= NEARER * distance);
        }
        None
    }

    /// The tips straight to another place, without the first; `None` over a wall.
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

    /// Marks what the cutter finishes on its way from a tip to another, as far as stations beside the way tell.
    fn pass(&self, from: [f64; 3], to: [f64; 3], is_passed: &mut [bool]) {
        let along = difference(to, from);
        let squared = dot(along, along);
        for index in self.near(from).chain(self.near(to)) {
            let out = difference(self.stands[index].tip, from);
            let share = if squared > 0.0 { dot(out, along) / squared } else { 0.0 };
            let beside: [f64; 3] = std::array::from_fn(|axis| out[axis] - share * along[axis]);
            if (0.0..=1.0).contains(&share) && length(beside) <= BESIDE * self.radius {
                is_passed[index] = true;
            }
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "extents over radii are under 2^31")]
    fn cell(&self, [x, y, _]: [f64; 3]) -> [i32; 2] {
        [x, y].map(|part| (part / self.radius).floor() as i32)
    }

    /// The places within a radius of a point, and some around them.
    fn near(&self, point: [f64; 3]) -> impl Iterator<Item = usize> {
        let [x, y] = self.cell(point);
        let cells = (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
        cells.filter_map(|cell| self.cells.get(&cell)).flatten().copied()
    }
}

fn count(is_passed: &[bool]) -> usize {
    is_passed.iter().filter(|passed| **passed).count()
}

fn direction(from: [f64; 3], to: [f64; 3]) -> Option<[f64; 2]> {
    let [x, y, _] = difference(to, from);
    let distance = x.hypot(y);
    (distance > 0.0).then(|| [x / distance, y / distance])
}

/// Whether walls stand on both sides of the tip that finishes a station.
fn is_in_slot(workpiece: &Workpiece, profile: &Profile, station: &Station, height: f64) -> bool {
    let room = ROOM * profile.outer_radius();
    let is_wall = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let touch = workpiece.drop.drop(profile, station.axis[0] + room * cos, station.axis[1] + room * sin, None);
        // A steep floor is no wall.
        touch.is_some_and(|touch| touch.height > station.tip + height + room)
    };
    (0_u8..4).map(|part| f64::from(part) * FRAC_PI_4).any(|angle| is_wall(angle) && is_wall(angle + std::f64::consts::PI))
}
