//! Requests beyond what is accepted at once are turned away, not queued: a queue would only make everybody late.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use tokio::sync::Semaphore;

use super::weight::Weight;
use crate::http::metrics::{Metrics, ShedReason};
use crate::http::problem::Problem;

/// How many requests may be in flight.
#[derive(Clone)]
pub(super) struct InFlight {
    places: Arc<Semaphore>,
    metrics: Metrics,
}

impl InFlight {
    pub(super) fn new(most: usize, metrics: Metrics) -> Self {
        Self { places: Arc::new(Semaphore::new(most)), metrics }
    }
}

/// Layer: a request in flight holds a place until its answer is ready to be sent; probes need none.
pub(super) async fn shed(State(in_flight): State<InFlight>, request: Request, next: Next) -> Response {
    if Weight::of(request.uri().path()) == Weight::Probe {
        return next.run(request).await;
    }
    let Ok(_place) = in_flight.places.try_acquire() else {
        in_flight.metrics.shed(ShedReason::InFlight);
        return overloaded("as many requests as are accepted at once are in flight".to_owned());
    };
    next.run(request).await
}

/// 503 with `Retry-After`: a second, since places come free within milliseconds unless the load lasts.
pub(crate) fn overloaded(detail: String) -> Response {
    Problem::new(StatusCode::SERVICE_UNAVAILABLE, "overloaded", "The server is busy", detail).retry_after(1).into_response()
}
