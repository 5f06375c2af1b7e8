//! Warnings: what is answered but must be looked at.

use crate::http::codes::WarningCode;
use crate::milling::{Concern, JudgedPass, Model, circle_concerns, concerns};
use crate::quantity::Length;
use serde::Serialize;
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

/// What strains the assumptions under which a contact was worked out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Strain {
    /// An assumption of the milling models.
    Concern(Concern),
    /// The envelope's correction for a curved surface is not exact.
    CurvatureApproximate,
}

impl Strain {
    /// All of one contact.
    pub(super) fn of(pass: &JudgedPass, step_over: Length, feed_per_tooth: Option<Length>) -> impl Iterator<Item = Self> + use<> {
        let analytic = pass.model() == Model::Analytic;
        let circle = analytic.then(|| circle_concerns(pass.pass(), step_over, feed_per_tooth)).into_iter().flatten();
        let curved = (!analytic && pass.pass().surface.radius().is_some()).then_some(Self::CurvatureApproximate);
        concerns(pass.pass(), feed_per_tooth).chain(circle).map(Self::Concern).chain(curved)
    }

    /// Its code.
    pub(super) fn code(self) -> WarningCode {
        match self {
            Self::Concern(Concern::RunoutNotSmall { .. }) => WarningCode::RunoutNotSmall,
            Self::Concern(Concern::StepOverWide { .. }) => WarningCode::StepOverWide,
            Self::Concern(Concern::FeedLong { .. }) => WarningCode::FeedPerToothLong,
            Self::Concern(Concern::RadiusBeyondCutter { .. }) => WarningCode::EffectiveRadiusBeyondCutter,
            Self::Concern(Concern::SharpMarks) => WarningCode::SharpMarks,
            Self::CurvatureApproximate => WarningCode::CurvatureApproximate,
        }
    }
}

impl std::fmt::Display for Strain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Concern(concern) => concern.fmt(f),
            Self::CurvatureApproximate => f.write_str(
                "the surface's curvature enters by a correction taken from the analytic model; this part of the height is not exact",
            ),
        }
    }
}

impl From<Strain> for Warning {
    fn from(strain: Strain) -> Self {
        Self::new(strain.code(), strain.to_string())
    }
}
