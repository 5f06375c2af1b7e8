//! The visibility of facets from above, along the tool axis.

use super::occluded::Uncertain;
use super::view::side_seen;
use super::{Mesh, twice_area};
use crate::cancellation::collect_until;
use crate::numerics::vector::length;
use crate::quantity::Angle;

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
