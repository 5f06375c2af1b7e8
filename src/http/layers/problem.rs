//! The one place where layers make an error answer.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::Value;

/// Problem details (RFC 9457) of type `slug`.
pub(super) fn problem(status: StatusCode, slug: &'static str, title: &'static str, detail: String) -> Response {
    let body = serde_json::json!({"type": slug, "title": title, "status": status.as_u16(), "detail": Value::String(detail)});
    let media_type = HeaderValue::from_static("application/problem+json");
    (status, [(header::CONTENT_TYPE, media_type)], body.to_string()).into_response()
}
