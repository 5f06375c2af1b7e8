//! The runs of waterlines: level curves of the tips' surface, as far as the tip finishes the region there, in chains.

use super::runs::{MOST_TIPS, Run, RunTip, target_under};
use super::spacing::Prepared;
use super::stations::Region;
use super::travel;
use super::workpiece::Workpiece;
use crate::path::{Area, Contour, LevelMap};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Cells of the raster on which curves are found in a cutter's radius, and the most nodes of it.
const CELLS_IN_RADIUS: f64 = 4.0;
const MOST_NODES: f64 = 250_000.0;

/// The levels that are followed at a time, so that a path that is too long ends early.
const AT_ONCE: usize = 16;

/// What waterlines are made from.
pub(super) struct LevelMaker<'a> {
    workpiece: &'a Workpiece,
    prepared: &'a Prepared,
    region: &'a Region,
    map: LevelMap<'a>,
    /// The largest distance in mm of chords from the tips' surface.
    chord_tolerance: f64,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> LevelMaker<'a> {
    /// The heights of a cutter's tips. Once `stop` returns true, the result must be discarded.
    pub(super) fn new(
        workpiece: &'a Workpiece,
        prepared: &'a Prepared,
        region: &'a Region,
        chord_tolerance: f64,
        stop: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        let radius = prepared.profile.outer_radius();
        let [low, high] = workpiece.bounds;
        let beyond = 1.5 * radius;
        let (min, max) = ([low[0] - beyond, low[1] - beyond], [high[0] + beyond, high[1] + beyond]);
        let coarsest = ((max[0] - min[0]) * (max[1] - min[1]) / MOST_NODES).sqrt();
        let area = Area { min, max, cell: (radius / CELLS_IN_RADIUS).max(coarsest) };
        let map = LevelMap::new(&workpiece.drop, &prepared.profile, &area, stop);
        Self { workpiece, prepared, region, map, chord_tolerance, stop }
    }

    /// The runs of all levels, given in rising order, from the highest level down; `None` if they have more than [`MOST_TIPS`]
    /// tips.
    pub(super) fn runs(&self, levels: &[f64]) -> Option<Vec<Run>> {
        let tips = AtomicUsize::new(0);
        let mut runs = Vec::new();
        let downwards: Vec<f64> = levels.iter().rev().copied().collect();
        for (group, heights) in downwards.chunks(AT_ONCE).enumerate() {
            let contours = self.map.waterlines(heights, self.chord_tolerance, self.stop);
            let of_level = |(level, contours): (usize, &Vec<Contour>)| -> Vec<Run> {
                let line = group * AT_ONCE + level;
                let runs: Vec<Run> = contours.iter().flat_map(|contour| self.runs_of(contour, line)).collect();
                tips.fetch_add(runs.iter().map(|run| run.tips.len()).sum(), Ordering::Relaxed);
                runs
            };
            runs.extend(contours.par_iter().with_max_len(1).enumerate().flat_map_iter(of_level).collect::<Vec<_>>());
            if tips.load(Ordering::Relaxed) > MOST_TIPS {
                return None;
            }
        }
        Some(runs)
    }

    fn runs_of(&self, contour: &Contour, line: usize) -> Vec<Run> {
        let radius = self.prepared.profile.outer_radius();
        let tips: Vec<RunTip> = points_along(contour, radius / 2.0).into_iter().map(|point| self.tip(point)).collect();
        let finishes: Vec<bool> = tips.iter().map(|tip| tip.target.is_some()).collect();
        let chain = Chain { tips, closed: contour.closed };
        // A tip more at each end: the region ends somewhere on the way to it.
        let count = finishes.len();
        let wanted = (0..count).map(|at| {
            let beside = if contour.closed {
                [Some((at + count - 1) % count), Some((at + 1) % count)]
            } else {
                [at.checked_sub(1), Some(at + 1).filter(|next| *next < count)]
            };
            finishes[at] || beside.into_iter().flatten().any(|beside| finishes[beside])
        });
        chain.runs(wanted.collect(), 2.0 * radius, Some(line))
    }

    /// A tip of a curve with what it finishes there. Where the surface of the tips has a step, the curve is beside what it would
    /// touch.
    fn tip(&self, tip: [f64; 3]) -> RunTip {
        let axis = [tip[0], tip[1]];
        let touch = self.workpiece.drop.drop(&self.prepared.profile, axis[0], axis[1], None);
        let touching = touch.filter(|touch| {
            let (off, most) = ((touch.height - tip[2]).abs(), 2.0 * self.chord_tolerance);
            // In height, or seen from above.
            off <= most || off * touch.normal.z <= most * touch.normal.x.hypot(touch.normal.y)
        });
        let target = touching
            .and_then(|touch| target_under(self.workpiece, self.prepared, axis, &touch, self.chord_tolerance))
            .filter(|target| self.region.includes(*target, axis));
        RunTip { tip, target, contact: touch.map_or(tip, |touch| touch.contact.into()) }
    }
}

/// The tips along a curve. A closed one does not repeat its first tip.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    pub(super) tips: Vec<RunTip>,
    pub(super) closed: bool,
}

/// Points along a contour at most `apart` mm apart.
fn points_along(contour: &Contour, apart: f64) -> Vec<[f64; 3]> {
    let ends = contour.tips.iter().zip(contour.tips.iter().skip(1).chain(contour.tips.first().filter(|_| contour.closed)));
    let mut points: Vec<[f64; 3]> = Vec::new();
    for (from, to) in ends.map(|(from, to)| (from.position, to.position)) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of parts")]
        let parts = ((travel::distance(from, to) / apart).ceil().max(1.0)) as u32;
        points.extend((0..parts).map(|part| {
            let share = f64::from(part) / f64::from(parts);
            [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        }));
    }
    points.extend(contour.tips.last().filter(|_| !contour.closed).map(|last| last.position));
    points
}

impl Chain {
    /// The runs over the tips that are wanted, joined over gaps up to `gap` mm along the chain. `line` is the position of their
    /// line.
    pub(super) fn runs(&self, mut wanted: Vec<bool>, gap: f64, line: Option<usize>) -> Vec<Run> {
        let count = self.tips.len();
        let Some(first) = wanted.iter().position(|wanted| *wanted) else { return Vec::new() };
        // Gaps are closed along the chain, a closed one from its first wanted tip all around.
        let around: Vec<usize> = if self.closed { (first..count).chain(0..first).collect() } else { (0..count).collect() };
        let mut open: Vec<usize> = Vec::new();
        let mut length = 0.0;
        let mut last: Option<usize> = None;
        for &index in around.iter().chain(self.closed.then_some(&first)) {
            length += last.map_or(0.0, |last| travel::distance(self.tips[last].tip, self.tips[index].tip));
            if wanted[index] {
                if length <= gap {
                    for between in &open {
                        wanted[*between] = true;
                    }
                }
                open.clear();
                length = 0.0;
            } else {
                open.push(index);
            }
            last = Some(index);
        }
        let run = |tips: Vec<RunTip>, closed| Run::along_curve(line, tips, closed);
        if self.closed && wanted.iter().all(|wanted| *wanted) {
            return vec![run(self.tips.clone(), true)];
        }
        let start = if self.closed { around.iter().position(|index| !wanted[*index]).unwrap_or(0) } else { 0 };
        let turned: Vec<usize> = around[start..].iter().chain(&around[..start]).copied().collect();
        let stretches = turned.split(|index| !wanted[*index]).filter(|stretch| stretch.len() > 1);
        stretches.map(|stretch| run(stretch.iter().map(|index| self.tips[*index]).collect(), false)).collect()
    }
}
