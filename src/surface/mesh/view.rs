//! A mesh seen from above, on a raster: the highest facet at each cell centre, and its height.

use super::{Mesh, WALL, twice_area};
use crate::numerics::raster::{Frame, Raster};
use crate::numerics::vector::dot;
use crate::surface::Bounds;
use rayon::prelude::*;

/// The facet number of a cell without surface.
pub const NO_FACET: u32 = u32::MAX;

/// The heights and facets seen from above at the centres of cells.
#[derive(Debug, Clone)]
pub struct ViewFromAbove {
    /// Position and size of the raster.
    pub frame: Frame,
    /// The largest height of the mesh at the cell's centre, in mm; minus infinity where there is no surface.
    pub heights: Vec<f64>,
    /// The number of the facet that has this height, or [`NO_FACET`].
    pub facets: Vec<u32>,
}

/// The largest number of rows and cells that rasterisation may visit, about 0.2 s. If many facets each cover the whole
/// part, the cells become larger.
const VISITS: f64 = 5e7;

/// The number of facets and cells between two checks for cancellation.
const TURN: usize = 16_384;

impl ViewFromAbove {
    /// The number of the facet seen in a cell; `None` if there is no surface.
    #[must_use]
    pub fn facet(&self, cell: usize) -> Option<usize> {
        Some(self.facets[cell]).filter(|&facet| facet != NO_FACET).map(|facet| facet as usize)
    }

    /// The middle of a cell on the surface that is seen there.
    #[must_use]
    pub fn middle(&self, cell: usize) -> [f64; 3] {
        let Frame { columns, cell: side, origin, .. } = self.frame;
        #[expect(clippy::cast_precision_loss, reason = "at most 4096")]
        let [x, y] = [cell % columns, cell / columns].map(|index| (index as f64 + 0.5) * side);
        [origin[0] + x, origin[1] + y, self.heights[cell]]
    }

    /// A raster of a value of the facet seen in each cell; `None` if there is no surface.
    pub fn of_facets<T: Clone>(&self, figure: impl Fn(usize) -> T) -> Raster<Option<T>> {
        let values = (0..self.facets.len()).map(|cell| self.facet(cell).map(&figure)).collect();
        Raster { frame: self.frame, values }
    }
}

impl Mesh {
    /// The mesh seen from above on at most `side` x `side` square cells, `side` from 1 to 4096; a number outside these
    /// bounds is set to the nearer bound.
    ///
    /// The longer side of the bounds is divided into `side` cells, or fewer if the cells covered by all facets together
    /// would exceed 5e7. Heights are exact at cell centres. Of facets with the same height, one that points up is seen,
    /// otherwise the first. Walls are not seen.
    ///
    /// Once `stop` returns true, it returns early, and the result must be discarded.
    ///
    /// # Panics
    /// Never: the bound on facets keeps their numbers within 32 bits.
    #[must_use]
    pub fn seen_from_above(&self, side: usize, stop: &(dyn Fn() -> bool + Sync)) -> ViewFromAbove {
        let frame = self.frame(side.clamp(1, 4096));
        let mut heights = vec![f64::NEG_INFINITY; frame.cells()];
        let mut facets = vec![NO_FACET; frame.cells()];
        // The rows are divided into bands. One thread fills each band from all facets.
        let rows = frame.rows.div_ceil(rayon::current_num_threads().min(8)).max(1);
        let band = rows * frame.columns;
        heights.par_chunks_mut(band).zip(facets.par_chunks_mut(band)).enumerate().for_each(|(number, (heights, facets))| {
            let (first, last) = (number * rows, ((number + 1) * rows).min(frame.rows));
            let (mut pointing_up, from) = (vec![false; heights.len()], first * frame.columns);
            let mut visited = 0;
            for facet in 0..self.triangles().len() {
                let [a, b, c] = self.corners(facet);
                let Some(up) = side_seen(twice_area(a, b, c)) else { continue };
                visited += 1;
                if visited >= TURN {
                    visited = 0;
                    if stop() {
                        return;
                    }
                }
                frame.scan([a, b, c], first..last, |cell, z, _| {
                    visited += 1;
                    let cell = cell - from;
                    if z > heights[cell] || (z >= heights[cell] && up && !pointing_up[cell]) {
                        heights[cell] = z;
                        facets[cell] = u32::try_from(facet).expect("the bound on facets is below 2^32");
                        pointing_up[cell] = up;
                    }
                });
            }
        });
        ViewFromAbove { frame, heights, facets }
    }

    /// Square cells over the bounds: `side` along the longer side, fewer if facets cover more cells than may be
    /// visited.
    fn frame(&self, side: usize) -> Frame {
        let Bounds { min, max } = self.bounds();
        let (min, max) = ([min[0], min[1]], [max[0], max[1]]);
        let (area, extent) = self.triangles().iter().fold((0.0, 0.0), |(area, extent), triangle| {
            let [a, b, c] = triangle.map(|index| self.points()[index as usize]);
            (area + 0.5 * twice_area(a, b, c)[2].abs(), extent + a[1].max(b[1]).max(c[1]) - a[1].min(b[1]).min(c[1]))
        });
        let affordable = Frame::affordable_cell(area, extent, VISITS);
        #[expect(clippy::cast_precision_loss, reason = "at most 4096")]
        let stated = (max[0] - min[0]).max(max[1] - min[1]) / side as f64;
        // A mesh of walls above one point has no extent, and any cell size is suitable. An extent as small as a
        // rounding error needs larger cells.
        let magnitude = self.bounds().largest_magnitude();
        let cell = stated.max(affordable).max(magnitude * f64::EPSILON).max(1e-300);
        // The ceiling of a rounded quotient can be side + 1.
        let frame = Frame::covering(min, max, cell);
        Frame { columns: frame.columns.min(side), rows: frame.rows.min(side), ..frame }
    }
}

/// Whether a facet with this normal points up (true) or down (false); `None` for a wall.
pub(super) fn side_seen(normal: [f64; 3]) -> Option<bool> {
    let z = normal[2];
    (z * z > WALL * WALL * dot(normal, normal)).then_some(z > 0.0)
}
