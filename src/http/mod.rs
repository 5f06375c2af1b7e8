//! The HTTP interface: a file or folder for each endpoint, and the modules that they share. Requests are read into
//! checked values and passed to the domain modules, and their results are written as JSON; no calculation is done here.

mod about;
mod app_state;
mod calculation;
mod codes;
mod document;
mod json_body;
pub mod metrics;
mod middleware;
mod multipart;
pub mod overload;
mod pages;
mod planning;
mod problem;
mod problem_schemas;
mod query;
pub mod readiness;
mod reading;
mod refusal;
mod request_body;
mod request_id;
mod routes;
mod wire;
pub mod work;

pub use app_state::AppState;
pub use routes::{RouteClass, Routes};

use std::sync::Arc;

use axum::Router;
use axum::http::StatusCode;
use utoipa_axum::routes;

use crate::settings::Settings;

/// All routes, each with its class and its documentation.
#[must_use]
pub fn routes() -> Routes {
    use RouteClass::Single;
    calculation::routes()
        .merge(planning::routes())
        .merge(health_routes())
        .documented(Single, routes!(about::show))
        .with_examples(document::examples!("about"))
        .documented(Single, routes!(pages::openapi))
        .documented(Single, routes!(pages::openapi_3_0))
        .nested(Single, pages::routes())
}

/// The OpenAPI document, as in `openapi/openapi.json`.
#[must_use]
pub fn openapi_json() -> String {
    format!("{:#}\n", document::of(routes()))
}

/// The OpenAPI document in version 3.0.3, as `/openapi-3.0.json` serves it. `openapi/to_3_0` writes it.
pub const OPENAPI_3_0_JSON: &str = include_str!("../../openapi/openapi-3.0.json");

/// The routes without `/metrics`, for a service with a separate address for probes and metrics.
#[must_use]
pub fn public_routes() -> Routes {
    routes().without("/metrics")
}

/// The probes and the metrics.
#[must_use]
pub fn health_routes() -> Routes {
    use RouteClass::Probe;
    Routes::new()
        .documented(Probe, routes!(readiness::livez))
        .documented(Probe, routes!(readiness::readyz))
        .documented(Probe, routes!(metrics::show))
}

/// Returns the function that writes answers to request heads that cannot be parsed.
#[must_use]
pub fn refusals(state: &AppState) -> Arc<dyn Fn(StatusCode) -> Vec<u8> + Send + Sync> {
    let metrics = state.metrics.clone();
    Arc::new(move |status| refusal::refuse(status, &metrics))
}

/// The service: `routes` inside the middleware.
pub fn service(routes: Routes, settings: &Settings, state: &AppState) -> Router {
    let stack = middleware::Stack::new(settings, state);
    let surround = |class, router| stack.surround(class, router);
    let no_such_path = surround(RouteClass::Single, Router::new().fallback(async || StatusCode::NOT_FOUND));
    routes.into_router(surround).merge(no_such_path).with_state(state.clone())
}
