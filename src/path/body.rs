//! The cutter's solid over its tip, as a convex function of the distance from the axis, and the solid swept along a
//! straight move.
//!
//! A move from the tip a to the tip a + L d, d with the length 1 in plan view, sweeps the points q for which
//! F(v, q) = a_z + g v + low(|q_xy - a_xy - v d_xy|) - q_z <= 0 at some v from 0 to L. F is convex in v and q together;
//! so is its least value over v in q. On a ray the swept solid is an interval, whose ends Newton's method finds from
//! outside.

use crate::milling::{Profile, ProfileArc};

/// The slope of the cutter's side in place of infinity, which would leave F without derivatives. Over 100 mm of height
/// the side is off by 0.1 um.
const SIDE: f64 = 1e6;

/// What is nearer to the surface of the solid than this, in mm of height, is on it.
const ON: f64 = 1e-10;

/// Newton's step in mm at which a search ends. Steps shrink quadratically: the error is far smaller.
const STEP: f64 = 1e-7;

#[derive(Debug, Clone, Copy)]
enum Shape {
    /// An arc about a centre at this distance from the axis and this height over the tip.
    Arc { radius: f64, offset: f64, height: f64 },
    /// A flat, a cone or the side, from this distance and height on.
    Straight { slope: f64, start: f64, height: f64 },
}

#[derive(Debug, Clone, Copy)]
struct Element {
    shape: Shape,
    start: f64,
    end: f64,
    start_slope: f64,
    end_slope: f64,
}

/// The solid of a cutter, infinitely high: low(rho) with finite slopes, and its support function.
#[derive(Debug, Clone)]
pub(super) struct Body {
    profile: Profile,
    elements: Vec<Element>,
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
}

impl Element {
    fn value(&self, rho: f64) -> (f64, f64) {
        match self.shape {
            Shape::Straight { slope, start, height } => (height + slope * (rho - start), slope),
            Shape::Arc { radius, offset, height } => {
                let x = rho - offset;
                let down = ((radius - x) * (radius + x)).max(0.0).sqrt();
                let slope = if x < SIDE * down { x / down } else { SIDE };
                (height - radius + x * x / (radius + down), slope)
            }
        }
    }

    /// The rho between `low` and the element's end where low'(rho) u/rho = grade with u = sqrt(rho^2 - across^2): there F
    /// is least along a move. The quotient is under `grade` at `low` and over it at the end.
    fn stationary(&self, low: f64, across_squared: f64, grade: f64) -> f64 {
        match self.shape {
            Shape::Straight { slope, .. } => {
                let rho_squared = across_squared * (1.0 + grade * grade / ((slope - grade) * (slope + grade)));
                rho_squared.sqrt().clamp(low, self.end)
            }
            Shape::Arc { radius, offset: 0.0, .. } => {
                let along_squared = grade * grade * (radius * radius - across_squared).max(0.0) / (1.0 + grade * grade);
                (along_squared + across_squared).sqrt()
            }
            Shape::Arc { radius, offset, .. } => {
                // x u - grade rho sqrt(r^2 - x^2) = 0 with x = rho - e, by Newton's method within a bracket.
                let (mut below, mut above) = (low, self.end);
                let mut rho = offset + radius * grade / (1.0 + grade * grade).sqrt();
                let u = (rho * rho - across_squared).max(0.0).sqrt();
                if u > 0.0 {
                    let steeper = grade * rho / u;
                    rho = offset + radius * steeper / (1.0 + steeper * steeper).sqrt();
                }
                // F is least there: an error of 1e-6 of rho is one of 1e-12 in F.
                while above - below > 1e-9 {
                    if !(rho > below && rho < above) {
                        rho = 0.5 * (below + above);
                    }
                    let x = rho - offset;
                    let u = (rho * rho - across_squared).max(0.0).sqrt();
                    let down = ((radius - x) * (radius + x)).max(0.0).sqrt();
                    let f = x * u - grade * rho * down;
                    if f < 0.0 {
                        below = rho;
                    } else {
                        above = rho;
                    }
                    let step = f / (u + x * rho / u - grade * down + grade * rho * x / down);
                    if step.abs() < 1e-6 {
                        break;
                    }
                    rho -= step;
                }
                rho.clamp(low, self.end)
            }
        }
    }
}

impl Body {
    pub(super) fn new(profile: &Profile) -> Self {
        let mut elements: Vec<Element> = Vec::with_capacity(8);
        let mut reached = (0.0, 0.0);
        for arc in profile.arcs() {
            let (rho, height) = arc.point(arc.from);
            if rho > reached.0 + 1e-9 {
                let slope = (height - reached.1) / (rho - reached.0);
                let shape = Shape::Straight { slope, start: reached.0, height: reached.1 };
                elements.push(Element { shape, start: reached.0, end: rho, start_slope: slope, end_slope: slope });
            }
            let end = if arc.to.tan() < SIDE && arc.to > 0.0 || arc.to == 0.0 {
                arc.point(arc.to)
            } else {
                (arc.centre_offset + arc.radius, arc.centre_height)
            };
            if arc.radius > 0.0 && end.0 > rho {
                let shape = Shape::Arc { radius: arc.radius, offset: arc.centre_offset, height: arc.centre_height };
                let (start_slope, end_slope) =
                    (arc.from.tan(), if arc.to.tan() < SIDE && arc.to.tan() >= 0.0 { arc.to.tan() } else { SIDE });
                elements.push(Element { shape, start: rho, end: end.0, start_slope, end_slope });
            }
            reached = end;
        }
        let side = Shape::Straight { slope: SIDE, start: reached.0, height: reached.1 };
        elements.push(Element { shape: side, start: reached.0, end: f64::INFINITY, start_slope: SIDE, end_slope: SIDE });
        Self { profile: *profile, elements }
    }

    pub(super) fn profile(&self) -> &Profile {
        &self.profile
    }

    pub(super) fn outer_radius(&self) -> f64 {
        self.profile.outer_radius()
    }

    /// low(rho) and its derivative.
    #[inline]
    fn value(&self, rho: f64) -> (f64, f64) {
        for element in &self.elements {
            if rho <= element.end {
                return element.value(rho);
            }
        }
        (f64::INFINITY, SIDE)
    }

    #[inline]
    pub(super) fn low(&self, rho: f64) -> f64 {
        self.value(rho).0
    }

    /// How far from the point's foot, back along the move, F is least on a line at the distance `across` and of this
    /// grade > 0, and whether that is at a corner of the profile, where F has no derivative.
    fn back(&self, across: f64, grade: f64) -> (f64, bool) {
        let across_squared = across * across;
        let along = |rho: f64| ((rho - across) * (rho + across)).max(0.0).sqrt();
        for element in &self.elements {
            if element.end <= across {
                continue;
            }
            if element.end.is_finite() && element.end_slope * along(element.end) < grade * element.end {
                continue;
            }
            let low = element.start.max(across);
            if element.start_slope * along(low) >= grade * low && low > across || element.end_slope <= grade {
                return (along(low), low > across);
            }
            return (along(element.stationary(low, across_squared, grade)), false);
        }
        (0.0, false)
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
        let sin = normal[0].hypot(normal[1]);
        let cos = normal[2];
        let arc = self.profile.arc_at(sin.atan2(cos));
        let rho = arc.centre_offset + arc.radius * sin;
        let (ux, uy) = if sin > 0.0 { (normal[0] / sin, normal[1] / sin) } else { (0.0, 0.0) };
        let tip = [rho * ux, rho * uy, arc.radius * cos - arc.centre_height];
        Ray { point, normal, tip, support: arc.radius + arc.centre_offset * sin - arc.centre_height * cos }
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
            t = t.max(-self.depth(swept, ray.point));
        }
        (t < best).then_some(t)
    }

    /// How far the point is in the solid: the largest distance from the surface of the cutter at any tip of the move.
    ///
    /// At the edge of a part the depth along a facet's normal jumps, from nothing to a wall's height where the cutter's side
    /// passes over the edge by a rounding error. This one does not.
    fn depth(&self, swept: &Swept, point: [f64; 3]) -> f64 {
        let at = |v: f64| {
            let (x, y) = (point[0] - swept.start[0] - v * swept.along[0], point[1] - swept.start[1] - v * swept.along[1]);
            self.depth_at(x.hypot(y), point[2] - swept.start[2] - v * swept.grade)
        };
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
