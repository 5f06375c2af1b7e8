//! The routes of the interactive documentation and of the OpenAPI document.

use super::app_state::AppState;
use super::{OPENAPI_3_0_JSON, openapi_json};
use axum::Router;
use axum::http::header;
use axum::response::{IntoResponse, Redirect};
use axum::routing::get;
use std::sync::LazyLock;
use utoipa_swagger_ui::{Config, SwaggerUi};

/// The routes of the documentation's scripts and styles; [`super::workbench`] serves the page itself. They are not in
/// the OpenAPI document, because programs do not call them.
pub(super) fn routes() -> Router<AppState> {
    let documentation = SwaggerUi::new("/docs/ui").config(
        Config::from("/openapi.json")
            // Expanded, the list of a hundred schemas would hide the operations.
            .default_models_expand_depth(0)
            .display_request_duration(true)
            .try_it_out_enabled(true),
    );
    Router::new().route("/docs", get(async || Redirect::to("/docs/"))).merge(documentation)
}

/// The OpenAPI document
///
/// This description of the service, in OpenAPI 3.1.
#[utoipa::path(
    get, path = "/openapi.json", tag = "service", operation_id = "openapi",
    responses((status = 200, description = "The document", body = serde_json::Value, content_type = "application/json")),
)]
pub(super) async fn openapi() -> impl IntoResponse {
    static DOCUMENT: LazyLock<String> = LazyLock::new(openapi_json);
    ([(header::CONTENT_TYPE, "application/json")], DOCUMENT.as_str())
}

/// The OpenAPI document in version 3.0.3
///
/// For generators of clients that do not read 3.1. It leaves out operations that take forms, which many of these
/// generators refuse.
#[utoipa::path(
    get, path = "/openapi-3.0.json", tag = "service", operation_id = "openapi_3_0",
    responses((status = 200, description = "The document", body = serde_json::Value, content_type = "application/json")),
)]
pub(super) async fn openapi_3_0() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], OPENAPI_3_0_JSON)
}
