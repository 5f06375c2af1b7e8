//! The marks of a pass: which pairs of neighbouring marks must cover a place between them, with and without runout; and the
//! lengths up to which passes and marks overlap.

use super::Envelope;
use super::cutter_body::STEEPEST;
use crate::milling::{NoAnswer, Pass};
use crate::quantity::Length;

/// Two neighbouring marks of a pass, at x and at x + `distance` along the feed. What is left at a place between them is the
/// higher of what the two leave; `drops` is how much less deep their teeth reach than the deepest one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MarkPair {
    pub(super) distance: f64,
    /// The derivative of the distance by the feed per tooth.
    pub(super) by_feed: f64,
    pub(super) drops: [f64; 2],
}

impl MarkPair {
    /// The drop of a mark half-way between both, which on a plane clears what both clear.
    pub(super) fn half_way_drop(&self) -> f64 {
        f64::midpoint(self.drops[0], self.drops[1])
    }
}

/// The pairs that decide what a pass leaves at a place in the worst phase of its teeth: the lower of `deepest`, the marks of
/// the deepest tooth alone, and the highest of `neighbours`, a deep mark and a shallow one in either order, or two shallow
/// ones. Without runout the deepest marks are all there are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Marks {
    pairs: [MarkPair; 3],
    count: usize,
}

/// The marks by which a pass clears a place: those of the deepest tooth, or all neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Which {
    Deepest,
    Neighbours,
}

impl Which {
    pub(super) fn others(self) -> Self {
        match self {
            Self::Deepest => Self::Neighbours,
            Self::Neighbours => Self::Deepest,
        }
    }
}

/// How runout changes the marks of a pass, for every feed per tooth.
#[derive(Debug, Clone, Copy)]
pub(super) struct MarkPattern {
    /// z, the number of teeth.
    teeth: f64,
    /// delta, how much less deep the shallowest tooth reaches than the deepest.
    drop: f64,
    /// How much longer the distance of neighbouring marks is than the feed per tooth.
    displacement: f64,
    shallow_pairs: bool,
}

impl MarkPattern {
    pub(super) fn new(pass: &Pass) -> Self {
        let shallow_pairs = pass.has_shallow_pairs();
        Self {
            teeth: pass.teeth.map_or(2.0, |teeth| f64::from(teeth.get())),
            drop: pass.runout.depth(pass.contact.slope()),
            displacement: pass.runout.displacement(pass.contact, shallow_pairs),
            shallow_pairs,
        }
    }

    /// The largest distance of neighbouring marks at a feed per tooth; at most that of the deepest tooth's own marks.
    pub(super) fn spacing(&self, feed: f64) -> f64 {
        (feed + self.displacement).min(self.teeth * feed).max(feed)
    }

    /// The feed per tooth of a distance of neighbouring marks, the inverse of [`MarkPattern::spacing`].
    pub(super) fn feed_per_tooth(&self, spacing: f64) -> f64 {
        (spacing - self.displacement).max(spacing / self.teeth)
    }

    /// An approximation of the distance at which marks of equal depth, of the curvature `along`, leave the same height.
    /// Circles of radius P, f apart and with every second one raised by delta, meet as if they were f + 2 P delta / f apart.
    pub(super) fn even_spacing(&self, feed: f64, along: f64) -> f64 {
        let spacing = self.spacing(feed);
        if self.drop == 0.0 || feed == 0.0 {
            spacing
        } else {
            (self.teeth * feed).min(spacing + 2.0 * self.drop / (along * spacing)).max(spacing)
        }
    }

    /// The marks that decide as far as that approximation tells.
    pub(super) fn likely(&self, feed: f64, along: f64) -> Which {
        let is_deep = self.even_spacing(feed, along) >= self.teeth * feed;
        if self.drop == 0.0 || is_deep { Which::Deepest } else { Which::Neighbours }
    }

    /// The marks by which two passes can clear their places.
    pub(super) fn choices(&self, has_marks: bool) -> &'static [[Which; 2]] {
        use Which::{Deepest, Neighbours};
        const ALL: [[Which; 2]; 4] = [[Deepest, Deepest], [Deepest, Neighbours], [Neighbours, Deepest], [Neighbours, Neighbours]];
        if self.drop == 0.0 || !has_marks { &ALL[..1] } else { &ALL }
    }

    /// The marks of a feed per tooth; 0 leaves a groove without marks.
    pub(super) fn marks(&self, feed: f64) -> Marks {
        let (spacing, deep) = (self.spacing(feed), self.teeth * feed);
        let by_feed = if spacing < deep { 1.0 } else { self.teeth };
        let pair = |drops| MarkPair { distance: spacing, by_feed, drops };
        if feed == 0.0 || self.drop == 0.0 || spacing >= deep {
            return Marks { pairs: [pair([0.0; 2]); 3], count: 1 };
        }
        let deepest = MarkPair { distance: deep, by_feed: self.teeth, drops: [0.0; 2] };
        let (one, other) = if self.shallow_pairs {
            (pair([self.drop; 2]), pair([self.drop; 2]))
        } else {
            (pair([0.0, self.drop]), pair([self.drop, 0.0]))
        };
        Marks { pairs: [deepest, one, other], count: if self.shallow_pairs { 2 } else { 3 } }
    }
}

impl Marks {
    /// The pairs, of which the first is that of the deepest marks.
    pub(super) fn pairs(&self) -> &[MarkPair] {
        &self.pairs[..self.count]
    }

    /// The indices of the pairs of some marks.
    pub(super) fn of(&self, which: Which) -> std::ops::Range<usize> {
        match which {
            Which::Deepest => 0..1,
            Which::Neighbours => self.count.min(2) - 1..self.count,
        }
    }
}

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
