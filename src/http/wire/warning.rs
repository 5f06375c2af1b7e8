//! Warnings of an answer.

use crate::http::codes::{WarningCode, same_names};
use crate::milling::ModelWarning;
use serde::Serialize;
use utoipa::ToSchema;

/// A fact about an answered request that needs attention.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct Warning {
    pub(crate) code: WarningCode,
    /// An explanation for people; for several contacts, that of the first.
    pub(crate) detail: String,
    /// The number of contacts of a batch that have the warning.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) contacts: Option<usize>,
    /// The index of the first such contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) first_index: Option<usize>,
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
