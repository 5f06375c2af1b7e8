//! The level of the ridge between two passes on a plane, for the worst phase between their teeth.
//!
//! A place at the height p over the surface stays uncut if no tooth's body covers it. The cutter's section K(p) at that height is
//! convex; let its chord along the feed have the length l(t) at the lateral offset t. One pass, its teeth f apart, leaves the
//! places at t uncut for some phase exactly when l(t) < f. So something is left at the height p, for some phase of each pass,
//! exactly when the interval {t: l(t) >= f} is shorter than the step-over s. Raising p moves the section along the cutter's side and never shortens
//! the interval, so the height h that is left in the worst case is the smallest p at which it is s long:
//!
//! h = min p such that (x, t, p), (x - f, t, p), (x', t - s, p) and (x' - f, t - s, p) all lie in the body.
//!
//! That is a convex problem in x, x', t and p. Nothing is assumed on where the lowest place is or on symmetry. A feed f = 0 leaves two points
//! and gives h1.
//!
//! In terms of the signed distance to the body, which is convex: c(t, p) = min over x of max(distance(x, t, p), distance(x - f, t, p))
//! and V(p) = min over t of max(c(t, p), c(t - s, p)) are convex as well, V falls with p, and V(h) = 0.

use super::body::{Body, Distance};
use super::root::{Slope, rising_root};

/// A chord along the feed at its best place: c and its derivatives to the side and along the normal.
#[derive(Debug, Clone, Copy)]
struct Chord {
    value: f64,
    by_side: f64,
    by_height: f64,
}

/// The search for the ridge of one pass and its neighbour.
pub(super) struct Ridge<'a> {
    body: &'a Body,
    step_over: f64,
    mark_spacing: f64,
    /// Places are found to this length. It moves h by about its product with the flank's slope, and slopes are about h over the lengths in play:
    /// a few roundings of h.
    resolution: f64,
}

/// Newton on a convex function gains at least a factor 2 a step even at a double root, so that 64 steps are more than a number has digits.
const MOST_STEPS: usize = 64;

impl<'a> Ridge<'a> {
    pub(super) fn new(body: &'a Body, step_over: f64, mark_spacing: f64) -> Self {
        Self { body, step_over, mark_spacing, resolution: 2.0 * f64::EPSILON * (step_over + mark_spacing) }
    }

    /// h, given a first guess of it and a height that it cannot exceed.
    ///
    /// Newton from any p gives the root of a tangent to the convex V, which is never above h; from there on it rises to h. The
    /// derivative is V's weighted one: where a maximum of two functions is least, weights make their slopes cancel.
    pub(super) fn level(&self, guess: f64, highest: f64) -> f64 {
        let skew = self.body.skew();
        let mut p = guess.min(highest);
        let mut t = self.step_over / 2.0;
        let mut x = (self.mark_spacing / 2.0 + skew * t, self.mark_spacing / 2.0 + skew * (t - self.step_over));
        for step in 0..MOST_STEPS {
            let (mut near, mut far) = (None, None);
            t = rising_root(t, self.step_over, self.resolution, |t| {
                let one = self.chord(t, p, &mut x.0);
                let other = self.chord(t - self.step_over, p, &mut x.1);
                (near, far) = (Some(one), Some(other));
                Slope { value: one.value - other.value, derivative: one.by_side - other.by_side }
            });
            let (Some(near), Some(far)) = (near, far) else { break };
            let share = balance(near.by_side, far.by_side);
            let value = share * near.value + (1.0 - share) * far.value;
            let slope = share * near.by_height + (1.0 - share) * far.by_height;
            // Above h the tangent may be level or meet 0 below the surface; 0 is under h as well.
            let next = if slope < 0.0 { (p - value / slope).clamp(0.0, highest) } else { 0.0 };
            let settled = (next - p).abs() <= 4.0 * f64::EPSILON * p || (step > 1 && next <= p);
            p = next;
            if settled {
                break;
            }
        }
        p
    }

    /// c at the lateral offset t and the height p; `x` is where the search starts and where it ended.
    fn chord(&self, t: f64, p: f64, x: &mut f64) -> Chord {
        let f = self.mark_spacing;
        let mut ends: Option<(Distance, Distance)> = None;
        *x = rising_root(*x, self.step_over + f, self.resolution, |x| {
            let front = self.body.distance(x, t, p);
            if f == 0.0 {
                ends = Some((front, front));
                return Slope { value: front.by_feed, derivative: front.bend };
            }
            let back = self.body.distance(x - f, t, p);
            ends = Some((front, back));
            Slope { value: front.value - back.value, derivative: front.by_feed - back.by_feed }
        });
        let (front, back) = ends.unwrap_or_else(|| (self.body.distance(*x, t, p), self.body.distance(*x - f, t, p)));
        let share = if f == 0.0 { 1.0 } else { balance(front.by_feed, back.by_feed) };
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        Chord {
            value: mix(front.value, back.value),
            by_side: mix(front.by_side, back.by_side),
            by_height: mix(front.by_height, back.by_height),
        }
    }
}

/// The weight of a rising slope against a falling one that makes their mean vanish; any weight does where neither slopes.
fn balance(rising: f64, falling: f64) -> f64 {
    let whole = rising - falling;
    if whole > 0.0 { (-falling / whole).clamp(0.0, 1.0) } else { 0.5 }
}
