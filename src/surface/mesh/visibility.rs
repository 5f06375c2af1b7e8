//! The visibility of facets from above, along the tool axis: on a raster with the highest facet at each cell centre, and
//! exactly for facets that are too narrow for it.

use super::{Mesh, WALL, twice_area};
use crate::cancellation::collect_until;
use crate::numerics::raster::{Frame, Raster};
use crate::numerics::vector::{dot, length};
use crate::quantity::Angle;
use crate::surface::Bounds;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The class of a facet for a cutter from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FacetClass {
    /// It points up, but another part of the surface is above it.
    Hidden,
    /// It points down, and its back is not visible from above.
    Overhanging,
    /// It is visible, but steeper than the limit. A wall, within 0.006 deg of vertical, is also steep.
    Steep {
        /// Whether it is a wall.
        wall: bool,
    },
    /// It is visible, at least in part, and not too steep. What is machined of it is its visible part.
    Machined,
}

/// Shares of the area of a mesh; they add up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaShares {
    /// [`FacetClass::Hidden`], and the hidden parts of visible facets.
    pub hidden: f64,
    /// [`FacetClass::Overhanging`]
    pub overhanging: f64,
    /// [`FacetClass::Steep`], walls included.
    pub steep: f64,
    /// [`FacetClass::Machined`]
    pub machined: f64,
}

/// The class of each facet.
#[derive(Debug, Clone)]
pub struct Visibility {
    classes: Vec<FacetClass>,
    /// For each facet, whether its back is seen from above.
    from_behind: Vec<bool>,
    /// For each facet, the visible share of its area.
    visible_shares: Vec<f32>,
    shares: AreaShares,
    area: f64,
    area_with_side: f64,
    area_from_behind: f64,
    cell: f64,
}

impl Visibility {
    /// The class of each facet.
    #[must_use]
    pub fn classes(&self) -> &[FacetClass] {
        &self.classes
    }

    /// Whether the back of a facet is seen from above: its orientation in the file is wrong. It counts as turned.
    #[must_use]
    pub fn is_seen_from_behind(&self, facet: usize) -> bool {
        self.from_behind[facet]
    }

    /// The visible share of a facet's area, as far as the raster shows it.
    #[must_use]
    pub fn visible_share(&self, facet: usize) -> f64 {
        f64::from(self.visible_shares[facet])
    }

    /// Shares of the whole area.
    #[must_use]
    pub fn shares(&self) -> AreaShares {
        self.shares
    }

    /// The area of the whole mesh, in mm^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The area of the facets seen from behind over that of all visible facets that are not walls.
    #[must_use]
    pub fn share_from_behind(&self) -> f64 {
        if self.area_with_side > 0.0 { self.area_from_behind / self.area_with_side } else { 0.0 }
    }

    /// The side of the cells of the depth raster, in mm.
    #[must_use]
    pub fn cell(&self) -> f64 {
        self.cell
    }
}

/// The visible or the hidden part of a facet is not told from the raster's roughness if it has fewer centres of cells than this, and
/// less than this share of its area.
const FEW: u32 = 4;
const LITTLE: f32 = 0.02;

/// A facet on the raster.
#[derive(Debug, Clone, Copy)]
struct Examined {
    /// The side that shows upwards; `None` for a wall.
    side: Option<bool>,
    visible_share: f32,
    steep: bool,
    /// Whether it covers no centre of a cell.
    is_between_centres: bool,
    area: f64,
}

impl Examined {
    fn class(self) -> FacetClass {
        match (self.side, self.is_visible()) {
            (Some(false), false) => FacetClass::Overhanging,
            (_, false) => FacetClass::Hidden,
            (None, true) => FacetClass::Steep { wall: true },
            (Some(_), true) if self.steep => FacetClass::Steep { wall: false },
            (Some(_), true) => FacetClass::Machined,
        }
    }

    fn is_visible(self) -> bool {
        self.visible_share > 0.0
    }

    fn is_seen_from_behind(self) -> bool {
        self.is_visible() && self.side == Some(false)
    }
}

impl Mesh {
    /// The class of each facet; facets with a slope over `max_slope` are steep.
    ///
    /// Visibility is determined on a raster with about 8 cells for each facet, from 256 x 256 to 1024 x 1024 over the
    /// longer side of the bounds ([`Mesh::seen_from_above`]; its cell size is [`Visibility::cell`]). Of a facet that
    /// points up the visible share is that of the cell centres that it covers at which no other facet is above it; with
    /// fewer than 4 of them and under 2 % it is hidden. A wall, or a facet that covers no centre, is visible if its centroid
    /// is not below everything seen in its cell and the eight around it, or, as in a narrow slot, if no facet is above its
    /// centroid. A facet that points down and is seen at half of its centres has the wrong orientation and counts as turned;
    /// a closed solid has no such facets.
    ///
    /// Once `stop` returns true, it returns early, and the result must be discarded.
    #[must_use]
    pub fn visibility(&self, max_slope: Angle, stop: &(dyn Fn() -> bool + Sync)) -> Visibility {
        let facets = self.triangles().len();
        let view = self.seen_from_above((8 * facets).isqrt().clamp(256, 1024), stop);
        let frame = view.frame;
        let height = self.bounds().max[2] - self.bounds().min[2];
        // The heights at a common edge, computed from each of its two facets, differ by rounding errors of the
        // coordinates.
        let rounding = 1e-9 * height + 4.0 * f64::EPSILON * self.bounds().largest_magnitude();
        let one = |facet: usize| {
            let corners = self.corners(facet);
            let [a, b, c] = corners;
            let side = side_seen(twice_area(a, b, c));
            let (mut covered, mut shown) = (0_u32, 0_u32);
            if let Some(up) = side {
                frame.scan(corners, 0..frame.rows, |cell, z, on_edge| {
                    covered += 1;
                    let seen = view.facets[cell] as usize == facet;
                    // A cell whose centre is on an edge shows one of the edge's facets; the others are visible too.
                    shown += u32::from(seen || (up && on_edge && z >= view.heights[cell] - rounding));
                });
            }
            let (normal, area) = self.normal_and_area(facet);
            let visible_share = if covered > 0 {
                visible_share(shown, covered, side)
            } else if side == Some(false) {
                0.0
            } else {
                let centroid = self.centroid(facet);
                let (column, row) = frame.nearest_cell([centroid[0], centroid[1]]);
                let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
                let at_the_border = column == 0 || row == 0 || column + 1 == frame.columns || row + 1 == frame.rows;
                let lowest = around(row, frame.rows)
                    .flat_map(|row| around(column, frame.columns).map(move |column| frame.index(column, row)))
                    .fold(f64::INFINITY, |lowest, cell| lowest.min(view.heights[cell]));
                f32::from(u8::from(at_the_border || centroid[2] >= lowest - rounding))
            };
            // tan(S) > tan(max), without a quotient or an arc tangent for each facet.
            let horizontal = length([normal[0], normal[1]]);
            let steep = horizontal * max_slope.cos() > normal[2].abs() * max_slope.sin();
            Examined { side, visible_share, steep, is_between_centres: covered == 0, area }
        };
        let mut examined: Vec<Examined> = collect_until(facets, stop, one);
        let is_uncertain = |facet: &Examined| facet.is_between_centres && facet.side != Some(false) && !facet.is_visible();
        let uncertain: Vec<Uncertain> = (0..)
            .zip(&examined)
            .filter(|(_, facet)| is_uncertain(facet))
            .map(|(number, facet)| Uncertain { facet: number, is_wall: facet.side.is_none() })
            .collect();
        if let Some(occluded) = self.are_occluded(&uncertain, frame, rounding, stop) {
            for (Uncertain { facet, .. }, occluded) in uncertain.into_iter().zip(occluded) {
                examined[facet as usize].visible_share = f32::from(u8::from(!occluded));
            }
        }
        let mut shares = AreaShares { hidden: 0.0, overhanging: 0.0, steep: 0.0, machined: 0.0 };
        let (mut area, mut area_with_side, mut area_from_behind) = (0.0, 0.0, 0.0);
        for facet in &examined {
            let (class, visible) = (facet.class(), f64::from(facet.visible_share) * facet.area);
            *match class {
                FacetClass::Overhanging => &mut shares.overhanging,
                _ => &mut shares.hidden,
            } += facet.area - visible;
            match class {
                FacetClass::Steep { .. } => shares.steep += visible,
                FacetClass::Machined => shares.machined += visible,
                FacetClass::Hidden | FacetClass::Overhanging => {}
            }
            area += facet.area;
            area_with_side += if matches!(class, FacetClass::Machined | FacetClass::Steep { wall: false }) { visible } else { 0.0 };
            area_from_behind += if facet.is_seen_from_behind() { visible } else { 0.0 };
        }
        for share in [&mut shares.hidden, &mut shares.overhanging, &mut shares.steep, &mut shares.machined] {
            *share /= area;
        }
        let (classes, from_behind) = examined.iter().map(|facet| (facet.class(), facet.is_seen_from_behind())).unzip();
        let visible_shares = examined.iter().map(|facet| facet.visible_share).collect();
        Visibility { classes, from_behind, visible_shares, shares, area, area_with_side, area_from_behind, cell: frame.cell }
    }
}

/// The visible share of a facet that is shown at some of the cell centres that it covers.
#[expect(clippy::cast_precision_loss, reason = "a share, told to a cell")]
fn visible_share(shown: u32, covered: u32, side: Option<bool>) -> f32 {
    let share = |count: u32| count as f32 / covered as f32;
    let is_negligible = |count: u32| count < FEW && share(count) < LITTLE;
    if side == Some(false) {
        // It is turned as a whole or not at all.
        f32::from(u8::from(2 * shown >= covered))
    } else if is_negligible(shown) {
        0.0
    } else if is_negligible(covered - shown) {
        1.0
    } else {
        share(shown)
    }
}

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
fn side_seen(normal: [f64; 3]) -> Option<bool> {
    let z = normal[2];
    (z * z > WALL * WALL * dot(normal, normal)).then_some(z > 0.0)
}
