//! Answers to requests that the server refuses under load: status 503 with `Retry-After`.

use std::fmt;

use axum::response::{IntoResponse, Response};

use super::codes::ServiceProblem;
use super::problem::Problem;
use crate::budget::NoMemory;

/// The value of `Retry-After`. Resources become free within milliseconds unless the load persists.
const RETRY_AFTER_S: u32 = 1;

/// The limit that a request would exceed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overload {
    /// The limit of requests in flight is reached.
    InFlight,
    /// The limit of requests that use the worker pool is reached.
    Workers,
    /// The memory budget is exhausted.
    Memory,
}

impl Overload {
    /// The limits whose refusals the metrics count; the memory budget counts its own.
    pub(crate) const ALL: [Self; 2] = [Self::InFlight, Self::Workers];

    /// The value of the label `reason` in the metrics.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::InFlight => "in_flight",
            Self::Workers => "workers",
            Self::Memory => "memory",
        }
    }
}

impl fmt::Display for Overload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InFlight => write!(f, "as many requests as are accepted at once are in flight"),
            Self::Memory => write!(f, "the memory for requests is in use"),
            Self::Workers => write!(f, "as many uploads and batches as are accepted at once are being worked on"),
        }
    }
}

impl std::error::Error for Overload {}

impl From<Overload> for Problem {
    fn from(overload: Overload) -> Self {
        Self::new(ServiceProblem::Overloaded, overload.to_string()).retry_after(RETRY_AFTER_S)
    }
}

impl From<NoMemory> for Problem {
    fn from(_: NoMemory) -> Self {
        Overload::Memory.into()
    }
}

impl IntoResponse for Overload {
    fn into_response(self) -> Response {
        Problem::from(self).into_response()
    }
}
