//! The condition that a pass clears a lateral offset: the chords along the feed that the cutter's section must contain
//! there, for teeth of equal depth and with runout.

use super::body::Body;
use super::chord::{Accuracy, Chord, Marks, Shift};

/// The marks that clear an offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Clearing {
    /// Marks of equal depth. Their spacing is `feeds` times that of neighbouring marks, less `less`; each is `drop` shallower than
    /// a mark of the deepest tooth.
    Even {
        /// 1 for neighbouring teeth, z for the deepest tooth alone.
        feeds: f64,
        /// z times the displacement of shallow marks for the deepest tooth alone, otherwise 0.
        less: f64,
        /// delta for shallow teeth, otherwise 0.
        drop: f64,
    },
    /// A deep mark and one that is `drop` shallower, before or behind it. The order that clears less counts.
    Mixed {
        /// delta.
        drop: f64,
    },
}

/// A row of the section: its lateral offset, its height, and the feed per tooth of the marks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) t: f64,
    pub(super) p: f64,
    pub(super) feed: f64,
}

/// The chord that limits, and the derivatives of the chords' ends by the other unknowns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held {
    pub(super) chord: Chord,
    pub(super) shifts: [Shift; 2],
}

impl Clearing {
    /// The marks of neighbouring teeth without runout.
    pub(super) const EVEN: Self = Self::Even { feeds: 1.0, less: 0.0, drop: 0.0 };

    /// The distance of the marks at a feed per tooth.
    pub(super) fn spacing(&self, feed: f64) -> f64 {
        match self {
            Self::Even { feeds, less, .. } => feeds * feed - less,
            Self::Mixed { .. } => feed,
        }
    }

    /// The pairs of marks that the section must all contain, at a feed per tooth.
    fn pairs(&self, feed: f64) -> (Marks, Option<Marks>) {
        match *self {
            Self::Even { feeds, less, drop } => (Marks { spacing: feeds * feed - less, front_drop: drop, back_drop: drop }, None),
            Self::Mixed { drop } => {
                let before = Marks { spacing: feed, front_drop: drop, back_drop: 0.0 };
                (before, Some(Marks { front_drop: 0.0, back_drop: drop, ..before }))
            }
        }
    }

    /// The chord in a row whose further end is furthest outside. `x` has the front end of each chord: the start of its
    /// search, and afterwards its result.
    #[inline]
    pub(super) fn search(&self, body: &Body, x: &mut [f64; 2], row: Row, accuracy: Accuracy, reach: f64) -> Held {
        let Row { t, p, feed } = row;
        let (one, other) = self.pairs(feed);
        let first = Chord::search(body, &mut x[0], t, p, &one, accuracy, reach);
        let second = other.map(|marks| Chord::search(body, &mut x[1], t, p, &marks, accuracy, reach));
        self.limiting(first, second)
    }

    /// As [`Clearing::search`], with the chords that `find` returns for the first pair of marks and for the second, if there
    /// is one.
    pub(super) fn held(&self, feed: f64, mut find: impl FnMut(usize, &Marks) -> Option<Chord>) -> Option<Held> {
        let (one, other) = self.pairs(feed);
        let first = find(0, &one)?;
        let second = match other {
            Some(marks) => Some(find(1, &marks)?),
            None => None,
        };
        Some(self.limiting(first, second))
    }

    #[inline]
    fn limiting(&self, first: Chord, second: Option<Chord>) -> Held {
        let mut shifts = [first.shift, second.map_or(first.shift, |second| second.shift)];
        let mut chord = match second {
            Some(second) => {
                let furthest = first.furthest.max(second.furthest);
                Chord { furthest, ..if first.value >= second.value { first } else { second } }
            }
            None => first,
        };
        if let Self::Even { feeds, .. } = self {
            // The distance of the marks grows by this much when the feed grows by 1.
            chord.by_spacing *= feeds;
            for shift in &mut shifts {
                shift.by_spacing *= feeds;
            }
        }
        Held { chord, shifts }
    }

    /// The distance of the chords in a row from the section, negative inside. The search starts at `x`.
    pub(super) fn outside(&self, body: &Body, mut x: [f64; 2], row: Row, reach: f64) -> f64 {
        self.search(body, &mut x, row, Accuracy::full(row.p), reach).chord.value
    }

    /// Whether the chords and the lines from the contact to their ends are inside the body, tested at a few points on
    /// them.
    pub(super) fn is_seen(&self, body: &Body, x: [f64; 2], Row { t, p, feed }: Row) -> bool {
        let (one, other) = self.pairs(feed);
        [Some(one), other].into_iter().zip(x).filter_map(|(marks, x)| Some((marks?, x))).all(|(marks, x)| {
            let (front, back) = (p - marks.front_drop, p - marks.back_drop);
            let highest = front.max(back);
            let inside = |share: f64| body.distance(x - share * marks.spacing, t, highest).value <= 1e-9 * p;
            body.reaches(x, t, front) && body.reaches(x - marks.spacing, t, back) && [0.25, 0.5, 0.75].into_iter().all(inside)
        })
    }
}
