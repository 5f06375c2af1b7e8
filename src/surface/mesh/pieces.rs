//! The connected pieces of a mesh, found by union-find.

use super::Mesh;

/// The piece to which each facet belongs. Facets that share a point are connected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pieces {
    of_facet: Vec<u32>,
    count: u32,
}

impl Pieces {
    /// The number of each facet's piece, from 0 in the order of the pieces' first facets.
    #[must_use]
    pub fn of_facets(&self) -> &[u32] {
        &self.of_facet
    }

    /// The number of pieces.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
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
        let of_facet = self
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
        Pieces { of_facet, count }
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
