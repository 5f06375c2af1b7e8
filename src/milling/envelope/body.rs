//! The cutter as a convex solid, seen from its contact with the surface.

use crate::milling::{Contact, Cutter};
use crate::quantity::Angle;

/// The solid that a turning cutter fills, with its side continued upwards: a horizontal disc of radius a = R - r, with everything
/// above it (the core), and whatever is nearer to that than r. It is a Minkowski sum of convex sets, so it is convex, and so is the
/// distance to its core.
///
/// Places are given from the contact: x along the feed, y to its side in the tangent plane, p along the surface's normal n. With
/// u the steepest descent and v = Z x D the level line, the feed is u cos(theta) + v sin(theta) and the side -u sin(theta) + v cos(theta).
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    core: f64,
    corner: f64,
    slope: Angle,
    along_steepest: f64,
    along_level: f64,
    axis: f64,
}

/// How far a place is from the body, negative inside, with its derivatives along the feed, to the side and along the normal, and
/// the second derivatives of which one is along the feed.
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

impl Body {
    pub(super) fn new(cutter: Cutter, contact: Contact) -> Self {
        let (core, corner, slope) = (cutter.core_radius().mm(), cutter.corner_radius().mm(), contact.slope());
        // Neither turning the feed round nor mirroring the feed at the steepest line changes what a pass leaves.
        let (along_steepest, along_level) = (contact.theta().cos().abs(), contact.theta().sin().abs());
        Self { core, corner, slope, along_steepest, along_level, axis: core + corner * slope.sin() }
    }

    /// The offset dx/dy of the lowest places beside the contact from its normal plane, where the body is an ellipsoid: with
    /// the curvature radii r along the steepest line and q = a/sin(S) + r along the level one, the quadratic form's least place is
    /// x/y = sin cos (1/r - 1/q) / (cos^2/r + sin^2/q). A first guess only.
    pub(super) fn skew(&self) -> f64 {
        let (c, s) = (self.along_steepest, self.along_level);
        let ratio = self.corner * self.slope.sin() / (self.core + self.corner * self.slope.sin());
        let bend = c * c + s * s * ratio;
        if bend > 0.0 { s * c * (1.0 - ratio) / bend } else { 0.0 }
    }

    /// The signed distance to the body at (x, y, p).
    ///
    /// From the axis the place has the radius rho = sqrt(b^2 + nu^2), where b = a + r sin(S) - d, and d, nu, e are its offsets from
    /// the contact along D, v and Z. The distance to the core is sqrt(g^2 + l^2) with g = rho - a outside and l = r cos(S) - e below
    /// it. With D' = rho - b = nu^2/(rho + b) the distance to the body is
    ///
    /// sqrt(g^2 + l^2) - r = (2 r (sin(S) D' - p) + (D' - d)^2 + e^2) / (sqrt(g^2 + l^2) + r),
    ///
    /// where nothing cancels near the contact, because sin(S) d + cos(S) e = p was taken out by hand.
    #[inline]
    pub(super) fn distance(&self, x: f64, y: f64, p: f64) -> Distance {
        let (sin, cos, r) = (self.slope.sin(), self.slope.cos(), self.corner);
        let steep = x * self.along_steepest - y * self.along_level;
        let level = x * self.along_level + y * self.along_steepest;
        let (d, e) = (p * sin + steep * cos, p * cos - steep * sin);
        let b = self.axis - d;
        let radius = (b * b + level * level).sqrt();
        let excess = if b > 0.0 { level * level / (radius + b) } else { radius - b };
        let grown = excess - d;
        let (outside, below) = (r * sin + grown, r * cos - e);
        let to_core = if outside > 0.0 && below > 0.0 { (outside * outside + below * below).sqrt() } else { outside.max(below) };
        let (value, out, down, meridian) = if outside > 0.0 && below > 0.0 {
            let value = (2.0 * r * (sin * excess - p) + grown * grown + e * e) / (to_core + r);
            (value, outside / to_core, below / to_core, to_core.recip())
        } else if outside > below {
            (grown - r * (1.0 - sin), 1.0, 0.0, 0.0)
        } else {
            (-e - r * (1.0 - cos), 0.0, 1.0, 0.0)
        };
        // The radial unit vector; on the axis the core's floor is nearer than its side, so that its direction does not matter.
        let (radial_d, radial_level) = if radius > 0.0 { (-b / radius, level / radius) } else { (-1.0, 0.0) };
        let (by_d, by_level, by_z) = (out * radial_d, out * radial_level, -down);
        let by_steep = by_d * cos - by_z * sin;
        // The distance bends along the meridian's tangent, down * radial + out * Z, and around the axis. Of these the feed has the
        // parts cos(theta) and sin(theta) times those of the steepest and the level line, the side -sin(theta) and cos(theta) times them.
        let meridian_steep = down * radial_d * cos - out * sin;
        let (meridian_level, meridian_height) = (down * radial_level, down * radial_d * sin + out * cos);
        let (around_steep, around_level, around_height) = (-radial_level * cos, radial_d, -radial_level * sin);
        let feed = |steep: f64, level: f64| steep * self.along_steepest + level * self.along_level;
        let side = |steep: f64, level: f64| level * self.along_steepest - steep * self.along_level;
        let along_meridian = meridian * feed(meridian_steep, meridian_level);
        let around = if out > 0.0 && radius > 0.0 { out / radius * feed(around_steep, around_level) } else { 0.0 };
        let bend = |meridian_part: f64, around_part: f64| along_meridian * meridian_part + around * around_part;
        Distance {
            value,
            by_feed: feed(by_steep, by_level),
            by_side: side(by_steep, by_level),
            by_height: by_d * sin + by_z * cos,
            bend: bend(feed(meridian_steep, meridian_level), feed(around_steep, around_level)),
            bend_to_side: bend(side(meridian_steep, meridian_level), side(around_steep, around_level)),
            bend_to_height: bend(meridian_height, around_height),
        }
    }
}
