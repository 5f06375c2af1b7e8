//! The service over HTTP.

pub mod heavy;
pub mod layers;
pub mod metrics;
pub mod operations;
mod process;
pub mod readiness;

use operations::Operations;

/// The OpenAPI document.
#[must_use]
pub fn openapi_json() -> String {
    "{}\n".to_owned()
}

/// The routes, before the layers around them.
pub fn router(operations: &Operations) -> axum::Router {
    axum::Router::new()
        .route("/livez", axum::routing::get(readiness::livez))
        .route("/readyz", axum::routing::get(readiness::readyz))
        .route("/metrics", axum::routing::get(metrics::show))
        .with_state(operations.clone())
}
