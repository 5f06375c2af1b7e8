//! One log line, one span and one count for each request, when its answer has been sent or given up.

use std::pin::Pin;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};
use std::task::{Context, Poll};
use std::time::Instant;

use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{MatchedPath, Request};
use axum::http::{HeaderValue, header};
use axum::response::Response;
use http_body::{Frame, SizeHint};
use tracing::{Instrument, Level, Span};

use super::around::Surround;
use super::request_id::{self, RequestId};
use super::weight::Weight;
use crate::http::AppState;
use crate::http::metrics::{Metrics, UNMATCHED, method_label};
use crate::http::problem::describe_error;

/// The status under which a request is counted whose client left before the answer: the one that nginx gives it.
const CLIENT_LEFT: u16 = 499;

/// Layer: identifies the request, describes its error where it fails, and tells and counts it at its end.
#[derive(Clone)]
pub(super) struct Observe(pub(super) AppState);

impl Surround for Observe {
    fn surround<F>(&self, mut request: Request, inside: impl FnOnce(Request) -> F) -> impl Future<Output = Response> + Send + 'static
    where
        F: Future<Output = Response> + Send + 'static,
    {
        let AppState { metrics, readiness, .. } = self.0.clone();
        let id = request_id::take_or_create(&mut request);
        let mut record = Record::begin(&request, &id, metrics);
        let span = record.span.clone();
        crate::telemetry::continue_trace(&span, request.headers());
        let sent = Arc::clone(&record.sent);
        let uri = request.uri().clone();
        let answered = span.in_scope(|| inside(request.map(|body| Counted::around(body, sent))));
        async move {
            let mut response = async { describe_error(answered.await, uri.path(), &id) }.instrument(span).await;
            record.status = response.status().as_u16();
            id.mark(&mut response);
            // hyper closes a connection with an unread body on it. A client that is told opens another; one that is not, and one that is
            // cut off by a server that stops, loses the request that it may just be sending.
            if record.sent.is_left_unread() || readiness.is_draining() {
                response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
            }
            response.map(|body| Body::new(Answer { body, record }))
        }
    }
}

/// What is known of one request. Dropping it is the request's end.
struct Record {
    id: RequestId,
    method: &'static str,
    route: Arc<str>,
    probe: bool,
    began: Instant,
    status: u16,
    sent: Arc<Sent>,
    response_bytes: u64,
    span: Span,
    metrics: Metrics,
}

impl Record {
    fn begin(request: &Request, id: &RequestId, metrics: Metrics) -> Self {
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
        let probe = Weight::of(request.uri().path()) == Weight::Probe;
        let sent = Arc::default();
        Self { id: id.clone(), method, route, probe, began: Instant::now(), status: CLIENT_LEFT, sent, response_bytes: 0, span, metrics }
    }
}

impl Drop for Record {
    fn drop(&mut self) {
        let duration = self.began.elapsed();
        self.metrics.ended(self.method, &self.route, self.status, duration);
        self.span.record("http.response.status_code", self.status);
        // The line stands for itself: what the span would add is in it.
        macro_rules! line {
            ($level:expr) => {
                tracing::event!(
                    parent: None,
                    $level,
                    request_id = self.id.as_str(),
                    method = self.method,
                    route = &*self.route,
                    status = self.status,
                    // Microseconds are enough for a person and half the digits.
                    duration_ms = (duration.as_secs_f64() * 1e6).round() / 1e3,
                    request_bytes = self.sent.bytes.load(Ordering::Relaxed),
                    response_bytes = self.response_bytes,
                    "request"
                )
            };
        }
        match self.status {
            500 => line!(Level::ERROR),
            // Probes and scrapes come every few seconds for ever.
            _ if self.probe => line!(Level::DEBUG),
            _ => line!(Level::INFO),
        }
    }
}

/// A request's body, counted as it comes over the wire.
struct Counted {
    body: Body,
    sent: Arc<Sent>,
}

/// What is known of a request's body.
#[derive(Debug, Default)]
struct Sent {
    bytes: AtomicU64,
    unread: AtomicBool,
}

impl Sent {
    fn is_left_unread(&self) -> bool {
        self.unread.load(Ordering::Relaxed)
    }
}

impl Counted {
    fn around(body: Body, sent: Arc<Sent>) -> Body {
        if body.is_end_stream() {
            return body;
        }
        sent.unread.store(true, Ordering::Relaxed);
        Body::new(Self { body, sent })
    }
}

impl HttpBody for Counted {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let polled = Pin::new(&mut self.body).poll_frame(context);
        self.sent.bytes.fetch_add(length(&polled), Ordering::Relaxed);
        if matches!(polled, Poll::Ready(None)) || self.body.is_end_stream() {
            self.sent.unread.store(false, Ordering::Relaxed);
        }
        polled
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

/// An answer's body, with the request's record until it is sent.
struct Answer {
    body: Body,
    record: Record,
}

impl HttpBody for Answer {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let polled = Pin::new(&mut self.body).poll_frame(context);
        self.record.response_bytes += length(&polled);
        polled
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

fn length(polled: &Poll<Option<Result<Frame<Bytes>, axum::Error>>>) -> u64 {
    match polled {
        Poll::Ready(Some(Ok(frame))) => frame.data_ref().map_or(0, |data| data.len() as u64),
        _ => 0,
    }
}
