//! Newton's method on all unknowns of the ridge from a place near it, on surfaces where the section need not be convex.
//!
//! Each end of a chord is bounded by smooth functions: the distances to the body's parts and to the overhang, and the
//! distance where the line from the contact to the end is highest. A chord is where the greatest of them is least along
//! the feed, that is, where one that rises along the feed meets one that falls, or where the only one is lowest. Each
//! step takes their tangents. The result is a ridge near the start; the section's outline shows whether there is
//! another one.

use super::body::{Body, Distance};
use super::chord::{Chord, Marks, Shift, balance};
use super::clearing::{Clearing, Held};
use super::newton::{COARSE, Change, Lengths, Place, Ridge, Sought, bounded, follow};
use crate::quantity::Length;

/// Quadratic convergence takes four to six steps from a start that is right to a few percent. Where the round begins a
/// distance grows with the square of the step beyond that line, so that steps only halve it.
const MOST_STEPS: usize = 20;
const MOST_STEPS_CONVEX: usize = 48;

/// The slope of the distance over the mark spacing from which on a small step is a small error.
const SLOPED: f64 = 0.01;

/// A step over this share of the one before is halved from the second third of the steps on: the chords alternate
/// between two pairs of bounds.
const SLOW: f64 = 0.7;

/// The size of a step, as a share of the lengths, after which the next one is a rounding: its square.
const LAST_STEP: f64 = 1e-8;

/// The distances outside of the bounds at the last step, as a share of the height.
const OUTSIDE: f64 = 1e-7;

/// The rounding errors of a height, as a share of it: some hundred roundings.
const ROUNDING: f64 = 2e-14;

/// The slope along the feed up to which a bound counts as level: some roundings.
const LEVEL: f64 = 2e-17;

/// A chord's front and back, each with the body, its side and its floor, the overhang and the top of the flat.
const MOST_BOUNDS: usize = 10;

/// A bound of a chord, to first order.
#[derive(Debug, Clone, Copy)]
struct Bound {
    at: Distance,
    by_spacing: f64,
    is_front: bool,
}

/// The bounds of a chord.
#[derive(Debug)]
struct Bounds {
    all: [Option<Bound>; MOST_BOUNDS],
    count: usize,
}

impl Bounds {
    fn of(body: &Body, x: f64, t: f64, p: f64, marks: &Marks) -> Self {
        let mut bounds = Self { all: [None; MOST_BOUNDS], count: 0 };
        body.bounds(x, t, p - marks.front_drop, |at| bounds.push(Bound { at, by_spacing: 0.0, is_front: true }));
        if !is_alone(marks) {
            body.bounds(x - marks.spacing, t, p - marks.back_drop, |at| {
                bounds.push(Bound { at, by_spacing: -at.by_feed, is_front: false });
            });
        }
        bounds
    }

    fn push(&mut self, bound: Bound) {
        if let Some(place) = self.all.get_mut(self.count) {
            *place = Some(bound);
            self.count += 1;
        }
    }

    fn iter(&self) -> impl Iterator<Item = &Bound> + Clone {
        self.all.iter().flatten()
    }

    /// The chord at which the greatest of the bounds' tangents is least, which is the greatest of the meeting points of
    /// a rising and a falling one; `None` where all rise or all fall and none has a lowest place.
    fn chord(&self) -> Option<Chord> {
        let furthest = self.iter().map(|bound| bound.at.value).fold(f64::NEG_INFINITY, f64::max);
        let rising = self.iter().filter(|bound| bound.at.by_feed >= 0.0);
        let falling = self.iter().filter(|bound| bound.at.by_feed < 0.0);
        let pairs = rising.flat_map(|rising| falling.clone().map(move |falling| (rising, falling)));
        let meeting = |(rising, falling): &(&Bound, &Bound)| {
            let share = balance(rising.at.by_feed, falling.at.by_feed);
            share * rising.at.value + (1.0 - share) * falling.at.value
        };
        let pair = pairs.max_by(|one, other| meeting(one).total_cmp(&meeting(other)));
        let highest = self.iter().max_by(|one, other| one.at.value.total_cmp(&other.at.value))?;
        // Where the highest bound is level along the feed, no place is lower: on the flat or the side.
        if highest.at.by_feed.abs() <= LEVEL {
            let flat = Bound { at: Distance { by_feed: 0.0, bend: 1.0, bend_to_side: 0.0, bend_to_height: 0.0, ..highest.at }, ..*highest };
            return Some(point(&flat, 0.0, furthest));
        }
        if highest.at.bend > 0.0 {
            let off = -highest.at.by_feed / highest.at.bend;
            let lowest = highest.at.value + highest.at.by_feed * off / 2.0;
            let there = |bound: &Bound, off: f64| bound.at.value + (bound.at.by_feed + 0.5 * bound.at.bend.max(0.0) * off) * off;
            let is_higher = |bound: &&Bound| !std::ptr::eq(*bound, highest) && there(bound, off) > lowest;
            let slopes_alike = |bound: &Bound| bound.is_front != highest.is_front && bound.at.by_feed * highest.at.by_feed > 0.0;
            // A bound of the other end that slopes the same way is met between the lowest places of both.
            let meeting = self.iter().filter(is_higher).find(|bound| slopes_alike(bound)).map(|bound| {
                let off = (bound.at.value - highest.at.value) / (highest.at.by_feed - bound.at.by_feed);
                // Both slope the same way here, so that this is not the place itself.
                Chord { value: there(highest, off), ..point(highest, off, f64::INFINITY) }
            });
            let is_met = self.iter().filter(is_higher).any(|bound| !slopes_alike(bound));
            if pair.is_none() || !is_met {
                return Some(meeting.unwrap_or_else(|| point(highest, off, furthest)));
            }
        }
        pair.map(|(rising, falling)| between(rising, falling, furthest))
    }
}

/// Whether the marks are one and the same.
fn is_alone(marks: &Marks) -> bool {
    marks.spacing == 0.0 && marks.front_drop - marks.back_drop == 0.0
}

/// The chord where a bound is lowest along the feed, `off` ahead.
fn point(Bound { at, is_front, .. }: &Bound, off: f64, furthest: f64) -> Chord {
    Chord {
        value: at.value + at.by_feed * off / 2.0,
        by_side: at.by_side + off * at.bend_to_side,
        by_height: at.by_height + off * at.bend_to_height,
        by_spacing: 0.0,
        furthest,
        steepest: at.by_feed.abs(),
        shift: Shift {
            off,
            by_side: -at.bend_to_side / at.bend,
            by_height: -at.bend_to_height / at.bend,
            by_spacing: if *is_front { 0.0 } else { 1.0 },
        },
    }
}

/// The chord where a rising and a falling bound meet.
fn between(rising: &Bound, falling: &Bound, furthest: f64) -> Chord {
    let share = balance(rising.at.by_feed, falling.at.by_feed);
    let steepening = rising.at.by_feed - falling.at.by_feed;
    let mix = |of: &dyn Fn(&Bound) -> f64| share * of(rising) + (1.0 - share) * of(falling);
    let change = |of: &dyn Fn(&Bound) -> f64| (of(falling) - of(rising)) / steepening;
    Chord {
        value: mix(&|bound| bound.at.value),
        by_side: mix(&|bound| bound.at.by_side),
        by_height: mix(&|bound| bound.at.by_height),
        by_spacing: mix(&|bound| bound.by_spacing),
        furthest,
        steepest: rising.at.by_feed.max(-falling.at.by_feed),
        shift: Shift {
            off: change(&|bound| bound.at.value),
            by_side: change(&|bound| bound.at.by_side),
            by_height: change(&|bound| bound.at.by_height),
            by_spacing: change(&|bound| bound.by_spacing),
        },
    }
}

/// The ridge near a place, whose near and far edges are cleared by marks of their own; `None` where the steps do not
/// converge.
pub(super) fn solve(body: &Body, sought: Sought, mut lengths: Lengths, mut place: Place, marks: [Clearing; 2]) -> Option<Ridge> {
    let edge = |marks: &Clearing, x: &[f64; 2], t: f64, lengths: &Lengths| -> Option<Held> {
        marks.held(lengths.mark_spacing, |i, marks| Bounds::of(body, x[i], t, lengths.level, marks).chord())
    };
    // The offsets of near chords that lie, with the far one, on the left and on the right of the deepest chord, with the
    // distance there and its slope.
    let (mut on_left, mut on_right) = (None::<[f64; 3]>, None::<[f64; 3]>);
    let most_steps = if body.is_concave() || matches!(sought, Sought::Level) { MOST_STEPS } else { MOST_STEPS_CONVEX };
    let (mut last_size, mut last_near) = (f64::INFINITY, f64::INFINITY);
    for step in 0..most_steps {
        let Lengths { level, step_over, mark_spacing } = lengths;
        let near_held = edge(&marks[0], &place.x, place.t, &lengths)?;
        let far_held = edge(&marks[1], &place.neighbour_x, place.t - step_over, &lengths)?;
        let (near, far) = (&near_held.chord, &far_held.chord);
        if !(near.by_side > 0.0 && far.by_side < 0.0) {
            let slope = f64::midpoint(near.by_side, far.by_side);
            let here = Some([place.t, near.value, slope]);
            if slope > 0.0 {
                on_right = here;
            } else {
                on_left = here;
            }
            let reach = step_over + mark_spacing;
            let aside = match (on_left, on_right) {
                (Some([left, left_value, falling]), Some([right, right_value, rising])) if left < right => {
                    // Where the slope vanishes by proportion, or at a corner where the tangents meet.
                    let t = if step % 2 == 0 {
                        left + (right - left) * balance(rising, falling)
                    } else {
                        (left_value - right_value + rising * right - falling * left) / (rising - falling)
                    };
                    t.clamp(left, right) - place.t
                }
                _ => {
                    let bend = (near.by_side - far.by_side) / step_over;
                    let aside = -slope / bend;
                    if bend > 0.0 && aside.abs() < reach { aside } else { -(0.1 * reach).copysign(slope) }
                }
            };
            if !aside.is_finite() {
                return None;
            }
            follow(&mut place, (&near_held, &far_held), aside, Change::NONE);
            continue;
        }
        (on_left, on_right) = (None, None);
        let share = balance(near.by_side, far.by_side);
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        let value = mix(near.value, far.value);
        let (by_height, by_spacing) = (mix(near.by_height, far.by_height), mix(near.by_spacing, far.by_spacing));
        let change = match sought {
            // Over the axis beside a wall the section shrinks with the height.
            Sought::Level if by_height >= 0.0 => return None,
            Sought::Level => Change { rise: bounded(-value / by_height, level), ..Change::NONE },
            Sought::StepOver => Change { wider: bounded(value / ((1.0 - share) * far.by_side), step_over), ..Change::NONE },
            Sought::MarkSpacing if by_spacing <= 0.0 => return None,
            Sought::MarkSpacing => Change { longer: bounded(-value / by_spacing, mark_spacing), ..Change::NONE },
        };
        let aside = -(near.value + near.by_height * change.rise + near.by_spacing * change.longer) / near.by_side;
        // Beyond the line where a round begins the distance grows with the square, which Newton's step only halves.
        let halves = near.value > 0.2 * last_near && near.value < 0.3 * last_near;
        last_near = near.value;
        let aside = if halves { 2.0 * aside } else { aside }.clamp(-step_over, step_over);
        let size = change.rise.abs() / level
            + (change.wider.abs() + aside.abs()) / step_over
            + if change.longer == 0.0 { 0.0 } else { change.longer.abs() / mark_spacing };
        if !size.is_finite() {
            return None;
        }
        let damping = if step > most_steps / 3 && size > SLOW * last_size { 0.5 } else { 1.0 };
        last_size = size;
        let change = Change { rise: damping * change.rise, wider: damping * change.wider, longer: damping * change.longer };
        let aside = damping * aside;
        let rounding = place.rounding(near, far, step_over + mark_spacing);
        follow(&mut place, (&near_held, &far_held), aside, change);
        lengths.level += change.rise;
        lengths.step_over += change.wider;
        lengths.mark_spacing += change.longer;
        if matches!(sought, Sought::StepOver) && lengths.step_over < Length::SMALLEST {
            // Passes side by side leave more than the height.
            return None;
        }
        let furthest = near.furthest.max(far.furthest);
        let height = level * by_height.abs();
        let is_rounding = value.abs().max(furthest) <= ROUNDING * height + rounding.min(COARSE * height);
        // On a convex section distances within their roundings prove the ridge. A mark spacing may be taken from
        // the last step's size, too, but not a height: the edge can be nearly upright.
        let is_sloped = matches!(sought, Sought::MarkSpacing) && by_spacing >= SLOPED;
        if is_rounding || (body.is_concave() || is_sloped) && size <= LAST_STEP && furthest <= OUTSIDE * level {
            return Some(Ridge { lengths, place, is_exact: is_rounding });
        }
    }
    None
}
