//! What stands beside the figures of an answer: the check against the envelope, and the failures and extremes of a batch.

use crate::http::codes::FaultCode;
use crate::http::reading::Fault;
use serde::Serialize;
use utoipa::ToSchema;

/// The analytic height beside the envelope's.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct Check {
    /// The height by the cutter's exact shape, model `envelope`.
    #[schema(minimum = 0)]
    pub(crate) envelope_scallop_height_mm: f64,
    /// (height - envelope) / envelope: negative where the model promises less than the cutter leaves. Absent where the envelope's height is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = -1)]
    pub(crate) deviation: Option<f64>,
}

/// A contact of a batch that has no answer.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct Failure {
    /// Which contact, counted from 0.
    pub(crate) index: usize,
    /// Where: a JSON pointer (RFC 6901) into the request.
    #[schema(example = "/contacts/17/slope_deg")]
    pub(crate) pointer: String,
    pub(crate) code: FaultCode,
    /// What is wrong and what would be right, for a person; further faults of the contact follow the first, each after its pointer.
    pub(crate) detail: String,
}

impl Failure {
    /// Of the contact's faults, of which there is at least one.
    pub(crate) fn new(index: usize, faults: &[Fault]) -> Option<Self> {
        let (first, further) = faults.split_first()?;
        let further = further.iter().map(|fault| format!("; {}: {}", fault.pointer, fault.detail));
        let detail = std::iter::once(first.detail.clone()).chain(further).collect();
        Some(Self { index, pointer: first.pointer.clone(), code: first.code, detail })
    }
}

/// A contact with an extreme figure.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub(crate) struct Extreme {
    /// Which contact, counted from 0.
    pub(crate) index: usize,
    /// Its figure, in mm: of the scallop height, the feed per tooth or the step-over, whichever the calculation finds.
    pub(crate) value_mm: f64,
}

/// A batch in short.
#[derive(Debug, Clone, Default, Serialize, ToSchema)]
pub(crate) struct Summary {
    /// How many contacts were sent.
    pub(crate) count: usize,
    /// How many have no answer.
    pub(crate) failures: usize,
    /// The contact with the smallest figure that the calculation finds; absent where none has an answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) minimum: Option<Extreme>,
    /// The contact with the largest one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) maximum: Option<Extreme>,
}
