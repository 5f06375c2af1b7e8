//! Runs along the feet of walls: the border of where the tip stands on what is to be machined, as far as it touches a wall
//! there. Lines that end at a wall leave triangles between their ends, and lines beside a wall a strip.

use super::judged::Judged;
use super::prepared::Prepared;
use super::runs::{Run, RunTip, target_under};
use super::stations::Station;
use super::travel;
use super::workpiece::Workpiece;
use crate::path::{Area, Contour, Tip, borders};
use std::collections::HashSet;

/// Cells of the raster on which borders are found in a cutter's radius, and the most nodes of it.
const CELLS_IN_RADIUS: f64 = 8.0;
const MOST_NODES: f64 = 250_000.0;

/// The distance beyond the border in radii of the cutter at which a wall is looked for.
const BEYOND: f64 = 0.02;

/// The borders of a cutter's tips beside walls, independent of the direction of lines.
#[derive(Debug, Clone)]
pub(super) struct Feet {
    curves: Vec<Foot>,
    radius: f64,
}

/// One border, in points at most half a cutter's radius apart.
#[derive(Debug, Clone)]
struct Foot {
    tips: Vec<RunTip>,
    /// For each tip, whether a wall rises beyond it.
    at_wall: Vec<bool>,
    closed: bool,
}

impl Feet {
    /// The feet of all walls beside what a cutter can machine. Once `stop` returns true, the result must be discarded.
    pub(super) fn of(workpiece: &Workpiece, prepared: &Prepared, chord_tolerance: f64, stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let radius = prepared.profile.outer_radius();
        let [low, high] = workpiece.bounds;
        let (min, max) = ([low[0] - radius, low[1] - radius], [high[0] + radius, high[1] + radius]);
        let coarsest = ((max[0] - min[0]) * (max[1] - min[1]) / MOST_NODES).sqrt();
        let area = Area { min, max, cell: (radius / CELLS_IN_RADIUS).max(coarsest) };
        let inside = |axis: [f64; 2]| {
            let touch = workpiece.drop.drop(&prepared.profile, axis[0], axis[1], None)?;
            target_under(workpiece, prepared, axis, &touch, chord_tolerance)?;
            Some(Tip { position: [axis[0], axis[1], touch.height], touch: Some(touch) })
        };
        let curves = borders(&inside, &area, chord_tolerance, stop);
        let foot = |contour: &Contour| Foot::of(workpiece, prepared, contour, chord_tolerance);
        Self { curves: curves.iter().map(foot).filter(|foot| foot.at_wall.contains(&true)).collect(), radius }
    }

    /// The runs along feet beside stations that the cutter can reach and a path leaves standing.
    pub(super) fn runs(&self, stations: &[Station], judged: &[Judged], height: f64) -> Vec<Run> {
        let cell = self.radius;
        #[expect(clippy::cast_possible_truncation, reason = "extents over radii are under 2^31")]
        let cell_of = |point: [f64; 2]| point.map(|part| (part / cell).floor() as i32);
        let stands = |(station, judged): &(&Station, &Judged)| station.lift <= height && judged.left.is_none_or(|left| left > 1.5 * height);
        let standing: HashSet<[i32; 2]> = stations.iter().zip(judged).filter(stands).map(|(station, _)| cell_of(station.axis)).collect();
        let is_near = |tip: &RunTip| {
            let [x, y] = cell_of([tip.tip[0], tip.tip[1]]);
            (-1..=1).any(|dx| (-1..=1).any(|dy| standing.contains(&[x + dx, y + dy])))
        };
        self.curves.iter().flat_map(|foot| foot.stretches(&is_near, 4.0 * self.radius)).collect()
    }
}

impl Foot {
    fn of(workpiece: &Workpiece, prepared: &Prepared, contour: &Contour, chord_tolerance: f64) -> Self {
        let radius = prepared.profile.outer_radius();
        let ends = contour.tips.iter().zip(contour.tips.iter().skip(1).chain(contour.tips.first().filter(|_| contour.closed)));
        let mut foot = Self { tips: Vec::new(), at_wall: Vec::new(), closed: contour.closed };
        for (from, to) in ends {
            let length = travel::distance(from.position, to.position);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of parts")]
            let parts = ((2.0 * length / radius).ceil().max(1.0)) as u32;
            for part in 0..parts {
                let share = f64::from(part) / f64::from(parts);
                let tip = [0, 1, 2].map(|axis| from.position[axis] + share * (to.position[axis] - from.position[axis]));
                foot.push(
                    workpiece,
                    prepared,
                    tip,
                    [to.position[0] - from.position[0], to.position[1] - from.position[1]],
                    chord_tolerance,
                );
            }
        }
        if let (false, [.., before, last]) = (contour.closed, &contour.tips[..]) {
            let along = [last.position[0] - before.position[0], last.position[1] - before.position[1]];
            foot.push(workpiece, prepared, last.position, along, chord_tolerance);
        }
        foot
    }

    /// Adds a tip of the border, which runs along `along` there, the inside on its left.
    fn push(&mut self, workpiece: &Workpiece, prepared: &Prepared, tip: [f64; 3], along: [f64; 2], chord_tolerance: f64) {
        let length = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
        let distance = BEYOND * prepared.profile.outer_radius();
        let beyond = [tip[0] + distance * along[1] / length, tip[1] - distance * along[0] / length];
        let rises = workpiece
            .drop
            .drop(&prepared.profile, beyond[0], beyond[1], None)
            .is_some_and(|touch| touch.height > tip[2] + 2.0 * chord_tolerance);
        let touch = workpiece.drop.drop(&prepared.profile, tip[0], tip[1], None);
        let target = touch.and_then(|touch| target_under(workpiece, prepared, [tip[0], tip[1]], &touch, 2.0 * chord_tolerance));
        let contact = touch.map_or(tip, |touch| touch.contact.into());
        self.tips.push(RunTip { tip, target, contact });
        self.at_wall.push(rises);
    }

    /// The stretches at walls that `is_near` accepts, joined over gaps up to `gap` mm along the border.
    fn stretches(&self, is_near: &dyn Fn(&RunTip) -> bool, gap: f64) -> Vec<Run> {
        let count = self.tips.len();
        let mut wanted: Vec<bool> = self.tips.iter().zip(&self.at_wall).map(|(tip, at_wall)| *at_wall && is_near(tip)).collect();
        let Some(first) = wanted.iter().position(|wanted| *wanted) else { return Vec::new() };
        // Gaps are closed along the border, a closed one from its first wanted tip all around.
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
        if self.closed && wanted.iter().all(|wanted| *wanted) {
            let tips = around.iter().chain([&first]).map(|index| self.tips[*index]).collect();
            return vec![Run::along_border(tips)];
        }
        let start = if self.closed { around.iter().position(|index| !wanted[*index]).unwrap_or(0) } else { 0 };
        let turned: Vec<usize> = around[start..].iter().chain(&around[..start]).copied().collect();
        let stretches = turned.split(|index| !wanted[*index]).filter(|stretch| stretch.len() > 1);
        stretches.map(|stretch| Run::along_border(stretch.iter().map(|index| self.tips[*index]).collect())).collect()
    }
}
