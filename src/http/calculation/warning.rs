//! Warnings: what is answered but must be looked at.

use crate::milling::{JudgedPass, ModelWarning};
use crate::quantity::Length;
use serde::Serialize;
use std::borrow::Cow;
use utoipa::ToSchema;

/// What must be looked at although the answer stands.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct Warning {
    /// Which: a stable name to decide by.
    #[schema(example = "step-over-wide")]
    pub(crate) code: Cow<'static, str>,
    /// What it is about, for a person; of the first contact where there are many.
    pub(crate) detail: String,
    /// How many contacts of a batch it concerns.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) contacts: Option<usize>,
    /// The index of the first such contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) first_index: Option<usize>,
}

impl Warning {
    pub(crate) fn new(code: &'static str, detail: impl Into<String>) -> Self {
        Self { code: code.into(), detail: detail.into(), contacts: None, first_index: None }
    }
}

/// A warning of the milling models, with its stable name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strain(ModelWarning);

impl Strain {
    /// All of one contact.
    pub(super) fn of(pass: &JudgedPass, step_over: Length, feed_per_tooth: Option<Length>) -> impl Iterator<Item = Self> + use<> {
        pass.warnings(step_over, feed_per_tooth).map(Self)
    }

    /// Its stable name.
    pub(super) fn code(self) -> &'static str {
        match self.0 {
            ModelWarning::RunoutNotSmall { .. } => "runout-not-small",
            ModelWarning::StepOverWide { .. } => "step-over-wide",
            ModelWarning::FeedPerToothLong { .. } => "feed-per-tooth-long",
            ModelWarning::EffectiveRadiusBeyondCutter { .. } => "effective-radius-beyond-cutter",
            ModelWarning::SharpMarks => "sharp-marks",
            ModelWarning::CurvatureApproximate => "curvature-approximate",
            ModelWarning::NearGouging { .. } => "near-gouging",
        }
    }
}

impl std::fmt::Display for Strain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

impl From<Strain> for Warning {
    fn from(strain: Strain) -> Self {
        Self::new(strain.code(), strain.to_string())
    }
}
