//! Warnings: what is answered but must be looked at.

use crate::http::codes::WarningCode;
use crate::milling::{Concern, JudgedPass, Model, circle_concerns, concerns};
use crate::quantity::Length;
use serde::Serialize;
use std::fmt;
use utoipa::ToSchema;

/// What must be looked at although the answer stands.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct Warning {
    pub(crate) code: WarningCode,
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
    pub(crate) fn new(code: WarningCode, detail: impl Into<String>) -> Self {
        Self { code, detail: detail.into(), contacts: None, first_index: None }
    }
}

/// An assumption of the models near its limit at a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ModelWarning {
    /// An assumption of the milling models.
    Concern(Concern),
    /// The envelope's correction for a curved surface is not exact.
    CurvatureApproximate,
}

/// The warnings of a contact.
pub(crate) fn model_warnings(
    pass: &JudgedPass,
    step_over: Length,
    feed_per_tooth: Option<Length>,
) -> impl Iterator<Item = ModelWarning> + use<> {
    let analytic = pass.model() == Model::Analytic;
    let circle = analytic.then(|| circle_concerns(pass.pass(), step_over, feed_per_tooth)).into_iter().flatten();
    let curved = (!analytic && pass.pass().surface.radius().is_some()).then_some(ModelWarning::CurvatureApproximate);
    concerns(pass.pass(), feed_per_tooth).chain(circle).map(ModelWarning::Concern).chain(curved)
}

/// The code of a warning.
pub(crate) fn warning_code(warning: ModelWarning) -> WarningCode {
    match warning {
        ModelWarning::Concern(Concern::RunoutNotSmall { .. }) => WarningCode::RunoutNotSmall,
        ModelWarning::Concern(Concern::StepOverWide { .. }) => WarningCode::StepOverWide,
        ModelWarning::Concern(Concern::FeedLong { .. }) => WarningCode::FeedPerToothLong,
        ModelWarning::Concern(Concern::RadiusBeyondCutter { .. }) => WarningCode::EffectiveRadiusBeyondCutter,
        ModelWarning::Concern(Concern::SharpMarks) => WarningCode::SharpMarks,
        ModelWarning::CurvatureApproximate => WarningCode::CurvatureApproximate,
    }
}

impl fmt::Display for ModelWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Concern(concern) => concern.fmt(f),
            Self::CurvatureApproximate => f.write_str(
                "the surface's curvature enters by a correction taken from the analytic model; this part of the height is not exact",
            ),
        }
    }
}

impl From<ModelWarning> for Warning {
    fn from(warning: ModelWarning) -> Self {
        Self::new(warning_code(warning), warning.to_string())
    }
}
