//! Heights and largest feeds on convex sections by nested searches, for contacts at which the fast search proves nothing.
//!
//! At an offset t from a pass, the height M(t) that its marks leave is the root of the distance c(t, p), a convex
//! function that falls with p. M is convex too, so that the height for a step-over s, the least of max(M(t), M(t - s)),
//! is bounded by tangents on both sides. Every search is of one convex function of one unknown, which takes a bounded
//! number of steps from any start.
//!
//! The largest feed per tooth that keeps a height at an offset is concave, because the section is convex. Times -1 it is
//! searched as M is. Both are **values**, of which the least is sought.
//!
//! - `mod` (this file): the search over offsets; `heights` and `feeds`: the searches at an offset
//!
//! With runout a pass clears what either kind of marks clears (`runout`). Each kind has an interval of offsets, which
//! grows with the value. As soon as both meet, the pass clears their union, whose edges can be of different kinds.

mod feeds;
mod heights;

use super::clearing::Clearing;
use super::section::FURTHEST;
pub(super) use feeds::Feeds;
pub(super) use heights::Heights;

/// The largest number of steps of each search: bisection down to rounding takes about 60.
const MOST_STEPS: usize = 80;

/// The relative error of a value at which a search ends: some roundings.
const CLOSE: f64 = 1e-14;

/// The relative gap between a value and its lower bound up to which a search that cannot go on has an answer.
const SETTLED: f64 = 1e-10;

/// The size of a step, as a share of the length sought, under which a step that does not shrink is a rounding error.
const NOISE: f64 = 1e-6;

/// How far a search from outside the section goes, as a multiple of Newton's step, which ends short of its edge.
const INTO_SECTION: f64 = 1.5;

/// What a pass leaves at a lateral offset: a convex function of the offset.
#[derive(Debug, Clone, Copy)]
pub(super) enum Left {
    /// The value and its slope.
    At { value: f64, by_side: f64 },
    /// The pass clears this offset with no value; `side` is 1 on its right side, -1 on its left side, and `step` a step of the
    /// offset towards it that does not pass the section's edge, or NaN.
    Beyond { side: f64, step: f64 },
    /// The search at this offset does not settle.
    Unknown,
}

/// The least value that two passes leave, infinite if none clears both, and the offset at which they do.
#[derive(Debug, Clone, Copy)]
struct Least {
    value: f64,
    t: f64,
}

/// A tangent of a value over the offset.
#[derive(Debug, Clone, Copy)]
struct Tangent {
    t: f64,
    value: f64,
    slope: f64,
}

impl Tangent {
    /// The tangent's value at an offset.
    fn at(&self, t: f64) -> f64 {
        self.value + self.slope * (t - self.t)
    }

    /// Where this tangent, which falls, meets one that rises.
    fn meets(&self, rising: &Self) -> Self {
        let steepening = rising.slope - self.slope;
        let t = (rising.slope * rising.t - self.slope * self.t - rising.value + self.value) / steepening;
        // The offset's rounding error counts less on the gentler tangent.
        let gentler = if self.slope.abs() < rising.slope.abs() { self } else { rising };
        Self { t, value: gentler.at(t), slope: 0.0 }
    }
}

/// A value at one contact and its searches. The start of a search at an offset is what the search before has found.
pub(super) trait Value {
    type Start;

    /// The start of the first search at an offset.
    fn start(&self) -> Self::Start;

    /// A length of the size of the section for the first steps of the offset.
    fn reach(&self) -> f64;

    /// What marks leave at the offset t.
    fn left(&self, marks: &Clearing, t: f64, start: &mut Self::Start) -> Left;

    /// Whether marks that leave at most `value` at the offset t also clear it at exactly that value.
    fn is_kept(&self, marks: &Clearing, t: f64, value: f64) -> bool;
}

/// The length whose value is the least for passes s apart, which marks of one kind in `alone` clear, or marks of one kind
/// a part and those of another, which can be `other`, the rest; `None` if there is none, and where a search does not
/// settle, because passes or marks hardly overlap.
pub(super) fn solve(values: &impl Value, s: f64, alone: &[Clearing], other: Option<Clearing>) -> Option<f64> {
    let mut best = None::<(Least, &Clearing)>;
    for marks in alone {
        let least = least(values, s, [marks; 2])?;
        if best.is_none_or(|(best, _)| least.value < best.value) {
            best = Some((least, marks));
        }
    }
    let best = best?;
    let mut value = best.0.value;
    for other in alone.iter().chain(&other).filter(|other| *other != best.1) {
        value = value.min(least_with(values, s, best, other)?);
    }
    Some(value.abs()).filter(|length| length.is_finite())
}

/// The least of passes of which one edge is cleared by `marks`, whose own least is `best`, and one by `other`; infinite
/// if `other` clears neither edge.
fn least_with(values: &impl Value, s: f64, (best, marks): (Least, &Clearing), other: &Clearing) -> Option<f64> {
    let is_less = |t: f64| matches!(values.left(other, t, &mut values.start()), Left::At { value, .. } if value < best.value);
    let pair = if is_less(best.t) {
        [other, marks]
    } else if is_less(best.t - s) {
        [marks, other]
    } else {
        return Some(f64::INFINITY);
    };
    // The two intervals meet from this value on.
    let meeting = least(values, 0.0, pair)?;
    Some(least(values, s, pair)?.value.max(meeting.value))
}

/// The least of the greater of what two passes s apart leave at one place, the near one at the offset t and the far one
/// at t - s.
///
/// The tangents of both passes at one place, and those at both ends of the bracket, meet at a lower bound. The search
/// goes on where they meet, and ends when the bound is reached.
fn least(values: &impl Value, s: f64, marks: [&Clearing; 2]) -> Option<Least> {
    let is_kept = |least: &Least| values.is_kept(marks[0], least.t, least.value) && values.is_kept(marks[1], least.t - s, least.value);
    searched_least(values, s, marks).filter(|least| least.value.is_infinite() || is_kept(least))
}

/// The same, although one of the passes may leave more where the other leaves this value.
fn searched_least(values: &impl Value, s: f64, marks: [&Clearing; 2]) -> Option<Least> {
    let (mut near, mut far) = (values.start(), values.start());
    let mut reach = s + values.reach();
    let mut t = s / 2.0;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut falling, mut rising) = (None::<Tangent>, None::<Tangent>);
    let mut best = None::<Least>;
    let mut bound = f64::NEG_INFINITY;
    let mut gaps = [f64::INFINITY; 3];
    // The last places where the far and where the near pass leaves more, and by how much the near pass's slope is greater
    // there.
    let mut lasts = [None::<(f64, f64)>; 2];
    for _ in 0..MOST_STEPS {
        let sides = [values.left(marks[0], t, &mut near), values.left(marks[1], t - s, &mut far)];
        let mut next = f64::NAN;
        match sides {
            [Left::At { value: near, by_side: near_slope }, Left::At { value: far, by_side: far_slope }] => {
                let (value, slope) = if near >= far { (near, near_slope) } else { (far, far_slope) };
                if best.is_none_or(|best| value < best.value) {
                    best = Some(Least { value, t });
                }
                let tangent = Tangent { t, value, slope };
                if slope > 0.0 {
                    (high, rising) = (t, Some(tangent));
                } else if slope < 0.0 {
                    (low, falling) = (t, Some(tangent));
                } else {
                    return Some(Least { value, t });
                }
                if near_slope > 0.0 && far_slope < 0.0 {
                    let (near, far) = (Tangent { t, value: near, slope: near_slope }, Tangent { t, value: far, slope: far_slope });
                    let meeting = far.meets(&near);
                    bound = bound.max(meeting.value);
                    // Where the round begins or a flat ends, a value grows with the square of the distance from there, which
                    // tangents only halve. The change of the slope since the last place on the same side shows it. Where the
                    // parabola has no root, the step is twice that of the tangent.
                    let (excess, steepness) = (near.value - far.value, near.slope - far.slope);
                    let last = lasts[usize::from(excess > 0.0)].replace((t, steepness));
                    let bend = last.map_or(0.0, |(last_t, last_steepness)| (steepness - last_steepness) / (t - last_t));
                    let root = (steepness * steepness - 2.0 * bend * excess).max(0.0).sqrt();
                    next = t - 2.0 * excess / (steepness + root);
                    gaps = [gaps[1], gaps[2], value - meeting.value];
                }
            }
            [Left::Unknown, _] | [_, Left::Unknown] => return None,
            [Left::Beyond { side: near, .. }, Left::Beyond { side: far, .. }] if near > far => {
                return Some(Least { value: f64::INFINITY, t });
            }
            [Left::Beyond { side, step }, _] | [_, Left::Beyond { side, step }] => {
                next = t + INTO_SECTION * step;
                if side > 0.0 {
                    (high, rising) = (t, None);
                } else {
                    (low, falling) = (t, None);
                }
            }
        }
        if let (Some(falling), Some(rising)) = (falling, rising) {
            let meeting = falling.meets(&rising);
            bound = bound.max(meeting.value);
            if !(next > low && next < high) {
                next = meeting.t;
            }
        }
        // Where the other pass ceases to clear, a tangent of one bounds the value up to there.
        let bounds = [rising.map(|rising| rising.at(low)), falling.map(|falling| falling.at(high))];
        bound = bounds.into_iter().flatten().fold(bound, f64::max);
        if best.is_some_and(|best| best.value - bound <= CLOSE * best.value.abs()) {
            return best;
        }
        let is_open = low == f64::NEG_INFINITY || high == f64::INFINITY;
        let width = high - low;
        if !is_open && width <= 2.0 * f64::EPSILON * low.abs().max(high.abs()) {
            break;
        }
        let is_slow = gaps[2] > 0.5 * gaps[0];
        if is_slow {
            gaps = [f64::INFINITY; 3];
        }
        t = if next > low && next < high && !is_slow && (!is_open || (next - t).abs() <= 4.0 * reach) {
            next
        } else if is_open {
            reach *= 2.0;
            if low == f64::NEG_INFINITY { t - reach / 2.0 } else { t + reach / 2.0 }
        } else {
            f64::midpoint(low, high)
        };
        if t.abs() > FURTHEST {
            break;
        }
    }
    best.filter(|best| best.value - bound <= SETTLED * best.value.abs())
}
