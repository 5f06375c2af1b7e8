//! Heights on convex sections by nested searches, for contacts at which the fast search proves nothing.
//!
//! At an offset t from a pass, the height M(t) that its marks leave is the root of the distance c(t, p), a convex
//! function that falls with p. M is convex too, so that the height for a step-over s, the least of max(M(t), M(t - s)),
//! is bounded by tangents on both sides. Every search is of one convex function of one unknown, which takes a bounded
//! number of steps from any start.
//!
//! With runout a pass clears what either kind of marks clears (`runout`). Each kind has an interval of offsets, which
//! grows with the height. As soon as both meet, the pass clears their union, whose edges can be of different kinds.

use super::body::Body;
use super::chord::Accuracy;
use super::clearing::{Clearing, Row};
use super::section::FURTHEST;
use crate::quantity::Length;

/// The largest number of steps of each search: bisection down to rounding takes about 60.
const MOST_STEPS: usize = 80;

/// The relative error at which a search ends: some roundings.
const CLOSE: f64 = 1e-14;

/// The size of the last step of Newton's method, as a share of the height: the step squares the error.
const LAST_STEP: f64 = 1e-10;

/// The relative gap between a height and its lower bound up to which a search that cannot go on has an answer.
const SETTLED: f64 = 1e-10;

/// The size of a step, as a share of the height, under which a step that does not shrink is a rounding error.
const NOISE: f64 = 1e-6;

/// The factor by which a height shrinks at most in a step.
const SHRINKING: f64 = 1.0 / 64.0;

/// What a pass leaves at a lateral offset: a convex function of the offset.
#[derive(Debug, Clone, Copy)]
enum Left {
    /// The height and its slope.
    At { height: f64, by_side: f64 },
    /// The pass does not clear this offset at any height; 1 on its right side, -1 on its left side.
    Beyond(f64),
}

/// The least height that two passes leave, and the offset at which they do.
#[derive(Debug, Clone, Copy)]
struct Least {
    height: f64,
    t: f64,
}

/// A tangent of a height over the offset.
#[derive(Debug, Clone, Copy)]
struct Tangent {
    t: f64,
    height: f64,
    slope: f64,
}

impl Tangent {
    /// Where this tangent, which falls, meets one that rises.
    fn meets(&self, rising: &Self) -> Self {
        let steepening = rising.slope - self.slope;
        let t = (rising.slope * rising.t - self.slope * self.t - rising.height + self.height) / steepening;
        Self { t, height: self.height + self.slope * (t - self.t), slope: 0.0 }
    }
}

/// The search at one contact.
#[derive(Debug)]
pub(super) struct Nested<'a> {
    pub(super) body: &'a Body,
    /// The feed per tooth.
    pub(super) feed: f64,
    /// A guess of the height.
    pub(super) guess: f64,
}

impl Nested<'_> {
    /// The height for passes s apart, of which marks of each kind in `alone` have one and marks of the kind `other` clear
    /// at least a part; `None` where a search does not settle, because passes or marks hardly overlap.
    pub(super) fn height(&self, s: f64, alone: &[Clearing], other: Option<Clearing>) -> Option<f64> {
        let mut best = None::<(Least, &Clearing)>;
        for marks in alone {
            let least = self.least(s, [marks; 2])?;
            if best.is_none_or(|(best, _)| least.height < best.height) {
                best = Some((least, marks));
            }
        }
        let best = best?;
        let mut height = best.0.height;
        for other in alone.iter().chain(&other).filter(|other| *other != best.1) {
            height = height.min(self.least_with(s, best, other)?);
        }
        Some(height)
    }

    /// The least of passes of which one edge is cleared by `marks`, whose own least is `best`, and one by `other`; infinite
    /// if `other` clears neither edge.
    fn least_with(&self, s: f64, (best, marks): (Least, &Clearing), other: &Clearing) -> Option<f64> {
        let is_less = |t: f64| matches!(self.left(other, t, &mut self.start()), Left::At { height, .. } if height < best.height);
        let pair = if is_less(best.t) {
            [other, marks]
        } else if is_less(best.t - s) {
            [marks, other]
        } else {
            return Some(f64::INFINITY);
        };
        // The two intervals meet from this height on.
        let meeting = self.least(0.0, pair)?;
        Some(self.least(s, pair)?.height.max(meeting.height))
    }

    /// The least of the greater of what two passes s apart leave at one place, the near one at the offset t and the far one
    /// at t - s.
    ///
    /// The tangents of both passes at one place, and those at both ends of the bracket, meet at a lower bound. The search
    /// goes on where they meet, and ends when the bound is reached.
    fn least(&self, s: f64, marks: [&Clearing; 2]) -> Option<Least> {
        let (mut near, mut far) = (self.start(), self.start());
        let mut reach = s + near.x[0];
        let mut t = s / 2.0;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut falling, mut rising) = (None::<Tangent>, None::<Tangent>);
        let mut best = None::<Least>;
        let mut bound = f64::NEG_INFINITY;
        let mut gaps = [f64::INFINITY; 3];
        for _ in 0..MOST_STEPS {
            let sides = [self.left(marks[0], t, &mut near), self.left(marks[1], t - s, &mut far)];
            let mut next = f64::NAN;
            match sides {
                [Left::At { height: near, by_side: near_slope }, Left::At { height: far, by_side: far_slope }] => {
                    let (height, slope) = if near >= far { (near, near_slope) } else { (far, far_slope) };
                    if best.is_none_or(|best| height < best.height) {
                        best = Some(Least { height, t });
                    }
                    let tangent = Tangent { t, height, slope };
                    if slope > 0.0 {
                        (high, rising) = (t, Some(tangent));
                    } else if slope < 0.0 {
                        (low, falling) = (t, Some(tangent));
                    } else {
                        return Some(Least { height, t });
                    }
                    if near_slope > 0.0 && far_slope < 0.0 {
                        let near = Tangent { t, height: near, slope: near_slope };
                        let meeting = Tangent { t, height: far, slope: far_slope }.meets(&near);
                        bound = bound.max(meeting.height);
                        // Beyond a line where the round begins a height grows with the square of the step, which Newton's
                        // step only halves.
                        let gap = height - meeting.height;
                        let halves = gap > 0.2 * gaps[2] && gap < 0.3 * gaps[2];
                        next = if halves { t + 2.0 * (meeting.t - t) } else { meeting.t };
                        gaps = [gaps[1], gaps[2], gap];
                    }
                }
                [Left::Beyond(near), Left::Beyond(far)] if near > far => return None,
                [Left::Beyond(side), _] | [_, Left::Beyond(side)] => {
                    if side > 0.0 {
                        (high, rising) = (t, None);
                    } else {
                        (low, falling) = (t, None);
                    }
                }
            }
            if let (Some(falling), Some(rising)) = (falling, rising) {
                let meeting = falling.meets(&rising);
                bound = bound.max(meeting.height);
                if !(next > low && next < high) {
                    next = meeting.t;
                }
            }
            if best.is_some_and(|best| best.height - bound <= CLOSE * best.height) {
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
        best.filter(|best| best.height - bound <= SETTLED * best.height)
    }

    /// The start of the first search at an offset.
    fn start(&self) -> Start {
        Start { height: self.guess, x: [self.feed / 2.0; 2] }
    }

    /// The height that marks leave at the offset t.
    ///
    /// The distance is convex and falls with the height, so that Newton's method rises to its root from below.
    fn left(&self, marks: &Clearing, t: f64, start: &mut Start) -> Left {
        let Self { body, feed, .. } = *self;
        let least = f64::EPSILON.powi(2) * body.reach();
        let mut p = start.height.max(least);
        let mut x = start.x;
        let mut last = f64::INFINITY;
        let mut is_below = false;
        let mut side = 1.0_f64.copysign(t);
        for _ in 0..MOST_STEPS {
            let chord = marks.search(body, &mut x, Row { t, p, feed }, Accuracy::full(p), t.abs() + marks.spacing(feed) + p).chord;
            if chord.by_height >= 0.0 {
                // The section shrinks again over the axis beside a wall.
                if is_below || p <= least {
                    break;
                }
                p = (SHRINKING * p).max(least);
                continue;
            }
            side = chord.by_side.signum();
            let rise = -chord.value / chord.by_height;
            let is_rounding = rise.abs() <= LAST_STEP * p || rise.abs() <= NOISE * p && rise.abs() >= 0.5 * last;
            if is_rounding || p <= least && rise <= 0.0 {
                *start = Start { height: p, x };
                return Left::At { height: (p + rise).max(0.0), by_side: -chord.by_side / chord.by_height };
            }
            if p + rise > 2.0 * Length::LARGEST {
                break;
            }
            is_below |= rise > 0.0;
            last = rise.abs();
            p = (p + rise).max(SHRINKING * p).max(least);
        }
        Left::Beyond(side)
    }
}

/// The height, and the front ends of the chords, from which the next search at an offset begins: those of the last one.
#[derive(Debug, Clone, Copy)]
struct Start {
    height: f64,
    x: [f64; 2],
}
