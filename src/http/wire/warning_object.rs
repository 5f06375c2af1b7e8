//! Warnings of an answer, and cutters that are not ranked.

use super::answer;
use crate::http::codes::{NotRankedCode, WarningCode, same_names};
use crate::milling::ModelWarning;

answer! {
    /// A fact about an answered request that needs attention.
    #[derive(Clone)]
    pub(crate) struct Warning {
        pub(crate) code: WarningCode,
        /// An explanation for people; for several contacts, that of the first.
        pub(crate) detail: String,
        /// The number of contacts of a batch that have the warning.
        pub(crate) contacts?: usize,
        /// The index of the first such contact.
        pub(crate) first_index?: usize,
    }
}

impl Warning {
    pub(crate) fn new(code: WarningCode, detail: impl Into<String>) -> Self {
        Self { code, detail: detail.into(), contacts: None, first_index: None }
    }
}

same_names! {
    ModelWarning => WarningCode:
    RunoutNotSmall, StepOverWide, FeedPerToothLong, EffectiveRadiusBeyondCutter, SharpMarks, CurvatureApproximate, NearGouging,
}

impl From<ModelWarning> for Warning {
    fn from(warning: ModelWarning) -> Self {
        Self::new(warning.into(), warning.to_string())
    }
}

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
