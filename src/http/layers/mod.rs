//! What surrounds every route, whatever it computes: identification, logs and metrics, panics, shedding, time-outs, body limits,
//! compression, and headers for browsers. Each layer has a file; this one sets their order.

mod around;
mod body;
mod browser;
mod observe;
mod request_id;
mod shed;
mod weight;

use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::{DefaultBodyLimit, Request};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{DefaultPredicate, Predicate, SizeAbove};
use tower_http::decompression::RequestDecompressionLayer;
use tower_http::map_request_body::MapRequestBodyLayer;

use around::{Around, Surround};
pub use request_id::RequestId;
pub(crate) use shed::overloaded;

use super::app_state::AppState;
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
///
/// They are one stack without boxes in it: each boxed service, as the router makes of a layer, is copied for every request with all
/// that is inside.
pub fn apply(router: Router, settings: &HttpSettings, state: &AppState) -> Router {
    let limits = Arc::new(body::Limits::new(settings));
    let in_flight = shed::InFlight::new(settings.max_in_flight, state.metrics.clone());
    let admit = Admit { in_flight, limits: Arc::clone(&limits) };
    let compression = CompressionLayer::new().compress_when(DefaultPredicate::new().and(SizeAbove::new(u64::from(WORTH_COMPRESSING))));
    // axum's own limit of 2 MB gives way to layer 8.
    let all = ServiceBuilder::new()
        .layer(Around(observe::Observe(state.clone())))
        .option_layer(browser::cors(&settings.cors_origins))
        .map_response(browser::secure)
        .layer(compression)
        .layer(CatchPanicLayer::custom(describe_panic))
        .layer(Around(admit))
        .layer(RequestDecompressionLayer::new())
        .layer(MapRequestBodyLayer::new(Body::new))
        .map_request(move |request| body::bound(&limits, request))
        .layer(DefaultBodyLimit::disable());
    router.layer(all)
}

/// Layers 6 and 7: what a request has to pass.
#[derive(Clone)]
struct Admit {
    in_flight: shed::InFlight,
    limits: Arc<body::Limits>,
}

impl Surround for Admit {
    #[expect(clippy::result_large_err, reason = "it is returned as it is, once")]
    fn surround<F>(&self, request: Request, inside: impl FnOnce(Request) -> F) -> impl Future<Output = Response> + Send + 'static
    where
        F: Future<Output = Response> + Send + 'static,
    {
        let place = self.in_flight.place_for(&request);
        let admitted = place.and_then(|place| Ok((place, body::receive(&self.limits, request)?)));
        let answered = admitted.map(|(place, (request, received))| (place, received.answer(inside(request))));
        async {
            match answered {
                Ok((_place, answer)) => answer.await,
                Err(refusal) => refusal,
            }
        }
    }
}

/// The hook that the program sets at its start has logged the panic with its place; the client learns nothing of it.
fn describe_panic(_panic: Box<dyn std::any::Any + Send>) -> Response {
    StatusCode::INTERNAL_SERVER_ERROR.into_response()
}
