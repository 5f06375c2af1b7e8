//! Requests beyond what is accepted at once are turned away, not queued: a queue would only make everybody late.

use axum::extract::Request;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::weight::Weight;
use crate::http::codes::ServiceProblem;
use crate::http::metrics::{Metrics, ShedReason};
use crate::http::problem::Problem;

/// How many requests may be in flight. Clones share it.
#[derive(Clone)]
pub(super) struct InFlight {
    places: Arc<Semaphore>,
    metrics: Metrics,
}

impl InFlight {
    pub(super) fn new(most: usize, metrics: Metrics) -> Self {
        Self { places: Arc::new(Semaphore::new(most)), metrics }
    }

    /// The place that a request in flight holds until its answer is ready to be sent; probes need none.
    ///
    /// # Errors
    /// The answer to a request for which there is no place.
    #[expect(clippy::result_large_err, reason = "it is returned as it is, once")]
    pub(super) fn place_for(&self, request: &Request) -> Result<Option<OwnedSemaphorePermit>, Response> {
        if Weight::of(request.uri().path()) == Weight::Probe {
            return Ok(None);
        }
        Arc::clone(&self.places).try_acquire_owned().map(Some).map_err(|_| {
            self.metrics.shed(ShedReason::InFlight);
            overloaded("as many requests as are accepted at once are in flight".to_owned())
        })
    }
}

/// 503 with `Retry-After`: a second, since places come free within milliseconds unless the load lasts.
pub(crate) fn overloaded(detail: String) -> Response {
    Problem::new(ServiceProblem::Overloaded, detail).retry_after(1).into_response()
}
