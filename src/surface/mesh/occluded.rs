//! Whether other facets are above a point of a facet, exactly: for facets that are too narrow for a raster.

use super::{Mesh, twice_area};
use crate::numerics::raster::Frame;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The largest number of rows of cells and pairs of facets that are examined, some 0.3 s.
const MOST_EXAMINED: u64 = 50_000_000;

/// The number of them that a thread examines between two checks for cancellation and for this limit, except that it finishes
/// a facet.
const EXAMINED_AT_ONCE: u64 = 65_536;

/// The number of facets that a thread examines at a time.
const FACETS_AT_ONCE: usize = 4096;

/// A facet whose centroid may be below others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Uncertain {
    pub(super) facet: u32,
    pub(super) is_wall: bool,
}

impl Mesh {
    /// For each of these facets, whether another facet is above its centroid by more than `rounding`; `None` if that takes
    /// too much work. `frame` divides the plane, so that only facets near a centroid are compared with it. Once `stop`
    /// returns true, it returns early, and the result must be discarded.
    pub(super) fn are_occluded(
        &self,
        uncertain: &[Uncertain],
        frame: Frame,
        rounding: f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Vec<bool>> {
        if uncertain.is_empty() {
            return Some(Vec::new());
        }
        let cell_of = |point: [f64; 3]| frame.nearest_cell([point[0], point[1]]);
        let mut places: Vec<(usize, usize)> = (0..uncertain.len())
            .map(|place| {
                let (column, row) = cell_of(self.centroid(uncertain[place].facet as usize));
                (frame.index(column, row), place)
            })
            .collect();
        places.sort_unstable();
        let row_starts: Vec<usize> = (0..=frame.rows).map(|row| places.partition_point(|&(cell, _)| cell < frame.index(0, row))).collect();
        let occluded: Vec<AtomicBool> = uncertain.iter().map(|_| AtomicBool::new(false)).collect();
        let compare = |facet: usize| {
            let corners = self.corners(facet);
            let [low, high] = [f64::min, f64::max].map(|pick: fn(f64, f64) -> f64| {
                cell_of([0, 1, 2].map(|axis| corners[1..].iter().fold(corners[0][axis], |end, corner| pick(end, corner[axis]))))
            });
            let mut count = 0;
            for row in low.1..=high.1 {
                let of_row = &places[row_starts[row]..row_starts[row + 1]];
                let start = of_row.partition_point(|&(cell, _)| cell < frame.index(low.0, row));
                for &(_, place) in of_row[start..].iter().take_while(|&&(cell, _)| cell <= frame.index(high.0, row)) {
                    count += 1;
                    let Uncertain { facet: other, is_wall } = uncertain[place];
                    let (other, point) = (other as usize, self.centroid(other as usize));
                    if other != facet && height_at(corners, point, is_wall).is_some_and(|z| z > point[2] + rounding) {
                        occluded[place].store(true, Ordering::Relaxed);
                    }
                }
                count += 1;
            }
            count
        };
        let examined = AtomicU64::new(0);
        let facets = self.triangles().len();
        (0..facets.div_ceil(FACETS_AT_ONCE)).into_par_iter().for_each(|part| {
            let mut count = 0;
            for facet in part * FACETS_AT_ONCE..facets.min((part + 1) * FACETS_AT_ONCE) {
                if count >= EXAMINED_AT_ONCE {
                    examined.fetch_add(std::mem::take(&mut count), Ordering::Relaxed);
                }
                if count == 0 && (stop() || examined.load(Ordering::Relaxed) > MOST_EXAMINED) {
                    return;
                }
                count += compare(facet);
            }
            examined.fetch_add(count, Ordering::Relaxed);
        });
        let is_complete = examined.into_inner() <= MOST_EXAMINED;
        is_complete.then(|| occluded.into_iter().map(AtomicBool::into_inner).collect())
    }
}

/// Points this near to an edge, as a share of the triangle, are inside, so that no facet is between two others; but the
/// wall below the edge of a top is not under the top.
const BORDER: f64 = 1e-9;

/// The height of a triangle at a point inside it, seen from above; `None` outside, and for a triangle that is a wall.
fn height_at([a, b, c]: [[f64; 3]; 3], point: [f64; 3], is_of_wall: bool) -> Option<f64> {
    let whole = twice_area(a, b, c)[2];
    let [u, v] = [twice_area(a, point, c)[2], twice_area(a, b, point)[2]].map(|part| part / whole);
    let border = if is_of_wall { BORDER } else { -BORDER };
    let is_inside = whole != 0.0 && u > border && v > border && u + v < 1.0 - border;
    is_inside.then(|| a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]))
}
