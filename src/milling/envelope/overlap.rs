//! The lengths up to which passes and marks overlap, and the refusals of longer ones.

use super::Envelope;
use super::cutter_body::STEEPEST;
use crate::milling::NoAnswer;
use crate::quantity::Length;

/// The share by which the largest length that a refusal states may be smaller than the largest that has a height on a curved
/// surface.
const STATED: f64 = 0.01;

impl Envelope {
    /// d/s, the ratio of the passes' distance seen from above to that along the surface: cos(S) / cos(climb). Seen from
    /// above, a unit square with a side along the feed has the area cos(S), and that side the length cos(climb). On a
    /// wall the ratio is 1 for the vertical feed and 0 for any other; only omega distinguishes feeds there.
    fn spacing_ratio(&self) -> f64 {
        if self.climb.cos() == 0.0 { 1.0 } else { self.contact().slope().cos().abs() / self.climb.cos() }
    }

    /// Whether passes s apart with marks f apart overlap, seen from above. The largest step-over and feed lie on the
    /// limit, up to a few rounding errors.
    pub(super) fn overlap(&self, s: f64, f: f64) -> bool {
        let (across, along) = (s * self.spacing_ratio(), f * self.climb.cos());
        let diameter = 2.0 * self.outer_radius * (1.0 + 16.0 * f64::EPSILON);
        across * across + along * along <= diameter * diameter
    }

    /// The reason why passes s apart with a feed per tooth have no height: they do not overlap seen from above, or on a curved
    /// surface the grooves or the marks do not meet.
    pub(super) fn no_height(&self, s: f64, feed: f64) -> NoAnswer {
        if feed == 0.0 || self.height(s, 0.0).is_none() {
            // With a feed at which no passes overlap, the feed is the next thing to change.
            let with_marks = Some(self.largest_met_step_over(feed)).filter(|step_over| feed > 0.0 && *step_over >= Length::SMALLEST);
            let largest_step_over = with_marks.unwrap_or_else(|| self.largest_met_step_over(0.0));
            return NoAnswer::PassesDoNotOverlap { largest_step_over: Length::computed(largest_step_over) };
        }
        let largest = self.pattern.feed_per_tooth(self.largest_spacing(s));
        let met = if self.pass.surface.is_plane() { largest } else { largest_met(largest, |feed| self.height(s, feed).is_some()) };
        NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(met) }
    }

    /// The largest step-over at which passes with a feed per tooth meet; on a curved surface one that is smaller by at most
    /// [`STATED`].
    fn largest_met_step_over(&self, feed: f64) -> f64 {
        let overlapping = self.largest_step_over(self.pattern.spacing(feed));
        if self.pass.surface.is_plane() {
            overlapping
        } else {
            // An answer has both heights.
            largest_met(overlapping, |s| [feed, 0.0].into_iter().all(|feed| self.height(s, feed).is_some()))
        }
    }

    /// The step-over up to which passes with marks f apart overlap, seen from above, and grooves meet on a curved
    /// surface. It is reduced by a rounding error, so that it is itself in the domain, and is at most the largest
    /// accepted length.
    pub(super) fn largest_step_over(&self, f: f64) -> f64 {
        let on_plane = largest_leg(2.0 * self.outer_radius, f * self.climb.cos(), self.spacing_ratio());
        on_plane.min(2.0 * STEEPEST / self.pass.surface.across_per_mm().abs())
    }

    /// The distance up to which marks overlap, seen from above, in passes s apart.
    pub(super) fn largest_spacing(&self, s: f64) -> f64 {
        largest_leg(2.0 * self.outer_radius, s * self.spacing_ratio(), self.climb.cos())
    }
}

/// The largest length, at most `length`, that has a height, to [`STATED`]: 0 if none has down to the smallest.
fn largest_met(length: f64, has_height: impl Fn(f64) -> bool) -> f64 {
    if has_height(length) {
        return length;
    }
    let mut high = length;
    let mut low = loop {
        let low = high / 2.0;
        if low < Length::SMALLEST {
            return 0.0;
        }
        if has_height(low) {
            break low;
        }
        high = low;
    };
    while high - low > STATED * high {
        let middle = f64::midpoint(low, high);
        if has_height(middle) { low = middle } else { high = middle }
    }
    low
}

/// The length x for which `ratio` x and `leg` are the legs of a right triangle with the hypotenuse `hypotenuse`. It is
/// reduced by a rounding error, and at most the largest accepted length.
fn largest_leg(hypotenuse: f64, leg: f64, ratio: f64) -> f64 {
    let room = ((hypotenuse - leg) * (hypotenuse + leg)).max(0.0).sqrt();
    (room / ratio * (1.0 - 4.0 * f64::EPSILON)).min(Length::LARGEST)
}
