//! The connected pieces of a mesh, found by union-find, and whether each is a closed solid.

use super::{Mesh, twice_area};
use crate::numerics::vector::{dot, length};

/// The piece to which each facet belongs. Facets that share a point are connected.
#[derive(Debug, Clone, PartialEq)]
pub struct Pieces {
    of_facet: Vec<u32>,
    closures: Vec<Closure>,
    missing_areas: Vec<f64>,
}

/// Whether a piece encloses a volume, and where its facets point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Closure {
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

    /// Whether each piece is closed.
    #[must_use]
    pub fn closures(&self) -> &[Closure] {
        &self.closures
    }

    /// The area in mm^2 that each piece lacks on its upper side to be a closed solid, if that is little. A facet that is turned counts
    /// twice, holes on opposite sides count by their difference.
    #[must_use]
    pub fn missing_areas(&self) -> &[f64] {
        &self.missing_areas
    }

    /// The number of pieces.
    #[must_use]
    pub fn count(&self) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "pieces are numbered in 32 bits")]
        let count = self.closures.len() as u32;
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
    /// Once `stop` returns true, it returns early, and the result must be discarded.
    ///
    /// # Panics
    /// Never: the bound on facets keeps point numbers within 32 bits.
    #[must_use]
    pub fn pieces(&self, stop: &(dyn Fn() -> bool + Sync)) -> Pieces {
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
        let sums = self.enclosed_until(&of_facet, count, stop);
        let bounds = self.bounds();
        let extent = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f64::max);
        let closures = sums.iter().map(|sums| sums.closure(extent)).collect();
        Pieces { of_facet, closures, missing_areas: sums.iter().map(Enclosed::missing_area).collect() }
    }

    /// The sums over each piece.
    fn enclosed_until(&self, of_facet: &[u32], count: u32, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Enclosed> {
        let bounds = self.bounds();
        let centre = [0, 1, 2].map(|axis| f64::midpoint(bounds.min[axis], bounds.max[axis]));
        let mut sums = vec![Enclosed::default(); count as usize];
        let facets = of_facet.chunks(TURN).zip(self.triangles().chunks(TURN)).take_while(|_| !stop());
        for (piece, &triangle) in facets.flat_map(|(pieces, triangles)| pieces.iter().zip(triangles)) {
            let [a, b, c] = triangle.map(|point| {
                let point = self.points()[point as usize];
                [0, 1, 2].map(|axis| point[axis] - centre[axis])
            });
            sums[*piece as usize].add(a, twice_area(a, b, c));
        }
        sums
    }

    /// Turns the facets of closed pieces that point inwards. The facets of a cavity are a piece of their own and are turned,
    /// too; no cutter reaches them.
    pub(crate) fn turn_solids_outwards(&mut self, pieces: &Pieces) {
        for (triangle, piece) in self.triangles.iter_mut().zip(&pieces.of_facet) {
            if pieces.closures[*piece as usize] == Closure::Inwards {
                triangle.swap(1, 2);
            }
        }
    }
}

/// Sums over the facets of a piece.
#[derive(Debug, Clone, Copy, Default)]
struct Enclosed {
    /// Of twice the facets' areas, as vectors along their normals; they cancel out on a closed surface.
    vector: [f64; 3],
    /// Of twice the areas.
    area: f64,
    /// Of six times the volumes between facets and the origin.
    volume: f64,
}

/// The share of a closed piece's area that may be missing or turned: single facets, and those without an area, which many
/// files have at edges.
const MISSING: f64 = 1e-3;

/// A piece that lacks more than this share of its area is a skin, whose borders are meant. The skin of a pocket lacks less only if it
/// is five times as deep as it is wide.
const MOST_MISSING: f64 = 0.05;

/// The least mean thickness of a solid, as a share of its extent. A sheet with each facet in both orientations has none.
const THINNEST: f64 = 1e-9;

impl Enclosed {
    /// Adds a facet by a corner, and its area vector times two.
    fn add(&mut self, corner: [f64; 3], vector: [f64; 3]) {
        self.vector = [0, 1, 2].map(|axis| self.vector[axis] + vector[axis]);
        self.area += length(vector);
        self.volume += dot(corner, vector);
    }

    fn closure(&self, extent: f64) -> Closure {
        let is_open = length(self.vector) > MISSING * self.area || self.volume.abs() < THINNEST * self.area * extent;
        match (is_open, self.volume > 0.0) {
            (true, _) => Closure::Open,
            (false, true) => Closure::Outwards,
            (false, false) => Closure::Inwards,
        }
    }

    /// Half of the length of the sum of vectors, which is that of missing facets, if these face up.
    fn missing_area(&self) -> f64 {
        let twice = length(self.vector);
        let is_above = self.vector[2] * self.volume < 0.0;
        if is_above && twice <= MOST_MISSING * self.area { twice / 2.0 } else { 0.0 }
    }
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
