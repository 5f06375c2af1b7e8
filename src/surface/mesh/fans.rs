//! The facets around each point of a mesh.

use super::Mesh;

/// The largest number of facets around a point that are examined if some are beyond a crease. If there are more, this
/// many are taken, evenly spread in the order of the file. This bounds the time for a million facets around one point.
pub(super) const LARGEST_FAN: usize = 64;

/// The facets around each point: those of point p are `facets[starts[p]..starts[p + 1]]`.
pub(super) struct Fans {
    starts: Vec<u32>,
    facets: Vec<u32>,
}

/// The number of facets between two checks for cancellation.
const TURN: usize = 65_536;

impl Fans {
    /// The facets around all points; `None` once `stop` returns true.
    pub(super) fn until(mesh: &Mesh, stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let mut starts = vec![0_u32; mesh.points().len() + 1];
        for some in mesh.triangles().chunks(TURN) {
            if stop() {
                return None;
            }
            for &point in some.iter().flatten() {
                starts[point as usize + 1] += 1;
            }
        }
        for point in 1..starts.len() {
            starts[point] += starts[point - 1];
        }
        let mut next = starts.clone();
        let mut facets = vec![0; 3 * mesh.triangles().len()];
        for (first, some) in (0_u32..).step_by(TURN).zip(mesh.triangles().chunks(TURN)) {
            if stop() {
                return None;
            }
            for (facet, triangle) in (first..).zip(some) {
                for &point in triangle {
                    facets[next[point as usize] as usize] = facet;
                    next[point as usize] += 1;
                }
            }
        }
        Some(Self { starts, facets })
    }

    /// The facets around a point.
    pub(super) fn around(&self, point: usize) -> &[u32] {
        &self.facets[self.starts[point] as usize..self.starts[point + 1] as usize]
    }
}
