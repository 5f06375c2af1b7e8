//! The probes: `/livez` (the process answers) and `/readyz` (the service accepts requests). The service depends on no
//! other service, so the probes check nothing else.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use axum::extract::State;
use axum::http::StatusCode;

use super::problem::ProblemBody;

/// Whether the service accepts requests, is draining, or cuts off its last requests. Clones share the state.
#[derive(Debug, Clone, Default)]
pub struct Readiness {
    draining: Arc<AtomicBool>,
    over: Arc<AtomicBool>,
}

impl Readiness {
    /// Starts draining before the server stops.
    pub fn drain(&self) {
        self.draining.store(true, Ordering::Relaxed);
    }

    /// Whether the server is draining.
    #[must_use]
    pub fn is_draining(&self) -> bool {
        self.draining.load(Ordering::Relaxed)
    }

    /// States that requests that end from now on are cut off.
    pub fn end(&self) {
        self.over.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }
}

/// The liveness probe
///
/// 200 as long as the process answers.
#[utoipa::path(
    get, path = "/livez", tag = "service", operation_id = "livez",
    responses((status = 200, description = "Alive", body = String, content_type = "text/plain", example = json!("alive\n"))),
)]
pub async fn livez() -> &'static str {
    "alive\n"
}

/// The readiness probe
///
/// 200, or 503 once the server is about to stop.
///
/// # Errors
/// 503 while the server is draining.
#[utoipa::path(
    get, path = "/readyz", tag = "service", operation_id = "readyz", description = "200, or 503 once the server is about to stop.",
    responses(
        (status = 200, description = "Ready", body = String, content_type = "text/plain", example = json!("ready\n")),
        (status = 503, description = "About to stop", body = ProblemBody, content_type = "application/problem+json"),
    ),
)]
pub async fn readyz(State(readiness): State<Readiness>) -> Result<&'static str, StatusCode> {
    if readiness.is_draining() { Err(StatusCode::SERVICE_UNAVAILABLE) } else { Ok("ready\n") }
}
