//! The cutter's solid over its tip, as a convex function of the distance from the axis, and the solid swept along a
//! straight move.
//!
//! A move from the tip a to the tip a + L d, d with the length 1 in plan view, sweeps the points q for which
//! F(v, q) = a_z + g v + low(|q_xy - a_xy - v d_xy|) - q_z <= 0 at some v from 0 to L. F is convex in v and q together;
//! so is its least value over v in q. On a ray the swept solid is an interval, whose ends Newton's method finds from
//! outside.

use super::bottom::{Bottom, Highest, Touching};
use crate::milling::{Profile, ProfileArc};

/// The slope of the cutter's side in place of infinity, which would leave F without derivatives. Over 100 mm of height
/// the side is off by 0.1 um.
const SIDE: f64 = 1e6;

/// What is nearer to the surface of the solid than this, in mm of height, is on it.
const ON: f64 = 1e-10;

/// A depth of this share of the largest possible one is not searched for longer.
const ALL: f64 = 0.999;

/// The tangent of the steepest slope at which a paraboloid rules out moves: on steeper ones its curvature is lost in rounding errors.
const STEEPEST_BENT: f64 = 100.0;

/// Newton's step in mm at which a search ends. Steps shrink quadratically: the error is far smaller.
const STEP: f64 = 1e-7;

/// The solid of a cutter, infinitely high: low(rho) with finite slopes, and its support function.
#[derive(Debug, Clone)]
pub(super) struct Body {
    profile: Profile,
    bottom: Bottom,
}

/// F's least value over a move for a point, where along the move it is, and the derivatives by the point's x and y.
/// The derivative by z is -1.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyLevel {
    pub(super) height: f64,
    by_x: f64,
    by_y: f64,
}

/// A move prepared for many points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Swept {
    start: [f64; 3],
    along: [f64; 2],
    length: f64,
    /// dz per plan length.
    grade: f64,
    pub(super) lowest: f64,
}

/// A place and the normal along which material is measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) point: [f64; 3],
    pub(super) normal: [f64; 3],
    /// The plan-view offset of the tip that touches the place, and its height over the place.
    pub(super) tip: [f64; 3],
    /// H(-n): how far the solid reaches against the normal from its tip.
    support: f64,
    /// [`Bottom::bend`] where the solid touches the place, times n_z.
    bend: f64,
}

impl Body {
    pub(super) fn new(profile: &Profile) -> Self {
        Self { profile: *profile, bottom: Bottom::of(profile) }
    }

    pub(super) fn outer_radius(&self) -> f64 {
        self.profile.outer_radius()
    }

    /// low(rho) and its derivative.
    #[inline]
    fn value(&self, rho: f64) -> (f64, f64) {
        let beyond = rho - self.bottom.radius();
        let (low, slope) = self.bottom.low_and_tangent(if beyond > 0.0 { self.bottom.radius() } else { rho });
        if beyond > 0.0 { (low + SIDE * beyond, SIDE) } else { (low, slope.min(SIDE)) }
    }

    #[inline]
    pub(super) fn low(&self, rho: f64) -> f64 {
        let radius = self.bottom.radius();
        self.bottom.low(rho.min(radius)) + SIDE * (rho - radius).max(0.0)
    }

    /// How far from the point's foot, back along the move, F is least on a line at the distance `across` and of this
    /// grade > 0, and whether that is at a corner of the profile, where F has no derivative.
    fn back(&self, across: f64, grade: f64) -> (f64, bool) {
        let radius = self.bottom.radius();
        let reach = ((radius - across) * (radius + across)).max(0.0).sqrt();
        let Highest { at, is_corner } = self.bottom.highest_uphill(grade, across, 0.0, reach);
        if at < reach {
            return (at, is_corner);
        }
        let on_side = across * grade / ((SIDE - grade) * (SIDE + grade)).sqrt();
        if on_side > reach { (on_side, false) } else { (reach, reach > 0.0) }
    }

    /// Where along the move, in mm of plan length, F is least for the point q.
    pub(super) fn lowest_along(&self, swept: &Swept, q: [f64; 3]) -> f64 {
        let (x, y) = (q[0] - swept.start[0], q[1] - swept.start[1]);
        let mut v = x * swept.along[0] + y * swept.along[1];
        if swept.grade != 0.0 {
            let across = (x * swept.along[1] - y * swept.along[0]).abs();
            v -= self.back(across, swept.grade.abs()).0.copysign(swept.grade);
        }
        v.min(swept.length).max(0.0)
    }

    /// F's least value over the move for the point q.
    #[inline]
    pub(super) fn level(&self, swept: &Swept, q: [f64; 3]) -> BodyLevel {
        let (x, y) = (q[0] - swept.start[0], q[1] - swept.start[1]);
        let foot = x * swept.along[0] + y * swept.along[1];
        let mut v = foot;
        let mut at_corner = None;
        if swept.grade != 0.0 {
            let across = (x * swept.along[1] - y * swept.along[0]).abs();
            let (back, is_corner) = self.back(across, swept.grade.abs());
            v -= back.copysign(swept.grade);
            at_corner = (is_corner && v > 0.0 && v < swept.length).then_some(swept.grade.abs() / back);
        }
        let v = v.min(swept.length).max(0.0);
        let (dx, dy) = (x - v * swept.along[0], y - v * swept.along[1]);
        let rho = (dx * dx + dy * dy).sqrt();
        let (low, slope) = self.value(rho);
        // At a corner of the profile the slope is the one for which F is least there.
        let factor = at_corner.unwrap_or(if rho > 0.0 { slope / rho } else { 0.0 });
        BodyLevel { height: swept.start[2] + swept.grade * v + low - q[2], by_x: factor * dx, by_y: factor * dy }
    }

    pub(super) fn ray(&self, point: [f64; 3], normal: [f64; 3]) -> Ray {
        let sin = (normal[0] * normal[0] + normal[1] * normal[1]).sqrt();
        let cos = normal[2];
        let tangent = sin / cos;
        let Touching { distance, height, support } = self.bottom.touching(sin, cos);
        let (ux, uy) = if sin > 0.0 { (normal[0] / sin, normal[1] / sin) } else { (0.0, 0.0) };
        let bend = if tangent < STEEPEST_BENT { cos * self.bottom.bend(distance, tangent) } else { 0.0 };
        Ray { point, normal, tip: [distance * ux, distance * uy, -height], support, bend }
    }

    /// The level t at which the ray p + t n enters the solid swept by the move: `None` if it does not, if that is not
    /// below `best`, or if the ray leaves the solid before t = 0, which is then a cut into another face of the part.
    pub(super) fn entry(&self, swept: &Swept, ray: &Ray, best: f64) -> Option<f64> {
        let at = |t: f64| {
            let n = ray.normal;
            let level = self.level(swept, [ray.point[0] + t * n[0], ray.point[1] + t * n[1], ray.point[2] + t * n[2]]);
            (level.height, level.by_x * n[0] + level.by_y * n[1] - n[2])
        };
        let (height, slope) = at(best);
        let mut t = if slope < 0.0 {
            if height >= 0.0 {
                return None;
            }
            // F is convex: its tangent at a point inside meets zero before F does.
            best - height / slope
        } else {
            // The tangent plane of the solid with the place's normal is before the solid.
            swept.tangent_plane(ray)
        };
        for _ in 0..60 {
            let (height, slope) = at(t);
            if height <= ON {
                break;
            }
            if slope >= 0.0 {
                return None;
            }
            let step = -height / slope;
            t += step;
            if t >= best {
                return None;
            }
            if step < STEP {
                break;
            }
        }
        if t < 0.0 {
            if at(0.0).0 > 1e3 * ON {
                return None;
            }
            t = t.max(-self.depth(swept, ray.point, -t));
        }
        (t < best).then_some(t)
    }

    /// How far the point is in the solid: the largest distance from the surface of the cutter at any tip of the move.
    ///
    /// At the edge of a part the depth along a facet's normal jumps, from nothing to a wall's height where the cutter's side
    /// passes over the edge by a rounding error. This one does not; it is at most the depth along the normal.
    fn depth(&self, swept: &Swept, point: [f64; 3], along_normal: f64) -> f64 {
        let at = |v: f64| {
            let (x, y) = (point[0] - swept.start[0] - v * swept.along[0], point[1] - swept.start[1] - v * swept.along[1]);
            self.depth_at((x * x + y * y).sqrt(), point[2] - swept.start[2] - v * swept.grade)
        };
        let at_lowest = at(self.lowest_along(swept, point));
        if at_lowest >= ALL * along_normal {
            return at_lowest;
        }
        // Concave: the distance from the border of a convex solid is. By golden sections.
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut low, mut high) = (0.0, swept.length);
        let (mut v, mut w) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_v, mut at_w) = (at(v), at(w));
        let mut deepest = at(low).max(at(high)).max(at_v).max(at_w);
        while high - low > 1e-7 {
            if at_v > at_w {
                (high, w, at_w) = (w, v, at_v);
                v = high - golden * (high - low);
                at_v = at(v);
            } else {
                (low, v, at_v) = (v, w, at_w);
                w = low + golden * (high - low);
                at_w = at(w);
            }
            deepest = deepest.max(at_v).max(at_w);
        }
        deepest.max(0.0)
    }

    /// The distance of a point in the solid, rho from the axis and at the height z over the tip, from the solid's surface:
    /// the least over all tangents. Negative outside.
    fn depth_at(&self, rho: f64, z: f64) -> f64 {
        let from = |arc: &ProfileArc| {
            let (x, y) = (rho - arc.centre_offset, z - arc.centre_height);
            let (sin, cos) = x.atan2(-y).clamp(arc.from, arc.to).sin_cos();
            // Beyond the centre the normal that is nearest is at one of the ends.
            let ends = [arc.from, arc.to].map(|angle| x * angle.sin() - y * angle.cos());
            arc.radius - (x * sin - y * cos).max(ends[0]).max(ends[1])
        };
        self.profile.arcs().iter().map(from).fold(f64::INFINITY, f64::min)
    }
}

impl Ray {
    /// The tip that touches the place.
    pub(super) fn standing(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.point[axis] + self.tip[axis])
    }

    /// Whether the ray does not enter the solid at any of some tips between 0 and `best`: n.D is at least `along`, and |D_xy| at least
    /// `distance`, with D from the tip that touches the place to any of them.
    ///
    /// A paraboloid that touches the solid in the place and contains it shows that: F at p + t n is at least
    /// (n.D - t)/n_z + bend/2 |D_xy - t n_xy|^2.
    #[inline]
    pub(super) fn rules_out(&self, along: f64, distance: f64, best: f64) -> bool {
        best > 0.0 && along + 0.5 * self.bend * (distance - best).max(0.0).powi(2) >= best
    }

    /// Whether the ray does not enter the solid at any tip of a move between 0 and `best`, as [`Self::rules_out`] shows it.
    #[inline]
    pub(super) fn rules_out_move(&self, swept: &Swept, best: f64) -> bool {
        let [x, y, _] = self.standing();
        self.rules_out(swept.tangent_plane(self), swept.distance_squared(x, y).sqrt(), best)
    }
}

impl Swept {
    pub(super) fn new(from: [f64; 3], to: [f64; 3]) -> Self {
        let (dx, dy, dz) = (to[0] - from[0], to[1] - from[1], to[2] - from[2]);
        let length = dx.hypot(dy);
        let lowest = from[2].min(to[2]);
        // A vertical move sweeps what the cutter holds at its lower end.
        if length < 1e-9 || dz.abs() > 0.1 * SIDE * length {
            let start = if dz < 0.0 { to } else { from };
            return Self { start, along: [0.0; 2], length: 0.0, grade: 0.0, lowest };
        }
        Self { start: from, along: [dx / length, dy / length], length, grade: dz / length, lowest }
    }

    pub(super) fn start(&self) -> [f64; 3] {
        self.start
    }

    /// The length in plan view.
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    pub(super) fn end(&self) -> [f64; 3] {
        let [x, y, z] = self.start;
        [x + self.along[0] * self.length, y + self.along[1] * self.length, z + self.grade * self.length]
    }

    /// A bound from below for the level: where the plane with the place's normal that touches the swept solid is.
    #[inline]
    pub(super) fn tangent_plane(&self, ray: &Ray) -> f64 {
        let [a, b] = [self.start, self.end()];
        let along = |tip: [f64; 3]| (0..3).map(|axis| ray.normal[axis] * (tip[axis] - ray.point[axis])).sum::<f64>();
        along(a).min(along(b)) - ray.support
    }

    /// The square of the distance in plan view.
    #[inline]
    pub(super) fn distance_squared(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - self.start[0], y - self.start[1]);
        let v = (x * self.along[0] + y * self.along[1]).min(self.length).max(0.0);
        let (dx, dy) = (x - v * self.along[0], y - v * self.along[1]);
        dx * dx + dy * dy
    }
}
