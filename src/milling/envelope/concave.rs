//! The model on concave surfaces, where the section at a height need not be convex: a coarse outline of the section has
//! the ridge to a few percent, from where Newton's method finds it.

use super::Envelope;
use super::clearing::Clearing;
use super::local;
use super::newton::{Lengths, Place, Ridge, Sought};
use super::outline::{Cleared, Outline, Outlook, Rows};
use super::section::Pattern;
use crate::quantity::Length;

/// The share by which the outline, a polygon, may differ in size from the section. Thin tips of the section are cut off
/// by the most.
const COARSE: f64 = 0.06;

/// The same of a height, which grows with the square of the lengths.
const COARSE_HEIGHT: f64 = 0.15;

/// Outlines that a height may take.
const MOST_OUTLINES: usize = 12;

/// The share of the height within which it is narrowed down where Newton's method finds no ridge.
const NARROW: f64 = 0.005;

/// Halvings that find the share of a step-over and a mark spacing that an outline clears.
const MOST_SHARES: usize = 16;

/// A result, and whether it is that of Newton's method, and not of the outline.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) value: f64,
    pub(super) is_exact: bool,
}

impl Envelope {
    /// The rows of the section at the height p, of which `deep` is the outline, for a pattern of marks.
    fn rows(&self, outlook: &Outlook<'_>, deep: &Outline, p: f64, pattern: &Pattern) -> Rows {
        if pattern.is_even() {
            return deep.rows();
        }
        let shallow = (p > self.drop).then(|| outlook.at(p - self.drop, deep));
        deep.rows_by_depth(pattern, shallow.as_ref())
    }

    /// The largest share of a step-over s and of a pattern's distances that the rows of an outline clear, and where;
    /// `None` where there is none.
    fn share(rows: &Rows, s: f64, pattern: &Pattern) -> Option<(f64, Cleared)> {
        let (f, deepest) = (pattern.spacing, pattern.deepest_spacing());
        if f == 0.0 {
            let cleared = rows.extent();
            return Some((cleared.width() / s, cleared));
        }
        let at = |share: f64| rows.cleared(share * f, share * deepest).filter(|cleared| cleared.width() >= share * s);
        let mut low = at(1.0).map(|cleared| (1.0, cleared));
        let mut high = if low.is_some() { f64::INFINITY } else { 1.0 };
        for _ in 0..MOST_SHARES {
            let lowest = low.map_or(0.0, |(share, _)| share);
            if high - lowest <= 0.2 * COARSE * lowest {
                break;
            }
            let middle = if high == f64::INFINITY {
                2.0 * lowest
            } else if lowest == 0.0 {
                0.5 * high
            } else {
                f64::midpoint(lowest, high)
            };
            match at(middle) {
                Some(cleared) => low = Some((middle, cleared)),
                None => high = middle,
            }
        }
        low
    }

    /// Whether an outline's rows agree with the ridge that has these lengths.
    fn agrees(rows: &Rows, s: f64, pattern: &Pattern) -> bool {
        Self::share(rows, s, pattern).is_some_and(|(share, _)| (share - 1.0).abs() <= COARSE)
    }

    /// The ridge near the edges of a cleared interval.
    fn ridge(&self, pattern: &Pattern, sought: Sought, lengths: Lengths, cleared: &Cleared) -> Option<Ridge> {
        let place = Place { t: cleared.right.t, x: cleared.right.x, neighbour_x: cleared.left.x };
        let marks = [&cleared.right, &cleared.left].map(|edge| {
            if pattern.is_even() {
                return Clearing::EVEN;
            }
            let [alternating, deep] = self.kinds(pattern);
            if edge.is_deep { deep } else { alternating }
        });
        local::solve(&self.body, sought, lengths, place, marks)
    }

    /// The height up to which the section grows: that of the cutter's axis beside a wall, and several radii elsewhere.
    pub(super) fn highest(&self) -> f64 {
        self.cutter.outer_radius().mm() / self.contact().slope().sin().max(0.25)
    }

    /// h for passes s apart; `quick` is what the fast search found. `None` where no height clears s.
    pub(super) fn level_on_concave(&self, s: f64, pattern: Pattern, quick: Option<f64>) -> Option<f64> {
        let highest = self.highest();
        let reach = self.body.reach() + s;
        let quick = quick.filter(|quick| *quick < highest);
        let mut p = quick.unwrap_or_else(|| self.guess(s, pattern));
        // Heights, and the shares of s and of the marks' distance that are cleared there.
        let (mut low, mut high) = ((0.0, 0.0), (f64::INFINITY, f64::INFINITY));
        let (mut least, mut most) = (0.0_f64, f64::INFINITY);
        for step in 0..MOST_OUTLINES {
            let outlook = Outlook::new(&self.body, p, reach);
            let found = Self::share(&self.rows(&outlook, outlook.first(), p, &pattern), s, &pattern);
            let share = found.map_or(0.0, |(share, _)| share);
            if share >= 1.0 {
                high = (p, share);
            } else {
                low = (p, share);
            }
            // Within the outline's errors the height can be on either side.
            if share >= 1.0 + COARSE {
                most = most.min(p);
            } else if share < 1.0 - COARSE {
                least = least.max(p);
            }
            // A height grows with the square of the lengths.
            let guess = p / (share * share);
            let ridge = found.filter(|_| share > 0.4 && share < 2.5).and_then(|(share, cleared)| {
                let lengths = Lengths { level: guess, step_over: s, mark_spacing: pattern.spacing };
                self.ridge(&pattern, Sought::Level, lengths, &cleared.scaled(share.recip()))
            });
            let ridge = ridge.map(|ridge| ridge.lengths.level);
            if let (None, 0, Some(found)) = (ridge, step, quick)
                && (share - 1.0).abs() <= COARSE
            {
                return Some(found);
            }
            if let Some(level) = ridge {
                if (share - 1.0).abs() <= COARSE && (level / p - 1.0).abs() <= COARSE_HEIGHT {
                    return Some(level);
                }
                if level > least && level < most {
                    p = level;
                    continue;
                }
            }
            if high.0 < f64::INFINITY && high.0 - low.0 <= NARROW * high.0 || low.0 >= highest {
                break;
            }
            p = if high.0 == f64::INFINITY && step == 1 && share < 1.0 - COARSE {
                // Where no height clears s, the highest one shows it.
                highest
            } else if high.0 == f64::INFINITY {
                guess.clamp(1.1 * p, 16.0 * p).min(highest)
            } else if low.0 == 0.0 {
                guess.clamp(p / 64.0, 0.9 * p)
            } else if step % 3 == 2 || low.1 == 0.0 {
                if high.0 > 4.0 * low.0 { (high.0 * low.0).sqrt() } else { f64::midpoint(low.0, high.0) }
            } else {
                let room = 0.2 * NARROW * high.0;
                let linear = low.0 + (high.0 - low.0) * (1.0 - low.1 * low.1) / (high.1 * high.1 - low.1 * low.1);
                linear.clamp(low.0 + room, high.0 - room)
            };
        }
        (high.0 < f64::INFINITY).then_some(high.0)
    }

    /// The largest step-over that keeps the height p, at most `largest`.
    pub(super) fn step_over_on_concave(&self, p: f64, pattern: Pattern, largest: f64) -> Found {
        let reach = self.body.reach() + largest;
        let outlook = Outlook::new(&self.body, p, reach);
        let rows = self.rows(&outlook, outlook.first(), p, &pattern);
        let (f, deepest) = (pattern.spacing, pattern.deepest_spacing());
        let cleared = |share: f64| rows.cleared(share * f, share * deepest).filter(|cleared| cleared.width() > 0.0);
        let here = if f == 0.0 { Some(rows.extent()) } else { cleared(1.0) };
        let near = here.or_else(|| cleared(1.0 - 0.5 * COARSE)).or_else(|| cleared(1.0 - COARSE));
        let ridge = near.and_then(|cleared| {
            let lengths = Lengths { level: p, step_over: cleared.width(), mark_spacing: pattern.spacing };
            self.ridge(&pattern, Sought::StepOver, lengths, &cleared).map(|ridge| ridge.lengths.step_over)
        });
        let exact = ridge.filter(|step_over| Self::agrees(&rows, *step_over, &pattern));
        let value = exact.or_else(|| here.map(|cleared| cleared.width())).unwrap_or(0.0);
        Found { value: value.min(largest), is_exact: exact.is_some() }
    }

    /// The largest feed per tooth that keeps the height p in passes s apart, at most `largest`; `None` where none does
    /// from [`Length::SMALLEST`] on.
    pub(super) fn feed_on_concave(&self, p: f64, s: f64, largest: f64) -> Option<Found> {
        let reach = self.body.reach() + s;
        let outlook = Outlook::new(&self.body, p, reach);
        let rows = self.rows(&outlook, outlook.first(), p, &self.pattern(1.0));
        let cleared = |feed: f64| rows.cleared(feed, self.pattern(feed).deepest_spacing()).filter(|cleared| cleared.width() >= s);
        let (mut low, mut high) = ((0.0, None), largest);
        if let Some(cleared) = cleared(largest) {
            low = (largest, Some(cleared));
        }
        while high - low.0 > 0.01 * high && high > 0.5 * Length::SMALLEST {
            let middle = if low.0 > 0.0 { f64::midpoint(low.0, high) } else { high / 4.0 };
            match cleared(middle) {
                Some(cleared) => low = (middle, Some(cleared)),
                None => high = middle,
            }
        }
        let (feed, near) = low;
        let ridge = near.and_then(|cleared| {
            let lengths = Lengths { level: p, step_over: s, mark_spacing: feed };
            self.ridge(&self.pattern(feed), Sought::MarkSpacing, lengths, &cleared).map(|ridge| ridge.lengths.mark_spacing)
        });
        let exact = ridge.filter(|exact| Self::agrees(&rows, s, &self.pattern(*exact)));
        let value = exact.unwrap_or(feed).min(largest);
        (value >= Length::SMALLEST).then_some(Found { value, is_exact: exact.is_some() })
    }
}
