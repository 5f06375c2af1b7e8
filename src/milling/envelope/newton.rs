//! Newton's method on all unknowns of the ridge at once: quick, and without an answer unless the outcome is proved.
//!
//! The ridge is where four places lie on the body: the ends of two chords along the feed, both as long as the marks are apart (f), lying
//! the step-over (s) apart, at one height p. Any of p, s and f can be sought when the others are given: the body's section at a height
//! never shrinks with the height, so the largest s, or f, that the section at a tolerance holds is the largest one that keeps the
//! tolerance.
//!
//! What proves the outcome is convexity. The distance to the body is nowhere less than a tangent, hence the greatest of four distances
//! nowhere less than a mean of their tangents. With weights that make the mean independent of where the chords lie, its root bounds what
//! is sought on one side; four places that are not outside the body bound it on the other. Where both bounds meet within a few
//! roundings, it does not matter how the search came there.

use super::body::{Body, Distance};
use super::ridge::{Place, balance};
use super::root::{Slope, rising_root};

/// The height of the ridge, the step-over and the distance of the marks, in mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lengths {
    pub(super) level: f64,
    pub(super) step_over: f64,
    pub(super) mark_spacing: f64,
}

/// Which of the three is sought.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sought {
    Level,
    StepOver,
    MarkSpacing,
}

/// Quadratic convergence takes four to six steps from a guess that is right to a few percent, and some more from elsewhere.
const MOST_STEPS: usize = 24;

/// The ridge on the body, of whose lengths the sought one is only a guess; `None` unless the outcome is proved.
pub(super) fn solve(body: &Body, sought: Sought, mut lengths: Lengths) -> Option<Lengths> {
    let mut place = Place::start(body, lengths.step_over, lengths.mark_spacing);
    for _ in 0..MOST_STEPS {
        let s = lengths.step_over;
        let near = Chord::near(body, &mut place.x, place.t, &lengths);
        let far = Chord::near(body, &mut place.neighbour_x, place.t - s, &lengths);
        if !(near.by_side > 0.0 && far.by_side < 0.0) {
            // The chords have to lie on both sides of the deepest one; the change of slope between them tells about where that is.
            let aside = -s * f64::midpoint(near.by_side, far.by_side) / (near.by_side - far.by_side);
            if aside.is_nan() {
                return None;
            }
            let reach = s + lengths.mark_spacing;
            follow(&mut place, (&near, &far), aside.clamp(-reach, reach), Change::NONE);
            continue;
        }
        let share = balance(near.by_side, far.by_side);
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        let (value, by_height) = (mix(near.value, far.value), mix(near.by_height, far.by_height));
        if by_height >= 0.0 {
            return None;
        }
        let rounding = 16.0 * f64::EPSILON * lengths.level * by_height.abs();
        let proved = value.abs() <= rounding && near.furthest.max(far.furthest) <= rounding;
        let change = match sought {
            Sought::Level => Change { rise: (-value / by_height).max(-0.75 * lengths.level), ..Change::NONE },
            Sought::StepOver => Change { wider: bounded(value / ((1.0 - share) * far.by_side), s), ..Change::NONE },
            Sought::MarkSpacing => {
                Change { longer: bounded(-value / mix(near.by_spacing, far.by_spacing), lengths.mark_spacing), ..Change::NONE }
            }
        };
        let aside = -(near.value + near.by_height * change.rise + near.by_spacing * change.longer) / near.by_side;
        follow(&mut place, (&near, &far), aside.clamp(-s, s), change);
        lengths.level += change.rise;
        lengths.step_over += change.wider;
        lengths.mark_spacing += change.longer;
        if proved {
            return Some(lengths);
        }
    }
    None
}

/// By how much a step changes the lengths; all but one are 0.
#[derive(Debug, Clone, Copy)]
struct Change {
    rise: f64,
    wider: f64,
    longer: f64,
}

impl Change {
    const NONE: Self = Self { rise: 0.0, wider: 0.0, longer: 0.0 };
}

/// A change that leaves a quarter of the length at least and makes it four times as long at most: from far off a tangent may point below 0
/// or to the horizon. The level needs the former only, since no tangent leads above h.
fn bounded(change: f64, length: f64) -> f64 {
    change.clamp(-0.75 * length, 3.0 * length)
}

/// Moves the place by a step of t, and x of both chords as the step changes them.
fn follow(place: &mut Place, (near, far): (&Chord, &Chord), aside: f64, change: Change) {
    place.t += aside;
    place.x += near.shift.of(aside, change);
    place.neighbour_x += far.shift.of(aside - change.wider, change);
}

/// The greater of the distances of a chord's ends where it is least along the feed, to first order in the other unknowns.
struct Chord {
    value: f64,
    by_side: f64,
    by_height: f64,
    by_spacing: f64,
    /// The greater distance at x itself.
    furthest: f64,
    shift: Shift,
}

/// How far off x is, and how it follows when the other unknowns change.
#[derive(Default)]
struct Shift {
    off: f64,
    by_side: f64,
    by_height: f64,
    by_spacing: f64,
}

impl Shift {
    fn of(&self, aside: f64, change: Change) -> f64 {
        self.off + self.by_side * aside + self.by_height * change.rise + self.by_spacing * change.longer
    }
}

impl Chord {
    /// The chord at the offset t. Where a Newton's step ends at an x that tells next to nothing about the best one, `x` is searched for.
    fn near(body: &Body, x: &mut f64, t: f64, lengths: &Lengths) -> Self {
        let (p, s, f) = (lengths.level, lengths.step_over, lengths.mark_spacing);
        let (mut found, mut rising, mut falling) = (None, None, None);
        *x = rising_root(*x, s + f, 2.0 * f64::EPSILON * (s + f), |x| {
            let front = body.distance(x, t, p);
            let slope = if f == 0.0 {
                found = Self::point(&front).filter(|chord| front.value - chord.value <= 0.1 * p);
                *(if front.by_feed < 0.0 { &mut falling } else { &mut rising }) = Some(front);
                Slope { value: front.by_feed, derivative: front.bend }
            } else {
                let back = body.distance(x - f, t, p);
                found = (front.by_feed > 0.0 && back.by_feed < 0.0).then(|| Self::between(&front, &back));
                (rising, falling) = (Some(front), Some(back));
                Slope { value: front.value - back.value, derivative: front.by_feed - back.by_feed }
            };
            // A root ends the search.
            if found.is_some() { Slope { value: 0.0, ..slope } } else { slope }
        });
        found.unwrap_or_else(|| {
            let alone = || body.distance(*x, t, p);
            let (rising, falling) = (rising.or(falling).unwrap_or_else(alone), falling.or(rising).unwrap_or_else(alone));
            Self { shift: Shift::default(), ..Self::between(&rising, &falling) }
        })
    }

    /// The chord of no length, on the parabola that the distance is along the feed.
    fn point(at: &Distance) -> Option<Self> {
        if at.bend <= 0.0 {
            return None;
        }
        let off = -at.by_feed / at.bend;
        Some(Self {
            value: at.value + at.by_feed * off / 2.0,
            by_side: at.by_side + off * at.bend_to_side,
            by_height: at.by_height + off * at.bend_to_height,
            by_spacing: 0.0,
            furthest: at.value,
            shift: Shift { off, by_side: -at.bend_to_side / at.bend, by_height: -at.bend_to_height / at.bend, by_spacing: 0.0 },
        })
    }

    /// The chord on the tangents at its ends, the front where the distance rises along the feed and the back, f behind it, where it falls.
    fn between(front: &Distance, back: &Distance) -> Self {
        let steepening = front.by_feed - back.by_feed;
        let share = balance(front.by_feed, back.by_feed);
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        Self {
            value: mix(front.value, back.value),
            by_side: mix(front.by_side, back.by_side),
            by_height: mix(front.by_height, back.by_height),
            by_spacing: -(1.0 - share) * back.by_feed,
            furthest: front.value.max(back.value),
            shift: Shift {
                off: (back.value - front.value) / steepening,
                by_side: (back.by_side - front.by_side) / steepening,
                by_height: (back.by_height - front.by_height) / steepening,
                by_spacing: -back.by_feed / steepening,
            },
        }
    }
}
