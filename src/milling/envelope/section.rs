//! The general search, on the cutter's section at a height over the surface: the lateral offsets that a pass clears
//! down to that height for any phase of its teeth, and the height at which their interval is as wide as the step-over.
//!
//! A point at the height p over the surface stays uncut if no tooth's body covers it. Let l(t) be the length of the
//! chord of the section {H <= p} along the feed at the lateral offset t. A pass whose teeth are f apart leaves points
//! at t uncut for some phase exactly if l(t) < f. So material is left at the height p, for some phases of the passes,
//! exactly if the interval {t: l(t) >= f} is narrower than the step-over s. The height left in the worst case is the
//! least p at which this interval is s wide:
//!
//! h = min p such that (x, t, p), (x - f, t, p), (x', t - s, p) and (x' - f, t - s, p) all lie in the body.
//!
//! With runout, the end of a chord that a shallow tooth cuts lies in the section at the height p - delta. Neither the
//! position of the lowest point nor symmetry is assumed. For a feed f = 0 the chords are points, and the result is h1.
//!
//! In terms of the signed distance to the body, c(t, p) = min over x of max(distance(x, t, p), distance(x - f, t, p)).
//! On planes and convex surfaces c is convex.

use super::body::Body;
use super::chord::{Accuracy, Chord, Marks};
use crate::quantity::Length;
use std::cell::Cell;
use std::ops::RangeInclusive;

/// The marks of one pass, whose teeth may differ in depth by delta.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pattern {
    /// The distance of the marks of neighbouring teeth along the feed.
    pub(super) spacing: f64,
    /// The distance of the marks of the deepest tooth.
    pub(super) deep_spacing: f64,
    /// delta, how much less deep the shallowest tooth cuts than the deepest.
    pub(super) drop: f64,
    /// Whether two shallow teeth can follow each other, as with three teeth or more.
    pub(super) shallow_pairs: bool,
}

impl Pattern {
    pub(super) fn even(spacing: f64) -> Self {
        Self { spacing, deep_spacing: spacing, drop: 0.0, shallow_pairs: false }
    }

    /// The distance of the marks of all teeth that cut as deep as the deepest.
    pub(super) fn deepest_spacing(&self) -> f64 {
        if self.is_even() { self.spacing } else { self.deep_spacing }
    }

    /// Whether all marks have the same depth, because all teeth cut equally deep or only one tooth cuts.
    pub(super) fn is_even(&self) -> bool {
        self.drop == 0.0 || self.deep_spacing <= self.spacing
    }
}

/// One end of the cleared interval.
#[derive(Debug, Clone, Copy)]
struct Edge {
    t: f64,
    x: f64,
    by_height: f64,
}

/// The cleared interval at a height, and how its width grows with the height.
#[derive(Debug, Clone, Copy)]
struct Interval {
    left: Edge,
    right: Edge,
}

impl Interval {
    fn width(&self) -> f64 {
        self.right.t - self.left.t
    }

    fn by_height(&self) -> f64 {
        self.right.by_height - self.left.by_height
    }
}

/// The search at one contact for one pattern of marks.
#[derive(Debug)]
pub(super) struct Section<'a> {
    body: &'a Body,
    pattern: Pattern,
    /// The largest width of interest; wider intervals are cut off at it.
    widest: f64,
    /// The number of chords that may still be searched.
    budget: Cell<u32>,
}

/// The largest number of chords that a search on a concave surface evaluates. If the section has lobes, the search may
/// not terminate; the outline then has the answer. Searches that end with an exact answer can take more than 150.
const CONCAVE_BUDGET: u32 = 1000;

/// No offset beyond this one is searched, in mm: twice the largest accepted length.
pub(super) const FURTHEST: f64 = 2.0 * Length::LARGEST;

/// The largest number of steps: bracketing and bisection take about 60 at most, Newton's method 3 to 6.
const MOST_STEPS: usize = 80;

impl<'a> Section<'a> {
    pub(super) fn new(body: &'a Body, pattern: Pattern, widest: f64) -> Self {
        let budget = Cell::new(if body.is_concave() { CONCAVE_BUDGET } else { u32::MAX });
        Self { body, pattern, widest, budget }
    }

    /// The width of the cleared interval at the height p, at most `widest`; 0 if the pass clears nothing down to p.
    pub(super) fn width(&self, p: f64) -> f64 {
        self.interval(p, None).map_or(0.0, |interval| interval.width().max(0.0))
    }

    /// The height at which the cleared interval is `width` wide, starting from `guess`. At the height `ceiling` it is
    /// known to be at least as wide; infinity if no such height is known.
    ///
    /// The square of the width is nearly linear in the height, exactly for a paraboloid. Newton's method is therefore
    /// applied to this square, inside a bracket. An interval that is cut off at the widest width has no derivative.
    /// Then, or if three steps have not halved the bracket, the bracket is divided.
    ///
    /// At the largest step-over, rounding can make every interval narrower than the width. The ceiling is then the
    /// result.
    pub(super) fn level(&self, width: f64, guess: f64, ceiling: f64) -> f64 {
        self.level_within(width, guess, ceiling, &(0.0..=f64::INFINITY))
    }

    /// The same; `f64::MAX` if the height is not `within` a range of heights.
    pub(super) fn level_within(&self, width: f64, guess: f64, ceiling: f64, within: &RangeInclusive<f64>) -> f64 {
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut p = guess.min(ceiling);
        let mut last = None::<Interval>;
        let least = f64::EPSILON.powi(2) * width;
        let mut lengths = [f64::INFINITY; 3];
        for step in 0..MOST_STEPS {
            let is_at_ceiling = p >= ceiling;
            let found = if is_at_ceiling { None } else { self.interval(p, last.as_ref()) };
            let excess = if is_at_ceiling { 0.0 } else { found.as_ref().map_or(-width, |interval| interval.width() - width) };
            if excess < 0.0 {
                low = p;
            } else {
                high = p;
            }
            if excess < 0.0 && p >= *within.end() || excess >= 0.0 && p <= *within.start() {
                return f64::MAX;
            }
            let newton = found.as_ref().filter(|interval| interval.width() < self.widest * (1.0 - 1e-9)).map_or(f64::NAN, |interval| {
                let (at, slope) = (interval.width(), interval.by_height());
                p - excess * (at + width) / (2.0 * at * slope)
            });
            last = found.or(last);
            // Newton's step squares the error, so that after a step of 1e-12 the error is below rounding. The rounding
            // of the edges can keep steps from becoming smaller.
            if (newton - p).abs() <= 1e-12 * p {
                return newton;
            }
            if p > FURTHEST || self.budget.get() == 0 {
                return f64::MAX;
            }
            let is_slow = high - low > 0.5 * lengths[step % 3];
            lengths[step % 3] = high - low;
            if (high < f64::INFINITY && high - low <= 4.0 * f64::EPSILON * high) || high < least {
                return if high < least { 0.0 } else { high };
            }
            p = if newton > low && newton < high && if high < f64::INFINITY { !is_slow } else { newton < 16.0 * p } {
                newton
            } else if high == f64::INFINITY {
                8.0 * p
            } else if low == 0.0 {
                p / 64.0
            } else {
                // The bracket is divided by ratio while it is wide, because the magnitude of the height is unknown.
                if high > 4.0 * low { (low * high).sqrt() } else { f64::midpoint(low, high) }
            }
            .min(ceiling)
            .clamp(*within.start(), *within.end());
        }
        high.min(f64::MAX)
    }

    /// The cleared interval at the height p. The search starts from `near`, an interval at another height.
    ///
    /// With runout, an offset is cleared in two cases. Either the deep mark meets a shallow one before it and one
    /// behind it; if two shallow marks can be neighbours, these must meet too. Or the deep marks alone meet.
    fn interval(&self, p: f64, near: Option<&Interval>) -> Option<Interval> {
        let pattern = &self.pattern;
        if pattern.is_even() {
            let marks = Marks::even(pattern.spacing);
            let left = self.edge(p, &marks, -1.0, near.map(|near| &near.left), FURTHEST)?;
            let right = self.edge(p, &marks, 1.0, near.map(|near| &near.right), left.t + self.widest)?;
            return Some(Interval { left, right });
        }
        // Two shallow marks leave at least as much as a deep and a shallow one. If two can be neighbours, only they
        // count.
        let before =
            Marks { spacing: pattern.spacing, front_drop: pattern.drop, back_drop: if pattern.shallow_pairs { pattern.drop } else { 0.0 } };
        let behind = if pattern.shallow_pairs { before } else { Marks { front_drop: 0.0, back_drop: pattern.drop, ..before } };
        let deep = Marks::even(pattern.deep_spacing);
        let left = |marks: &Marks| self.edge(p, marks, -1.0, near.map(|near| &near.left), FURTHEST);
        let before_left = left(&before);
        let lefts = (before_left, if pattern.shallow_pairs { before_left } else { left(&behind) }, left(&deep));
        let furthest_left = [lefts.0, lefts.1, lefts.2].iter().flatten().map(|edge| edge.t).fold(-FURTHEST, f64::max);
        let right = |marks: &Marks| self.edge(p, marks, 1.0, near.map(|near| &near.right), furthest_left + self.widest);
        let interval = |left: Option<Edge>, marks: &Marks| left.and_then(|left| Some(Interval { left, right: right(marks)? }));
        let alternating = interval(lefts.0, &before);
        let alternating = if pattern.shallow_pairs {
            alternating
        } else {
            alternating.zip(interval(lefts.1, &behind)).map(|(a, b)| Interval {
                left: if a.left.t > b.left.t { a.left } else { b.left },
                right: if a.right.t < b.right.t { a.right } else { b.right },
            })
        };
        let alternating = alternating.filter(|interval| interval.width() >= 0.0);
        match (alternating, interval(lefts.2, &deep)) {
            (Some(a), Some(b)) if a.left.t <= b.right.t && b.left.t <= a.right.t => Some(Interval {
                left: if a.left.t < b.left.t { a.left } else { b.left },
                right: if a.right.t > b.right.t { a.right } else { b.right },
            }),
            // Two intervals that do not meet leave material between them, so that only the wider one counts.
            (Some(a), Some(b)) => Some(if a.width() >= b.width() { a } else { b }),
            (one, other) => one.or(other),
        }
    }

    /// The furthest offset on `side` (1 or -1) at which the section contains a chord, at most `furthest` times `side`.
    fn edge(&self, p: f64, marks: &Marks, side: f64, near: Option<&Edge>, furthest: f64) -> Option<Edge> {
        let start = near.map_or_else(|| self.start(p, marks, side), |near| (near.t, near.x));
        self.edge_from(p, marks, side, start, furthest)
    }

    /// The edge of a paraboloid with the curvature at the contact, as a first guess.
    fn start(&self, p: f64, marks: &Marks, side: f64) -> (f64, f64) {
        let (radii, reach) = (self.body.relative_radii(), self.body.reach());
        let t = (2.0 * p * radii.across).sqrt().max(p).min(reach) * side;
        let ahead = (radii.skew / radii.across.max(f64::MIN_POSITIVE) * t).clamp(-reach, reach);
        (t, ahead + marks.spacing / 2.0)
    }

    /// The edge by Newton's method on c(t), which converges monotonically from outside the section if c is convex. A
    /// bracket secures convergence otherwise.
    fn edge_from(&self, p: f64, marks: &Marks, side: f64, start: (f64, f64), furthest: f64) -> Option<Edge> {
        let (mut t, mut x) = start;
        let mut reach = t.abs() + marks.spacing;
        // The bracket, as offsets times `side`: `inner` is inside the section or on its other side, `outer` is outside
        // on this side.
        let (mut inner, mut outer) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut is_inside = false;
        let (mut on_inner, mut on_outer) = (None::<(f64, Chord)>, None::<(f64, Chord)>);
        for _ in 0..MOST_STEPS {
            self.budget.set(self.budget.get().saturating_sub(1));
            if self.budget.get() == 0 {
                return None;
            }
            let chord = Chord::search(self.body, &mut x, t, p, marks, Accuracy::full(p), reach);
            let rise = chord.by_side * side;
            let edge = |t: f64| Edge { t, x: x + chord.shift.off, by_height: -chord.by_height / chord.by_side };
            if chord.value <= 0.0 && t * side >= furthest {
                return Some(Edge { t: furthest * side, x, by_height: 0.0 });
            }
            let newton = t - chord.value / chord.by_side;
            // Far from the contact, the height can change by more than 1e-12 within the rounding error of t.
            let is_rounding = (newton - t).abs() <= 0.5 * f64::EPSILON * t.abs();
            if rise > 0.0 && (is_rounding || chord.value.abs() <= 1e-12 * p * chord.by_height.abs()) {
                return Some(edge(newton));
            }
            if chord.value > 0.0 && rise > 0.0 {
                (outer, on_outer) = (t * side, Some((t, chord)));
            } else {
                is_inside |= chord.value <= 0.0;
                (inner, on_inner) = (t * side, Some((t, chord)));
            }
            let open = outer == f64::INFINITY || inner == f64::NEG_INFINITY;
            if !open && outer - inner <= 2.0 * f64::EPSILON * inner.abs().max(outer.abs()) {
                return is_inside.then(|| edge(t));
            }
            let next = newton * side;
            let next = if rise > 0.0 && next > inner && next < outer && (!open || (newton - t).abs() <= 4.0 * reach) {
                next
            } else if outer == f64::INFINITY {
                reach *= 2.0;
                t * side + reach / 2.0
            } else if inner == f64::NEG_INFINITY {
                reach *= 2.0;
                t * side - reach / 2.0
            } else if is_inside {
                f64::midpoint(inner, outer)
            } else if let (Some((inner_t, inner_chord)), Some((outer_t, outer_chord))) = (on_inner, on_outer) {
                // Both ends are outside, on either side of the section. Where their tangents meet, they bound c from
                // below.
                let meet = (outer_chord.by_side * outer_t - inner_chord.by_side * inner_t - outer_chord.value + inner_chord.value)
                    / (outer_chord.by_side - inner_chord.by_side);
                if inner_chord.value + inner_chord.by_side * (meet - inner_t) > 1e-9 * p * inner_chord.by_height.abs() {
                    return None;
                }
                let meet = meet * side;
                if meet > inner && meet < outer { meet } else { f64::midpoint(inner, outer) }
            } else {
                return None;
            };
            t = next * side;
        }
        None
    }
}
