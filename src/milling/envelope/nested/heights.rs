//! The height that marks of a feed per tooth leave at an offset.

use super::{Left, MOST_STEPS, NOISE, Value};
use crate::milling::envelope::body::Body;
use crate::milling::envelope::chord::Accuracy;
use crate::milling::envelope::clearing::{Clearing, Row};
use crate::quantity::Length;

/// The size of the last step of Newton's method, as a share of the height: the step squares the error.
const LAST_STEP: f64 = 1e-10;

/// The factor by which a height shrinks at most in a step.
const SHRINKING: f64 = 1.0 / 64.0;

/// The share of a height by which it may be too low for a chord to count as inside.
const KEPT: f64 = 1e-8;

/// The heights at one contact.
#[derive(Debug)]
pub(in crate::milling::envelope) struct Heights<'a> {
    pub(in crate::milling::envelope) body: &'a Body,
    /// The feed per tooth.
    pub(in crate::milling::envelope) feed: f64,
    /// A guess of the height.
    pub(in crate::milling::envelope) guess: f64,
}

/// The height, and the front ends of the chords, from which the next search at an offset begins: those of the last one.
#[derive(Debug, Clone, Copy)]
pub(in crate::milling::envelope) struct Start {
    height: f64,
    x: [f64; 2],
}

impl Value for Heights<'_> {
    type Start = Start;

    fn start(&self) -> Start {
        Start { height: self.guess, x: [self.feed / 2.0; 2] }
    }

    fn reach(&self) -> f64 {
        self.feed / 2.0
    }

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
                return Left::At { value: (p + rise).max(0.0), by_side: -chord.by_side / chord.by_height };
            }
            if p + rise > 2.0 * Length::LARGEST {
                break;
            }
            is_below |= rise > 0.0;
            last = rise.abs();
            p = (p + rise).max(SHRINKING * p).max(least);
        }
        Left::Beyond { side, step: f64::NAN }
    }

    /// Beside a wall the section shrinks again over the axis.
    fn is_kept(&self, marks: &Clearing, t: f64, value: f64) -> bool {
        let Self { body, feed, .. } = *self;
        let reach = t.abs() + marks.spacing(feed) + value;
        let row = Row { t, p: value, feed };
        let chord = marks.search(body, &mut [feed / 2.0; 2], row, Accuracy::full(value), reach).chord;
        chord.value <= KEPT * value * chord.by_height.abs() + 16.0 * f64::EPSILON * (body.reach() + reach)
    }
}
