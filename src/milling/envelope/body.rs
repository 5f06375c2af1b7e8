//! The cutter as a convex solid above the surface, in coordinates relative to the contact.

use crate::milling::{Contact, Cutter, SurfaceCurvature};
use crate::numerics::bracketed_root;
use crate::quantity::Angle;
use std::convert::Infallible;

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
    /// The surface in the axes of the steepest and the level line, where it has a concave direction.
    concave: Option<SurfaceCurvature>,
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

/// The relative radii of curvature of cutter and surface at the contact, in the axes of the feed: the inverse of C^-1 +
/// K, in mm. For a paraboloid, the groove of a pass has the radius `across`, and its lowest points at the lateral
/// offset t are t `skew`/`across` ahead of the contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct RelativeRadii {
    pub(super) across: f64,
    pub(super) skew: f64,
}

/// Where H can turn from rising to falling on a line from the contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// The share of the line.
    pub(super) at: f64,
    /// Whether H is highest there, on the flat.
    pub(super) is_top: bool,
}

/// A part of the surface of a sharp-edged body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Face {
    Floor,
    Side,
}

/// Places around a ring between which its lowest ones are searched.
const AROUND: u8 = 16;

/// The sine of an overhang under which it is rounding.
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
            // On a wall that the cutter does not gouge the side bends away from the surface everywhere.
            concave: (surface.principal_per_mm()[1] < 0.0 && slope.cos() != 0.0).then(|| surface.turned(-sin.abs(), cos.abs())),
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

    /// The feed's components along the steepest and the level line, neither negative.
    pub(super) fn along_steepest(&self) -> f64 {
        self.along_steepest
    }

    pub(super) fn along_level(&self) -> f64 {
        self.along_level
    }

    /// The parts along the feed and to its side of a step along the steepest and the level line.
    pub(super) fn along_feed(&self, steep: f64, level: f64) -> [f64; 2] {
        [steep * self.along_steepest + level * self.along_level, level * self.along_steepest - steep * self.along_level]
    }

    /// Whether the flat is so nearly level that the section at most heights lies around the axis.
    pub(super) fn is_nearly_level(&self) -> bool {
        self.slope.sin() < 0.05
    }

    /// The place under the middle of the flat.
    pub(super) fn flat_centre(&self) -> [f64; 2] {
        let (sin, cos) = (self.slope.sin(), self.slope.cos());
        self.along_feed(self.axis * cos + self.corner * (1.0 - cos) * sin, 0.0)
    }

    /// About the height of places around the axis that are `across` apart: that of the flat's tilt and of the round
    /// beyond the flat.
    pub(super) fn height_under_axis(&self, across: f64) -> f64 {
        let beyond = ((across / 2.0 - self.core) / self.corner.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        self.slope.sin() * across + self.corner * (1.0 - (1.0 - beyond * beyond).sqrt())
    }

    /// About half of the section's extent along the level line at the height p, the parabola of H there.
    pub(super) fn level_extent(&self, p: f64) -> f64 {
        let (sin, outer) = (self.slope.sin(), self.core + self.corner);
        let bend = (if self.core > 0.0 { sin / self.axis } else { self.corner.recip() })
            + self.concave.map_or(0.0, SurfaceCurvature::across_per_mm);
        if bend > 0.0 { (2.0 * p / bend).sqrt().min(outer) } else { outer }
    }

    /// Where on the line from the contact through a place H can turn from rising to falling, as a share of the line up
    /// to the place: where the parabola of H on the flat is highest, or, where the line misses the flat, nearest to the
    /// axis. `None` where it does not turn.
    ///
    /// The flat is the disc of radius a, shortened by cos(S) along the steepest line. On it H = tan(S) u_s + r (1 -
    /// 1/cos(S)) + 1/2 u'Ku.
    pub(super) fn turn(&self, [x, y]: [f64; 2]) -> Option<Turn> {
        let (sin, cos) = (self.slope.sin(), self.slope.cos());
        let (steep, level) = self.in_slope(x, y);
        let bend = self.surface.along_per_mm() * x * x + 2.0 * self.surface.twist_per_mm() * x * y + self.surface.across_per_mm() * y * y;
        if bend >= 0.0 || self.core == 0.0 || cos <= 0.0 || steep <= 0.0 {
            return None;
        }
        let centre = self.axis * cos + self.corner * (1.0 - cos) * sin;
        let (square, half) = ((steep / cos).powi(2) + level * level, centre * steep / (cos * cos));
        let discriminant = half * half - square * ((centre / cos).powi(2) - self.core * self.core);
        if discriminant <= 0.0 {
            return Some(Turn { at: half / square, is_top: false });
        }
        let root = discriminant.sqrt();
        let (enters, leaves, top) = ((half - root) / square, (half + root) / square, -sin / cos * steep / bend);
        Some(Turn { at: top.clamp(enters, leaves), is_top: top > enters && top < leaves })
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
        let is_small = clear_of_flat && reach_squared < (a + r) * (a + r) && along_steepest < cos * (r - reach_squared / (a + r));
        is_small || r > 0.0 && (a == 0.0 || sin_least < sin) && self.rings_are_above(p, sin_least)
    }

    /// Whether H exceeds p wherever the round ceases to make H convex: around the flat, where the sine of the angle
    /// between normal and axis is `sin_least`, and where the side begins, unless H is convex over the side, too.
    ///
    /// Then the section seen from the contact lies in a region in which H is convex everywhere. A closed connected set
    /// that is convex near each of its points is convex (Tietze and Nakajima), also where the region is not.
    fn rings_are_above(&self, p: f64, sin_least: f64) -> bool {
        let Some(surface) = self.concave else { return true };
        let (sin, cos, a, r) = (self.slope.sin(), self.slope.cos(), self.core, self.corner);
        let (bend, twist, level_bend) = (surface.along_per_mm(), surface.twist_per_mm(), surface.across_per_mm());
        // The overhang's line has to pass the shadow of the core, a disc about a cos(S), by more than r.
        let furthest = bend * a * cos + a * (bend * cos).hypot(twist) + r * bend.hypot(twist);
        if sin * furthest > cos {
            return false;
        }
        let above = p + 1e-12 * (a + r);
        let is_above = |(sin_beta, cos_beta): (f64, f64)| {
            let (radius, e) = (a + r * sin_beta, r * (cos - cos_beta));
            // At the azimuth psi from the contact steepest part, level part and height over the tangent plane are s0 +
            // s1 cos(psi), radius sin(psi) and n0 + n1 cos(psi).
            let (s0, s1) = (self.axis * cos - e * sin, -radius * cos);
            let (n0, n1) = (self.axis * sin + e * cos, -radius * sin);
            let height = |(sin_psi, cos_psi): (f64, f64)| {
                let (steep, level) = (s0 + s1 * cos_psi, radius * sin_psi);
                n0 + n1 * cos_psi + 0.5 * (bend * steep * steep + 2.0 * twist * steep * level + level_bend * level * level)
            };
            let by_psi = |psi: f64| {
                let (sin_psi, cos_psi) = psi.sin_cos();
                let (steep, level) = (s0 + s1 * cos_psi, radius * sin_psi);
                let (steep_by_psi, level_by_psi) = (-s1 * sin_psi, radius * cos_psi);
                -n1 * sin_psi + (bend * steep + twist * level) * steep_by_psi + (twist * steep + level_bend * level) * level_by_psi
            };
            // A trigonometric polynomial of the second degree has at most two lowest places.
            let step = std::f64::consts::TAU / f64::from(AROUND);
            (0..AROUND).all(|i| {
                let psi = step * f64::from(i);
                if height(psi.sin_cos()) <= above {
                    return false;
                }
                let (low, high) = (by_psi(psi), by_psi(psi + step));
                if low >= 0.0 || high <= 0.0 {
                    return true;
                }
                let Ok(lowest) = bracketed_root(psi, psi + step, |psi| Ok::<_, Infallible>(by_psi(psi)));
                height(lowest.sin_cos()) > above
            })
        };
        let side_bends = bend >= 0.0 && bend * (((a + r) * sin).recip() + level_bend) >= twist * twist;
        (a == 0.0 || is_above((sin_least, (1.0 - sin_least * sin_least).sqrt()))) && (side_bends || is_above((1.0, 0.0)))
    }

    /// Whether the line from the contact to a point of the body at the height p is inside the body, tested at a few
    /// points of the line.
    pub(super) fn reaches(&self, x: f64, y: f64, p: f64) -> bool {
        [0.2, 0.4, 0.6, 0.8].into_iter().all(|share| self.distance(share * x, share * y, p).value <= 1e-9 * p)
    }

    /// The distance of a place from the region where the surface overhangs uphill of the contact, so that the cutter's
    /// straight side would pass through it: positive inside the region; `None` where there is no such region.
    ///
    /// The normal of the surface is n + K u, its part along the axis cos(S) - sin(S) (k_ss u_s + k_sl u_l). Along the
    /// side, up to where that vanishes, the height over the surface rises, and falls beyond it. The region is bounded
    /// by that line and by the contact's level line.
    fn overhang(&self, steep: f64, level: f64) -> Option<Distance> {
        let surface = self.concave?;
        let (bend, twist) = (surface.along_per_mm(), surface.twist_per_mm());
        let length = self.slope.sin() * bend.hypot(twist);
        if length <= 0.0 {
            return None;
        }
        let excess = self.slope.sin() * (bend * steep + twist * level) - self.slope.cos() - OVERHANG;
        let (value, (by_steep, by_level)) = if excess / length < -steep {
            (excess / length, (self.slope.sin() * bend / length, self.slope.sin() * twist / length))
        } else {
            (-steep, (-1.0, 0.0))
        };
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

    /// The steepest and the level part of a place in the tangent plane.
    fn in_slope(&self, x: f64, y: f64) -> (f64, f64) {
        (x * self.along_steepest - y * self.along_level, x * self.along_level + y * self.along_steepest)
    }

    /// The signed distance to the body at (x, y, p), or from the overhang where that is greater.
    #[inline]
    pub(super) fn distance(&self, x: f64, y: f64, p: f64) -> Distance {
        if self.concave.is_some() {
            let (steep, level) = self.in_slope(x, y);
            if let Some(overhang) = self.overhang(steep, level).filter(|overhang| overhang.value > 0.0) {
                let solid = self.solid(x, y, p, None);
                return if overhang.value > solid.value { overhang } else { solid };
            }
        }
        self.solid(x, y, p, None)
    }

    /// Calls `bound` with each smooth function of the place (x, y, p) that is not positive where the place and the line
    /// to it from the contact lie in the section.
    ///
    /// Such are the distance to the body, that to the overhang, and the distance where H is greatest on the flat on the
    /// way. At a sharp edge the distance has a corner, and the distances to side and floor replace it; beside a round
    /// they show where the other face is.
    pub(super) fn bounds(&self, x: f64, y: f64, p: f64, mut bound: impl FnMut(Distance)) {
        if self.corner > 0.0 {
            bound(self.solid(x, y, p, None));
        }
        if self.core > 0.0 {
            bound(self.solid(x, y, p, Some(Face::Side)));
            bound(self.solid(x, y, p, Some(Face::Floor)));
        }
        if self.concave.is_some() {
            let (steep, level) = self.in_slope(x, y);
            if let Some(overhang) = self.overhang(steep, level) {
                bound(overhang);
            }
            if let Some(Turn { at, is_top: true }) = self.turn([x, y])
                && at < 1.0
            {
                let top = self.solid(at * x, at * y, p, Some(Face::Floor));
                // Along the line the top does not slope, so that a step aside moves it by its share of the line. Its
                // second derivatives are left out.
                bound(Distance {
                    by_feed: at * top.by_feed,
                    by_side: at * top.by_side,
                    bend: 0.0,
                    bend_to_side: 0.0,
                    bend_to_height: 0.0,
                    ..top
                });
            }
        }
    }

    /// The signed distance to the body at (x, y, p), or to the plane of its floor or the cylinder of its side alone.
    ///
    /// d, nu and e are the point's offsets from the contact along D, v and Z. Its distance from the axis is rho =
    /// sqrt(b^2 + nu^2) with b = a + r sin(S) - d. The distance to the core is sqrt(g^2 + l^2) with g = rho - a outside
    /// the core and l = r cos(S) - e below it. With D' = rho - b = nu^2/(rho + b), the distance to the body is
    ///
    /// sqrt(g^2 + l^2) - r = (2 r (sin(S) D' - p) + (D' - d)^2 + e^2) / (sqrt(g^2 + l^2) + r),
    ///
    /// where nothing cancels near the contact, because sin(S) d + cos(S) e = p was taken out by hand.
    #[expect(clippy::inline_always, reason = "callers that need the slope alone are spared the second derivatives")]
    #[inline(always)]
    fn solid(&self, x: f64, y: f64, p: f64, face: Option<Face>) -> Distance {
        let (sin, cos, r) = (self.slope.sin(), self.slope.cos(), self.corner);
        let (k_f, k_t, k_ft) = (self.surface.along_per_mm(), self.surface.across_per_mm(), self.surface.twist_per_mm());
        // How far the surface has fallen from the tangent plane, and its derivatives along the feed and to the side.
        let (fall_by_feed, fall_by_side) = (k_f * x + k_ft * y, k_ft * x + k_t * y);
        let p = p - 0.5 * (x * fall_by_feed + y * fall_by_side);
        let (steep, level) = self.in_slope(x, y);
        let (d, e) = (p * sin + steep * cos, p * cos - steep * sin);
        let b = self.axis - d;
        let radius = (b * b + level * level).sqrt();
        let excess = if b > 0.0 { level * level / (radius + b) } else { radius - b };
        let grown = excess - d;
        let (outside, below) = (r * sin + grown, r * cos - e);
        let to_core = if outside > 0.0 && below > 0.0 { (outside * outside + below * below).sqrt() } else { outside.max(below) };
        let is_round = face.is_none() && outside > 0.0 && below > 0.0;
        let is_side = face.map_or(outside > below, |face| face == Face::Side);
        let (value, out, down, meridian) = if is_round {
            let value = (2.0 * r * (sin * excess - p) + grown * grown + e * e) / (to_core + r);
            (value, outside / to_core, below / to_core, to_core.recip())
        } else if is_side {
            (grown - r * (1.0 - sin), 1.0, 0.0, 0.0)
        } else {
            (-e - r * (1.0 - cos), 0.0, 1.0, 0.0)
        };
        // The radial unit vector; on the axis the core's floor is nearer than its side, so that its direction does not
        // matter.
        let (radial_d, radial_level) = if radius > 0.0 { (-b / radius, level / radius) } else { (-1.0, 0.0) };
        // The components of a vector along the feed, to the side and along the normal. The feed is cos(theta) times the
        // steepest line plus sin(theta) times the level line; the side is -sin(theta) and cos(theta) times them. A step
        // along the feed or to the side also includes the fall of the surface.
        let parts = |d: f64, level: f64, z: f64| {
            let (steep, height) = (d * cos - z * sin, d * sin + z * cos);
            let feed = steep * self.along_steepest + level * self.along_level;
            let side = level * self.along_steepest - steep * self.along_level;
            if self.is_plane { (feed, side, height) } else { (feed - height * fall_by_feed, side - height * fall_by_side, height) }
        };
        let (by_feed, by_side, by_height) = parts(out * radial_d, out * radial_level, -down);
        // The second derivatives have three parts: along the meridian's tangent, around the axis, and from the surface.
        let along = parts(down * radial_d, down * radial_level, out);
        let around = parts(-radial_level, radial_d, 0.0);
        let around_axis = if out > 0.0 && radius > 0.0 { out / radius } else { 0.0 };
        let bend = meridian * along.0 * along.0 + around_axis * around.0 * around.0;
        let bend_to_side = meridian * along.0 * along.1 + around_axis * around.0 * around.1;
        Distance {
            value,
            by_feed,
            by_side,
            by_height,
            bend: if self.is_plane { bend } else { bend - by_height * k_f },
            bend_to_side: if self.is_plane { bend_to_side } else { bend_to_side - by_height * k_ft },
            bend_to_height: meridian * along.0 * along.2 + around_axis * around.0 * around.2,
        }
    }
}
