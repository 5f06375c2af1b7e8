//! The fast search: Newton's method on all unknowns of the ridge at once. It has an answer only if the result is
//! proved.
//!
//! At the ridge, four points at one height p lie on the body: the ends of two chords along the feed. Both chords are as
//! long as the distance of the marks, f, and they are the step-over s apart. Any of p, s and f can be the unknown if
//! the others are given. The body's section never shrinks with the height, so the largest s, or f, that fits into the
//! section at a tolerance is the largest one that keeps the tolerance.
//!
//! Convexity proves the result. The distance to the body is nowhere less than its tangent, so the greatest of four
//! distances is nowhere less than a weighted mean of their tangents. With weights for which the mean does not depend on
//! the positions of the chords, its root bounds the unknown on one side. Four points that are not outside the body
//! bound it on the other side. If both bounds agree within a few rounding errors, the path of the search does not
//! matter.
//!
//! On a concave surface the distance is convex only near the contact. There the search ends when its steps are
//! roundings, and a result is accepted if the lines from the contact to all four points, and the chords, are inside the
//! body.

use super::body::Body;
use super::chord::{Accuracy, Chord, balance};
use super::clearing::{Clearing, Held, Row};

/// The height p of the ridge, the step-over s and the distance f of the marks, in mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lengths {
    pub(super) level: f64,
    pub(super) step_over: f64,
    pub(super) mark_spacing: f64,
}

/// The unknown among the three.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sought {
    Level,
    StepOver,
    MarkSpacing,
}

impl Sought {
    /// The unknown's value.
    pub(super) fn of(self, lengths: &Lengths) -> f64 {
        match self {
            Self::Level => lengths.level,
            Self::StepOver => lengths.step_over,
            Self::MarkSpacing => lengths.mark_spacing,
        }
    }
}

/// The largest number of steps. Quadratic convergence takes four to six from a guess within a few percent, and some
/// more from others.
const MOST_STEPS: usize = 24;

/// The same for a step-over on a convex section, whose edges take hardly longer to search than further steps.
const MOST_STEPS_STEP_OVER: usize = 12;

/// The number of first steps for which the chords are searched roughly. If these do not suffice, the parabola of a
/// chord is misleading because it crosses an edge of the body, and chords are searched accurately.
const ROUGH_STEPS: usize = 8;

/// The size of a step, as a share of the lengths, after which the next one is a rounding: its square.
pub(super) const LAST_STEP: f64 = 1e-8;

/// The number of such steps after which no further one can bring the points nearer to the body.
const MOST_SMALL_STEPS: usize = 8;

/// The distances outside of the body at the last step, as a share of the height.
pub(super) const OUTSIDE: f64 = 1e-7;

/// The largest share of a height that counts as the rounding of coordinates. Where the body is nearly upright, roundings
/// of coordinates would leave the height open.
pub(super) const COARSE: f64 = 1e-8;

/// The share of the lengths within which a point is at an overhang.
const AT_OVERHANG: f64 = 1e-6;

/// The size of a step, as a share of the lengths, after which a search ends near the ridge: the step leaves an error of
/// the order of its square.
const NEARBY: f64 = 0.3;

/// The number of steps after which a search that has to end near the ridge gives up.
const MOST_STEPS_NEARBY: usize = 6;

/// Where a search ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// At the ridge, to the rounding of the height, with the proof by convexity.
    AtRidge,
    /// Near the ridge, where a search that knows more goes on. Nothing is proved.
    Nearby,
}

/// A ridge: its lengths, and the positions of its chords.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ridge {
    pub(super) lengths: Lengths,
    pub(super) place: Place,
    /// Whether all four points are within the rounding of the height from the body. Beside an overhang they need not be,
    /// because their coordinates are rounded.
    pub(super) is_exact: bool,
}

impl Ridge {
    /// Whether an end of a chord without runout is at the surface's overhang.
    pub(super) fn is_at_overhang(&self, body: &Body) -> bool {
        let (Lengths { step_over, mark_spacing, .. }, Place { t, x, neighbour_x }) = (self.lengths, self.place);
        let ends = [[x[0], t], [x[0] - mark_spacing, t], [neighbour_x[0], t - step_over], [neighbour_x[0] - mark_spacing, t - step_over]];
        ends.into_iter().any(|end| body.beyond_overhang(end) > -AT_OVERHANG * (step_over + mark_spacing))
    }
}

/// The ridge, searched from a position near it. Different marks may clear its near and its far edge.
pub(super) fn solve_from(
    body: &Body,
    sought: Sought,
    mut lengths: Lengths,
    mut place: Place,
    [near_marks, far_marks]: [Clearing; 2],
    end: End,
) -> Option<Ridge> {
    // If edges of the body meet there, the position of a chord's end is only as accurate as its search.
    let mut is_close = false;
    let mut small_steps = 0;
    let most_steps = match sought {
        _ if end == End::Nearby => MOST_STEPS_NEARBY,
        Sought::StepOver | Sought::MarkSpacing if !body.is_concave() => MOST_STEPS_STEP_OVER,
        Sought::Level | Sought::StepOver | Sought::MarkSpacing => MOST_STEPS,
    };
    for step in 0..most_steps {
        let s = lengths.step_over;
        let f = lengths.mark_spacing;
        let (p, reach) = (lengths.level, s + f);
        let accuracy = if is_close || step >= ROUGH_STEPS { Accuracy::full(p) } else { Accuracy::rough(p) };
        let row = |t: f64| Row { t, p, feed: f };
        let near_held = near_marks.search(body, &mut place.x, row(place.t), accuracy, reach);
        let far_held = far_marks.search(body, &mut place.neighbour_x, row(place.t - s), accuracy, reach);
        let (near, far) = (&near_held.chord, &far_held.chord);
        if !(near.by_side > 0.0 && far.by_side < 0.0) {
            // The chords must be on both sides of the deepest one. The change of slope between them shows where that
            // approximately is.
            let aside = -s * f64::midpoint(near.by_side, far.by_side) / (near.by_side - far.by_side);
            if aside.is_nan() {
                return None;
            }
            follow(&mut place, (&near_held, &far_held), aside.clamp(-reach, reach), Change::NONE);
            continue;
        }
        let share = balance(near.by_side, far.by_side);
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        let (value, by_height) = (mix(near.value, far.value), mix(near.by_height, far.by_height));
        if by_height >= 0.0 {
            return None;
        }
        let height = lengths.level * by_height.abs();
        let rounding = 16.0 * f64::EPSILON * height + place.rounding(near, far, reach).min(COARSE * height);
        is_close |= value.abs() <= rounding;
        let furthest = near.furthest.max(far.furthest);
        let proved = value.abs() <= rounding && furthest <= rounding;
        let change = match sought {
            Sought::Level => Change { rise: (-value / by_height).max(-0.75 * lengths.level), ..Change::NONE },
            Sought::StepOver => Change { wider: bounded(value / ((1.0 - share) * far.by_side), s), ..Change::NONE },
            Sought::MarkSpacing => {
                Change { longer: bounded(-value / mix(near.by_spacing, far.by_spacing), lengths.mark_spacing), ..Change::NONE }
            }
        };
        let aside = -(near.value + near.by_height * change.rise + near.by_spacing * change.longer) / near.by_side;
        let aside = aside.clamp(-s, s);
        // Beside overhangs the ends of chords are only as accurate as their coordinates are rounded, so that the distances
        // need not fall below the rounding of the height.
        let size = change.share_of(&lengths) + aside.abs() / s;
        if size.is_nan() {
            return None;
        }
        let is_small = body.is_concave() && furthest <= OUTSIDE * p && size <= LAST_STEP;
        small_steps += usize::from(is_small);
        follow(&mut place, (&near_held, &far_held), aside, change);
        lengths.level += change.rise;
        lengths.step_over += change.wider;
        lengths.mark_spacing += change.longer;
        if end == End::Nearby && size <= NEARBY {
            return Some(Ridge { lengths, place, is_exact: false });
        }
        if proved || small_steps >= MOST_SMALL_STEPS {
            if body.is_concave()
                && !(near_marks.is_seen(body, place.x, row(place.t)) && far_marks.is_seen(body, place.neighbour_x, row(place.t - s)))
            {
                return None;
            }
            return Some(Ridge { lengths, place, is_exact: proved });
        }
    }
    None
}

/// The changes of the lengths in a step; all except that of the unknown are 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    pub(super) rise: f64,
    pub(super) wider: f64,
    pub(super) longer: f64,
}

impl Change {
    pub(super) const NONE: Self = Self { rise: 0.0, wider: 0.0, longer: 0.0 };

    /// The sum of the changes as shares of the lengths.
    pub(super) fn share_of(&self, lengths: &Lengths) -> f64 {
        let longer = if self.longer == 0.0 { 0.0 } else { self.longer.abs() / lengths.mark_spacing };
        self.rise.abs() / lengths.level + self.wider.abs() / lengths.step_over + longer
    }
}

/// The change, limited so that a length shrinks at most to a quarter and grows at most fourfold: far from the root, a
/// tangent may lead below 0 or very far away. The height needs only the former limit, because no tangent leads above h.
pub(super) fn bounded(change: f64, length: f64) -> f64 {
    change.clamp(-0.75 * length, 3.0 * length)
}

/// Moves the position by a step of t, and the ends of both chords accordingly.
pub(super) fn follow(place: &mut Place, (near, far): (&Held, &Held), aside: f64, change: Change) {
    place.t += aside;
    for (x, shift) in place.x.iter_mut().zip(&near.shifts) {
        *x += shift.of(aside, change.rise, change.longer);
    }
    for (x, shift) in place.neighbour_x.iter_mut().zip(&far.shifts) {
        *x += shift.of(aside - change.wider, change.rise, change.longer);
    }
}

/// The current position of the search: the offset t, and the front ends of the chords at both edges along the feed.
/// Each edge has two chords if deep and shallow marks alternate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) t: f64,
    pub(super) x: [f64; 2],
    pub(super) neighbour_x: [f64; 2],
}

impl Place {
    /// The rounding errors of the distances at both chords, which are those of the coordinates times the slopes there.
    /// Near a floor they exceed the rounding of the height.
    pub(super) fn rounding(&self, near: &Chord, far: &Chord, reach: f64) -> f64 {
        let steepest = near.steepest.max(far.steepest).max(near.by_side.abs()).max(far.by_side.abs());
        4.0 * f64::EPSILON * (self.x[0].abs() + self.t.abs() + reach) * steepest
    }

    /// The position on both sides of the axis, around which a nearly level section lies.
    pub(super) fn under_axis(body: &Body, Lengths { step_over, mark_spacing, .. }: Lengths, marks: [Clearing; 2]) -> Self {
        let [x, t] = body.flat_centre();
        let [near, far] = marks.map(|marks| x + marks.spacing(mark_spacing) / 2.0);
        Self { t: t + step_over / 2.0, x: [near; 2], neighbour_x: [far; 2] }
    }

    /// The position half-way between the passes, with the chords of a paraboloid with the body's curvature.
    pub(super) fn start(body: &Body, step_over: f64, [near, far]: [Clearing; 2], feed: f64) -> Self {
        let (half_step, radii) = (step_over / 2.0, body.relative_radii());
        // A sharp edge fed along the level line has no radius across the feed, so the guess is limited to the extent of
        // the cutter.
        let ahead = (radii.skew * half_step / radii.across.max(f64::MIN_POSITIVE)).clamp(-body.reach(), body.reach());
        Self { t: half_step, x: [near.spacing(feed) / 2.0 + ahead; 2], neighbour_x: [far.spacing(feed) / 2.0 - ahead; 2] }
    }
}
