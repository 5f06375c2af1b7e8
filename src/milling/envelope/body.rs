//! The cutter as a convex solid above the surface, in coordinates relative to the contact.

mod ray;
mod turns;

use crate::milling::{Contact, Cutter, SurfaceCurvature};
use crate::quantity::Angle;
pub(super) use ray::Ray;
use turns::Turn;

/// The solid that a rotating cutter sweeps, with its side continued upwards. Its core is a horizontal disc of radius a
/// = R - r with everything above it; the solid is the set of all points within r of the core. It is a Minkowski sum of
/// convex sets, so it is convex, and so is the distance to its core.
///
/// Coordinates are relative to the contact: x along the feed, y to its side in the tangent plane, and p above the
/// **surface**, along its normal n at the contact. With u the steepest descent and v = Z x D the level line, the feed
/// is u cos(theta) + v sin(theta) and the side -u sin(theta) + v cos(theta). The surface is 1/2 u'Ku below the tangent
/// plane, so a point is p - 1/2 u'Ku above the tangent plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    core: f64,
    corner: f64,
    slope: Angle,
    along_steepest: f64,
    along_level: f64,
    axis: f64,
    surface: SurfaceCurvature,
    is_plane: bool,
    /// The overhang of the surface, if it has a concave direction.
    concave: Option<Overhang>,
}

/// The signed distance of a point from the body, negative inside. With its derivatives along the feed, to the side and
/// along the normal, and the second derivatives that include the feed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Distance {
    pub(super) value: f64,
    pub(super) by_feed: f64,
    pub(super) by_side: f64,
    pub(super) by_height: f64,
    pub(super) bend: f64,
    pub(super) bend_to_side: f64,
    pub(super) bend_to_height: f64,
}

/// The curvature of a surface with a concave direction, in the axes of the steepest and the level line.
#[derive(Debug, Clone, Copy)]
struct Overhang {
    /// k_ss, along the steepest line.
    bend: f64,
    /// k_sl, the twist.
    twist: f64,
    /// k_ll, along the level line.
    level_bend: f64,
    /// sin(S) sqrt(k_ss^2 + k_sl^2), the gradient of the normal's component along the axis.
    length: f64,
}

/// The relative radii of curvature of cutter and surface at the contact, in the axes of the feed: the inverse of C^-1 +
/// K, in mm. For a paraboloid, the groove of a pass has the radius `across`, and its lowest points at the lateral
/// offset t are t `skew`/`across` ahead of the contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct RelativeRadii {
    pub(super) across: f64,
    pub(super) skew: f64,
}

/// A point of a sharp edge: its coordinates along the feed and to the side, its height above the surface, and the
/// derivatives of offset and height by the angle around the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgePlace {
    pub(super) x: f64,
    pub(super) t: f64,
    pub(super) t_by_psi: f64,
    pub(super) height: f64,
    pub(super) height_by_psi: f64,
}

/// A part of the surface of a body with a flat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Face {
    Floor,
    Side,
}

/// The slope's sine below which the section at most heights lies around the axis.
const NEARLY_LEVEL: f64 = 0.05;

/// The sine of an overhang below which it counts as a rounding error.
const OVERHANG: f64 = 1e-12;

impl Body {
    pub(super) fn new(cutter: Cutter, contact: Contact, surface: SurfaceCurvature) -> Self {
        let (core, corner, slope) = (cutter.core_radius().mm(), cutter.corner_radius().mm(), contact.slope());
        let (cos, sin) = (contact.theta().cos(), contact.theta().sin());
        // Under the whole cutter such a surface falls by less than coordinates are rounded, and noise in derivatives
        // would mislead the search.
        let is_flat = surface.principal_per_mm().into_iter().all(|curvature| curvature.abs() * (core + corner) <= 1e-14);
        let surface = if is_flat { SurfaceCurvature::PLANE } else { surface };
        // Reversing the feed, or mirroring feed and surface about the steepest line, does not change what a pass
        // leaves.
        let surface = if (cos < 0.0) == (sin < 0.0) || cos == 0.0 || sin == 0.0 { surface } else { surface.mirrored() };
        Self {
            core,
            corner,
            slope,
            along_steepest: cos.abs(),
            along_level: sin.abs(),
            axis: core + corner * slope.sin(),
            surface,
            is_plane: surface.is_plane(),
            // On a wall that the cutter does not gouge, the side curves away from the surface everywhere.
            concave: (surface.principal_per_mm()[1] < 0.0 && slope.cos() != 0.0).then(|| {
                let steepest = surface.turned(-sin.abs(), cos.abs());
                let (bend, twist) = (steepest.along_per_mm(), steepest.twist_per_mm());
                Overhang { bend, twist, level_bend: steepest.across_per_mm(), length: slope.sin() * bend.hypot(twist) }
            }),
        }
    }

    /// The point of a sharp edge at the angle psi from the contact, seen along the axis.
    ///
    /// Its coordinates are d = R (1 - cos(psi)) towards the axis and R sin(psi) along the level line.
    pub(super) fn sharp_edge(&self, psi: f64) -> EdgePlace {
        let (sin, cos) = psi.sin_cos();
        // R (1 - cos(psi)) without cancellation.
        let inwards = 2.0 * self.core * (psi / 2.0).sin().powi(2);
        let sheared = |inwards: f64, level: f64| {
            let steep = inwards * self.slope.cos();
            (steep * self.along_steepest + level * self.along_level, level * self.along_steepest - steep * self.along_level)
        };
        let (x, y) = sheared(inwards, self.core * sin);
        let (x_by_psi, y_by_psi) = sheared(self.core * sin, self.core * cos);
        let (k_f, k_t, k_ft) = (self.surface.along_per_mm(), self.surface.across_per_mm(), self.surface.twist_per_mm());
        let (fall_by_feed, fall_by_side) = (k_f * x + k_ft * y, k_ft * x + k_t * y);
        EdgePlace {
            x,
            t: y,
            t_by_psi: y_by_psi,
            height: inwards * self.slope.sin() + 0.5 * (x * fall_by_feed + y * fall_by_side),
            height_by_psi: self.core * sin * self.slope.sin() + x_by_psi * fall_by_feed + y_by_psi * fall_by_side,
        }
    }

    /// C (1 + K C)^-1 = (C + det(C) adj(K)) / (1 + tr(K C) + det(K) det(C)). C has the cutter's radii of curvature, r
    /// along the steepest line and q = a/sin(S) + r along the level one, turned into the axes of the feed. For first
    /// guesses only: near the floor, q is limited to a value that no cut reaches.
    pub(super) fn relative_radii(&self) -> RelativeRadii {
        let (c, s, r) = (self.along_steepest, self.along_level, self.corner);
        let q = if self.core > 0.0 { (self.core / self.slope.sin()).min(1e6 * self.core) + r } else { r };
        let (along, across, skew, det) = (r * c * c + q * s * s, r * s * s + q * c * c, (q - r) * s * c, r * q);
        let (k_f, k_t, k_ft) = (self.surface.along_per_mm(), self.surface.across_per_mm(), self.surface.twist_per_mm());
        let whole = 1.0 + k_f * along + 2.0 * k_ft * skew + k_t * across + (k_f * k_t - k_ft * k_ft) * det;
        RelativeRadii { across: (across + det * k_f) / whole, skew: (skew - det * k_ft) / whole }
    }

    /// The curvature of cutter and surface together along the feed, of a cutter with a corner radius.
    pub(super) fn bend_along_feed(&self) -> f64 {
        let (sin, r) = (self.slope.sin(), self.corner);
        let across_steepest = sin / (self.core + r * sin);
        self.along_steepest * self.along_steepest / r + self.along_level * self.along_level * across_steepest + self.surface.along_per_mm()
    }

    /// An upper bound of the distance from the contact to any point of the cutter's lower body.
    pub(super) fn reach(&self) -> f64 {
        2.0 * (self.core + self.corner)
    }

    /// a = R - r, the radius of the flat.
    pub(super) fn core(&self) -> f64 {
        self.core
    }

    /// r, the corner's radius.
    pub(super) fn corner(&self) -> f64 {
        self.corner
    }

    /// The slope at the contact.
    pub(super) fn slope(&self) -> Angle {
        self.slope
    }

    /// The curvature of the surface in the axes of the feed, mirrored if the feed was.
    pub(super) fn surface(&self) -> SurfaceCurvature {
        self.surface
    }

    /// Whether the surface has a concave direction, so that the section need not be convex; on a wall that the cutter
    /// does not gouge it is.
    pub(super) fn is_concave(&self) -> bool {
        self.concave.is_some()
    }

    /// The feed's parts along the steepest and the level line, neither negative.
    pub(super) fn along_steepest(&self) -> f64 {
        self.along_steepest
    }

    pub(super) fn along_level(&self) -> f64 {
        self.along_level
    }

    /// The components along the feed and to its side of a step along the steepest and the level line.
    pub(super) fn along_feed(&self, steep: f64, level: f64) -> [f64; 2] {
        [steep * self.along_steepest + level * self.along_level, level * self.along_steepest - steep * self.along_level]
    }

    /// The components along the steepest and the level line of a point in the tangent plane.
    fn in_slope(&self, x: f64, y: f64) -> (f64, f64) {
        (x * self.along_steepest - y * self.along_level, x * self.along_level + y * self.along_steepest)
    }

    /// Whether the flat is so nearly level that the section at most heights lies around the axis.
    pub(super) fn is_nearly_level(&self) -> bool {
        self.slope.sin() < NEARLY_LEVEL
    }

    /// The point under the middle of the flat.
    pub(super) fn flat_centre(&self) -> [f64; 2] {
        let (sin, cos) = (self.slope.sin(), self.slope.cos());
        self.along_feed(self.axis * cos + self.corner * (1.0 - cos) * sin, 0.0)
    }

    /// An approximation of the height of points around the axis that are `across` apart: that of the tilted flat and of
    /// the round beyond the flat.
    pub(super) fn height_under_axis(&self, across: f64) -> f64 {
        let beyond = ((across / 2.0 - self.core) / self.corner.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        self.slope.sin() * across + self.corner * (1.0 - (1.0 - beyond * beyond).sqrt())
    }

    /// An approximation of half of the section's extent along the level line at the height p, by the parabola of H.
    pub(super) fn level_extent(&self, p: f64) -> f64 {
        let (sin, outer) = (self.slope.sin(), self.core + self.corner);
        let bend =
            (if self.core > 0.0 { sin / self.axis } else { self.corner.recip() }) + self.concave.map_or(0.0, |surface| surface.level_bend);
        if bend > 0.0 { (2.0 * p / bend).sqrt().min(outer) } else { outer }
    }

    /// Whether the section at the height p is known to be convex although the surface is not, because the section
    /// reaches neither the flat nor the side.
    ///
    /// On the round, the cutter's curvature is at least sin(beta) / (a + r sin(beta)), with beta the angle between its
    /// normal and the axis. H is convex where this exceeds the largest concave curvature k. The section lies within the
    /// circle about the contact in which the cutter's sphere of radius q = a/sin(S) + r is at most p above the surface,
    /// and along the steepest line within that of the corner's round.
    pub(super) fn is_convex_up_to(&self, p: f64) -> bool {
        let (sin, cos, a, r) = (self.slope.sin(), self.slope.cos(), self.core, self.corner);
        let k = -self.surface.principal_per_mm()[1];
        if k <= 0.0 {
            return true;
        }
        let free = (if a > 0.0 { sin / (a + r * sin) } else { r.recip() }) - k;
        if free <= 0.0 || k * r >= 1.0 {
            return false;
        }
        let reach_squared = 2.0 * p / free;
        let along_steepest = (2.0 * r * (p + 0.5 * k * reach_squared)).sqrt();
        let sin_least = k * a / (1.0 - k * r);
        // The sine of S - beta, the angle of the round from the contact to the point where H ceases to be convex.
        let clear_of_flat =
            a == 0.0 || sin_least < sin && along_steepest < r * (sin * (1.0 - sin_least * sin_least).sqrt() - cos * sin_least);
        clear_of_flat && reach_squared < (a + r) * (a + r) && along_steepest < cos * (r - reach_squared / (a + r))
    }

    /// Whether the line from the contact to a point of the body at the height p is inside the body, tested at a few
    /// points of the line.
    pub(super) fn reaches(&self, x: f64, y: f64, p: f64) -> bool {
        [0.2, 0.4, 0.6, 0.8].into_iter().all(|share| self.distance(share * x, share * y, p).value <= 1e-9 * p)
    }

    /// The distance of a point beyond the line from which the surface overhangs, or beyond the contact's level line if
    /// that is nearer. Uphill of that line the cutter's straight side would pass through the surface.
    ///
    /// The normal of the surface is n + K u; its component along the axis is cos(S) - sin(S) (k_ss u_s + k_sl u_l).
    /// Along the cutter's side, the height above the surface rises up to the point where this component is 0, and falls
    /// beyond it.
    ///
    /// Negative on this side of either line; `None` if the surface has no such line.
    fn overhang(&self, steep: f64, level: f64) -> Option<Distance> {
        let Overhang { bend, twist, length, .. } = self.concave?;
        let gradient = (self.slope.sin() * bend, self.slope.sin() * twist);
        if length <= 0.0 {
            return None;
        }
        let excess = self.slope.sin() * (bend * steep + twist * level) - self.slope.cos() - OVERHANG;
        let (value, (by_steep, by_level)) =
            if excess / length < -steep { (excess / length, (gradient.0 / length, gradient.1 / length)) } else { (-steep, (-1.0, 0.0)) };
        Some(Distance {
            value,
            by_feed: by_steep * self.along_steepest + by_level * self.along_level,
            by_side: by_level * self.along_steepest - by_steep * self.along_level,
            by_height: 0.0,
            bend: 0.0,
            bend_to_side: 0.0,
            bend_to_height: 0.0,
        })
    }

    /// The distance of a point beyond an overhang, negative before it and infinitely so without one.
    pub(super) fn beyond_overhang(&self, [x, y]: [f64; 2]) -> f64 {
        let (steep, level) = self.in_slope(x, y);
        self.overhang(steep, level).map_or(f64::NEG_INFINITY, |overhang| overhang.value)
    }

    /// Calls `bound` with each smooth function of the point (x, y, p) that is not positive if the point, and the line to
    /// it from the contact, are in the section.
    ///
    /// These are the distance to the body, that to the overhang, and the distance at the point of the line at which H is
    /// greatest on the flat. At a sharp edge the distance has a corner, and the distances to side and floor replace it;
    /// beside a round they bound the other part.
    pub(super) fn bounds(&self, x: f64, y: f64, p: f64, mut bound: impl FnMut(Distance)) {
        if self.corner > 0.0 {
            bound(self.solid::<false>(x, y, p, None));
        }
        if self.core > 0.0 {
            bound(self.solid::<false>(x, y, p, Some(Face::Side)));
            bound(self.solid::<false>(x, y, p, Some(Face::Floor)));
        }
        if self.concave.is_none() {
            return;
        }
        let (steep, level) = self.in_slope(x, y);
        if let Some(overhang) = self.overhang(steep, level) {
            bound(overhang);
        }
        if steep > 0.0
            && let Some(Turn { at, is_top: true }) = self.turn([x, y])
            && at < 1.0
        {
            let top = self.solid::<false>(at * x, at * y, p, Some(Face::Floor));
            // Along the line the highest point has no slope, so that a step aside moves it by its share of the line. Its
            // second derivatives are left out.
            let (by_feed, by_side) = (at * top.by_feed, at * top.by_side);
            bound(Distance { by_feed, by_side, bend: 0.0, bend_to_side: 0.0, bend_to_height: 0.0, ..top });
        }
    }

    /// The signed distance to the body at (x, y, p).
    ///
    /// d, nu and e are the point's offsets from the contact along D, v and Z. Its distance from the axis is rho =
    /// sqrt(b^2 + nu^2) with b = a + r sin(S) - d. The distance to the core is sqrt(g^2 + l^2) with g = rho - a outside
    /// the core and l = r cos(S) - e below it. With D' = rho - b = nu^2/(rho + b), the distance to the body is
    ///
    /// sqrt(g^2 + l^2) - r = (2 r (sin(S) D' - p) + (D' - d)^2 + e^2) / (sqrt(g^2 + l^2) + r),
    ///
    /// in which nothing cancels near the contact, because sin(S) d + cos(S) e = p has been substituted.
    #[inline]
    pub(super) fn distance(&self, x: f64, y: f64, p: f64) -> Distance {
        if self.is_plane { self.distance_over::<true>(x, y, p) } else { self.distance_over_curved(x, y, p) }
    }

    #[inline(never)]
    fn distance_over_curved(&self, x: f64, y: f64, p: f64) -> Distance {
        self.distance_over::<false>(x, y, p)
    }

    /// The distance over a surface that is a plane or not: most contacts are on planes, where the terms of the curvature
    /// are 0.
    #[inline]
    fn distance_over<const PLANE: bool>(&self, x: f64, y: f64, p: f64) -> Distance {
        if !PLANE && self.concave.is_some() {
            let (steep, level) = self.in_slope(x, y);
            if let Some(overhang) = self.overhang(steep, level).filter(|overhang| overhang.value > 0.0) {
                let solid = self.solid::<PLANE>(x, y, p, None);
                return if overhang.value > solid.value { overhang } else { solid };
            }
        }
        self.solid::<PLANE>(x, y, p, None)
    }

    /// The distance to the whole body, or to the plane of its floor or the cylinder of its side alone.
    #[expect(clippy::inline_always, reason = "callers that do not use the second derivatives need not compute them")]
    #[inline(always)]
    fn solid<const PLANE: bool>(&self, x: f64, y: f64, p: f64, face: Option<Face>) -> Distance {
        let (sin, cos, r) = (self.slope.sin(), self.slope.cos(), self.corner);
        let (k_f, k_t, k_ft) = (self.surface.along_per_mm(), self.surface.across_per_mm(), self.surface.twist_per_mm());
        // How far the surface has fallen from the tangent plane, and its derivatives along the feed and to the side.
        let (fall_by_feed, fall_by_side) = (k_f * x + k_ft * y, k_ft * x + k_t * y);
        let p = if PLANE { p } else { p - 0.5 * (x * fall_by_feed + y * fall_by_side) };
        let (steep, level) = self.in_slope(x, y);
        let (d, e) = (p * sin + steep * cos, p * cos - steep * sin);
        let b = self.axis - d;
        let radius = (b * b + level * level).sqrt();
        // One division for two quotients, here and at the round: divisions take most of the time.
        let (excess, per_radius) = if b > 0.0 {
            let per_both = (radius * (radius + b)).recip();
            (level * level * per_both * radius, per_both * (radius + b))
        } else {
            (radius - b, radius.recip())
        };
        let grown = excess - d;
        let (outside, below) = (r * sin + grown, r * cos - e);
        let is_round = face.is_none() && outside > 0.0 && below > 0.0;
        let is_side = face.map_or(outside > below, |face| face == Face::Side);
        let (value, out, down, meridian) = if is_round {
            let to_core = (outside * outside + below * below).sqrt();
            let per_both = (to_core * (to_core + r)).recip();
            let per_core = per_both * (to_core + r);
            let value = (2.0 * r * (sin * excess - p) + grown * grown + e * e) * (per_both * to_core);
            (value, outside * per_core, below * per_core, per_core)
        } else if is_side {
            (grown - r * (1.0 - sin), 1.0, 0.0, 0.0)
        } else {
            (-e - r * (1.0 - cos), 0.0, 1.0, 0.0)
        };
        // The radial unit vector. On the axis the core's floor is nearer than its side, so the direction does not
        // matter.
        let (radial_d, radial_level) = if radius > 0.0 { (-b * per_radius, level * per_radius) } else { (-1.0, 0.0) };
        // The components of a vector along the feed, to the side and along the normal. The feed is cos(theta) times the
        // steepest line plus sin(theta) times the level line; the side is -sin(theta) and cos(theta) times them. A step
        // along the feed or to the side also includes the fall of the surface.
        let parts = |d: f64, level: f64, z: f64| {
            let (steep, height) = (d * cos - z * sin, d * sin + z * cos);
            let feed = steep * self.along_steepest + level * self.along_level;
            let side = level * self.along_steepest - steep * self.along_level;
            if PLANE { (feed, side, height) } else { (feed - height * fall_by_feed, side - height * fall_by_side, height) }
        };
        let (by_feed, by_side, by_height) = parts(out * radial_d, out * radial_level, -down);
        // The second derivatives have three parts: along the meridian's tangent, around the axis, and from the surface.
        let along = parts(down * radial_d, down * radial_level, out);
        let around = parts(-radial_level, radial_d, 0.0);
        let around_axis = if out > 0.0 && radius > 0.0 { out * per_radius } else { 0.0 };
        let bend = meridian * along.0 * along.0 + around_axis * around.0 * around.0;
        let bend_to_side = meridian * along.0 * along.1 + around_axis * around.0 * around.1;
        Distance {
            value,
            by_feed,
            by_side,
            by_height,
            bend: if PLANE { bend } else { bend - by_height * k_f },
            bend_to_side: if PLANE { bend_to_side } else { bend_to_side - by_height * k_ft },
            bend_to_height: meridian * along.0 * along.2 + around_axis * around.0 * around.2,
        }
    }
}
