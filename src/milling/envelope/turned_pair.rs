//! The two neighbouring marks of a pass that are equally far from a place, each with a normal of its own.

use super::chord::balance;
use super::turning_marks::{MarkDistance, RidgePlace, TurningMarks};

/// The rounding errors of distances, as a share of the cutter's diameter. If the distance changes by no more between the
/// two marks of a pass, its slope determines where they are.
const ROUNDING: f64 = 1e-13;

/// Slopes along the feed up to this, a few rounding errors, count as zero: both marks are on the cutter's flat or side,
/// and may lie anywhere.
const STRAIGHT: f64 = 1e-14;

/// The share of a length by which the last step may change it. Newton's method squares that error, to 1e-14.
pub(super) const NEARLY: f64 = 1e-7;

/// The share of the lengths within which marks are near their place.
pub(super) const NEAR: f64 = 1e-4;

/// The largest number of steps of a search along the feed: it grows its bracket to the cutter's diameter and halves it
/// down to a rounding.
const MOST_CHORD_STEPS: usize = 100;

/// Two neighbouring marks of a pass, weighted so that the mean of their distances from the ridge's place does not depend
/// on where they are along the feed, with its derivatives; and how the marks move with the other unknowns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    pub(super) value: f64,
    pub(super) by_offset: f64,
    pub(super) by_place: f64,
    pub(super) by_height: f64,
    pub(super) by_spacing: f64,
    /// Whether both marks touch with the corner's round.
    pub(super) is_round: bool,
    /// The error of the value, by the parabola of the distance along the feed.
    pub(super) error: f64,
    pub(super) shift: Shift,
}

/// The error of the marks' place along the feed, and its derivatives by the other unknowns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    pub(super) off: f64,
    pub(super) by_offset: f64,
    pub(super) by_place: f64,
    pub(super) by_height: f64,
    pub(super) by_spacing: f64,
}

/// How far the marks of a pass are apart along the feed, and the rounding errors of their distances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spacing {
    pub(super) length: f64,
    rounding: f64,
}

impl Spacing {
    /// The spacing of marks `length` apart.
    pub(super) fn new(marks: &TurningMarks, length: f64) -> Self {
        Self { length, rounding: ROUNDING * marks.diameter() }
    }

    /// Whether the difference of both distances is a rounding error. The distance is then nearly a parabola.
    fn is_close(&self, front: &MarkDistance, back: &MarkDistance) -> bool {
        (front.by_behind - back.by_behind) * self.length <= self.rounding
    }

    /// The difference of the distances of front and back mark.
    fn difference(&self, front: &MarkDistance, back: &MarkDistance) -> f64 {
        if self.is_close(front, back) { 0.5 * (front.by_behind + back.by_behind) * self.length } else { front.value - back.value }
    }
}

impl Pair {
    /// The pair by the tangents at both marks. The distance falls from the back mark and rises to the front one.
    fn between(front: &MarkDistance, back: &MarkDistance, spacing: Spacing, is_straight: bool) -> Self {
        let steepening = front.by_behind - back.by_behind;
        let is_close = spacing.is_close(front, back);
        let share = if is_close { 0.5 } else { balance(front.by_behind, back.by_behind) };
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        let per_steepening = if is_straight { 0.0 } else { steepening.recip() };
        let shift = |one: f64, other: f64| (other - one) * per_steepening;
        let off = -spacing.difference(front, back) * per_steepening;
        let sag = if is_close && !is_straight { 0.5 * steepening / spacing.length * off * off } else { 0.0 };
        Self {
            value: mix(front.value, back.value) - sag,
            by_offset: mix(front.by_offset, back.by_offset),
            by_place: mix(front.by_place, back.by_place),
            by_height: mix(front.by_height, back.by_height),
            by_spacing: -(1.0 - share) * back.by_behind,
            is_round: front.is_round && back.is_round,
            error: 0.5 * steepening / spacing.length * off * off,
            shift: Shift {
                off,
                by_offset: shift(front.by_offset, back.by_offset),
                by_place: shift(front.by_place, back.by_place),
                by_height: shift(front.by_height, back.by_height),
                by_spacing: -back.by_behind * per_steepening,
            },
        }
    }

    /// The two marks of a pass that are equally far from the ridge's place. `behind` is the start,
    /// and afterwards the end, of the search.
    ///
    /// The difference of the distances of front and back mark changes its sign only there if the distance has one
    /// minimum along the feed.
    pub(super) fn search(
        marks: &TurningMarks,
        place: &RidgePlace,
        offset: f64,
        spacing: Spacing,
        behind: &mut f64,
        Accuracy { tolerance, near }: Accuracy,
    ) -> Option<Self> {
        let length = spacing.length;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut reach = 0.25 * (length + offset.abs());
        for _ in 0..MOST_CHORD_STEPS {
            let front = marks.distance(place, *behind, offset);
            let back = marks.distance(place, *behind - length, offset);
            let (difference, steepening) = (spacing.difference(&front, &back), front.by_behind - back.by_behind);
            if !difference.is_finite() {
                return None;
            }
            let is_straight = steepening.abs() <= STRAIGHT && difference.abs() <= STRAIGHT * length;
            let is_between = front.by_behind >= -STRAIGHT && back.by_behind <= STRAIGHT;
            // On the round, the distance over marks so close together is a parabola, which shows its lowest place from
            // beside it, too.
            let is_parabola = front.is_round && steepening > 0.0 && spacing.is_close(&front, &back);
            if is_straight || is_between || is_parabola {
                let pair = Self::between(&front, &back, spacing, is_straight);
                if is_straight || pair.error <= tolerance && pair.shift.off.abs() <= near * (length + offset.abs()) {
                    return Some(pair);
                }
            }
            if difference > 0.0 {
                high = *behind;
            } else {
                low = *behind;
            }
            let is_open = high == f64::INFINITY || low == f64::NEG_INFINITY;
            if !is_open && high - low <= 4.0 * f64::EPSILON * low.abs().max(high.abs()) {
                return is_between.then(|| Self::between(&front, &back, spacing, is_straight));
            }
            let newton = *behind - difference / steepening;
            *behind = if steepening > 0.0 && newton > low && newton < high && (newton - *behind).abs() <= reach {
                if !is_open {
                    reach = 0.5 * (high - low);
                }
                newton
            } else if is_open {
                reach *= 2.0;
                if reach > 8.0 * marks.diameter() {
                    return None;
                }
                *behind - (0.5 * reach).copysign(difference)
            } else {
                reach = 0.5 * (high - low);
                f64::midpoint(low, high)
            };
        }
        None
    }
}

/// The accuracy of a pair: the error of its value, and how near the marks are to their place, as a share of the lengths.
/// The parabola along the feed holds only near the marks, because a flat ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    tolerance: f64,
    near: f64,
}

impl Accuracy {
    /// For Newton's method, which also corrects the marks' places.
    pub(super) fn rough(level: f64) -> Self {
        Self { tolerance: 0.1 * level, near: 0.25 }
    }

    /// For a value to the rounding of the height.
    pub(super) fn full(level: f64) -> Self {
        Self { tolerance: NEARLY * NEARLY * level, near: NEAR }
    }
}
