//! Places drawn evenly over the area to machine, on which plans are estimated and judged.

use super::cells::Cells;
use super::workpiece::Workpiece;
use crate::numerics::random::Random;
use crate::numerics::z_order::z_order;
use crate::path::Place;
use rayon::prelude::*;

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
pub(super) fn drawn_from(workpiece: &Workpiece, count: usize, seed: u64, belongs: &dyn Fn(usize) -> bool) -> Vec<DrawnPlace> {
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
    places.into_par_iter().with_min_len(64).filter(|place| workpiece.drop.is_seen(place.point)).collect()
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
