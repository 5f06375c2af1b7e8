//! The marks of a pass: which pairs of neighbouring marks must cover a place between them, with and without runout.

use crate::milling::Pass;

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
