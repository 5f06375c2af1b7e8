//! The facets of a surface, prepared for marching over them in any direction.

use super::slopes::{SlopePlace, place_of};
use crate::quantity::{Angle, Area, Length};
use crate::surface::FinishFacet;
use rayon::prelude::*;

/// Facets with what the simulation needs of each: once for all cutters and directions.
///
/// Corners are kept relative to the middle of the surface, so that coordinates far from the origin lose nothing in
/// differences.
#[derive(Debug, Clone)]
pub(super) struct Workpiece {
    pub(super) corners: Vec<[[f64; 3]; 3]>,
    pub(super) areas: Vec<f64>,
    pub(super) tangents: Vec<Tangent>,
    /// The middle of the box around the facets, in mm.
    pub(super) origin: [f64; 3],
    /// The highest point, relative to the middle.
    pub(super) top: f64,
    /// The area of all facets, in mm^2.
    pub(super) area: f64,
    /// The factor by which a facet's share of a length is multiplied: 1, or where facets were sampled what each one
    /// stands for.
    pub(super) weights: Vec<f64>,
    /// The gap between cuts along a plane that sampling alone hardly ever makes; 0 where all facets are there.
    pub(super) sampling_gap: f64,
}

/// Slope and curvature of one facet, in the axes of its steepest line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tangent {
    /// The horizontal unit vector down the slope; +X on a level facet.
    pub(super) down_hill: [f64; 2],
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// The rise of the facet along X and Y, per length seen from above.
    pub(super) gradient: [f64; 2],
    /// Curvature along the steepest line, between both lines, and along the level line, in 1/mm, positive where convex.
    pub(super) curvature: [f64; 3],
    /// The place of the slope in the tables of spacings.
    pub(super) place: SlopePlace,
    /// Whether the facet is too steep to set a spacing.
    pub(super) is_steep: bool,
}

impl Tangent {
    fn of(facet: &FinishFacet, cos_of_steepest: f64) -> Self {
        let [x, y, z] = facet.normal;
        let horizontal = x.hypot(y);
        let length = horizontal.hypot(z);
        let (sin, cos) = (horizontal / length, z / length);
        let down_hill = if horizontal > 0.0 { [x / horizontal, y / horizontal] } else { [1.0, 0.0] };
        let steepest = [down_hill[0] * cos, down_hill[1] * cos, -sin];
        let level = [-down_hill[1], down_hill[0], 0.0];
        let curvature =
            [facet.curvature_between(steepest, steepest), facet.curvature_between(steepest, level), facet.curvature_between(level, level)];
        Self { down_hill, sin, cos, gradient: [-x / z, -y / z], curvature, place: place_of(sin), is_steep: cos < cos_of_steepest }
    }

    /// cos(alpha) and sin(alpha) of a direction seen from above, alpha counted from the steepest line down the slope.
    pub(super) fn alpha(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let [u, v] = self.down_hill;
        (x * u + y * v, y * u - x * v)
    }

    /// cos^2(S) + sin^2(S) cos^2(alpha), the square of the ratio of spacing seen from above to spacing along the
    /// surface.
    pub(super) fn ratio_squared(&self, cos_alpha: f64) -> f64 {
        self.cos * self.cos + (self.sin * cos_alpha) * (self.sin * cos_alpha)
    }
}

impl Workpiece {
    /// Prepares the facets; `cos_of_steepest` is the cosine of the slope up to which they set spacings. Once `stop`
    /// returns true, no facets are prepared.
    pub(super) fn new(facets: &[FinishFacet], cos_of_steepest: f64, stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let facets = if stop() { &[] } else { facets };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in facets.iter().flat_map(|facet| &facet.corners) {
            for axis in 0..3 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
            }
        }
        let origin = [0, 1, 2].map(|axis| if facets.is_empty() { 0.0 } else { f64::midpoint(low[axis], high[axis]) });
        let corners =
            facets.par_iter().with_min_len(4096).map(|facet| facet.corners.map(|p| [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]]));
        let corners: Vec<_> = corners.collect();
        let facets = if stop() { &[] } else { facets };
        let corners = if facets.is_empty() { Vec::new() } else { corners };
        let tangents = facets.par_iter().with_min_len(4096).map(|facet| Tangent::of(facet, cos_of_steepest));
        Self {
            corners,
            areas: facets.iter().map(|facet| facet.area).collect(),
            tangents: tangents.collect(),
            origin,
            top: if facets.is_empty() { 0.0 } else { high[2] - origin[2] },
            area: facets.iter().map(|facet| facet.area).sum(),
            weights: vec![1.0; facets.len()],
            sampling_gap: 0.0,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    /// The figures of the surface.
    pub(super) fn figures(&self) -> SurfaceFigures {
        let (mut slopes, mut steep, mut curvature) = (0.0, 0.0, 0.0);
        for (tangent, area) in self.tangents.iter().zip(&self.areas) {
            slopes += area * tangent.sin.atan2(tangent.cos);
            let [steepest, twist, level] = tangent.curvature;
            curvature += area * steepest.hypot(level).hypot(std::f64::consts::SQRT_2 * twist);
            steep += if tangent.is_steep { *area } else { 0.0 };
        }
        let area = self.area;
        let of_area = |sum: f64| if area > 0.0 { sum / area } else { 0.0 };
        #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
        let count = self.len().max(1) as f64;
        SurfaceFigures {
            area: Area::computed(area),
            mean_slope: Angle::from_radians(of_area(slopes)),
            steep_area_share: of_area(steep),
            facet_size: Length::computed((2.0 * area / count).sqrt()),
            sagitta: Length::computed(of_area(curvature) * 2.0 * area / count / 8.0),
        }
    }

    /// About `count` facets that stand for all of them, drawn evenly by area: facet after facet is passed over until
    /// its share of the area is due. What a drawn facet adds to a length counts as often as its area is contained in
    /// the area that it stands for.
    pub(super) fn sampled(&self, count: usize) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
        let share = self.area / count as f64;
        let mut due = 0.5 * share;
        let mut passed = 0.0;
        let mut drawn = Vec::with_capacity(count + count / 8);
        for (index, &area) in self.areas.iter().enumerate() {
            passed += area;
            if passed >= due {
                // A facet larger than the share stands for itself.
                let times = ((passed - due) / share).floor() + 1.0;
                due += times * share;
                drawn.push((index, (times * share / area).max(1.0)));
            }
        }
        // A plane cuts as many facets per length as there are in a strip of their width. Gaps between random places
        // 12 times as wide as the mean have a probability of e^-12, one in 100 planes of a thousand cuts; places
        // drawn evenly have fewer.
        let widths: f64 = drawn.iter().map(|&(index, _)| (2.0 * self.areas[index]).sqrt()).sum();
        let sampling_gap = if widths > 0.0 { 12.0 * self.area / widths } else { 0.0 };
        Self {
            sampling_gap,
            corners: drawn.iter().map(|&(index, _)| self.corners[index]).collect(),
            areas: drawn.iter().map(|&(index, weight)| self.areas[index] * weight).collect(),
            tangents: drawn.iter().map(|&(index, _)| self.tangents[index]).collect(),
            origin: self.origin,
            top: self.top,
            area: self.area,
            weights: drawn.iter().map(|&(_, weight)| weight).collect(),
        }
    }
}

/// The figures of the surface in the simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFigures {
    /// The area of all facets.
    pub area: Area,
    /// The mean slope over the area.
    pub mean_slope: Angle,
    /// The share of the area that is steeper than the largest slope and sets no spacing.
    pub steep_area_share: f64,
    /// The edge length of a square of the mean facet's area: two triangles to a square of it are as many facets.
    pub facet_size: Length,
    /// The distance of facets of that size from the surface, by the mean curvature k over the area: k size^2 / 8.
    pub sagitta: Length,
}
