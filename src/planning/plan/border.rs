//! Runs along the feet of walls: the border of where the tip stands on what is to be machined, as far as it touches a wall
//! there. Lines that end at a wall leave triangles between their ends, and lines beside a wall a strip.

use super::chain::{Chain, points_along};
use super::judged::Judged;
use super::prepared::Prepared;
use super::region::Region;
use super::runs::{Run, RunTip, target_under};
use super::stations::Station;
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
    chain: Chain,
    /// For each tip, whether a wall rises beyond it.
    at_wall: Vec<bool>,
}

impl Feet {
    /// The feet of all walls beside what a cutter can machine of a region. Once `stop` returns true, the result must be discarded.
    pub(super) fn of(
        workpiece: &Workpiece,
        prepared: &Prepared,
        region: &Region,
        chord_tolerance: f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Self {
        let radius = prepared.profile.outer_radius();
        let [low, high] = workpiece.bounds;
        let (min, max) = ([low[0] - radius, low[1] - radius], [high[0] + radius, high[1] + radius]);
        let coarsest = ((max[0] - min[0]) * (max[1] - min[1]) / MOST_NODES).sqrt();
        let area = Area { min, max, cell: (radius / CELLS_IN_RADIUS).max(coarsest) };
        let inside = |axis: [f64; 2]| {
            let touch = workpiece.drop.drop(&prepared.profile, axis[0], axis[1], None)?;
            target_under(workpiece, prepared, axis, &touch, chord_tolerance).filter(|target| region.includes(*target, axis))?;
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
        let mut foot = Self { chain: Chain { tips: Vec::new(), closed: contour.closed }, at_wall: Vec::new() };
        for (tip, along) in points_along(contour, prepared.profile.outer_radius() / 2.0) {
            foot.push(workpiece, prepared, tip, along, chord_tolerance);
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
        self.chain.tips.push(RunTip { tip, target, contact });
        self.at_wall.push(rises);
    }

    /// The stretches at walls that `is_near` accepts, joined over gaps up to `gap` mm along the border.
    fn stretches(&self, is_near: &dyn Fn(&RunTip) -> bool, gap: f64) -> Vec<Run> {
        let wanted = self.chain.tips.iter().zip(&self.at_wall).map(|(tip, at_wall)| *at_wall && is_near(tip));
        self.chain.runs(wanted.collect(), gap, None)
    }
}
