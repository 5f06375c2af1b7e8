//! Places drawn evenly over the area to machine, on which plans are estimated and judged.

use super::workpiece::Workpiece;
use rayon::prelude::*;

/// A place of the surface to machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// The position of its facet among the targets.
    pub(super) target: usize,
    pub(super) point: [f64; 3],
    /// The area that it represents, in mm^2.
    pub(super) area: f64,
}

/// A facet higher than this over a place, in mm, hides it.
const HIDDEN: f64 = 1e-3;

/// About `count` places of the targets that are seen from above: the area is divided into equal parts along a curve that fills the plane, and in each
/// a random place is drawn. Evenly spaced, the places of a regular grid would lie on a few lines.
#[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
pub(super) fn drawn(workpiece: &Workpiece, count: usize, seed: u64) -> Vec<Place> {
    let order = along_curve(workpiece);
    let whole: f64 = workpiece.targets.iter().map(|target| target.area).sum();
    let share = whole / count as f64;
    let mut random = Random(seed);
    let mut places = Vec::with_capacity(count);
    let mut passed = 0.0;
    let mut due = random.next() * share;
    for target in order {
        passed += workpiece.targets[target].area;
        while passed >= due && places.len() < count {
            places.push(Place { target, point: random.within(workpiece.targets[target].corners), area: share });
            due = (places.len() as f64 + random.next()) * share;
        }
    }
    // Of a large facet that is partly hidden, its visible part is machined.
    let is_seen = |place: &Place| {
        let [x, y, z] = place.point;
        workpiece.facet_under([x, y]).is_none_or(|over| over.height <= z + HIDDEN)
    };
    places.into_par_iter().with_min_len(64).filter(is_seen).collect()
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
        spread_bits(cell(centre(0), 0)) | spread_bits(cell(centre(1), 1)) << 1
    };
    let mut order: Vec<(u32, usize)> = workpiece.targets.iter().map(|target| key(&target.corners)).zip(0..).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, target)| target).collect()
}

/// The 16 lower bits, each followed by a bit of 0.
fn spread_bits(number: u32) -> u32 {
    let mut bits = number & 0xffff;
    bits = (bits | bits << 8) & 0x00ff_00ff;
    bits = (bits | bits << 4) & 0x0f0f_0f0f;
    bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

/// Random numbers from 0 to 1, always the same ones: the 64-bit generator SplitMix (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    #[expect(clippy::cast_precision_loss, reason = "53 bits")]
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A point evenly drawn from a triangle.
    fn within(&mut self, [a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
        let (mut u, mut v) = (self.next(), self.next());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        [0, 1, 2].map(|axis| a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis]))
    }
}
