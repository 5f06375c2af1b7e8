//! The connected pieces of a mesh, found by union-find, and whether each is a closed solid.

use super::{Mesh, cross, dot};

/// The piece to which each facet belongs. Facets that share a point are connected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pieces {
    of_facet: Vec<u32>,
    sides: Vec<Sides>,
}

/// The sides of a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// It has borders, or facets of both orientations.
    Open,
    /// It is a closed solid whose facets point outwards.
    Outwards,
    /// It is a closed solid whose facets point inwards.
    Inwards,
}

impl Pieces {
    /// The number of each facet's piece, from 0 in the order of the pieces' first facets.
    #[must_use]
    pub fn of_facets(&self) -> &[u32] {
        &self.of_facet
    }

    /// The sides of each piece.
    #[must_use]
    pub fn sides(&self) -> &[Sides] {
        &self.sides
    }

    /// The number of pieces.
    #[must_use]
    pub fn count(&self) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "pieces are numbered in 32 bits")]
        let count = self.sides.len() as u32;
        count
    }
}

/// The number of facets between two checks for cancellation.
const TURN: usize = 4096;

/// The number of a piece that is not assigned yet.
const NONE: u32 = u32::MAX;

impl Mesh {
    /// The connected pieces, found by joining the sets of points that each facet connects: O(n log n), amortised.
    ///
    /// # Panics
    /// Never: the bound on facets keeps point numbers within 32 bits.
    #[must_use]
    pub fn pieces(&self) -> Pieces {
        self.pieces_until(&|| false)
    }

    /// The same as [`Mesh::pieces`]. Once `stop` returns true, it returns early, and the result must be discarded.
    ///
    /// # Panics
    /// Never, as [`Mesh::pieces`].
    #[must_use]
    pub fn pieces_until(&self, stop: &(dyn Fn() -> bool + Sync)) -> Pieces {
        let points = u32::try_from(self.points().len()).expect("points are numbered in 32 bits");
        let mut parent: Vec<u32> = (0..points).collect();
        for some in self.triangles().chunks(TURN).take_while(|_| !stop()) {
            for &[a, b, c] in some {
                let a = join(&mut parent, a, b);
                join(&mut parent, a, c);
            }
        }
        let mut piece_of_root = vec![NONE; parent.len()];
        let mut count = 0;
        let of_facet: Vec<u32> = self
            .triangles()
            .chunks(TURN)
            .take_while(|_| !stop())
            .flatten()
            .map(|triangle| {
                let piece = &mut piece_of_root[root(&mut parent, triangle[0]) as usize];
                if *piece == NONE {
                    *piece = count;
                    count += 1;
                }
                *piece
            })
            .collect();
        let sides = self.sides_until(&of_facet, count, stop);
        Pieces { of_facet, sides }
    }

    /// The sides of each piece. In a closed solid each edge belongs to one facet in each of its directions, so that the sum
    /// of a random number for each edge, negative in one direction, is zero; in an open piece it is not, but with a
    /// probability of 2^-64.
    fn sides_until(&self, of_facet: &[u32], count: u32, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Sides> {
        let bounds = self.bounds();
        let centre = [0, 1, 2].map(|axis| f64::midpoint(bounds.min[axis], bounds.max[axis]));
        let mut sums = vec![(0_u64, 0.0); count as usize];
        let facets = of_facet.chunks(TURN).zip(self.triangles().chunks(TURN)).take_while(|_| !stop());
        for (piece, &triangle) in facets.flat_map(|(pieces, triangles)| pieces.iter().zip(triangles)) {
            let (edges, volume) = &mut sums[*piece as usize];
            let [a, b, c] = triangle;
            *edges = [[a, b], [b, c], [c, a]].into_iter().fold(*edges, |sum, edge| sum.wrapping_add(signed_number(edge)));
            let [a, b, c] = triangle.map(|point| {
                let point = self.points()[point as usize];
                [0, 1, 2].map(|axis| point[axis] - centre[axis])
            });
            *volume += dot(a, cross([0.0; 3], b, c));
        }
        let sides = |(edges, volume): (u64, f64)| match edges {
            0 if volume > 0.0 => Sides::Outwards,
            0 if volume < 0.0 => Sides::Inwards,
            _ => Sides::Open,
        };
        sums.into_iter().map(sides).collect()
    }
}

/// A random number for each edge, the same ones in every run, with the opposite sign in the opposite direction: the
/// mixing function of SplitMix (Steele, Lea and Flood 2014), twice.
fn signed_number([from, to]: [u32; 2]) -> u64 {
    let mixed = |mut bits: u64| {
        bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    };
    let edge = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
    let number = mixed(mixed(edge));
    if from < to { number } else { number.wrapping_neg() }
}

/// The representative of a point's set. Halves the path to it.
fn root(parent: &mut [u32], mut point: u32) -> u32 {
    while parent[point as usize] != point {
        let above = parent[parent[point as usize] as usize];
        parent[point as usize] = above;
        point = above;
    }
    point
}

/// Joins the sets of two points under the smaller representative, which it returns. Linking by index with path halving
/// is O(log n) for each step, amortised.
fn join(parent: &mut [u32], a: u32, b: u32) -> u32 {
    let (a, b) = (root(parent, a), root(parent, b));
    let (low, high) = (a.min(b), a.max(b));
    parent[high as usize] = low;
    low
}
