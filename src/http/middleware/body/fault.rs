//! The rules that a body can break as it arrives, before its content is looked at.

use std::fmt;
use std::time::Duration;

use axum::response::{IntoResponse, Response};

use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;
use crate::memory_budget::BudgetExceeded;

/// The rule that a body broke.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum BodyFault {
    /// More bytes than are accepted, decompressed.
    TooLarge {
        /// How many are accepted.
        max_bytes: u64,
    },
    /// Nothing came for too long.
    Stalled {
        /// How long nothing may come.
        longest: Duration,
    },
    /// It came too slowly on average.
    TooSlow {
        /// The slowest average that is accepted.
        min_bytes_s: u64,
    },
    /// It came in very many tiny pieces.
    Fragmented,
    /// There is no memory to hold it.
    Memory(BudgetExceeded),
    /// It could not be read or decompressed.
    Unreadable(String),
}

impl fmt::Display for BodyFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge { max_bytes } => write!(f, "the body, counted decompressed, is larger than {max_bytes} bytes"),
            Self::Stalled { longest } => write!(f, "nothing of the body came for {} s", longest.as_secs()),
            Self::TooSlow { min_bytes_s } => write!(f, "the body came at less than {min_bytes_s} bytes a second"),
            Self::Fragmented => write!(f, "the body came in too many chunks of a few bytes"),
            Self::Memory(exceeded) => write!(f, "{exceeded}"),
            Self::Unreadable(cause) => write!(f, "the body could not be read: {cause}"),
        }
    }
}

impl std::error::Error for BodyFault {}

impl IntoResponse for BodyFault {
    fn into_response(self) -> Response {
        let kind = match self {
            Self::TooLarge { .. } => ServiceProblem::TooLarge,
            Self::Stalled { .. } | Self::TooSlow { .. } => ServiceProblem::Timeout,
            Self::Unreadable(_) | Self::Fragmented => ServiceProblem::UnreadableBody,
            Self::Memory(exceeded) => return Problem::from(exceeded).into_response(),
        };
        Problem::new(kind, self.to_string()).into_response()
    }
}
