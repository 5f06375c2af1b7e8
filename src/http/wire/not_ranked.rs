//! Wire object of a cutter that is not ranked, with the reason.

use super::answer;
use crate::http::codes::NotRankedCode;

answer! {
    /// A cutter that is not ranked, and the reason.
    #[derive(Clone, PartialEq)]
    #[schema(as = NotRankedCutter)]
    pub(crate) struct NotRanked {
        /// The position of the cutter in the request, from 0; cutters of libraries follow, and then their faulty tools.
        pub(crate) cutter: usize,
        /// The cutter's name, if it has one.
        pub(crate) name?: String,
        pub(crate) code: NotRankedCode,
        /// The reason in words, for people.
        pub(crate) detail: String,
        /// The share of the area that the cutter leaves uncut; only with the code `cannot-reach`.
        pub(crate) uncut_share?: f64 [minimum = 0, maximum = 1],
        /// The largest height that the cutter leaves there; only with the code `cannot-reach`.
        pub(crate) uncut_height_mm?: f64 [minimum = 0],
    }
}

impl NotRanked {
    pub(crate) fn new(cutter: usize, name: Option<String>, code: NotRankedCode, detail: String) -> Self {
        Self { cutter, name, code, detail, uncut_share: None, uncut_height_mm: None }
    }
}
