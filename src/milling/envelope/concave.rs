//! The model on concave surfaces, on which the section at a height need not be convex. Results of the other searches
//! are compared with the section's outline; if they differ, the search is repeated from the outline.

use super::Envelope;
use super::clearing::Clearing;
use super::newton::{self, Lengths, Place, Sought};
use super::outline::{Cleared, Outline, Outlook};
use super::section::{Pattern, Section};
use crate::quantity::Length;

/// The outline, a polygon inside the section, may give a height that is lower than the result by this share. Widths may
/// differ by half as much.
const COARSE: f64 = 0.03;

/// The outline may give a height that is higher by this share, because the polygon cuts off thin tips of the section.
const CUT_OFF: f64 = 0.3;

/// The largest number of steps of the search for a height on the outline, more than a tenth of [`COARSE`] needs.
const MOST_STEPS: usize = 40;

impl Envelope {
    /// The interval that a pattern of marks clears on the outline `deep` at the height p.
    fn cleared_by(outlook: &Outlook<'_>, deep: &Outline, p: f64, pattern: &Pattern) -> Option<Cleared> {
        if pattern.is_even() {
            return deep.cleared(pattern.spacing);
        }
        let shallow = (p > pattern.drop).then(|| outlook.at(p - pattern.drop, deep));
        deep.cleared_by(pattern, shallow.as_ref())
    }

    /// h for passes s apart: `found` if the outline agrees with it, otherwise the result of a search from the outline;
    /// `None` if no height clears s. `is_clear` states that `found` clears s, so that only lower heights are searched.
    pub(super) fn height_on_concave(&self, s: f64, pattern: Pattern, found: Option<f64>, is_clear: bool) -> Option<f64> {
        let highest = 4.0 * self.cutter.outer_radius().mm();
        let found = found.filter(|found| *found < highest);
        let mut p = found.map_or_else(|| self.guess(s, pattern), |found| found * (1.0 - COARSE));
        let outlook = Outlook::new(&self.body, p);
        let mut near = *outlook.first();
        let mut cleared = |p: f64, is_first: bool| {
            if !is_first {
                near = outlook.at(p, &near);
            }
            Self::cleared_by(&outlook, &near, p, &pattern)
        };
        let width = |cleared: Option<&Cleared>| cleared.map_or(0.0, Cleared::width);
        let (mut low, mut high) = ((0.0, 0.0), (f64::INFINITY, f64::INFINITY));
        let mut at_high = None;
        for step in 0..MOST_STEPS {
            let outline = cleared(p, step == 0);
            let wide = width(outline.as_ref());
            if wide >= s {
                (high, at_high) = ((p, wide), outline);
            } else {
                low = (p, wide);
            }
            if let Some(found) = found
                && step == 0
                && wide < s
            {
                if is_clear {
                    return Some(found);
                }
                // If the outline is wide enough at a slightly higher p, `found` is right.
                p = found * (1.0 + CUT_OFF);
                continue;
            }
            if let Some(found) = found
                && step == 1
                && low.0 > 0.0
                && wide >= s
            {
                return Some(found);
            }
            if high.0 < f64::INFINITY && high.0 - low.0 <= 0.5 * COARSE * high.0 || low.0 >= highest {
                break;
            }
            // The square of the width is nearly linear in the height.
            let linear = if high.0 < f64::INFINITY && high.1 > low.1 {
                low.0 + (high.0 - low.0) * (s * s - low.1 * low.1) / (high.1 * high.1 - low.1 * low.1)
            } else {
                p * (s / wide).powi(2)
            };
            p = if high.0 == f64::INFINITY {
                linear.clamp(1.5 * p, 16.0 * p).min(highest)
            } else if step % 3 == 2 {
                if high.0 > 4.0 * low.0 { (high.0 * low.0.max(high.0 / 4096.0)).sqrt() } else { f64::midpoint(low.0, high.0) }
            } else {
                let room = 0.2 * COARSE * high.0;
                linear.clamp(low.0 + room, high.0 - room)
            };
        }
        let (cleared, high) = (at_high?, high.0);
        let lengths = Lengths { level: high, step_over: s, mark_spacing: pattern.spacing };
        let agrees = |level: &f64| (high * (1.0 - CUT_OFF)..=high * (1.0 + COARSE)).contains(level);
        let quick = self.polished(&pattern, lengths, &cleared, Sought::Level).map(|lengths| lengths.level).filter(agrees);
        let general = || Some(Section::new(&self.body, pattern, 2.0 * s).level(s, high, f64::INFINITY)).filter(agrees);
        Some(quick.or_else(general).unwrap_or(high))
    }

    /// The largest step-over, at most `largest`, that keeps the height p. It is `found`, which keeps p, unless the
    /// outline has a larger one; then it is the result of a search from the outline.
    pub(super) fn step_over_on_concave(&self, p: f64, pattern: Pattern, found: Option<f64>, largest: f64) -> f64 {
        let under = p * (1.0 - COARSE);
        let outlook = Outlook::new(&self.body, under);
        let cleared = |p: f64| Self::cleared_by(&outlook, &outlook.at(p, outlook.first()), p, &pattern);
        let width = |p: f64| cleared(p).map_or(0.0, |cleared| cleared.width()).min(largest);
        let least = Self::cleared_by(&outlook, outlook.first(), under, &pattern).map_or(0.0, |cleared| cleared.width()).min(largest);
        if let Some(found) = found.filter(|found| *found >= least) {
            return found;
        }
        let most = width(p * (1.0 + CUT_OFF));
        let agrees = |step_over: &f64| (least..=most).contains(step_over);
        let quick = cleared(p).and_then(|cleared| {
            let lengths = Lengths { level: p, step_over: cleared.width(), mark_spacing: pattern.spacing };
            self.polished(&pattern, lengths, &cleared, Sought::StepOver).map(|lengths| lengths.step_over)
        });
        let general = || Some(Section::new(&self.body, pattern, 2.0 * largest).width(p)).filter(agrees);
        quick.filter(agrees).or_else(general).unwrap_or_else(|| width(p))
    }

    /// The largest feed per tooth, at most `largest`, that keeps the height p in passes s apart. It is `found`, which
    /// keeps p, unless the outline has a larger one; then it is the result of a search from the outline.
    pub(super) fn feed_on_concave(&self, p: f64, s: f64, found: Option<f64>, largest: f64) -> Option<f64> {
        let outlook = Outlook::new(&self.body, p * (1.0 - COARSE));
        let with_shallow = |deep: Outline, p: f64| (deep, (self.drop > 0.0 && p > self.drop).then(|| outlook.at(p - self.drop, &deep)));
        let outlines = |p: f64| with_shallow(outlook.at(p, outlook.first()), p);
        let cleared = |(deep, shallow): &(Outline, Option<Outline>), feed: f64| {
            let pattern = self.pattern(feed);
            if pattern.is_even() { deep.cleared(feed) } else { deep.cleared_by(&pattern, shallow.as_ref()) }
        };
        let is_wide =
            |outlines: &(Outline, Option<Outline>), feed: f64| cleared(outlines, feed).is_some_and(|cleared| cleared.width() >= s);
        let under = with_shallow(*outlook.first(), outlook.height());
        if let Some(found) = found.filter(|found| !is_wide(&under, *found)) {
            return Some(found);
        }
        let (here, over) = (outlines(p), outlines(p * (1.0 + CUT_OFF)));
        let agrees = |feed: &f64| is_wide(&over, *feed) && !is_wide(&under, *feed);
        if is_wide(&here, largest) {
            return Some(largest);
        }
        let (mut low, mut high) = (0.0, largest);
        while high - low > 0.1 * COARSE * high {
            let middle = if low > 0.0 { f64::midpoint(low, high) } else { high / 4.0 };
            if is_wide(&here, middle) {
                low = middle;
            } else {
                high = middle;
            }
            if high < Length::SMALLEST {
                return None;
            }
        }
        let pattern = self.pattern(low);
        let lengths = Lengths { level: p, step_over: s, mark_spacing: low };
        let quick = cleared(&here, low).and_then(|cleared| self.polished(&pattern, lengths, &cleared, Sought::MarkSpacing));
        let quick = quick.map(|lengths| lengths.mark_spacing).filter(agrees);
        let general = || self.feed_between(p, s, (low * (1.0 - CUT_OFF)).max(Length::SMALLEST), (low * (1.0 + CUT_OFF)).min(largest));
        Some(quick.or_else(|| general().filter(agrees)).unwrap_or(low))
    }

    /// The ridge by Newton's method, starting from the ridge on the outline.
    fn polished(&self, pattern: &Pattern, lengths: Lengths, cleared: &Cleared, sought: Sought) -> Option<Lengths> {
        if !pattern.is_even() || !self.is_quick(pattern.spacing) {
            return None;
        }
        let place = Place { t: cleared.right, x: [cleared.right_x; 2], neighbour_x: [cleared.left_x; 2] };
        newton::solve_from(&self.body, sought, lengths, place, [Clearing::EVEN; 2]).map(|ridge| ridge.lengths)
    }
}
