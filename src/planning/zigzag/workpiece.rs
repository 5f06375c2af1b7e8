//! The facets of a surface, prepared for simulation in any direction.

use super::footprint::Footprint;
use super::slopes::{SlopePlace, place_of};
use crate::cancellation::collect_until;
use crate::quantity::{Angle, Area, Length};
use crate::surface::FinishFacet;
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// The data of the facets that the simulation needs, computed once for all cutters and directions.
///
/// Corners are stored relative to the middle of the surface, so that differences of coordinates far from the origin do
/// not lose digits.
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
    /// The factor by which a facet's part of a length is multiplied: 1, or the number of facets that a sampled one
    /// represents.
    pub(super) weights: Vec<f64>,
    /// The facets in the order in which they are sampled, once it is known.
    order: OnceLock<Vec<u32>>,
    /// Where the surface is, if the facets were sampled: their cuts do not show where runs end.
    pub(super) footprint: Option<Arc<Footprint>>,
}

/// Slope and curvature of one facet, in the axes of its steepest line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tangent {
    /// The horizontal unit vector down the slope; +X on a level facet.
    pub(super) down_hill: [f64; 2],
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// 1/cos(S)
    pub(super) per_cos: f64,
    /// Curvature along the steepest line, the mixed one, and that along the level line, in 1/mm, positive where convex.
    pub(super) curvature: [f64; 3],
    /// The position of the slope in the tables of spacings.
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
        Self { down_hill, sin, cos, per_cos: length / z, curvature, place: place_of(sin), is_steep: cos < cos_of_steepest }
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

/// The number of facets whose figures one thread adds up at a time.
const SUMMED_AT_ONCE: usize = 4096;

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
        let corners = collect_until(facets.len(), stop, |facet| {
            facets[facet].corners.map(|p| [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]])
        });
        let tangents = collect_until(facets.len(), stop, |facet| Tangent::of(&facets[facet], cos_of_steepest));
        let (facets, corners, tangents) = if stop() { (&facets[..0], Vec::new(), Vec::new()) } else { (facets, corners, tangents) };
        Self {
            corners,
            areas: facets.iter().map(|facet| facet.area).collect(),
            tangents,
            origin,
            top: if facets.is_empty() { 0.0 } else { high[2] - origin[2] },
            area: facets.iter().map(|facet| facet.area).sum(),
            weights: vec![1.0; facets.len()],
            order: OnceLock::new(),
            footprint: None,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    /// The figures of the surface.
    pub(super) fn figures(&self) -> SurfaceFigures {
        let sums_of = |(tangents, areas): (&[Tangent], &[f64])| {
            let mut sums = [0.0; 3];
            for (tangent, area) in tangents.iter().zip(areas) {
                let [steepest, twist, level] = tangent.curvature;
                sums[0] += area * tangent.sin.atan2(tangent.cos);
                sums[1] += if tangent.is_steep { *area } else { 0.0 };
                sums[2] += area * (steepest * steepest + level * level + 2.0 * twist * twist).sqrt();
            }
            sums
        };
        // Added in the order of the facets, so that the result does not depend on the number of threads.
        let parts: Vec<[f64; 3]> =
            self.tangents.par_chunks(SUMMED_AT_ONCE).zip(self.areas.par_chunks(SUMMED_AT_ONCE)).map(sums_of).collect();
        let [slopes, steep, curvature] = [0, 1, 2].map(|place| parts.iter().map(|part| part[place]).sum::<f64>());
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

    /// The facets in the order of a curve that fills the plane (Morton's), so that neighbours in the order are neighbours
    /// seen from above. It does not depend on the order in the file.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole numbers under 2^16")]
    fn along_curve(&self) -> Vec<u32> {
        let centre = |[a, b, c]: &[[f64; 3]; 3]| [0, 1].map(|axis| a[axis] + b[axis] + c[axis]);
        let furthest = self.corners.iter().flat_map(centre).fold(f64::MIN_POSITIVE, |furthest, part| part.abs().max(furthest));
        let place = |part: f64| ((part / furthest + 1.0) * f64::from(u16::MAX / 2)) as u32;
        let key = |corners| {
            let [x, y] = centre(corners).map(place);
            spread_bits(x) | spread_bits(y) << 1
        };
        let mut order: Vec<(u32, u32)> = self.corners.iter().map(key).zip(0..).collect();
        order.par_sort_unstable();
        order.into_iter().map(|(_, index)| index).collect()
    }

    /// About `count` places, drawn by area from the facets that `counts` accepts, as facets and how often each is drawn: the
    /// area is divided into `count` equal parts along a curve that fills it, and in each a random place is drawn. Evenly
    /// drawn, the facets of a regular grid would be those of a few lines.
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    pub(super) fn drawn(&self, count: usize, counts: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
        let in_order = || self.order.get_or_init(|| self.along_curve()).iter().map(|&index| index as usize).filter(|&index| counts(index));
        let share = in_order().map(|index| self.areas[index]).sum::<f64>() / count as f64;
        let mut places = RandomPlaces(0);
        let (mut part, mut passed) = (0, 0.0);
        let mut due = places.next_place() * share;
        let mut drawn = Vec::with_capacity(count + count / 8);
        for index in in_order() {
            passed += self.areas[index];
            let mut times = 0;
            while passed >= due && part < count {
                (times, part) = (times + 1, part + 1);
                due = (part as f64 + places.next_place()) * share;
            }
            if times > 0 {
                drawn.push((index, times));
            }
        }
        drawn
    }

    /// A sample of about `count` facets, drawn by area. A drawn facet's part of a length is multiplied by the area that it
    /// represents over its own. `footprint` is that of all facets, if runs are wanted.
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    pub(super) fn sampled(&self, count: usize, footprint: Option<Arc<Footprint>>) -> Self {
        let share = self.area / count as f64;
        // A facet larger than the share represents itself.
        let weight = |(index, times): (usize, usize)| (index, (times as f64 * share / self.areas[index]).max(1.0));
        let drawn: Vec<(usize, f64)> = self.drawn(count, |_| true).into_iter().map(weight).collect();
        Self {
            footprint,
            corners: drawn.iter().map(|&(index, _)| self.corners[index]).collect(),
            areas: drawn.iter().map(|&(index, weight)| self.areas[index] * weight).collect(),
            tangents: drawn.iter().map(|&(index, _)| self.tangents[index]).collect(),
            origin: self.origin,
            top: self.top,
            area: self.area,
            order: OnceLock::new(),
            weights: drawn.iter().map(|&(_, weight)| weight).collect(),
        }
    }
}

/// The 16 lower bits, each followed by a bit of 0.
fn spread_bits(number: u32) -> u32 {
    let mut bits = number & 0xffff;
    bits = (bits | bits << 8) & 0x00ff_00ff;
    bits = (bits | bits << 4) & 0x0f0f_0f0f;
    bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

/// Random places from 0 to 1, always the same ones: the 64-bit generator SplitMix (Steele, Lea and Flood 2014).
struct RandomPlaces(u64);

impl RandomPlaces {
    #[expect(clippy::cast_precision_loss, reason = "53 bits")]
    fn next_place(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
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
    /// The side of a square with twice the area of the mean facet: squares of this side, each split into two triangles,
    /// are as many facets.
    pub facet_size: Length,
    /// The distance of facets of that size from the surface: k size^2 / 8, with k the mean of the curvature over the
    /// area.
    pub sagitta: Length,
}
