//! Runs along the feet of walls: the border of where the tip stands on what is to be machined, as far as it touches a wall
//! there. Lines that end at a wall leave triangles between their ends, and lines beside a wall a strip, or all of a ledge that is
//! too narrow for the axis to stand over it.

use super::chain::{Chain, points_along};
use super::judged::{Judged, left_standing};
use super::prepared::Prepared;
use super::region::Region;
use super::runs::{Run, RunTip, target_under};
use super::stations::Station;
use super::workpiece::Workpiece;
use crate::milling::Profile;
use crate::path::{Area, Contour, Tip, Touch, borders};
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

/// The largest distance of a ledge from the axis, in radii of the cutter, at which it is finished from beside it. Between the tips that
/// finish two neighbouring narrow steps are then tips that finish neither, over a width of more than one cell of the raster. A ledge over
/// which the axis can stand up to the rest of the radius beyond its edge, or less, counts as narrow.
const FROM_BESIDE: f64 = 0.8;

/// The halvings in the search of the distance of a ledge, for 2 % of the cutter's radius.
const DISTANCE_HALVINGS: u32 = 5;

/// One border, in points at most half a cutter's radius apart.
#[derive(Debug, Clone)]
struct Foot {
    chain: Chain,
    /// For each tip, whether a wall rises beyond it.
    at_wall: Vec<bool>,
}

/// Where the axis stands when the cutter finishes what is at the foot of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AxisPlace {
    /// Over it, or where the contact's normal says.
    Over,
    /// There, or beside a level ledge over which it can stand hardly or not at all: the edge of the flat finishes it.
    Beside,
}

impl AxisPlace {
    /// The target that a tip finishes.
    fn finished(self, workpiece: &Workpiece, prepared: &Prepared, axis: [f64; 2], touch: &Touch, tolerance: f64) -> Option<usize> {
        target_under(workpiece, prepared, axis, touch, tolerance).or_else(|| {
            let target = workpiece.finished_by(touch).filter(|_| self == Self::Beside)?;
            let radius = prepared.profile.outer_radius();
            let nearest = nearest_at(workpiece, axis, touch.height - tolerance, FROM_BESIDE * radius)?;
            let [x, y] = [0, 1].map(|part| nearest[part] - axis[part]);
            let farther = 1.0 + (1.0 - FROM_BESIDE) * radius / x.hypot(y).max(f64::MIN_POSITIVE);
            let over_it = workpiece.drop.drop(&prepared.profile, axis[0] + farther * x, axis[1] + farther * y, None);
            over_it.is_some_and(|over_it| over_it.height > touch.height + tolerance).then_some(target)
        })
    }
}

/// The place of the part at least this high that is the nearest to an axis, up to a distance.
fn nearest_at(workpiece: &Workpiece, [x, y]: [f64; 2], height: f64, distance: f64) -> Option<[f64; 2]> {
    let within = |distance: f64| workpiece.drop.drop(&Profile::torus(distance, 0.0), x, y, None).filter(|touch| touch.height >= height);
    let mut nearest = within(distance)?;
    let [mut near, mut far] = [0.0, distance];
    for _ in 0..DISTANCE_HALVINGS {
        let middle = f64::midpoint(near, far);
        match within(middle) {
            Some(touch) => (nearest, far) = (touch, middle),
            None => near = middle,
        }
    }
    Some([nearest.contact.x, nearest.contact.y])
}

impl Feet {
    /// The feet of all walls beside what a cutter can machine of a region. Once `stop` returns true, the result must be discarded.
    pub(super) fn of(
        workpiece: &Workpiece,
        prepared: &Prepared,
        region: &Region,
        place: AxisPlace,
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
            place.finished(workpiece, prepared, axis, &touch, chord_tolerance).filter(|target| region.includes(*target, axis))?;
            Some(Tip { position: [axis[0], axis[1], touch.height], touch: Some(touch) })
        };
        let curves = borders(&inside, &area, chord_tolerance, stop);
        let foot = |contour: &Contour| Foot::of(workpiece, prepared, contour, place, chord_tolerance);
        Self { curves: curves.iter().map(foot).filter(|foot| foot.at_wall.contains(&true)).collect(), radius }
    }

    /// The runs along feet beside stations that the cutter can reach and a path leaves standing.
    pub(super) fn runs(&self, stations: &[Station], judged: &[Judged], height: f64) -> Vec<Run> {
        let cell = self.radius;
        #[expect(clippy::cast_possible_truncation, reason = "extents over radii are under 2^31")]
        let cell_of = |point: [f64; 2]| point.map(|part| (part / cell).floor() as i32);
        let standing: HashSet<[i32; 2]> = left_standing(stations, judged, height).map(|station| cell_of(station.axis)).collect();
        let is_near = |tip: &RunTip| {
            let [x, y] = cell_of([tip.tip[0], tip.tip[1]]);
            (-1..=1).any(|dx| (-1..=1).any(|dy| standing.contains(&[x + dx, y + dy])))
        };
        self.curves.iter().flat_map(|foot| foot.stretches(&is_near, 4.0 * self.radius)).collect()
    }
}

impl Foot {
    fn of(workpiece: &Workpiece, prepared: &Prepared, contour: &Contour, place: AxisPlace, chord_tolerance: f64) -> Self {
        let mut foot = Self { chain: Chain { tips: Vec::new(), closed: contour.closed }, at_wall: Vec::new() };
        for (tip, along) in points_along(contour, prepared.profile.outer_radius() / 2.0) {
            let axis = [tip[0], tip[1]];
            let touch = workpiece.drop.drop(&prepared.profile, axis[0], axis[1], None);
            let target = touch.and_then(|touch| place.finished(workpiece, prepared, axis, &touch, 2.0 * chord_tolerance));
            let contact = touch.map_or(tip, |touch| touch.contact.into());
            foot.chain.tips.push(RunTip { tip, target, contact });
            foot.at_wall.push(rises_beyond(workpiece, prepared, tip, along, 2.0 * chord_tolerance));
        }
        foot
    }

    /// The stretches at walls that `is_near` accepts, joined over gaps up to `gap` mm along the border.
    fn stretches(&self, is_near: &dyn Fn(&RunTip) -> bool, gap: f64) -> Vec<Run> {
        let wanted = self.chain.tips.iter().zip(&self.at_wall).map(|(tip, at_wall)| *at_wall && is_near(tip));
        self.chain.runs(wanted.collect(), gap, None)
    }
}

/// Whether a wall rises by more than `least` mm beyond a tip of a border, which runs along `along` there, the inside on its left.
fn rises_beyond(workpiece: &Workpiece, prepared: &Prepared, tip: [f64; 3], along: [f64; 2], least: f64) -> bool {
    let length = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
    let distance = BEYOND * prepared.profile.outer_radius();
    let beyond = [tip[0] + distance * along[1] / length, tip[1] - distance * along[0] / length];
    let touch = workpiece.drop.drop(&prepared.profile, beyond[0], beyond[1], None);
    touch.is_some_and(|touch| touch.height > tip[2] + least)
}
