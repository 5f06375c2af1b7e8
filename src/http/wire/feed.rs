//! The feed per tooth of a request. 0 means no tooth marks.

use crate::http::reading::{Quantity, members};
use crate::quantity::{Length, OutOfRange};

members! {
    /// The feed per tooth.
    pub(super) struct FeedMembers {
        feed_per_tooth: optional FEED_PER_TOOTH: Quantity<Feed> = ("feed_per_tooth_mm", Quantity::new(Feed::from_mm, 0.3).down_to(0.0, "; or 0 for no tooth marks"),
            "feed per tooth f_z, at least 1e-6; 0 or absent = no tooth marks"),
    }
}

/// A stated feed per tooth. 0 means no tooth marks and overrides the default.
#[derive(Debug, Clone, Copy)]
pub(super) enum Feed {
    NoMarks,
    PerTooth(Length),
}

impl Feed {
    fn from_mm(feed: f64) -> Result<Self, OutOfRange> {
        if feed == 0.0 { Ok(Self::NoMarks) } else { Length::from_mm(feed).map(Self::PerTooth) }
    }

    /// The feed per tooth; `None` without tooth marks.
    pub(super) fn per_tooth(self) -> Option<Length> {
        match self {
            Self::PerTooth(length) => Some(length),
            Self::NoMarks => None,
        }
    }
}
