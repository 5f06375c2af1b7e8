//! Warnings of an answer.

use super::answer;
use crate::http::codes::{WarningCode, same_names};
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
    RunoutNotSmall, StepOverWide, FeedPerToothLong, EffectiveRadiusBeyondCutter, SharpMarks, CurvatureApproximate, HeightNotABound, NearGouging,
}

impl From<ModelWarning> for Warning {
    fn from(warning: ModelWarning) -> Self {
        Self::new(warning.into(), warning.to_string())
    }
}
