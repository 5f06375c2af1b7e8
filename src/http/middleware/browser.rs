//! Response headers for browsers: which origins may call the service (CORS), and what the service's own pages may load.

use std::time::Duration;

use axum::BoxError;
use axum::body::{Body, Bytes, HttpBody};
use axum::http::{self, HeaderName, HeaderValue, Method, header};
use axum::response::Response;
use tower_http::cors::{AllowOrigin, CorsLayer};

use crate::http::request_id;
use crate::settings::CorsOrigins;

/// The cross-origin rules; `None` if no origin is listed, so that browsers allow only the service's own pages.
pub(super) fn cors(origins: &CorsOrigins) -> Option<CorsLayer> {
    let allowed = match origins {
        CorsOrigins::Any => AllowOrigin::any(),
        CorsOrigins::Listed(listed) if listed.is_empty() => return None,
        CorsOrigins::Listed(listed) => AllowOrigin::list(listed.iter().cloned()),
    };
    let layer = CorsLayer::new()
        .allow_origin(allowed)
        .allow_methods([Method::GET, Method::POST])
        .allow_headers([header::CONTENT_TYPE, header::CONTENT_ENCODING, request_id::HEADER, HeaderName::from_static("traceparent")])
        .expose_headers([request_id::HEADER, header::RETRY_AFTER])
        .max_age(Duration::from_hours(1));
    Some(layer)
}

/// Scripts and styles from this server only. The script of the documentation page sets style attributes.
const PAGE_POLICY: HeaderValue = HeaderValue::from_static(
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; object-src 'none'; base-uri 'none'; frame-ancestors 'none'",
);

/// Adds the security headers: browsers must not guess the media type, and an answer without a content policy gets a
/// strict one.
pub(super) fn secure<B>(response: http::Response<B>) -> Response
where
    B: HttpBody<Data = Bytes, Error: Into<BoxError>> + Send + 'static,
{
    let mut response = response.map(Body::new);
    let page = response.headers().get(header::CONTENT_TYPE).is_some_and(|media_type| media_type.as_bytes().starts_with(b"text/html"));
    let headers = response.headers_mut();
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    if page {
        headers.entry(header::CONTENT_SECURITY_POLICY).or_insert(PAGE_POLICY);
        headers.insert(header::REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
        headers.insert(header::X_FRAME_OPTIONS, HeaderValue::from_static("DENY"));
    }
    response
}
