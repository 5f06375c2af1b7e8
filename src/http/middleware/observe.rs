//! Observation of requests: one log line, one span and one count for each, written when its answer has been sent or
//! abandoned.

use std::sync::{Arc, LazyLock};
use std::time::Instant;

use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::Response;
use http_body::Frame;
use http_body_util::BodyExt;
use tracing::{Instrument, Level, Span};

use super::body::{BodyProgress, RecordedBody};
use crate::http::metrics::{Metrics, UNMATCHED, method_label};
use crate::http::problem::{Refusal, describe_error};
use crate::http::readiness::Readiness;
use crate::http::request_id::{self, RequestId};
use crate::http::routes::RouteClass;

/// The status that is logged for a request whose client closed the connection before the answer, as in nginx.
const CLIENT_LEFT: u16 = 499;

/// The longest part of an unknown path that is logged.
const LONGEST_PATH: usize = 200;

/// What the outermost layer needs to give a request its id, to log and to count it.
#[derive(Clone)]
pub(super) struct Observer {
    pub(super) class: RouteClass,
    pub(super) metrics: Metrics,
    pub(super) readiness: Readiness,
}

/// The outermost layer: it gives the request an id, turns errors into problems, and logs and counts the request at its
/// end.
pub(super) async fn observe(State(observer): State<Observer>, mut request: Request, next: Next) -> Response {
    let Observer { class, metrics, readiness } = observer;
    let id = request_id::take_or_create(&mut request);
    let has_body = !request.body().is_end_stream();
    let progress = Arc::new(BodyProgress::begin(has_body));
    request.extensions_mut().insert(Arc::clone(&progress));
    if has_body {
        request = request.map(|body| Body::new(RecordedBody { body, progress: Arc::clone(&progress) }));
    }
    let mut record = Record::begin(&request, class, &id, progress, metrics, readiness.clone());
    let span = record.span.clone();
    crate::telemetry::continue_trace(&span, request.headers());
    let uri = request.uri().clone();
    let answer = async { describe_error(next.run(request).await, uri.path(), &id) };
    let mut response = answer.instrument(span).await;
    record.status = response.status().as_u16();
    record.refusal = response.extensions_mut().remove::<Refusal>();
    if record.status == StatusCode::NOT_FOUND {
        record.path = Some(uri.path().chars().take(LONGEST_PATH).collect());
    }
    id.mark(&mut response);
    // hyper closes a connection on which a body is unread. This header makes the client open another one; without it,
    // the client's next request on this connection would be lost. The same applies when the server stops.
    if record.progress.is_unread() || readiness.is_draining() {
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    // The body keeps the record until it has been sent or dropped.
    let count = move |frame: &Frame<Bytes>| record.count(frame);
    response.map(|body| Body::new(body.inspect_frame(count)))
}

/// The record of one request for the log and the metrics. Dropping it at the request's end writes it.
struct Record {
    id: RequestId,
    method: &'static str,
    route: Arc<str>,
    class: RouteClass,
    began: Instant,
    status: u16,
    progress: Arc<BodyProgress>,
    response_bytes: u64,
    refusal: Option<Refusal>,
    /// The path of a request that no route matches.
    path: Option<String>,
    span: Span,
    metrics: Metrics,
    readiness: Readiness,
}

impl Record {
    fn begin(
        request: &Request,
        class: RouteClass,
        id: &RequestId,
        progress: Arc<BodyProgress>,
        metrics: Metrics,
        readiness: Readiness,
    ) -> Self {
        static NO_ROUTE: LazyLock<Arc<str>> = LazyLock::new(|| Arc::from(UNMATCHED));
        let route = request.extensions().get::<MatchedPath>().map_or_else(|| Arc::clone(&NO_ROUTE), |path| Arc::from(path.as_str()));
        let method = method_label(request.method());
        let span = tracing::info_span!(
            "request",
            request_id = id.as_str(),
            otel.name = format_args!("{method} {route}"),
            otel.kind = "server",
            http.request.method = method,
            http.route = &*route,
            http.response.status_code = tracing::field::Empty,
        );
        metrics.began();
        let id = id.clone();
        Self {
            id,
            method,
            route,
            class,
            began: Instant::now(),
            status: CLIENT_LEFT,
            progress,
            response_bytes: 0,
            refusal: None,
            path: None,
            span,
            metrics,
            readiness,
        }
    }

    /// Counts the bytes of a frame of the answer.
    fn count(&mut self, frame: &Frame<Bytes>) {
        self.response_bytes += frame.data_ref().map_or(0, |data| data.len() as u64);
    }
}

impl Drop for Record {
    fn drop(&mut self) {
        let duration = self.began.elapsed();
        self.metrics.ended(self.method, &self.route, self.status, duration);
        self.span.record("http.response.status_code", self.status);
        let fault = self.refusal.as_ref().and_then(|refusal| refusal.fault.as_ref());
        // `parent: None`, because the line itself contains the span's fields.
        macro_rules! line {
            ($level:expr, $message:literal) => {
                tracing::event!(
                    parent: None,
                    $level,
                    request_id = self.id.as_str(),
                    method = self.method,
                    route = &*self.route,
                    status = self.status,
                    // Microseconds suffice for a reader and have half the digits.
                    duration_ms = (duration.as_secs_f64() * 1e6).round() / 1e3,
                    request_bytes = self.progress.wire_bytes(),
                    response_bytes = self.response_bytes,
                    problem = self.refusal.as_ref().map(|refusal| refusal.problem),
                    fault = fault.map(|(code, _)| *code),
                    pointer = fault.map(|(_, pointer)| pointer.as_str()),
                    path = self.path.as_deref(),
                    $message
                )
            };
        }
        match self.status {
            _ if self.readiness.is_over() => line!(Level::WARN, "request cut off at the end of the grace"),
            500 => line!(Level::ERROR, "request"),
            // Probes and scrapes arrive every few seconds.
            _ if self.class == RouteClass::Probe => line!(Level::DEBUG, "request"),
            _ => line!(Level::INFO, "request"),
        }
    }
}
