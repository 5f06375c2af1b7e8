//! The middleware around every route: request ids, logs and metrics, panics, load shedding, time-outs, body limits,
//! compression, and headers for browsers. This file sets their order.

mod body;
mod browser;
mod observe;

use std::sync::Arc;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{StatusCode, Version, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;

use super::app_state::AppState;
use super::codes::ServiceProblem;
use super::json_body::{accepts_gzip, compress};
use super::metrics::Metrics;
use super::overload::Overload;
use super::problem::Problem;
use super::routes::RouteClass;
use super::work::Work;
use crate::settings::Settings;
use body::{BodyProgress, BodyRules};
use observe::{Observer, observe};

/// The middleware of one service.
pub(super) struct Stack<'a> {
    settings: &'a Settings,
    state: &'a AppState,
    /// Permits for requests in flight. Requests beyond them are refused, not queued, because a queue would delay every
    /// request.
    in_flight: Arc<Semaphore>,
}

impl<'a> Stack<'a> {
    pub(super) fn new(settings: &'a Settings, state: &'a AppState) -> Self {
        Self { settings, state, in_flight: Arc::new(Semaphore::new(settings.max_in_flight)) }
    }

    /// Wraps `router`, whose routes are all of `class`, in the middleware. From the outermost to the innermost:
    /// 1. request id, log line and counters, which cover every other layer; the body is counted as it arrives;
    /// 2. errors become problems, whichever layer or handler they come from;
    /// 3. headers for browsers, on errors as well;
    /// 4. compression of answers that no worker has compressed;
    /// 5. panics become answers;
    /// 6. load shedding, before the body is read;
    /// 7. the request time-out;
    /// 8. the body's time-outs, its decompression, and inside it the body limit, so that a small compressed body cannot
    ///    expand without bound.
    ///
    /// All layers are added as one service: the router would box each separate layer, and clone it with all inner
    /// layers for every request.
    pub(super) fn surround<S: Clone + Send + Sync + 'static>(&self, class: RouteClass, router: Router<S>) -> Router<S> {
        let AppState { metrics, readiness, workers, budget, .. } = self.state.clone();
        let rules = Arc::new(BodyRules::new(class, self.settings));
        let work = class.uses_workers().then(|| Work::new(workers.clone(), budget, metrics.clone()));
        let in_flight = class.is_shed().then(|| Arc::clone(&self.in_flight));
        let admit = Admit { in_flight, metrics: metrics.clone(), work, rules: Arc::clone(&rules) };
        let observer = Observer { class, metrics, readiness };
        // Layer 8 replaces the framework's own body limit of 2 MB.
        let all = ServiceBuilder::new()
            .layer(from_fn_with_state(observer, observe))
            .option_layer(browser::cors(&self.settings.cors_origins))
            .map_response(browser::secure)
            .layer(from_fn_with_state(workers.clone(), compress))
            .layer(CatchPanicLayer::custom(describe_panic))
            .layer(from_fn_with_state(Arc::new(admit), answer_admitted))
            .map_request(move |request| rules.limit(request))
            .layer(DefaultBodyLimit::disable());
        router.layer(all)
    }
}

/// The limits of layers 6 and 7.
struct Admit {
    /// `None` for routes that are answered under any load.
    in_flight: Option<Arc<Semaphore>>,
    metrics: Metrics,
    /// `Some` for routes that may use the worker pool.
    work: Option<Work>,
    rules: Arc<BodyRules>,
}

impl Admit {
    /// The permit that a request holds until its answer is ready to be sent; the answer if it is refused.
    #[expect(clippy::result_large_err, reason = "the response is returned as it is, once")]
    fn admit(&self, request: &Request) -> Result<Option<OwnedSemaphorePermit>, Response> {
        let permit = self.in_flight.clone().map(Semaphore::try_acquire_owned).transpose().map_err(|_| {
            self.metrics.shed(Overload::InFlight);
            Overload::InFlight.into_response()
        })?;
        check_host(request)?;
        self.rules.check_head(request.headers())?;
        Ok(permit)
    }
}

/// Layers 6 and 7.
async fn answer_admitted(State(admit): State<Arc<Admit>>, mut request: Request, next: Next) -> Response {
    let _permit = match admit.admit(&request) {
        Ok(permit) => permit,
        Err(refusal) => return refusal,
    };
    if let Some(work) = &admit.work {
        let work = work.clone().compressing(accepts_gzip(request.headers()));
        request.extensions_mut().insert(work);
    }
    let progress = BodyProgress::of(&request);
    body::answer_in_time(admit.rules.request_timeout, progress, next.run(request)).await
}

/// Checks that an HTTP/1.1 request has one `Host` header (RFC 9112, section 3.2).
#[expect(clippy::result_large_err, reason = "the response is returned as it is, once")]
fn check_host(request: &Request) -> Result<(), Response> {
    let hosts = request.headers().get_all(header::HOST).iter().count();
    if hosts == 1 || (hosts == 0 && request.version() < Version::HTTP_11) {
        return Ok(());
    }
    let detail = format!("a request has one header host; this one has {hosts}");
    Err(Problem::new(ServiceProblem::MalformedRequest, detail).into_response())
}

/// The answer after a panic. The panic hook has logged the panic with its location; the client gets no detail.
fn describe_panic(_panic: Box<dyn std::any::Any + Send>) -> Response {
    StatusCode::INTERNAL_SERVER_ERROR.into_response()
}
