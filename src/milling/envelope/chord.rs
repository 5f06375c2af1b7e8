//! The chord between two neighbouring tooth marks of one pass, at a lateral offset and a height.

use super::body::{Body, Distance};

/// Two tooth marks of one pass: their distance along the feed, and how much less deep each is than that of the deepest
/// tooth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Marks {
    pub(super) spacing: f64,
    pub(super) front_drop: f64,
    pub(super) back_drop: f64,
}

impl Marks {
    /// Marks of equally deep teeth.
    pub(super) fn even(spacing: f64) -> Self {
        Self { spacing, front_drop: 0.0, back_drop: 0.0 }
    }
}

/// The minimum over x of the greater of two distances to the body: that of (x, t, p - front drop) and that of (x - f,
/// t, p - back drop). It is at most 0 if the section at the height p contains a chord of the length f at the offset t.
/// With its derivatives, to first order in x.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chord {
    pub(super) value: f64,
    pub(super) by_side: f64,
    pub(super) by_height: f64,
    pub(super) by_spacing: f64,
    /// The greater of the two distances at x itself.
    pub(super) furthest: f64,
    /// The steepest slope of the two along the feed.
    pub(super) steepest: f64,
    pub(super) shift: Shift,
}

/// The error of x, and the derivatives of x by the other unknowns.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shift {
    pub(super) off: f64,
    pub(super) by_side: f64,
    pub(super) by_height: f64,
    pub(super) by_spacing: f64,
}

impl Shift {
    /// The shift of x if the chord moves to the side by `aside`, up by `rise`, and becomes longer by `longer`.
    pub(super) fn of(&self, aside: f64, rise: f64, longer: f64) -> f64 {
        self.off + self.by_side * aside + self.by_height * rise + self.by_spacing * longer
    }
}

/// The tolerance of a search: the difference between the value at x and the least value, as a share of the height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    crossing: f64,
    round: f64,
    corner: f64,
}

impl Accuracy {
    /// The accuracy for Newton's method on all unknowns at once, which also corrects x.
    pub(super) fn rough(p: f64) -> Self {
        Self { crossing: 0.1 * p, round: 0.1 * p, corner: 1e-15 * p }
    }

    /// The accuracy for a value to the rounding of p. At a crossing, the error of the value is the square of that of x
    /// times the second derivative. On a round, the parabola is accurate only near its minimum, because the second derivative jumps where flat,
    /// corner and side meet.
    pub(super) fn full(p: f64) -> Self {
        Self { crossing: 1e-9 * p, round: 1e-14 * p, corner: 1e-15 * p }
    }
}

/// The largest number of steps: halving a bracket of any possible length down to rounding takes about 60, and growing
/// it to that length about 40.
const MOST_STEPS: usize = 120;

impl Chord {
    /// Searches the chord at the offset t and the height p to an accuracy. `x` is the start, and afterwards the end, of
    /// the search.
    ///
    /// The greater of two convex functions is convex, and the sign of its slope brackets its minimum. The steps are
    /// Newton's: to the minimum of the greater function, or to the point at which both are equal, whichever comes
    /// first. If these steps do not shrink the bracket, the tangents at its ends are intersected, which finds the
    /// corner of a sharp edge at once, or the bracket is halved.
    #[inline]
    pub(super) fn search(body: &Body, x: &mut f64, t: f64, p: f64, marks: &Marks, accuracy: Accuracy, mut reach: f64) -> Self {
        let f = marks.spacing;
        let alone = f == 0.0 && marks.front_drop - marks.back_drop == 0.0;
        let (mut falling, mut rising) = (None::<(f64, Distance)>, None::<(f64, Distance)>);
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut length = f64::INFINITY;
        let mut best = None::<(f64, Self)>;
        for step in 0..MOST_STEPS {
            let front = body.distance(*x, t, p - marks.front_drop);
            let back = if alone { front } else { body.distance(*x - f, t, p - marks.back_drop) };
            let (is_front, active) = if front.value >= back.value { (true, front) } else { (false, back) };
            if active.by_feed == 0.0 {
                // The flat of the cutter, or its side along a wall.
                return Self::flat(&active);
            }
            let crossing = !alone && front.by_feed > 0.0 && back.by_feed < 0.0;
            let to_least = -active.by_feed / active.bend;
            let is_round = active.bend > 0.0;
            let to_crossing = (back.value - front.value) / (front.by_feed - back.by_feed);
            let by_crossing = crossing && !(is_round && to_least.abs() < to_crossing.abs());
            if by_crossing {
                let chord = Self::between(&front, &back);
                // The tangents err by the square of the distance from the crossing, which is far off where they are
                // nearly level, as those of marks close together.
                let error = front.bend.max(back.bend) * chord.shift.off * chord.shift.off;
                if chord.furthest - chord.value <= accuracy.crossing && error <= accuracy.round {
                    return chord;
                }
                best = Some((*x, chord));
            } else if is_round {
                let chord = Self::point(&active, if is_front { 0.0 } else { 1.0 });
                if chord.furthest - chord.value <= accuracy.round {
                    return chord;
                }
                best = Some((*x, chord));
            }
            if active.by_feed > 0.0 {
                (high, rising) = (*x, Some((*x, active)));
            } else {
                (low, falling) = (*x, Some((*x, active)));
            }
            if let (Some(falling), Some(rising)) = (falling, rising) {
                if !crossing {
                    // At a corner the value lies between that of the tangents and the active one; on a round, the error
                    // is quadratic.
                    let chord = Self::between_places(&rising, &falling);
                    best = Some((*x, chord));
                    if active.value - chord.value <= accuracy.corner {
                        return Self { furthest: active.value, ..chord };
                    }
                }
                if high - low <= 2.0 * f64::EPSILON * low.abs().max(high.abs()).max(f64::MIN_POSITIVE) {
                    break;
                }
            }
            let newton = *x
                + if by_crossing {
                    to_crossing
                } else if is_round {
                    to_least
                } else {
                    f64::NAN
                };
            let open = low == f64::NEG_INFINITY || high == f64::INFINITY;
            let next = if newton > low && newton < high && (newton - *x).abs() < if open { reach } else { 0.6 * length } {
                newton
            } else if open {
                reach *= 2.0;
                *x - (reach / 2.0).copysign(active.by_feed)
            } else {
                let tangents = match (falling, rising) {
                    (Some((at, falling)), Some((rising_at, rising))) => {
                        (rising.by_feed * rising_at - falling.by_feed * at - rising.value + falling.value)
                            / (rising.by_feed - falling.by_feed)
                    }
                    _ => f64::NAN,
                };
                if step % 3 != 2 && tangents > low && tangents < high { tangents } else { f64::midpoint(low, high) }
            };
            if next - *x == 0.0 {
                break;
            }
            length = (next - *x).abs();
            *x = next;
        }
        let (at, chord) = best.unwrap_or_else(|| (*x, Self::flat(&body.distance(*x, t, p - marks.front_drop))));
        *x = at;
        chord
    }

    /// The chord of a distance that does not change along the feed.
    fn flat(at: &Distance) -> Self {
        Self {
            value: at.value,
            by_side: at.by_side,
            by_height: at.by_height,
            by_spacing: 0.0,
            furthest: at.value,
            steepest: at.by_feed.abs(),
            shift: Shift::default(),
        }
    }

    /// The chord at the minimum of one distance while the other is smaller, by the parabola of that distance along the
    /// feed. `back` is 1 for the point f behind x, otherwise 0.
    fn point(at: &Distance, back: f64) -> Self {
        let off = -at.by_feed / at.bend;
        Self {
            value: at.value + at.by_feed * off / 2.0,
            by_side: at.by_side + off * at.bend_to_side,
            by_height: at.by_height + off * at.bend_to_height,
            by_spacing: 0.0,
            furthest: at.value,
            steepest: at.by_feed.abs(),
            shift: Shift { off, by_side: -at.bend_to_side / at.bend, by_height: -at.bend_to_height / at.bend, by_spacing: back },
        }
    }

    /// The chord by the tangents at its ends: at the front the distance rises along the feed, and at the back, f behind
    /// it, it falls.
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
            steepest: front.by_feed.max(-back.by_feed),
            shift: Shift {
                off: (back.value - front.value) / steepening,
                by_side: (back.by_side - front.by_side) / steepening,
                by_height: (back.by_height - front.by_height) / steepening,
                by_spacing: -back.by_feed / steepening,
            },
        }
    }

    /// The chord by the tangents at two points, one where the distance rises along the feed and one where it falls.
    /// Their balanced mean does not depend on x. It is a lower bound of the minimum, and the minimum itself at the
    /// corner of a sharp edge.
    fn between_places((rising_x, rising): &(f64, Distance), (falling_x, falling): &(f64, Distance)) -> Self {
        let share = balance(rising.by_feed, falling.by_feed);
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        Self {
            value: mix(rising.value, falling.value) - share * rising.by_feed * (rising_x - falling_x),
            by_side: mix(rising.by_side, falling.by_side),
            by_height: mix(rising.by_height, falling.by_height),
            by_spacing: 0.0,
            furthest: rising.value.max(falling.value),
            steepest: rising.by_feed.max(-falling.by_feed),
            shift: Shift::default(),
        }
    }
}

/// The weight of a rising slope for which the weighted mean with a falling slope is 0. If both slopes are 0, any weight
/// is valid.
pub(super) fn balance(rising: f64, falling: f64) -> f64 {
    let whole = rising - falling;
    if whole > 0.0 { (-falling / whole).clamp(0.0, 1.0) } else { 0.5 }
}
