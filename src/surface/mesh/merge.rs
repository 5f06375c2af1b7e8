//! The heights of a surface seen from above on a lattice whose spacing doubles as the surface grows, so that memory is
//! bounded for any file.

use crate::numerics::raster::scan;
use crate::numerics::scalar::{ceil, floor};
use crate::surface::Bounds;

/// The largest heights at the nodes (i cell, j cell) for whole numbers i and j; cell is a power of two.
///
/// Every second node of a lattice is a node of the next coarser one. Doubling the spacing therefore gives exactly the
/// heights of a lattice that had this spacing from the start. Node (i, j) is stored at (i mod side, j mod side): no two
/// nodes in a range of `side` share a slot, and the range can grow without moving stored heights.
#[derive(Debug)]
pub(super) struct HeightLattice {
    side: i64,
    exponent: i32,
    /// The reciprocal of the spacing, which is exact for a power of two.
    by_cell: f64,
    /// The largest height at each node; minus infinity where there is no surface.
    heights: Vec<f64>,
    low: [i64; 2],
    high: [i64; 2],
    /// The number of nodes and rows visited since the spacing last doubled.
    visits: u64,
}

/// The number of visits after which the spacing doubles, about a tenth of a second of work. Without this limit, many facets
/// that are each as large as the part would take the product of facets and nodes. The 20 million facets of the largest file take
/// fewer visits if they lie side by side.
const VISITS: u64 = 50_000_000;

impl HeightLattice {
    /// A lattice for at most `limit` facets, two for each square between nodes, with the smallest spacing that covers
    /// `bounds`. Further facets may enlarge the bounds.
    pub(super) fn new(limit: usize, bounds: &Bounds) -> Self {
        let side = (limit / 2).isqrt().max(2);
        #[expect(clippy::cast_precision_loss, reason = "under 2^53")]
        let spacing = (bounds.max[0] - bounds.min[0]).max(bounds.max[1] - bounds.min[1]) / side as f64;
        // Node numbers stay under 2^40, so that their distances stay exact in f64.
        let spacing = spacing.max(bounds.largest_magnitude() * 2.0_f64.powi(-40)).max(f64::MIN_POSITIVE);
        #[expect(clippy::cast_possible_truncation, reason = "logarithms of doubles are within 1100")]
        let exponent = spacing.log2().ceil() as i32;
        let side = i64::try_from(side).expect("a square root of a bound of 1e9");
        let mut lattice = Self::empty(side, exponent);
        lattice.heights = vec![f64::NEG_INFINITY; lattice.nodes()];
        lattice
    }

    /// A lattice without its nodes, which are added when the bounds are known.
    fn empty(side: i64, exponent: i32) -> Self {
        let by_cell = 2.0_f64.powi(-exponent);
        Self { side, exponent, by_cell, heights: Vec::new(), low: [i64::MAX; 2], high: [i64::MIN; 2], visits: 0 }
    }

    /// The spacing, in the unit of the coordinates.
    pub(super) fn cell(&self) -> f64 {
        2.0_f64.powi(self.exponent)
    }

    fn nodes(&self) -> usize {
        usize::try_from(self.side * self.side).expect("half of a bound that is a usize")
    }

    fn place(&self, column: i64, row: i64) -> usize {
        usize::try_from(row.rem_euclid(self.side) * self.side + column.rem_euclid(self.side)).expect("not negative")
    }

    pub(super) fn add(&mut self, corners: [[f64; 3]; 3]) {
        loop {
            let corners = corners.map(|[x, y, z]| [x * self.by_cell, y * self.by_cell, z]);
            let mut bounds = Bounds::NONE;
            for corner in corners {
                bounds.include(corner);
            }
            let (first, last) = ([0, 1].map(|axis| ceil(bounds.min[axis])), [0, 1].map(|axis| floor(bounds.max[axis])));
            if first[0] > last[0] || first[1] > last[1] {
                // The facet covers no node.
                return;
            }
            let low = [0, 1].map(|axis| self.low[axis].min(first[axis]));
            let high = [0, 1].map(|axis| self.high[axis].max(last[axis]));
            if (0..2).any(|axis| high[axis].saturating_sub(low[axis]) >= self.side) {
                self.double();
                continue;
            }
            (self.low, self.high) = (low, high);
            let (heights, side) = (&mut self.heights, self.side);
            let mut visits = (last[1] - first[1]).unsigned_abs();
            scan(corners, first, last, |column, row, z, _| {
                visits += 1;
                let place = usize::try_from(row.rem_euclid(side) * side + column.rem_euclid(side)).expect("not negative");
                heights[place] = heights[place].max(z);
            });
            self.visits += visits;
            if self.visits > VISITS {
                self.double();
            }
            return;
        }
    }

    fn double(&mut self) {
        let mut coarse = Self::empty(self.side, self.exponent + 1);
        coarse.heights = vec![f64::NEG_INFINITY; self.nodes()];
        if self.low[0] <= self.high[0] {
            coarse.low = self.low.map(|i| -((-i).div_euclid(2)));
            coarse.high = self.high.map(|i| i.div_euclid(2));
            for row in coarse.low[1]..=coarse.high[1] {
                for column in coarse.low[0]..=coarse.high[0] {
                    let place = coarse.place(column, row);
                    coarse.heights[place] = self.heights[self.place(2 * column, 2 * row)];
                }
            }
        }
        *self = coarse;
    }

    /// Points and up-facing triangles: two for a square whose four nodes have a height, one for a square with three.
    #[expect(clippy::cast_precision_loss, reason = "node numbers are under 2^41")]
    pub(super) fn finish(self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let cell = self.cell();
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        if self.low[0] > self.high[0] || self.low[1] > self.high[1] {
            return (points, triangles);
        }
        // The indices of the points of the previous row, and of this one.
        let mut below: Vec<Option<u32>> = Vec::new();
        for row in self.low[1]..=self.high[1] {
            let mut here = Vec::with_capacity(below.len());
            for column in self.low[0]..=self.high[0] {
                let z = self.heights[self.place(column, row)];
                here.push((z > f64::NEG_INFINITY).then(|| {
                    points.push([column as f64 * cell, row as f64 * cell, z]);
                    u32::try_from(points.len() - 1).expect("at most half of the bound on facets")
                }));
            }
            for (lower, upper) in below.windows(2).zip(here.windows(2)) {
                match (lower[0], lower[1], upper[1], upper[0]) {
                    (Some(a), Some(b), Some(c), Some(d)) => {
                        let z = |index: u32| points[index as usize][2];
                        // The flatter diagonal does not cut across an edge of the part.
                        if (z(a) - z(c)).abs() <= (z(b) - z(d)).abs() {
                            triangles.extend([[a, b, c], [a, c, d]]);
                        } else {
                            triangles.extend([[a, b, d], [b, c, d]]);
                        }
                    }
                    (None, Some(a), Some(b), Some(c))
                    | (Some(a), None, Some(b), Some(c))
                    | (Some(a), Some(b), None, Some(c))
                    | (Some(a), Some(b), Some(c), None) => triangles.push([a, b, c]),
                    _ => {}
                }
            }
            below = here;
        }
        (points, triangles)
    }
}
