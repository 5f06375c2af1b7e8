//! Wire objects of an answer's confidence: its level, and the weaknesses of the method on this surface.

use super::surface_answer::UnitDoubt;
use crate::http::codes::{ConfidenceCode, same_names};
use crate::http::wire::answer;
use crate::planning::{Confidence, Level, Reason};
use serde::Serialize;
use std::fmt::Display;
use utoipa::ToSchema;

answer! {
    /// The reliability of a recommendation.
    #[schema(as = Confidence)]
    pub(super) struct ConfidenceAnswer {
        /// `high`: the surface is of the kind for which the method is intended; `moderate`: the times are estimates; `low`:
        /// the recommendation may be wrong.
        level: LevelName,
        /// The reasons why the level is not high, the most important first.
        reasons: Vec<ReasonAnswer>,
    }
}

/// A level of confidence.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ConfidenceLevel)]
enum LevelName {
    High,
    Moderate,
    Low,
}

answer! {
    /// A weakness of the method on this surface.
    #[schema(as = ConfidenceReason)]
    struct ReasonAnswer {
        code: ConfidenceCode,
        /// The level to which it lowers the confidence.
        level: LevelName,
        /// An explanation for people.
        detail: String,
        /// The figure on which the reason is based, in the unit that `detail` names.
        value: f64,
        /// The threshold that the figure crossed, in the same unit.
        threshold: f64,
    }
}

impl<W: Copy + Into<ConfidenceCode>> From<&Confidence<W>> for ConfidenceAnswer
where
    Reason<W>: Display,
{
    fn from(confidence: &Confidence<W>) -> Self {
        let reasons = confidence.reasons().iter().map(|reason| ReasonAnswer {
            code: reason.weakness.into(),
            level: reason.level.into(),
            detail: reason.to_string(),
            value: reason.figure,
            threshold: reason.threshold,
        });
        Self { level: confidence.level().into(), reasons: reasons.collect() }
    }
}

impl ConfidenceAnswer {
    /// This confidence, low if there is a doubt about the unit.
    pub(super) fn doubting(mut self, doubt: Option<&UnitDoubt>) -> Self {
        if let Some(UnitDoubt { side_mm, bound_mm, detail }) = doubt {
            self.level = LevelName::Low;
            let code = ConfidenceCode::UnitUnlikely;
            let reason = ReasonAnswer { code, level: LevelName::Low, detail: detail.clone(), value: *side_mm, threshold: *bound_mm };
            self.reasons.insert(0, reason);
        }
        self
    }
}

same_names!(Level => LevelName: High, Moderate, Low);
