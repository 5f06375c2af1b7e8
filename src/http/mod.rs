//! The service over HTTP: a file or folder for each endpoint, and around them what they share. Nothing in it computes: requests are
//! read into checked values, handed to the mathematics, and the results written.

mod app_state;
mod body;
mod calculation;
mod codes;
mod document;
pub mod layers;
pub mod metrics;
mod pages;
mod planning;
mod problem;
mod process;
mod query;
pub mod readiness;
mod reading;
mod wire;
mod workbench;
pub mod worker_pool;

pub use app_state::AppState;
use axum::Router;
use axum::http::StatusCode;
use calculation::{cutting_parameters, max_feed, scallop_height, step_over};
use planning::{critical_slope, machines, recommendation, upload};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

/// All routes with their documentation.
fn routes() -> OpenApiRouter<AppState> {
    OpenApiRouter::with_openapi(document::outline())
        .routes(routes!(scallop_height::answer, scallop_height::answer_query))
        .routes(routes!(scallop_height::answer_batch))
        .routes(routes!(max_feed::answer, max_feed::answer_query))
        .routes(routes!(max_feed::answer_batch))
        .routes(routes!(step_over::answer, step_over::answer_query))
        .routes(routes!(step_over::answer_batch))
        .routes(routes!(cutting_parameters::answer, cutting_parameters::answer_query))
        .routes(routes!(cutting_parameters::answer_batch))
        .routes(routes!(critical_slope::answer))
        .routes(routes!(machines::list))
        .routes(routes!(recommendation::answer))
        .routes(routes!(upload::answer))
        .routes(routes!(readiness::livez))
        .routes(routes!(readiness::readyz))
        .routes(routes!(metrics::show))
        .routes(routes!(pages::openapi))
}

/// The OpenAPI document, as `openapi/openapi.json` holds it.
#[must_use]
pub fn openapi_json() -> String {
    format!("{:#}\n", document::with_examples(&routes().into_openapi()))
}

/// The routes, before the layers around them.
pub fn router(state: &AppState) -> Router {
    let (router, _) = routes().split_for_parts();
    router.merge(pages::routes()).merge(workbench::routes()).fallback(async || StatusCode::NOT_FOUND).with_state(state.clone())
}
