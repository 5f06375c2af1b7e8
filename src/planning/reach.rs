//! The reach of a cutter: the area that it leaves uncut because it does not fit. The surface seen from above is dilated
//! and then eroded with the cutter's profile.
//!
//! Symbols: R and r outer and corner radius, p(d) the height of the cutter's bottom over its tip at distance d from
//! its axis, z(x, y) the surface, h the side of a raster cell, and e = h/sqrt(2), half a cell's diagonal.
//!
//! **Tip and cut.** t(x) = max over |u| <= R of z(x + u) - p(|u|) is the lowest height of the tip at x. The surface
//! that the cutter leaves from all tip positions is m(x) = min over |u| <= R of t(x + u) + p(|u|). The uncut height is
//! m - z >= 0. This also holds on the raster, because every cell within R limits the tip at a cell.
//!
//! **The raster's error.** On a plane it is 0: offsets come in pairs u and -u, so that dilation lifts the plane by as
//! much as erosion lowers it. On a curved surface the tip that touches at a cell may be up to e away from every tip of
//! the raster. In a hollow of radius rho the relative curvature is 1/R - 1/rho. There a tip moved by e along the
//! surface leaves e^2/2 (1/R)^2 / (1/R - 1/rho) = e^2/(2 R lambda), lambda = 1 - R/rho. On a slope S, distances along
//! the surface and heights along the normal each grow by 1/cos S, which makes e^2/(2 R lambda cos^3 S). The error
//! stated uses r, the smallest radius of the cutter's bottom, in place of R, and lambda = 1/3, which covers hollows of
//! at least 1.5 times the cutter's radius. It is at most 2 e tan S + e^2/(2 R lambda), which bounds the rise of the
//! surface between tips for a sharp corner.
//!
//! **Cells that seem uncut.** In a tighter hollow the tips of the raster leave more than that although the cutter fits.
//! If a cell's height exceeds the error, the cutter is therefore also placed in contact with the facet at the cell, and
//! raised until it cuts nowhere. The cell's height is the smaller of this rise and the raster's height. The tip is then
//! exact; only the height at which it rests comes from the raster. On a smooth surface that height is too low by e^2/2
//! times the relative curvature. Near a sharp edge the raster has the edge up to half a cell too far away, so that
//! heights are too small by the change of p over that distance.

mod morphology;
mod resting;

pub use resting::RestingHeights;

use crate::milling::Cutter;
use crate::numerics::raster::{Frame, Raster};
use crate::quantity::Length;
use crate::surface::Mesh;
use crate::surface::mesh::ViewFromAbove;
use morphology::{Coarse, Disc, stride};
use rayon::prelude::*;

/// 1 - R/rho of the tightest hollow for which the stated error holds.
const LEAST_CLEARANCE: f64 = 1.0 / 3.0;

/// The largest number of cells that seem uncut at which the cutter is placed, which takes up to some 0.05 s. If there
/// are more, this many are taken, evenly spread.
const MOST_PLACED: usize = 512;

/// The steps of the search for a normal: 0.618^10 = 0.8 % of the turn between neighbouring cells.
const TURNS: u32 = 10;

/// A surface on a raster, for computing the reach of cutters.
#[derive(Debug, Clone)]
pub struct ReachMap {
    frame: Frame,
    heights: RestingHeights,
    /// For each cell the horizontal part of the unit normal of the machined surface over it.
    normals: Vec<[f32; 2]>,
    /// For each cell the area of the machined surface over it, per area of the cell: 1/cos S, 0 where nothing is
    /// machined.
    area: Vec<f32>,
    /// The largest rounding of a height.
    rounding: f64,
}

/// The material that a cutter leaves on a surface because it does not fit.
#[derive(Debug, Clone)]
pub struct Uncut {
    /// The share of the machined area whose uncut height exceeds the scallop height and the raster's error there: 0 to
    /// 1.
    pub share: f64,
    /// The largest height left on the machined area if it exceeds the raster's error, otherwise 0.
    pub height: Length,
    /// The error of that height near sharp edges: the change of the cutter's profile between the cells on both sides of
    /// its contact, plus the error on smooth surfaces.
    pub height_error: Length,
    /// The raster's error on a level part of the surface; on a slope it is larger.
    pub level_error: Length,
    /// The side of the cells that were used: a multiple of the raster's cell for a cutter that is large compared with
    /// it.
    pub cell: Length,
}

/// The heights that a cutter leaves on the cells that were used.
struct UncutHeights {
    uncut: Uncut,
    /// The number of cells from one used cell to the next.
    stride: usize,
    /// The used cells in a row.
    columns: usize,
    /// The height in each used cell, in mm; NaN if nothing is machined.
    heights: Vec<f32>,
}

/// p(d) for 0 <= d <= R: 0 up to R - r, then the corner's circle; the height of the cutter's bottom over its tip, in
/// mm.
fn profile(cutter: Cutter, d: f64) -> f64 {
    let (r, over) = (cutter.corner_radius().mm(), d - cutter.core_radius().mm());
    if over <= 0.0 {
        return 0.0;
    }
    // r - sqrt(r^2 - over^2) without cancellation. At d = R rounding may leave over a little larger than r.
    let root = (r * r - over * over).max(0.0).sqrt();
    over.min(r) * over.min(r) / (r + root)
}

impl ReachMap {
    /// The surface that `view` shows of `mesh`. `machined` has one entry for each facet of the mesh: whether it is to
    /// be cut. The other facets limit the cutter as well.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "heights in single precision; the rounding is part of the error")]
    pub fn new(mesh: &Mesh, view: &ViewFromAbove, machined: &[bool]) -> Self {
        let bounds = mesh.bounds();
        let normal_of = |cell: usize| match view.facet(cell) {
            Some(facet) if machined[facet] => {
                let ([x, y, z], _) = mesh.normal_and_area(facet);
                // The normal of the visible side. Facets that a view shows are not walls: |n_z| is at least 1e-4.
                ([(x * z.signum()) as f32, (y * z.signum()) as f32], z.abs().recip() as f32)
            }
            _ => ([0.0; 2], 0.0),
        };
        let (normals, area) = (0..view.facets.len()).into_par_iter().with_min_len(4096).map(normal_of).unzip();
        let rounding = (bounds.max[2] - bounds.min[2]) * f64::from(f32::EPSILON);
        Self { frame: view.frame, heights: RestingHeights::new(view), normals, area, rounding }
    }

    /// The material that a cutter leaves where it does not fit. Heights of up to `scallop_height` do not count.
    #[must_use]
    pub fn uncut(&self, cutter: Cutter, scallop_height: Length) -> Uncut {
        self.uncut_until(cutter, scallop_height, &|| false)
    }

    /// The material that a cutter leaves, as [`Self::uncut`]. Once `stop` returns true, it ends early, and the result must be discarded.
    #[must_use]
    pub fn uncut_until(&self, cutter: Cutter, scallop_height: Length, stop: &(dyn Fn() -> bool + Sync)) -> Uncut {
        self.left(cutter, scallop_height, stop).uncut
    }

    /// The largest height in mm that a cutter leaves in each cell of `frame`, whose cells are at least as large as those of
    /// this map; `None` if nothing is machined there. Once `stop` returns true, it ends early, and the result must be
    /// discarded.
    #[must_use]
    pub fn uncut_heights(
        &self,
        cutter: Cutter,
        scallop_height: Length,
        frame: Frame,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Raster<Option<f32>> {
        let UncutHeights { stride, columns, heights, .. } = self.left(cutter, scallop_height, stop);
        let rows = heights.len() / columns;
        let mut largest = Raster::filled(frame, None);
        for cell in (0..self.frame.cells()).filter(|&cell| self.area[cell] > 0.0) {
            let (column, row) = (cell % self.frame.columns, cell / self.frame.columns);
            let height = heights[(row / stride).min(rows - 1) * columns + (column / stride).min(columns - 1)];
            let (column, row) = frame.nearest_cell(self.frame.centre(column, row));
            let of_cell: &mut Option<f32> = &mut largest.values[frame.index(column, row)];
            if !height.is_nan() {
                *of_cell = Some(of_cell.map_or(height, |largest| largest.max(height)));
            }
        }
        largest
    }

    #[expect(clippy::cast_possible_truncation, reason = "single precision; its rounding is part of the error")]
    fn left(&self, cutter: Cutter, scallop_height: Length, stop: &(dyn Fn() -> bool + Sync)) -> UncutHeights {
        let radius = cutter.outer_radius().mm();
        let stride = stride(self.frame, radius);
        let coarse = Coarse::of(self, stride, radius);
        let disc = Disc::new(cutter, coarse.cell, coarse.pad);
        let tips = coarse.tips(&disc);
        let mut left = coarse.cut(&tips, &disc);

        let half_diagonal = coarse.cell * std::f64::consts::FRAC_1_SQRT_2;
        let bend = |r: f64| half_diagonal * half_diagonal / (2.0 * LEAST_CLEARANCE * r);
        let error = |inverse_cosine: f64| {
            let tangent = (inverse_cosine * inverse_cosine - 1.0).max(0.0).sqrt();
            let rise = 2.0 * half_diagonal * tangent + bend(radius);
            (bend(cutter.corner_radius().mm()) * inverse_cosine.powi(3)).min(rise) + self.rounding
        };
        let fine_cell = |cell: usize| self.frame.index(cell % coarse.columns * stride, cell / coarse.columns * stride);
        let (mut machined, mut seeming) = (0.0, 0);
        for (cell, left) in left.iter_mut().enumerate() {
            let fine = fine_cell(cell);
            let area = f64::from(self.area[fine]);
            if area == 0.0 {
                *left = f32::NAN;
                continue;
            }
            machined += area;
            *left = (f64::from(*left) - f64::from(self.heights.cells()[fine])) as f32;
            seeming += usize::from(f64::from(*left) > error(area));
        }
        let (mut over, mut worst) = (0.0, None::<(f64, usize)>);
        let step = seeming.div_ceil(MOST_PLACED).max(1);
        // The cells that seem uncut.
        let seems_uncut = |&cell: &usize| f64::from(left[cell]) > error(f64::from(self.area[fine_cell(cell)]));
        let placed: Vec<usize> = (0..left.len()).filter(seems_uncut).step_by(step).collect();
        let rise = |&cell: &usize| (!stop()).then(|| self.rise(cutter, fine_cell(cell), error(f64::from(self.area[fine_cell(cell)]))));
        let rises: Vec<Option<f64>> = placed.par_iter().with_min_len(4).map(rise).collect();
        for (cell, rise) in placed.into_iter().zip(rises) {
            let Some(rise) = rise else { continue };
            let area = f64::from(self.area[fine_cell(cell)]);
            let height = f64::from(left[cell]).min(rise).max(0.0);
            left[cell] = height as f32;
            if height > error(area) {
                // A cell represents those between it and the next sampled one.
                #[expect(clippy::cast_precision_loss, reason = "the square of a raster's side")]
                let represented = area * step as f64;
                over += if height > scallop_height.mm() + error(area) { represented } else { 0.0 };
                if worst.is_none_or(|(most, _)| height > most) {
                    worst = Some((height, cell));
                }
            }
        }
        let height_error = worst.map_or(error(1.0), |(_, cell)| {
            let d = coarse.rest(cell, &tips, &disc);
            let change = profile(cutter, (d + half_diagonal).min(radius)) - profile(cutter, (d - half_diagonal).max(0.0));
            change + error(1.0)
        });
        let uncut = Uncut {
            // The last sampled cell may represent more cells than there are.
            share: if machined > 0.0 { (over / machined).min(1.0) } else { 0.0 },
            height: Length::computed(worst.map_or(0.0, |(height, _)| height)),
            height_error: Length::computed(height_error),
            level_error: Length::computed(error(1.0)),
            cell: Length::computed(coarse.cell),
        };
        UncutHeights { uncut, stride, columns: coarse.columns, heights: left }
    }

    /// The height in mm by which the cutter must rise from its contact at the middle of a cell until it does not cut
    /// into the surface: the least over the contact's normals that were tried, or the first at most `enough`.
    ///
    /// Every placement that touches the point shows how far the surface can be cut there, whatever the normal is. The
    /// facet's own normal comes first, then the mean of the nine cells around: near the end of a facet that
    /// approximates an arc, the facet's normal differs from the arc's by half the angle to the next facet. A cutter of
    /// nearly the radius of a hollow fits with one normal only: the search turns the mean normal within the normals of
    /// the cells around, about two axes.
    fn rise(&self, cutter: Cutter, cell: usize, enough: f64) -> f64 {
        let (column, row) = (cell % self.frame.columns, cell / self.frame.columns);
        let [x, y] = self.frame.centre(column, row);
        let z = f64::from(self.heights.cells()[cell]) + self.heights.level();
        let rise = |normal: [f64; 3]| {
            let tip = tip_of(cutter, [x, y, z], normal);
            self.heights.raised(cutter, tip) - tip[2]
        };
        let own = self.normal(cell);
        let mut least = rise(own);
        if least <= enough {
            return least;
        }
        let nine: Vec<[f64; 3]> = self.around(cell).map(|cell| self.normal(cell)).collect();
        let mean = unit(nine.iter().fold([0.0; 3], |sum, n| [sum[0] + n[0], sum[1] + n[1], sum[2] + n[2]]));
        least = least.min(rise(mean));
        if least <= enough {
            return least;
        }
        let turn = |n: &[f64; 3]| [n[0] - mean[0], n[1] - mean[1], n[2] - mean[2]];
        let length = |v: [f64; 3]| v[0].hypot(v[1]).hypot(v[2]);
        let Some(widest) = nine.iter().map(turn).max_by(|a, b| length(*a).total_cmp(&length(*b))).filter(|widest| length(*widest) > 0.0)
        else {
            return least;
        };
        let across = [
            mean[1] * widest[2] - mean[2] * widest[1],
            mean[2] * widest[0] - mean[0] * widest[2],
            mean[0] * widest[1] - mean[1] * widest[0],
        ];
        let mut centre = mean;
        for axis in [widest, across] {
            let turned = |share: f64| unit([0, 1, 2].map(|i| centre[i] + share * axis[i]));
            let (share, found) = least_of(|share| rise(turned(share)), enough);
            if found < least {
                (least, centre) = (found, turned(share));
            }
            if least <= enough {
                break;
            }
        }
        least
    }

    /// The unit normal of the machined surface over a cell.
    fn normal(&self, cell: usize) -> [f64; 3] {
        let [x, y] = self.normals[cell].map(f64::from);
        [x, y, f64::from(self.area[cell]).recip()]
    }

    /// The machined cells among the nine around a cell.
    fn around(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (column, row) = (cell % self.frame.columns, cell / self.frame.columns);
        let three = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let nine = three(row, self.frame.rows).flat_map(move |row| three(column, self.frame.columns).map(move |column| (column, row)));
        nine.map(|(column, row)| self.frame.index(column, row)).filter(|&cell| self.area[cell] > 0.0)
    }

    /// [`ReachMap::uncut`] of several cutters, in their order, on all threads.
    #[must_use]
    pub fn uncut_of_each(&self, cutters: &[Cutter], scallop_height: Length) -> Vec<Uncut> {
        cutters.par_iter().map(|&cutter| self.uncut(cutter, scallop_height)).collect()
    }
}

/// The place from -1 to 1 with the least value of a function that falls and then rises, and that value, by the golden
/// section; a value of at most `enough` ends the search.
fn least_of(f: impl Fn(f64) -> f64, enough: f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let (mut low, mut high) = (-1.0, 1.0);
    let at = |place: f64| (place, f(place));
    let (mut one, mut other) = (at(high - GOLDEN * (high - low)), at(low + GOLDEN * (high - low)));
    for _ in 0..TURNS {
        if one.1.min(other.1) <= enough {
            break;
        }
        if one.1 < other.1 {
            high = other.0;
            other = one;
            one = at(high - GOLDEN * (high - low));
        } else {
            low = one.0;
            one = other;
            other = at(low + GOLDEN * (high - low));
        }
    }
    if one.1 < other.1 { one } else { other }
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v[0].hypot(v[1]).hypot(v[2]);
    v.map(|part| part / length)
}

/// The tip of a cutter that touches a plane with the normal n at the contact c: the corner's centre is r n above it,
/// the axis R - r further along the horizontal part of n, and the tip r below the centre.
pub(super) fn tip_of(cutter: Cutter, contact: [f64; 3], normal: [f64; 3]) -> [f64; 3] {
    let (core, corner) = (cutter.core_radius().mm(), cutter.corner_radius().mm());
    let horizontal = normal[0].hypot(normal[1]);
    // On a floor the whole flat touches; its middle is placed over the contact.
    let out = if horizontal > 0.0 { core / horizontal } else { 0.0 };
    [contact[0] + (corner + out) * normal[0], contact[1] + (corner + out) * normal[1], contact[2] + corner * normal[2] - corner]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
mod tests;
