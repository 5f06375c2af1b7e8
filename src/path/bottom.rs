//! A cutter's profile as pieces over the distance from the axis, prepared for many evaluations.

use crate::milling::{MOST_ARCS, Profile, ProfileArc};

/// The most pieces: each arc, and a straight piece before each.
const MOST_PIECES: usize = 2 * MOST_ARCS;

/// Steps of the search on an edge. After the eighth, every second one halves the bracket: 2^-48 of it in 104 steps. Newton's
/// method takes four to six.
const MOST_STEPS: u32 = 104;

/// The bottom of a cutter: low(rho), the height over the tip at the distance rho from the axis, for rho from 0 to R.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bottom {
    pieces: [Piece; MOST_PIECES],
    count: usize,
    arcs: [ArcOfSlopes; MOST_ARCS],
    arc_count: usize,
    radius: f64,
}

/// The part of the profile between two distances from the axis.
#[derive(Debug, Clone, Copy)]
struct Piece {
    inner: f64,
    outer: f64,
    shape: Shape,
}

#[derive(Debug, Clone, Copy)]
enum Shape {
    /// The height `at_inner` at the inner end, and the tangent of the piece's slope.
    Straight { at_inner: f64, tangent: f64 },
    /// Radius and centre of the circle: r, e, z of [`ProfileArc`].
    Arc { r: f64, e: f64, z: f64 },
}

/// An arc, with the tangent of the slope from which on planes are touched by it.
#[derive(Debug, Clone, Copy)]
struct ArcOfSlopes {
    from: f64,
    r: f64,
    e: f64,
    z: f64,
}

/// The point where a cutter touches a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touching {
    /// Its distance from the axis.
    pub(super) distance: f64,
    /// Its height over the tip.
    pub(super) height: f64,
    /// The distance of the plane from the tip, along the normal.
    pub(super) support: f64,
}

/// Where on an uphill line, seen from the cutter's axis, the line is highest over the bottom.
#[derive(Debug, Clone, Copy)]
pub(super) struct Highest {
    /// The distance along the line from the point nearest to the axis.
    pub(super) at: f64,
    /// Whether the line touches a corner of the profile there.
    pub(super) is_corner: bool,
}

/// How a cutter stands on a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stand {
    /// The height of the tip over the plane, measured at the axis.
    pub(super) rise: f64,
    /// The distance of the contact from the axis, uphill.
    pub(super) distance: f64,
}

impl Bottom {
    pub(super) fn of(profile: &Profile) -> Self {
        let none = Piece { inner: 0.0, outer: 0.0, shape: Shape::Straight { at_inner: 0.0, tangent: 0.0 } };
        let no_arc = ArcOfSlopes { from: 0.0, r: 0.0, e: 0.0, z: 0.0 };
        let radius = profile.outer_radius();
        let mut bottom = Self { pieces: [none; MOST_PIECES], count: 0, arcs: [no_arc; MOST_ARCS], arc_count: 0, radius };
        let (mut reached, mut height) = (0.0, 0.0);
        for arc in profile.arcs() {
            let (start, start_height) = arc.point(arc.from);
            bottom.push(reached, start, Shape::Straight { at_inner: height, tangent: arc.from.tan() });
            let (end, end_height) = end_of(arc);
            bottom.push(start.max(reached), end, Shape::Arc { r: arc.radius, e: arc.centre_offset, z: arc.centre_height });
            (reached, height) = if end > reached { (end, end_height) } else { (reached, start_height) };
            bottom.arcs[bottom.arc_count] = ArcOfSlopes { from: arc.from.tan(), r: arc.radius, e: arc.centre_offset, z: arc.centre_height };
            bottom.arc_count += 1;
        }
        bottom
    }

    fn push(&mut self, inner: f64, outer: f64, shape: Shape) {
        if outer > inner {
            self.pieces[self.count] = Piece { inner, outer, shape };
            self.count += 1;
        }
    }

    fn pieces(&self) -> &[Piece] {
        &self.pieces[..self.count]
    }

    /// R.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// low(rho) for 0 <= rho <= R.
    pub(super) fn low(&self, rho: f64) -> f64 {
        self.piece_at(rho).map_or(0.0, |piece| piece.height(rho))
    }

    /// low(rho) for 0 <= rho <= R, and its derivative: infinite where the side begins.
    #[inline]
    pub(super) fn low_and_tangent(&self, rho: f64) -> (f64, f64) {
        self.piece_at(rho).map_or((0.0, f64::INFINITY), |piece| (piece.height(rho), piece.tangent(rho)))
    }

    /// The tangents of the profile's slope at the distance rho, inside and outside of it. They differ at a corner.
    pub(super) fn tangents(&self, rho: f64) -> (f64, f64) {
        let within = 1e-9 * self.radius;
        let pieces = self.pieces();
        let (Some(first), Some(last)) =
            (pieces.iter().find(|piece| rho <= piece.outer + within), pieces.iter().rev().find(|piece| rho >= piece.inner - within))
        else {
            return (0.0, f64::INFINITY);
        };
        let before = first.tangent(rho.clamp(first.inner, first.outer));
        let after = if rho >= self.radius - within { f64::INFINITY } else { last.tangent(rho.clamp(last.inner, last.outer)) };
        (before, after)
    }

    /// The curvature of the most curved paraboloid that touches the bottom at the distance `rho` from the axis, where the profile's
    /// slope has this tangent, and is nowhere over it: for every point p within R,
    ///
    /// low(|p|) >= low(rho) + g.(p - c) + bend/2 |p - c|^2
    ///
    /// with the contact c and its gradient g, which is radial. For p at the distance q from the axis, the right side is greatest in the
    /// contact's direction as long as bend rho <= tangent. What is left is a condition on N(q) = low(q) - low(rho) - tangent (q - rho):
    /// 2 N(q) >= bend (q - rho)^2. N has the curvature 1/r or more on the arc of the contact. On a piece further away N is at least its
    /// tangent at the near end, over whose square of the distance it is least at one of the ends.
    pub(super) fn bend(&self, rho: f64, tangent: f64) -> f64 {
        let within = 1e-9 * self.radius;
        let low = self.low(rho);
        let mut bend = if rho > within { tangent / rho } else { f64::INFINITY };
        for piece in self.pieces() {
            let outwards = if rho < 0.5 * (piece.inner + piece.outer) { 1.0 } else { -1.0 };
            let [near, far] = if outwards > 0.0 { [piece.inner, piece.outer] } else { [piece.outer, piece.inner] };
            let [to_near, to_far] = [outwards * (near - rho), outwards * (far - rho)];
            let most = match piece.shape {
                Shape::Arc { r, .. } if to_near <= within => r.recip(),
                _ => {
                    let at_near = piece.height(near) - low - outwards * tangent * to_near;
                    let steeper = outwards * (piece.tangent(near) - tangent);
                    let at_far = at_near + steeper * (to_far - to_near);
                    let least = if to_near > within { 2.0 * at_near / (to_near * to_near) } else { f64::INFINITY };
                    least.min(2.0 * at_far / (to_far * to_far))
                }
            };
            bend = bend.min(most);
        }
        bend.max(0.0)
    }

    fn piece_at(&self, rho: f64) -> Option<&Piece> {
        self.pieces().iter().find(|piece| rho <= piece.outer).or(self.pieces().last())
    }

    /// How the cutter stands on a plane whose slope has this tangent. Of several points that touch, the outermost counts.
    pub(super) fn on_plane(&self, tangent: f64) -> Stand {
        let arc = self.arc_at(tangent);
        let secant = (1.0 + tangent * tangent).sqrt();
        // e + r sin S; e tan S - z + r / cos S
        Stand { rise: arc.e * tangent - arc.z + arc.r * secant, distance: arc.e + arc.r * tangent / secant }
    }

    /// The point that touches a plane with this sine and cosine of its slope.
    pub(super) fn touching(&self, sin: f64, cos: f64) -> Touching {
        let arc = self.arc_at(sin / cos);
        Touching { distance: arc.e + arc.r * sin, height: arc.z - arc.r * cos, support: arc.r + arc.e * sin - arc.z * cos }
    }

    /// The arc that touches planes whose slope has this tangent: the outermost of several.
    fn arc_at(&self, tangent: f64) -> &ArcOfSlopes {
        let arcs = &self.arcs[..self.arc_count];
        arcs.iter().rev().find(|arc| tangent >= arc.from).unwrap_or(&arcs[0])
    }

    /// Where a straight line limits the cutter most. Seen from above the line passes the axis at the distance h; s counts
    /// along it from the point nearest to the axis, from and to the two `ends`, and the line's height is `tangent` times s.
    ///
    /// Returns the s at which tangent s - low(sqrt(h^2 + s^2)), which is concave, is largest, and this value; `None` if the
    /// line is nowhere within R.
    pub(super) fn over_line(&self, tangent: f64, h: f64, ends: [f64; 2]) -> Option<(f64, f64)> {
        let reach = ((self.radius - h) * (self.radius + h)).max(0.0).sqrt();
        let (first, last) = (ends[0].max(-reach), ends[1].min(reach));
        if h > self.radius || first > last {
            return None;
        }
        let s = if tangent < 0.0 {
            -self.highest_uphill(-tangent, h, -last, -first).at
        } else {
            self.highest_uphill(tangent, h, first, last).at
        };
        Some((s, tangent * s - self.low((h * h + s * s).sqrt().min(self.radius))))
    }

    /// The s from `first` to `last` at which tangent s - low(sqrt(h^2 + s^2)) is largest, for tangent >= 0.
    pub(super) fn highest_uphill(&self, tangent: f64, h: f64, first: f64, last: f64) -> Highest {
        let end = |at: f64| Highest { at, is_corner: false };
        if last <= 0.0 {
            return end(last);
        }
        // Uphill is towards positive s: the largest value is not before s = 0.
        let first = first.max(0.0);
        if tangent <= 0.0 {
            return end(first);
        }
        for piece in self.pieces() {
            if piece.outer <= h {
                continue;
            }
            let from = if piece.inner > h { ((piece.inner - h) * (piece.inner + h)).sqrt() } else { 0.0 }.max(first);
            let to = ((piece.outer - h) * (piece.outer + h)).sqrt().min(last);
            if from >= last {
                return end(last);
            }
            if to <= from {
                continue;
            }
            let Some(level) = piece.level_point(tangent, h, from, to) else { continue };
            if level < to {
                return Highest { at: level.max(from), is_corner: level <= from && from > first };
            }
        }
        end(last)
    }
}

/// Distance and height of an arc's end. A horizontal normal is exactly at e + r.
fn end_of(arc: &ProfileArc) -> (f64, f64) {
    if arc.to >= std::f64::consts::FRAC_PI_2 { (arc.centre_offset + arc.radius, arc.centre_height) } else { arc.point(arc.to) }
}

impl Piece {
    fn height(&self, rho: f64) -> f64 {
        match self.shape {
            Shape::Straight { at_inner, tangent } => at_inner + (rho - self.inner) * tangent,
            Shape::Arc { r, e, z } => {
                // r - sqrt(r^2 - w^2) = w^2 / (r + sqrt(r^2 - w^2)), without cancellation.
                let w = rho - e;
                z - r + w * w / (r + ((r - w) * (r + w)).max(0.0).sqrt())
            }
        }
    }

    fn tangent(&self, rho: f64) -> f64 {
        match self.shape {
            Shape::Straight { tangent, .. } => tangent,
            Shape::Arc { r, e, .. } => {
                let w = rho - e;
                w / ((r - w) * (r + w)).max(0.0).sqrt()
            }
        }
    }

    /// The s at which the derivative of tangent s - low is zero, or one before `from` if it is negative there already;
    /// `None` if it is positive at `to`.
    fn level_point(&self, tangent: f64, h: f64, from: f64, to: f64) -> Option<f64> {
        match self.shape {
            Shape::Straight { tangent: own, .. } => {
                // own s / rho = tangent
                let share = tangent / own;
                (share < 1.0).then(|| share * h / ((1.0 - share) * (1.0 + share)).sqrt())
            }
            // s / sqrt(r^2 - h^2 - s^2) = tangent
            Shape::Arc { r, e: 0.0, .. } => Some(tangent * ((r - h) * (r + h) / (1.0 + tangent * tangent)).max(0.0).sqrt()),
            Shape::Arc { r, e, .. } => level_point_of_torus(tangent, h, r, e, from, to),
        }
    }
}

/// The root s of tangent - w/q s/rho with rho = sqrt(h^2 + s^2), w = rho - e, q = sqrt(r^2 - w^2). The root is sought of
/// tangent q rho - w s, which has the same sign and no pole.
fn level_point_of_torus(tangent: f64, h: f64, r: f64, e: f64, from: f64, to: f64) -> Option<f64> {
    let value = |s: f64| {
        let rho = (h * h + s * s).sqrt();
        let w = rho - e;
        let q = ((r - w) * (r + w)).max(0.0).sqrt();
        let rise = s / rho;
        (tangent * q * rho - w * s, tangent * (q * rise - w * rise * rho / q) - rise * s - w)
    };
    // Where the line passes the axis itself, w = r sin S: a first guess, too near to the axis for other lines. There the bottom is
    // as much steeper than the line as s is shorter than rho.
    let of_slope = |tangent: f64| e + r * tangent / (1.0 + tangent * tangent).sqrt();
    let on_line = |rho: f64| ((rho - h) * (rho + h)).max(0.0).sqrt();
    let through_axis = of_slope(tangent);
    let mut s = on_line(of_slope(tangent * through_axis / on_line(through_axis).max(1e-3 * h)));
    let (mut low, mut high) = (from, to);
    if !(s > from && s < to) {
        s = 0.5 * (from + to);
    }
    for step in 0..MOST_STEPS {
        let (f, derivative) = value(s);
        if f > 0.0 {
            low = s;
        } else {
            high = s;
        }
        let newton = s - f / derivative;
        let is_safe = newton > low && newton < high && (step < 8 || step % 2 == 0);
        // The ends are looked at only where the search seems to leave them.
        if !is_safe && low <= from && value(from).0 <= 0.0 {
            return Some(from);
        }
        if !is_safe && high >= to && value(to).0 >= 0.0 {
            return None;
        }
        let next = if is_safe { newton } else { 0.5 * (low + high) };
        let moved = (next - s).abs();
        s = next;
        // After a step of Newton's method of 1e-7, the next one would be of some 1e-14, and the value is level there.
        if moved <= 1e-7 * to && is_safe {
            break;
        }
    }
    Some(s)
}
