//! The model on concave surfaces, on which the section at a height need not be convex. The section's outline gives the
//! ridge to a few percent, from which Newton's method finds it. A result is accepted if its chords are seen from the
//! contact, and if the outline a little below it clears less than the step-over.

use super::clearing::{Clearing, Row};
use super::local;
use super::newton::{Lengths, Place, Ridge, Sought};
use super::outline::{Cleared, Outline, Outlook, Rows};
use super::section::{Pattern, Section};
use super::{Envelope, QuickLevel};
use crate::quantity::Length;

/// The outline, a polygon inside the section, may clear a step-over at a height that is lower than the result by this
/// share.
const COARSE: f64 = 0.03;

/// A little below the result the outline may clear this share less, because the polygon cuts off thin tips.
const CUT_OFF: f64 = 0.12;

/// The largest number of outlines that a search for a height evaluates.
const MOST_OUTLINES: usize = 24;

/// The share of the height to which the bracket is narrowed down if Newton's method finds no ridge.
const NARROW: f64 = 0.005;

/// The number of halvings that find the share of step-over and mark spacing that an outline clears.
const MOST_SHARES: usize = 24;

/// The error of a share.
const SHARE_ERROR: f64 = 1e-3;

/// The shares from which Newton's method is tried.
const NEAR: std::ops::Range<f64> = 0.4..2.5;

/// A proved result counts although the outline has a lower one, for which no ridge is found, if they differ by no more
/// than this share.
const FAR: f64 = 0.06;

/// Two results that differ by less than this share are the same.
const SAME: f64 = 1e-3;

impl Envelope {
    /// The rows of the section at the height p, whose outline is `deep`, for a pattern of marks.
    fn rows(&self, outlook: &Outlook<'_>, deep: &Outline, p: f64, pattern: &Pattern) -> Rows {
        if pattern.is_even() {
            return deep.rows(None);
        }
        let shallow = (p > self.drop).then(|| outlook.at(p - self.drop, deep));
        deep.rows(shallow.as_ref().map(|shallow| (pattern, shallow)))
    }

    /// The largest share of a step-over s and of a pattern's distances that the rows of an outline clear, and the cleared
    /// interval; `None` if there is none.
    fn share(rows: &Rows, s: f64, pattern: &Pattern) -> Option<(f64, Cleared)> {
        let (f, deepest) = (pattern.spacing, pattern.deepest_spacing());
        if f == 0.0 {
            let cleared = rows.extent();
            return Some((cleared.width() / s, cleared));
        }
        // The room is the width that is cleared beyond a share of the step-over. It falls as the share grows.
        let room = |share: f64| {
            let cleared = rows.cleared(share * f, share * deepest);
            (cleared.map_or(0.0, |cleared| cleared.width()) - share * s, cleared)
        };
        let (mut low, mut high) = ((0.0, None), None::<(f64, f64)>);
        // False position: the room at an end of the bracket that is kept again counts half, so that both ends move.
        let mut weights = [1.0; 2];
        let mut share = 1.0;
        for _ in 0..MOST_SHARES {
            let (here, cleared) = room(share);
            if here >= 0.0 {
                low = (share, cleared.map(|cleared| (here, cleared)));
                weights = [1.0, 0.5 * weights[1]];
            } else {
                high = Some((share, here));
                weights = [0.5 * weights[0], 1.0];
            }
            share = match (low, high) {
                (_, None) => 2.0 * share,
                ((_, None), Some((high, _))) => 0.5 * high,
                ((low, Some((room, _))), Some((high, lack))) => {
                    let error = if NEAR.contains(&low) { SHARE_ERROR } else { 0.1 } * low;
                    if high - low <= error {
                        break;
                    }
                    let (room, lack) = (weights[0] * room, weights[1] * lack);
                    // A little beyond the estimated root, so that the next share is likely to be the bracket's other end.
                    let at = low + (high - low) * room / (room - lack);
                    let margin = (0.25 * error).min(0.25 * (high - low));
                    if at < f64::midpoint(low, high) { (at + margin).max(low + margin) } else { (at - margin).min(high - margin) }
                }
            };
        }
        low.1.map(|(_, cleared)| (low.0, cleared))
    }

    /// The ridge near the edges of a cleared interval, if its chords are seen from the contact and, where an edge is of deep
    /// marks and the other of alternating ones, the intervals that both clear meet.
    fn ridge(&self, pattern: &Pattern, sought: Sought, lengths: Lengths, cleared: &Cleared) -> Option<Ridge> {
        let place = Place { t: cleared.right.t, x: cleared.right.x, neighbour_x: cleared.left.x };
        let marks = [&cleared.right, &cleared.left].map(|edge| {
            if pattern.is_even() {
                return Clearing::EVEN;
            }
            let [alternating, deep] = self.kinds(pattern);
            if edge.is_deep { deep } else { alternating }
        });
        let ridge = local::solve(&self.body, sought, lengths, place, marks)?;
        let Ridge { lengths: Lengths { level, step_over, mark_spacing }, place: Place { t, x, neighbour_x }, .. } = ridge;
        let row = |t: f64| Row { t, p: level, feed: mark_spacing };
        let is_seen = marks[0].is_seen(&self.body, x, row(t)) && marks[1].is_seen(&self.body, neighbour_x, row(t - step_over));
        (is_seen && (marks[0] == marks[1] || self.meet(&ridge, marks))).then_some(ridge)
    }

    /// The height up to which the section grows: that of the cutter's axis beside a wall, and several radii elsewhere.
    fn highest(&self) -> f64 {
        self.cutter.outer_radius().mm() / self.contact().slope().sin().max(0.25)
    }

    /// h for passes s apart; `None` if no height clears s. `quick` is the result of the fast search.
    pub(super) fn level_on_concave(&self, s: f64, pattern: Pattern, quick: Option<QuickLevel>) -> Option<f64> {
        let highest = self.highest();
        let reach = self.body.reach() + s;
        // A ridge that is clear, and whether the outline need not clear nearly as much.
        let mut candidate = quick.filter(|quick| quick.level < highest).map(|quick| (quick.level, quick.is_exact));
        let mut refused = f64::NAN;
        let mut p = candidate.map_or_else(|| self.guess(s, pattern), |(level, _)| level * (1.0 - COARSE));
        // Heights, and the shares of the lengths that are cleared there.
        let (mut low, mut high) = ((0.0, 0.0), (f64::INFINITY, f64::INFINITY));
        for step in 0..MOST_OUTLINES {
            let outlook = Outlook::new(&self.body, p, reach);
            let found = Self::share(&self.rows(&outlook, outlook.first(), p, &pattern), s, &pattern);
            let share = found.map_or(0.0, |(share, _)| share);
            // A height grows with the square of the lengths.
            let guess = p / (share * share);
            let ridge = found.filter(|_| NEAR.contains(&share)).and_then(|(share, cleared)| {
                let lengths = Lengths { level: guess, step_over: s, mark_spacing: pattern.spacing };
                self.ridge(&pattern, Sought::Level, lengths, &cleared.scaled(share.recip()))
            });
            if let Some((level, is_proved)) = candidate.take() {
                if share < 1.0 && (is_proved || share >= 1.0 - CUT_OFF) {
                    // Another ridge can be lower by less than the outline's error.
                    let lower = ridge.map(|ridge| ridge.lengths.level).filter(|lower| *lower > p && share >= 1.0 - CUT_OFF);
                    return Some(lower.map_or(level, |lower| level.min(lower)));
                }
                refused = level;
            }
            if share >= 1.0 {
                high = (p, share);
            } else {
                low = (p, share);
            }
            if high.0 < f64::INFINITY && high.0 - low.0 <= NARROW * high.0 || low.0 >= highest {
                break;
            }
            if let Some(level) = ridge.map(|ridge| ridge.lengths.level)
                && (refused.is_nan() || (level / refused - 1.0).abs() > SAME)
                && level > low.0
                && level * (1.0 - COARSE) < high.0
            {
                candidate = Some((level, false));
                p = level * (1.0 - COARSE);
                continue;
            }
            p = if high.0 == f64::INFINITY && step == 2 && share < 1.0 - CUT_OFF {
                // If no height clears s, the highest one shows it.
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
        let high = (high.0 < f64::INFINITY).then_some(high.0)?;
        if let Some(QuickLevel { level, .. }) = quick.filter(|quick| quick.is_exact && high > quick.level * (1.0 - FAR)) {
            return Some(level);
        }
        let near = high * (1.0 - CUT_OFF)..=high * (1.0 + COARSE);
        let general = Section::new(&self.body, pattern, 2.0 * s).level_within(s, high, f64::INFINITY, &near);
        // A search that ends at an end of the range has found no height.
        let is_inside = general > near.start() * (1.0 + SAME) && general < near.end() * (1.0 - SAME);
        Some(if is_inside { general } else { high })
    }

    /// An approximation of the largest step-over that keeps the height p, at most `largest`: a ridge, or the width of the
    /// outline.
    pub(super) fn step_over_on_concave(&self, p: f64, pattern: Pattern, largest: f64) -> f64 {
        let outlook = Outlook::new(&self.body, p, self.body.reach() + largest);
        let rows = self.rows(&outlook, outlook.first(), p, &pattern);
        let (f, deepest) = (pattern.spacing, pattern.deepest_spacing());
        let cleared = |share: f64| rows.cleared(share * f, share * deepest).filter(|cleared| cleared.width() > 0.0);
        let here = if f == 0.0 { Some(rows.extent()) } else { cleared(1.0) };
        let near = here.or_else(|| cleared(1.0 - COARSE));
        let ridge = near.and_then(|cleared| {
            let lengths = Lengths { level: p, step_over: cleared.width(), mark_spacing: f };
            let step_over = self.ridge(&pattern, Sought::StepOver, lengths, &cleared)?.lengths.step_over;
            let share = Self::share(&rows, step_over, &pattern).map_or(0.0, |(share, _)| share);
            (1.0 - CUT_OFF..1.0 + COARSE).contains(&share).then_some(step_over)
        });
        ridge.or_else(|| here.map(|cleared| cleared.width())).unwrap_or(0.0).min(largest)
    }

    /// An approximation of the largest distance of marks that keeps the height p in passes s apart, at most `largest`, from a
    /// ridge or the outline; `None` if none does from [`Length::SMALLEST`] on.
    pub(super) fn feed_on_concave(&self, p: f64, s: f64, largest: f64) -> Option<f64> {
        let outlook = Outlook::new(&self.body, p, self.body.reach() + s);
        let rows = self.rows(&outlook, outlook.first(), p, &self.pattern(largest));
        let cleared = |feed: f64| rows.cleared(feed, self.pattern(feed).deepest_spacing()).filter(|cleared| cleared.width() >= s);
        let (mut low, mut high) = ((0.0, None), largest);
        if let Some(cleared) = cleared(largest) {
            low = (largest, Some(cleared));
        }
        while high - low.0 > 0.003 * high && high > 0.5 * Length::SMALLEST {
            let middle = if low.0 > 0.0 { f64::midpoint(low.0, high) } else { high / 4.0 };
            match cleared(middle) {
                Some(cleared) => low = (middle, Some(cleared)),
                None => high = middle,
            }
        }
        let (feed, near) = low;
        let ridge = near.and_then(|cleared| {
            let lengths = Lengths { level: p, step_over: s, mark_spacing: feed };
            let feed = self.ridge(&self.pattern(feed), Sought::MarkSpacing, lengths, &cleared)?.lengths.mark_spacing;
            let share = Self::share(&rows, s, &self.pattern(feed)).map_or(0.0, |(share, _)| share);
            (1.0 - CUT_OFF..1.0 + COARSE).contains(&share).then_some(feed)
        });
        let value = ridge.unwrap_or(feed).min(largest);
        (value >= Length::SMALLEST).then_some(value)
    }
}
