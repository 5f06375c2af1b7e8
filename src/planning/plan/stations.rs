//! Places drawn evenly over the area to machine, for each the tip at which a cutter finishes it, and whether the cutter can
//! stand there; and which of them an operation machines: by slope, by what another operation has left, or by what another
//! cutter cannot reach.

use super::workpiece::Workpiece;
use crate::milling::Profile;
use crate::numerics::random::Random;
use crate::numerics::raster::z_order;
use crate::path::{Place, Standing};
use rayon::prelude::*;
use std::collections::HashSet;

/// The places on which times are estimated.
pub(super) const ESTIMATED_ON: usize = 4_000;

/// The places on which plans are judged. The standard error of a share of 0.5 % is then 0.05 %.
pub(super) const JUDGED_ON: usize = 20_000;

/// The sets of places on which plans are judged, each drawn anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Set {
    /// Lines are spaced on these. There a plan is better than elsewhere.
    Spaced = 1,
    /// Plans are judged on these. One that fails is spaced on them too, and judged on the last.
    Unseen = 2,
    Last = 3,
    /// Many more places, of which those around high ones are used.
    Dense = 4,
}

impl Set {
    pub(super) fn seed(self) -> u64 {
        self as u64
    }

    /// About how many places it has.
    pub(super) fn count(self) -> usize {
        if self == Self::Dense { 8 * JUDGED_ON } else { JUDGED_ON }
    }
}

/// The most places that a thread takes at once. Where a cutter does not fit, a place takes many times as long as elsewhere, and
/// such places are neighbours: in larger parts one thread would have most of them.
pub(super) const AT_ONCE: usize = 64;

/// A place of the surface to machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct DrawnPlace {
    /// The position of its facet among the targets.
    pub(super) target: usize,
    pub(super) point: [f64; 3],
    /// The area that it represents, in mm^2.
    pub(super) area: f64,
}

impl DrawnPlace {
    pub(super) fn seen_from_above(&self) -> [f64; 2] {
        [self.point[0], self.point[1]]
    }

    /// The place on its facet.
    pub(super) fn on(&self, workpiece: &Workpiece) -> Place {
        Place { point: self.point, normal: workpiece.targets[self.target].normal, facet: workpiece.facet_of(self.target) }
    }
}

/// The places in some cells, or all of them.
pub(super) fn within(places: &[DrawnPlace], cells: Option<&Cells>) -> Vec<DrawnPlace> {
    places.iter().filter(|place| cells.is_none_or(|cells| cells.contain(place.seen_from_above()))).copied().collect()
}

/// About `count` places of the targets that are seen from above: the area is divided into equal parts along a curve that fills the plane, and in each
/// a random place is drawn. Evenly spaced, the places of a regular grid would lie on a few lines.
pub(super) fn drawn(workpiece: &Workpiece, count: usize, seed: u64) -> Vec<DrawnPlace> {
    drawn_from(workpiece, count, seed, &|_| true)
}

/// About `count` places, drawn alike, of the targets that `belongs` accepts.
#[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
fn drawn_from(workpiece: &Workpiece, count: usize, seed: u64, belongs: &dyn Fn(usize) -> bool) -> Vec<DrawnPlace> {
    let order: Vec<usize> = along_curve(workpiece).into_iter().filter(|target| belongs(*target)).collect();
    let whole: f64 = order.iter().map(|target| workpiece.targets[*target].area).sum();
    let share = whole / count as f64;
    let mut random = Random::new(seed);
    let mut places = Vec::with_capacity(count);
    let mut passed = 0.0;
    let mut due = random.unit() * share;
    for target in order {
        passed += workpiece.targets[target].area;
        while passed >= due && places.len() < count {
            places.push(DrawnPlace { target, point: in_triangle(workpiece.targets[target].corners, &mut random), area: share });
            due = (places.len() as f64 + random.unit()) * share;
        }
    }
    // Of a facet that is partly hidden, its visible part is machined.
    places.into_par_iter().with_max_len(AT_ONCE).filter(|place| workpiece.drop.is_seen(place.point)).collect()
}

/// The targets in the order of a curve that fills the plane (Morton's), so that neighbours in the order are neighbours seen
/// from above. It does not depend on the order in the file.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole numbers under 2^16")]
fn along_curve(workpiece: &Workpiece) -> Vec<usize> {
    let [low, high] = workpiece.bounds;
    let side = (high[0] - low[0]).max(high[1] - low[1]).max(f64::MIN_POSITIVE);
    let cell = |value: f64, axis: usize| (f64::from(u16::MAX) * ((value - low[axis]) / side).clamp(0.0, 1.0)) as u32;
    let key = |corners: &[[f64; 3]; 3]| {
        let centre = |axis: usize| (corners[0][axis] + corners[1][axis] + corners[2][axis]) / 3.0;
        z_order([0, 1].map(|axis| cell(centre(axis), axis)))
    };
    let mut order: Vec<(u32, usize)> = workpiece.targets.iter().map(|target| key(&target.corners)).zip(0..).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, target)| target).collect()
}

/// A point evenly drawn from a triangle.
fn in_triangle([a, b, c]: [[f64; 3]; 3], random: &mut Random) -> [f64; 3] {
    let (mut u, mut v) = (random.unit(), random.unit());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    [0, 1, 2].map(|axis| a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis]))
}

/// A place with the tip that finishes it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Station {
    pub(super) place: DrawnPlace,
    /// Where the axis stands, seen from above.
    pub(super) axis: [f64; 2],
    /// The height of the tip that touches the place, in mm.
    pub(super) tip: f64,
    /// The height in mm by which other facets hold the cutter above its contact with the place; 0 where it can touch it.
    pub(super) lift: f64,
}

/// The stations of places for a cutter; `tolerance` is the lift in mm that does not count. Once `stop` returns true, the
/// result must be discarded.
pub(super) fn stations(
    workpiece: &Workpiece,
    profile: &Profile,
    places: &[DrawnPlace],
    tolerance: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<Station> {
    let station = |place: &DrawnPlace| {
        if stop() {
            return None;
        }
        let Standing { axis, tip, lift } = Standing::at(&workpiece.drop, profile, &place.on(workpiece), tolerance);
        Some(Station { place: *place, axis, tip, lift })
    };
    places.par_iter().with_max_len(AT_ONCE).filter_map(station).collect()
}

/// Square cells of the plan view.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    side: f64,
    marked: HashSet<[i64; 2]>,
}

impl Cells {
    /// The cells of points, and those around them.
    pub(super) fn around(points: impl Iterator<Item = [f64; 2]>, side: f64) -> Self {
        let mut cells = Self { side, marked: HashSet::new() };
        for [x, y] in points.map(|point| cells.cell(point)).collect::<HashSet<_>>() {
            cells.marked.extend((-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy])));
        }
        cells
    }

    #[expect(clippy::cast_possible_truncation, reason = "places over sides are under 2^63")]
    fn cell(&self, point: [f64; 2]) -> [i64; 2] {
        point.map(|part| (part / self.side).floor() as i64)
    }

    pub(super) fn contain(&self, point: [f64; 2]) -> bool {
        self.marked.contains(&self.cell(point))
    }
}

/// A part of the surface to machine.
#[derive(Debug, Clone)]
pub(super) struct Region {
    /// For each target whether it belongs to the region; `None` for all.
    targets: Option<Vec<bool>>,
    /// Where the cutter's axis may stand; `None` for everywhere.
    standing: Option<Cells>,
}

impl Region {
    /// Everything that is to be machined.
    pub(super) const WHOLE: Self = Self { targets: None, standing: None };

    /// The targets that `belongs` accepts.
    pub(super) fn of_targets(workpiece: &Workpiece, belongs: impl Fn(usize) -> bool) -> Self {
        Self { targets: Some((0..workpiece.targets.len()).map(belongs).collect()), standing: None }
    }

    /// Where a cutter stands on those of these stations that it reaches, and up to a quarter of its radius around them.
    pub(super) fn of_rest(stations: &[Station], profile: &Profile, height: f64) -> Self {
        let reached = stations.iter().filter(|station| station.lift <= height);
        Self { targets: None, standing: Some(Cells::around(reached.map(|station| station.axis), profile.outer_radius() / 4.0)) }
    }

    /// Whether a tip over a point that finishes a target belongs to the region.
    pub(super) fn includes(&self, target: usize, axis: [f64; 2]) -> bool {
        self.targets.as_ref().is_none_or(|targets| targets[target]) && self.standing.as_ref().is_none_or(|cells| cells.contain(axis))
    }
}

/// The most places that are looked at to find enough that are left.
const MOST_LOOKED_AT: usize = 200_000;

/// The depth in mm to which a cutter that fits the surface cuts beside a place: where it touches a facet at an edge, a cutter of the
/// surface's radius cuts the next facet four times as deep as the facets are off the surface.
pub(super) fn cut_by_fitting(workpiece: &Workpiece, place: &DrawnPlace) -> f64 {
    4.0 * workpiece.sagitta_of(place.target)
}

/// Whether a cutter that stands over a place can touch it where it may cut others by `tolerance`.
pub(super) fn stands_at(workpiece: &Workpiece, profile: &Profile, place: &DrawnPlace, tolerance: f64) -> bool {
    Standing::at(&workpiece.drop, profile, &place.on(workpiece), tolerance).lift <= tolerance
}

/// The places that `profile` cannot reach within `height` mm, and not only because facets are a little off the surface. Once `stop`
/// returns true, the result must be discarded.
pub(super) fn left_by(
    workpiece: &Workpiece,
    profile: &Profile,
    places: &[DrawnPlace],
    height: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<DrawnPlace> {
    let is_left =
        |place: &&DrawnPlace| !stop() && !stands_at(workpiece, profile, place, height + cut_by_fitting(workpiece, place).min(height));
    places.par_iter().with_max_len(AT_ONCE).filter(is_left).copied().collect()
}

/// About `count` places of the targets that `belongs` accepts, of those that `left` leaves, or as many as are found; of these, those
/// in some cells, or all of them.
pub(super) fn drawn_until(
    workpiece: &Workpiece,
    count: usize,
    seed: u64,
    belongs: &dyn Fn(usize) -> bool,
    left: &dyn Fn(Vec<DrawnPlace>) -> Vec<DrawnPlace>,
    cells: Option<&Cells>,
) -> Vec<DrawnPlace> {
    // Whether a place is left takes long to find out: a few tell how many must be looked at.
    let looked_at = match left(drawn_from(workpiece, ESTIMATED_ON, seed, belongs)).len() {
        few @ 1.. if few < ESTIMATED_ON / 2 => (count * ESTIMATED_ON / few).min(MOST_LOOKED_AT),
        _ => count,
    };
    left(within(&drawn_from(workpiece, looked_at, seed, belongs), cells))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_places_far_from_the_origin_are_apart() {
        let cells = Cells::around([[1e6, -1e6]].into_iter(), 1e-6);
        assert!(cells.contain([1e6, -1e6]) && cells.contain([1e6 + 1e-6, -1e6]));
        assert!(!cells.contain([1e6 + 1e-3, -1e6]));
    }
}
