//! What surrounds every route, whatever it computes: identification, logs and metrics, panics, shedding, time-outs, body limits,
//! compression, and headers for browsers. Each layer has a file; this one sets their order.

mod body;
mod browser;
mod observe;
mod request_id;
mod shed;
mod weight;

use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::DefaultBodyLimit;
use axum::http::StatusCode;
use axum::middleware::{from_fn, from_fn_with_state, map_response};
use axum::response::{IntoResponse, Response};
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{DefaultPredicate, Predicate, SizeAbove};
use tower_http::decompression::RequestDecompressionLayer;
use tower_http::map_request_body::MapRequestBodyLayer;

pub use request_id::RequestId;
pub(crate) use shed::overloaded;

use super::operations::Operations;
use super::problem::describe_errors;
use crate::settings::HttpSettings;

/// Answers this small fit one packet as they are: compressing them would cost time and save nothing.
const WORTH_COMPRESSING: u16 = 1024;

/// `router` inside all layers, the outermost first:
/// 1. identification, log line and counters, so that whatever happens further in is seen;
/// 2. errors are described, whichever layer or handler they come from;
/// 3. headers for browsers, which must be on errors, too;
/// 4. compression of answers;
/// 5. panics become answers;
/// 6. shedding, before anything of the body is read;
/// 7. time-outs and the pace of the body, counted as it arrives;
/// 8. decompression of the body, and inside it the limit: outside, a small body could unfold without bound.
pub fn apply(router: Router, settings: &HttpSettings, operations: &Operations) -> Router {
    let limits = Arc::new(body::Limits::new(settings));
    let in_flight = shed::InFlight::new(settings.max_in_flight, operations.metrics.clone());
    // axum's own limit of 2 MB gives way to layer 8.
    let inner = ServiceBuilder::new()
        .layer(CatchPanicLayer::custom(describe_panic))
        .layer(from_fn_with_state(in_flight, shed::shed))
        .layer(from_fn_with_state(Arc::clone(&limits), body::receive))
        .layer(RequestDecompressionLayer::new())
        .layer(MapRequestBodyLayer::new(Body::new))
        .layer(from_fn_with_state(limits, body::bound))
        .layer(DefaultBodyLimit::disable());
    let compression = CompressionLayer::new().compress_when(DefaultPredicate::new().and(SizeAbove::new(u64::from(WORTH_COMPRESSING))));
    let router = router.layer(inner).layer(compression).layer(map_response(browser::secure));
    let router = match browser::cors(&settings.cors_origins) {
        Some(cors) => router.layer(cors),
        None => router,
    };
    router.layer(from_fn(describe_errors)).layer(from_fn_with_state(operations.clone(), observe::observe))
}

/// The hook that the program sets at its start has logged the panic with its place; the client learns nothing of it.
fn describe_panic(_panic: Box<dyn std::any::Any + Send>) -> Response {
    StatusCode::INTERNAL_SERVER_ERROR.into_response()
}
