//! Sums over facets, in blocks of several facets at a time. Facets that point up, are walls or point down have separate
//! sums.
//!
//! Blocks are summed with AVX2 if the processor has it; this is detected at run time. The operations and their order
//! are the same without it, and no product is fused with a sum, so that the sums are bitwise equal on every processor.

#![allow(clippy::inline_always, reason = "a call among these operations keeps the compiler from making vector instructions of them")]

use super::lanes::{LANES, Lanes};
use super::piece::Piece;
use super::slope::slope;
use multiversion::multiversion;

/// The sides of facets: pointing up, vertical (a level normal), and pointing down.
pub(super) const UP: usize = 0;
pub(super) const LEVEL: usize = 1;
pub(super) const DOWN: usize = 2;

/// The side of a facet without an area.
const NOWHERE: usize = 3;

/// A facet is a wall if |n_z| of its unit normal is at most this: within 0.006 deg of vertical. Single precision rounds
/// corners by 6e-8 of their coordinates, which turns the normal of a 1 mm facet half a metre from the origin by 3e-5.
const WALL: f64 = 1e-4;

/// The number of facets in a block: 4.6 kB of corners, which fit the first-level cache.
const SIZE: usize = 64;

/// Corner, axis, facet.
type Corners = [[[f64; SIZE]; 3]; 3];

/// Facets that have not been summed yet.
#[derive(Debug, Clone)]
pub(super) struct Block {
    corners: Corners,
    count: usize,
}

/// The sums over facets by their side, and the number of facets without area.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facets {
    pub(super) pieces: [Piece; 3],
    pub(super) degenerate: u64,
}

impl Facets {
    pub(super) fn count(&self) -> u64 {
        self.pieces.iter().map(|piece| piece.count).sum()
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.degenerate += other.degenerate;
        self.pieces.iter_mut().zip(&other.pieces).for_each(|(own, others)| own.merge(others));
    }
}

/// Area, slope and side of the facets of a block.
struct Facing {
    area: [f64; SIZE],
    slope: [f64; SIZE],
    /// [`UP`], [`LEVEL`], [`DOWN`] or [`NOWHERE`].
    side: [usize; SIZE],
}

impl Block {
    pub(super) fn empty() -> Self {
        Self { corners: [[[0.0; SIZE]; 3]; 3], count: 0 }
    }

    /// Adds a facet, and returns whether the block is full; then it must be summed.
    #[inline]
    pub(super) fn push(&mut self, corners: [[f64; 3]; 3]) -> bool {
        for (places, corner) in self.corners.iter_mut().zip(corners) {
            for (place, coordinate) in places.iter_mut().zip(corner) {
                place[self.count] = coordinate;
            }
        }
        self.count += 1;
        self.count == SIZE
    }

    /// Adds the facets to the sums and empties the block.
    pub(super) fn sum(&mut self, facets: &mut Facets) {
        let facing = facing(&self.corners);
        let sides = &facing.side[..self.count];
        facets.degenerate += count_of(sides, NOWHERE);
        for (side, piece) in facets.pieces.iter_mut().enumerate() {
            match count_of(sides, side) {
                0 => {}
                // The common case: all facets of the block have one side.
                all if all == SIZE as u64 => add(piece, &self.corners, &facing.area, &facing.slope, all),
                some => {
                    let (corners, area, slope) = self.those_of(side, &facing);
                    add(piece, &corners, &area, &slope, some);
                }
            }
        }
        self.count = 0;
    }

    /// The facets of one side, which must not be empty. The rest of the block is filled with facets without area: all
    /// their corners are the first corner.
    fn those_of(&self, side: usize, facing: &Facing) -> (Corners, [f64; SIZE], [f64; SIZE]) {
        let mut chosen = (0..self.count).filter(|at| facing.side[*at] == side).collect::<Vec<_>>();
        let count = chosen.len();
        chosen.resize(SIZE, chosen[0]);
        let corners = std::array::from_fn(|corner| {
            std::array::from_fn(|axis| std::array::from_fn(|to| self.corners[if to < count { corner } else { 0 }][axis][chosen[to]]))
        });
        let of = |values: &[f64; SIZE]| std::array::from_fn(|to| if to < count { values[chosen[to]] } else { 0.0 });
        (corners, of(&facing.area), of(&facing.slope))
    }
}

fn count_of(sides: &[usize], side: usize) -> u64 {
    sides.iter().map(|other| u64::from(*other == side)).sum()
}

/// Area, slope and side of every facet.
#[inline(always)]
fn facing_anywhere(corners: &Corners) -> Facing {
    let mut facing = Facing { area: [0.0; SIZE], slope: [0.0; SIZE], side: [NOWHERE; SIZE] };
    for at in (0..SIZE).step_by(LANES) {
        let [a, b, c] = corners_from(corners, at);
        let (u, v) = (minus(b, a), minus(c, a));
        // A vector along the normal, with twice the facet's area as its length.
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let level = normal[0] * normal[0] + normal[1] * normal[1];
        let doubled = (level + normal[2] * normal[2]).sqrt();
        let area = doubled * Lanes::all(0.5);
        let slope = slope(level.sqrt(), normal[2].abs());
        facing.area[at..at + LANES].copy_from_slice(&area.0);
        facing.slope[at..at + LANES].copy_from_slice(&slope.0);
        for lane in 0..LANES {
            let (z, limit) = (normal[2].0[lane], WALL * doubled.0[lane]);
            // NaN does not equal 0, so a facet with NaN gets a side, and the sums become NaN.
            let side = LEVEL + usize::from(z < -limit) - usize::from(z > limit);
            facing.side[at + lane] = if doubled.0[lane] == 0.0 { NOWHERE } else { side };
        }
    }
    facing
}

/// [`facing_anywhere`] with the instructions that the processor has.
#[multiversion(targets("x86_64+avx+avx2"))]
#[inline(never)] // Inlined, it would leave the caller too few registers.
fn facing(corners: &Corners) -> Facing {
    facing_anywhere(corners)
}

/// Adds a full block to a piece: see [`Moments::add_triangle`](super::Moments::add_triangle) for the formula.
#[inline(always)]
fn add_anywhere(piece: &mut Piece, corners: &Corners, area: &[f64; SIZE], slope: &[f64; SIZE], count: u64) {
    let nothing = Lanes::all(0.0);
    let shift = piece.moments.shift().map(Lanes::all);
    let (mut weight, mut first, mut second, mut slope_by_weight) = (nothing, [nothing; 3], [nothing; 6], nothing);
    let (mut min, mut max) = ([Lanes::all(f64::INFINITY); 3], [Lanes::all(f64::NEG_INFINITY); 3]);
    for at in (0..SIZE).step_by(LANES) {
        let [a, b, c] = corners_from(corners, at);
        let (f, slope) = (lanes_from(area, at), lanes_from(slope, at));
        let (u, v) = (minus(b, a), minus(c, a));
        let (s, d) = (plus(u, v), minus(u, v));
        let g = plus(minus(a, shift), times(s, Lanes::all(1.0 / 3.0)));
        let (by_f, s_part, d_part) = (times(g, f), times(s, f * Lanes::all(1.0 / 72.0)), times(d, f * Lanes::all(1.0 / 24.0)));
        weight = weight + f;
        slope_by_weight = slope_by_weight + f * slope;
        for (entry, (i, j)) in second.iter_mut().zip([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]) {
            *entry = *entry + (by_f[i] * g[j] + s_part[i] * s[j] + d_part[i] * d[j]);
        }
        for axis in 0..3 {
            first[axis] = first[axis] + by_f[axis];
            min[axis] = min[axis].lesser(a[axis].lesser(b[axis]).lesser(c[axis]));
            max[axis] = max[axis].greater(a[axis].greater(b[axis]).greater(c[axis]));
        }
    }
    piece.count += count;
    piece.area += weight.sum();
    piece.slope_by_weight += slope_by_weight.sum();
    piece.moments.add_sums(weight.sum(), first.map(Lanes::sum), second.map(Lanes::sum));
    for lane in 0..LANES {
        piece.bounds.include(min.map(|min| min.0[lane]));
        piece.bounds.include(max.map(|max| max.0[lane]));
    }
}

/// [`add_anywhere`] with the instructions that the processor has.
#[multiversion(targets("x86_64+avx+avx2"))]
#[inline(never)] // As above.
fn add(piece: &mut Piece, corners: &Corners, area: &[f64; SIZE], slope: &[f64; SIZE], count: u64) {
    add_anywhere(piece, corners, area, slope, count);
}

#[inline(always)]
fn lanes_from(values: &[f64; SIZE], at: usize) -> Lanes {
    Lanes(std::array::from_fn(|lane| values[at + lane]))
}

#[inline(always)]
fn corners_from(corners: &Corners, at: usize) -> [[Lanes; 3]; 3] {
    // The library's `map` over arrays is not inlined here.
    let corner = |[x, y, z]: &[[f64; SIZE]; 3]| [lanes_from(x, at), lanes_from(y, at), lanes_from(z, at)];
    [corner(&corners[0]), corner(&corners[1]), corner(&corners[2])]
}

#[inline(always)]
fn plus(a: [Lanes; 3], b: [Lanes; 3]) -> [Lanes; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn minus(a: [Lanes; 3], b: [Lanes; 3]) -> [Lanes; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn times(a: [Lanes; 3], factor: Lanes) -> [Lanes; 3] {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // a facet without an area has the same corner thrice
mod tests {
    use super::*;
    use crate::surface::{Bounds, Moments};
    use approx::assert_relative_eq;
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::*;

    type Facet = [[f64; 3]; 3];

    fn summed(facets: &[Facet]) -> Facets {
        let mut sums = Facets { pieces: [Piece::about(facets[0][0]); 3], degenerate: 0 };
        let mut block = Block::empty();
        for facet in facets {
            if block.push(*facet) {
                block.sum(&mut sums);
            }
        }
        block.sum(&mut sums);
        sums
    }

    /// The sums facet by facet, with nalgebra, the standard library's arc tangent and [`Moments::add_triangle`].
    fn one_by_one(facets: &[Facet], wanted: usize) -> Piece {
        let mut piece = Piece::about(facets[0][0]);
        for facet in facets {
            let [a, b, c] = facet.map(Vector3::from);
            let normal = (b - a).cross(&(c - a)) / 2.0;
            let area = normal.norm();
            let side = if normal.z > WALL * area {
                UP
            } else if normal.z < -WALL * area {
                DOWN
            } else {
                LEVEL
            };
            if area > 0.0 && side == wanted {
                piece.count += 1;
                piece.moments.add_triangle(*facet, area);
                piece.area += area;
                piece.slope_by_weight += area * normal.xy().norm().atan2(normal.z.abs());
                for corner in facet {
                    piece.bounds.include(*corner);
                }
            }
        }
        piece
    }

    fn moments_of(moments: &Moments) -> (Vector3<f64>, Matrix3<f64>) {
        (Vector3::from(moments.centroid().unwrap()), moments.covariance().unwrap())
    }

    fn assert_same(block: &Piece, single: &Piece) {
        assert_eq!((block.count, block.bounds), (single.count, single.bounds));
        if single.count == 0 {
            assert_eq!(block.bounds, Bounds::NONE);
            return;
        }
        // Areas of 300 mm^2 are within 1e-13 of exact if corners are 1e-14 mm off, in sums of up to 200; so are moments
        // of 1e4 mm^2.
        assert_relative_eq!(block.area, single.area, max_relative = 1e-11);
        assert_relative_eq!(block.slope_by_weight, single.slope_by_weight, max_relative = 1e-11, epsilon = 1e-11);
        let ((mean, covariance), (other_mean, other_covariance)) = (moments_of(&block.moments), moments_of(&single.moments));
        assert_relative_eq!(mean, other_mean, epsilon = 1e-9);
        assert_relative_eq!(covariance, other_covariance, epsilon = 1e-8);
    }

    fn facets() -> impl Strategy<Value = Vec<Facet>> {
        let corner = || prop::array::uniform3(-20.0..20.0_f64);
        let facet = prop_oneof![
            8 => prop::array::uniform3(corner()).boxed(),
            // A wall, and one without an area.
            1 => corner().prop_map(|[x, y, z]| [[x, y, z], [x + 1.0, y + 2.0, z], [x, y, z + 3.0]]).boxed(),
            1 => corner().prop_map(|corner| [corner; 3]).boxed(),
        ];
        // Slivers have no area to compare.
        let area = |[a, b, c]: &Facet| (Vector3::from(*b) - Vector3::from(*a)).cross(&(Vector3::from(*c) - Vector3::from(*a))).norm();
        let whole = move |facet: &Facet| facet[0] == facet[1] || area(facet) > 1.0;
        prop::collection::vec(facet.prop_filter("a sliver", whole), 1..200)
    }

    proptest! {
        #[test]
        fn blocks_agree_with_facets_one_by_one(facets in facets()) {
            let sums = summed(&facets);
            for side in [UP, LEVEL, DOWN] {
                assert_same(&sums.pieces[side], &one_by_one(&facets, side));
            }
            prop_assert_eq!(sums.degenerate, facets.iter().filter(|facet| facet[0] == facet[1]).count() as u64);
        }

        #[test]
        fn sums_are_the_same_to_the_bit_without_wide_instructions(facets in prop::collection::vec(prop::array::uniform3(prop::array::uniform3(-20.0..20.0_f64)), SIZE)) {
            let mut block = Block::empty();
            for facet in &facets {
                block.push(*facet);
            }
            let (wide, plain) = (facing(&block.corners), facing_anywhere(&block.corners));
            prop_assert_eq!((wide.area, wide.slope, wide.side), (plain.area, plain.slope, plain.side));
            let (mut wide_sums, mut plain_sums) = (Piece::about(facets[0][0]), Piece::about(facets[0][0]));
            add(&mut wide_sums, &block.corners, &wide.area, &wide.slope, SIZE as u64);
            add_anywhere(&mut plain_sums, &block.corners, &plain.area, &plain.slope, SIZE as u64);
            // Doubles are shown with all their digits.
            prop_assert_eq!(format!("{wide_sums:?}"), format!("{plain_sums:?}"));
        }

        #[test]
        fn a_full_block_of_one_side_is_summed_like_any_other(heights in prop::collection::vec(-1.0..1.0_f64, SIZE)) {
            let facets: Vec<Facet> = heights.iter().map(|z| [[0.0; 3], [3.0, 0.0, *z], [0.0, 2.0, -z]]).collect();
            assert_same(&summed(&facets).pieces[UP], &one_by_one(&facets, UP));
        }
    }

    #[test]
    fn a_facet_with_nan_makes_the_sums_nan() {
        let sums = summed(&[[[0.0; 3], [1.0, 0.0, 0.0], [0.0, f64::NAN, 0.0]]]);
        assert!(sums.pieces.iter().any(|piece| piece.area.is_nan()));
    }
}
