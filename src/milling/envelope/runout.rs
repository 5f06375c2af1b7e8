//! The fast search with runout. A pass clears the offsets that neighbouring deep and shallow marks clear, and those
//! that the marks of the deepest tooth alone clear.
//!
//! Each of the two kinds of marks clears an interval of offsets with a left and a right edge. If the intervals meet,
//! the pass clears their union, so that a ridge can be between an edge of one and an edge of the other. In every case,
//! with both edges of one kind or one edge of each, the search is for the root of a convex function, and its result is
//! proved as without runout.

use super::clearing::{Clearing, Row};
use super::nested::{self, Feeds, Heights};
use super::newton::{self, End, Lengths, Place, Ridge, Sought};
use super::proved;
use super::section::Pattern;
use super::{Envelope, QuickLevel};
use crate::quantity::Length;

/// The depth, as a share of the height, at which a point counts as cleared by the other marks too: some hundred
/// rounding errors.
const INSIDE: f64 = 1e-13;

/// The share of the lengths by which passes or marks overlap so little that rounding decides the height.
const HARDLY: f64 = 1e-9;

/// A ridge between marks of one kind.
#[derive(Debug, Clone, Copy)]
struct Found {
    ridge: Ridge,
    marks: Clearing,
}

impl Envelope {
    /// The two kinds: marks that alternate in depth, and marks of the deepest tooth alone.
    pub(super) fn kinds(&self, pattern: &Pattern) -> [Clearing; 2] {
        let drop = self.drop;
        let alternating = if pattern.shallow_pairs { Clearing::Even { feeds: 1.0, less: 0.0, drop } } else { Clearing::Mixed { drop } };
        let feeds = self.teeth();
        [alternating, Clearing::Even { feeds, less: feeds * pattern.spacing - pattern.deep_spacing, drop: 0.0 }]
    }

    /// The height by nested searches, from a guess; `None` where they do not settle, or where passes or marks overlap so
    /// little that rounding decides the height.
    pub(super) fn nested_level(&self, s: f64, pattern: &Pattern, guess: f64) -> Option<f64> {
        let heights = Heights { body: &self.body, feed: pattern.spacing, guess };
        let overlap_clearly = |s: f64, f: f64| self.overlap((1.0 + HARDLY) * s, (1.0 + HARDLY) * f);
        if !overlap_clearly(s, pattern.spacing) {
            return None;
        }
        if pattern.is_even() {
            return nested::solve(&heights, s, &[Clearing::EVEN], None);
        }
        let [alternating, deep] = self.kinds(pattern);
        if overlap_clearly(s, pattern.deep_spacing) {
            return nested::solve(&heights, s, &[alternating, deep], None);
        }
        if self.overlap(s, pattern.deep_spacing) {
            return None;
        }
        // Deep marks that meet clear a part of the step-over.
        nested::solve(&heights, s, &[alternating], self.overlap(0.0, pattern.deep_spacing).then_some(deep))
    }

    /// The largest distance of marks that keeps the height p in passes s apart by nested searches, from a guess; `None`
    /// where they do not settle.
    pub(super) fn nested_feed(&self, p: f64, s: f64, guess: f64) -> Option<f64> {
        let feeds = Feeds { body: &self.body, level: p, guess };
        // Marks that are so close together that those of the deepest tooth are no further apart.
        let even = nested::solve(&feeds, s, &[Clearing::EVEN], None)?;
        let pattern = self.pattern(even);
        if pattern.is_even() {
            return Some(even);
        }
        let [alternating, deep] = self.kinds(&pattern);
        if p > self.drop { nested::solve(&feeds, s, &[alternating, deep], None) } else { nested::solve(&feeds, s, &[deep], None) }
    }

    fn ridge_between(&self, sought: Sought, lengths: Lengths, marks: Clearing) -> Option<Found> {
        proved::solve(&self.body, sought, lengths, [marks; 2]).map(|ridge| Found { ridge, marks })
    }

    /// The same if all points are exactly on the body.
    fn exact_ridge_between(&self, sought: Sought, lengths: Lengths, marks: Clearing) -> Option<Found> {
        self.ridge_between(sought, lengths, marks).filter(|found| found.ridge.is_exact)
    }

    /// Whether the intervals of both kinds in `marks` meet at a ridge.
    pub(super) fn meet(&self, ridge: &Ridge, marks: [Clearing; 2]) -> bool {
        let Lengths { level, step_over, mark_spacing } = ridge.lengths;
        let Place { t, x, neighbour_x } = ridge.place;
        [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().any(|share| {
            let middle = f64::midpoint(x[0] - marks[0].spacing(mark_spacing) / 2.0, neighbour_x[0] - marks[1].spacing(mark_spacing) / 2.0);
            marks.into_iter().all(|marks| {
                let x = [middle + marks.spacing(mark_spacing) / 2.0; 2];
                let row = Row { t: t - share * step_over, p: level, feed: mark_spacing };
                marks.outside(&self.body, x, row, step_over + mark_spacing) <= INSIDE * level
            })
        })
    }

    /// The ridge between an edge of `best` and an edge of `other` marks if it is better than `best`, otherwise `best`;
    /// `None` if the search ends without an answer.
    fn or_with(&self, sought: Sought, best: Found, other: Clearing) -> Option<Ridge> {
        let Lengths { level, step_over, mark_spacing } = best.ridge.lengths;
        let Place { t, x, neighbour_x } = best.ridge.place;
        let longer = (other.spacing(mark_spacing) - best.marks.spacing(mark_spacing)) / 2.0;
        let [near_x, far_x] = [x, neighbour_x].map(|x| [x[0] + longer; 2]);
        let reach = step_over + mark_spacing;
        let clears = |x: [f64; 2], t: f64| other.outside(&self.body, x, Row { t, p: level, feed: mark_spacing }, reach) < -INSIDE * level;
        let (place, marks) = if clears(near_x, t) {
            (Place { t, x: near_x, neighbour_x }, [other, best.marks])
        } else if clears(far_x, t - step_over) {
            (Place { t, x, neighbour_x: far_x }, [best.marks, other])
        } else {
            return Some(best.ridge);
        };
        newton::solve_from(&self.body, sought, best.ridge.lengths, place, marks, End::AtRidge).filter(|ridge| self.meet(ridge, marks))
    }

    /// h for passes s apart; `None` if the search's result is not proved.
    pub(super) fn quick_level_with_runout(&self, s: f64, pattern: &Pattern) -> Option<QuickLevel> {
        if !self.is_quick(pattern.spacing) {
            return None;
        }
        let [alternating, deep] = self.kinds(pattern);
        let lengths = |level: f64| Lengths { level, step_over: s, mark_spacing: pattern.spacing };
        let even = |spacing: f64| self.guess(s, Pattern::even(spacing));
        let across = s * self.spacing_ratio();
        let (diameter, deep_along) = (2.0 * self.cutter.outer_radius().mm(), pattern.deep_spacing * self.climb.cos());
        let deep_overlaps = across.hypot(deep_along) <= diameter;
        let by_deep = deep_overlaps.then(|| self.ridge_between(Sought::Level, lengths(even(pattern.deep_spacing)), deep));
        let by_deep = match by_deep {
            Some(found) => Some(found?),
            None => None,
        };
        if let Some(by_deep) = by_deep.filter(|found| found.ridge.lengths.level <= self.drop) {
            // Shallow teeth do not reach this depth.
            return Some(QuickLevel::of(&by_deep.ridge));
        }
        let by_both = self.ridge_between(Sought::Level, lengths(even(pattern.spacing) + self.drop), alternating)?;
        let are_exact = by_both.ridge.is_exact && by_deep.is_none_or(|by_deep| by_deep.ridge.is_exact);
        let ridge = match by_deep {
            // Deep marks that meet clear a part of the step-over, although not all of it.
            None if deep_along < diameter => self.or_with(Sought::Level, by_both, deep)?,
            None => by_both.ridge,
            Some(by_deep) if by_deep.ridge.lengths.level < by_both.ridge.lengths.level => {
                self.or_with(Sought::Level, by_deep, alternating)?
            }
            Some(_) => self.or_with(Sought::Level, by_both, deep)?,
        };
        Some(QuickLevel { level: ridge.lengths.level, is_exact: are_exact && ridge.is_exact })
    }

    /// The largest feed per tooth that keeps the height p in passes s apart, whose step-over alone leaves
    /// `step_over_height` < p; `None` if the search ends without a result. Nothing proves a result on a section that is not
    /// convex.
    pub(super) fn quick_feed_with_runout(&self, p: f64, s: f64, step_over_height: f64, guess: f64) -> Option<f64> {
        let pattern = self.pattern(guess);
        if !self.is_quick(guess) {
            return None;
        }
        let [alternating, deep] = self.kinds(&pattern);
        let lengths = |mark_spacing: f64| Lengths { level: p, step_over: s, mark_spacing };
        let by_deep = self.exact_ridge_between(Sought::MarkSpacing, lengths(guess * pattern.spacing / pattern.deep_spacing), deep)?;
        if p <= self.drop {
            return Some(by_deep.ridge.lengths.mark_spacing);
        }
        // Without marks, shallow teeth leave delta more than the deepest.
        let is_held = step_over_height + self.drop < p;
        let by_both = if is_held { Some(self.exact_ridge_between(Sought::MarkSpacing, lengths(guess), alternating)?) } else { None };
        let ridge = match by_both {
            Some(by_both) if by_both.ridge.lengths.mark_spacing > by_deep.ridge.lengths.mark_spacing => {
                self.or_with(Sought::MarkSpacing, by_both, deep).filter(|ridge| ridge.is_exact)?
            }
            _ => self.or_with(Sought::MarkSpacing, by_deep, alternating).filter(|ridge| ridge.is_exact)?,
        };
        Some(ridge.lengths.mark_spacing)
    }

    /// The largest step-over that keeps the height p; 0 if the marks alone leave more; `None` if the search ends without a
    /// result. Nothing proves a result on a section that is not convex.
    pub(super) fn quick_step_over_with_runout(&self, p: f64, pattern: &Pattern, guess: f64) -> Option<f64> {
        if !self.is_quick(pattern.spacing) {
            return None;
        }
        let [alternating, deep] = self.kinds(pattern);
        let lengths = |level: f64, step_over: f64| Lengths { level, step_over, mark_spacing: pattern.spacing };
        // The right and the left end of the interval of offsets that marks of one kind clear; empty if they leave more
        // than p at every offset.
        let interval = |marks: Clearing| {
            if let Some(found) = self.exact_ridge_between(Sought::StepOver, lengths(p, guess), marks) {
                let right = found.ridge.place.t;
                return Some(Some([right, right - found.ridge.lengths.step_over]));
            }
            let start = self.guess(0.0, Pattern::even(marks.spacing(pattern.spacing))) + self.drop;
            let least = self.exact_ridge_between(Sought::Level, lengths(start, Length::SMALLEST), marks)?;
            (least.ridge.lengths.level >= p).then_some(None)
        };
        let by_both = if p > self.drop { interval(alternating)? } else { None };
        let deep_overlaps = pattern.deep_spacing * self.climb.cos() < 2.0 * self.cutter.outer_radius().mm();
        let by_deep = if deep_overlaps { interval(deep)? } else { None };
        let width = |[right, left]: [f64; 2]| right - left;
        Some(match (by_both, by_deep) {
            (Some(a), Some(b)) if a[1] <= b[0] && b[1] <= a[0] => width([a[0].max(b[0]), a[1].min(b[1])]),
            (a, b) => a.into_iter().chain(b).map(width).fold(0.0, f64::max),
        })
    }
}
