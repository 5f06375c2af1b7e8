//! The rules for a request's body: the longest pause and the longest time of its arrival, the largest size after
//! decompression, and the longest time from its last byte to the answer. A body that breaks a rule ends with
//! an error. The service then answers with the problem of that rule, whatever the handler returned.

use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;
use crate::http::routes::RouteClass;
use crate::settings::Settings;
use async_compression::tokio::bufread::GzipDecoder;
use axum::body::{Body, Bytes, HttpBody};
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use http_body::{Frame, SizeHint};
use http_body_util::{BodyExt, LengthLimitError, Limited};
use std::error::Error;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::time::{Instant, timeout_at};
use tokio_util::io::{ReaderStream, StreamReader};
use tower_http::timeout::{DeadlineBody, TimeoutBody, TimeoutError};

/// The progress of one request's body. The outermost layer adds it to the request's extensions.
#[derive(Debug)]
pub(super) struct BodyProgress {
    began: Instant,
    /// Bytes received, before decompression.
    wire_bytes: AtomicU64,
    /// The time of the last bytes, in ms since `began`.
    last_byte_ms: AtomicU64,
    /// Whether a part of the body is still unread.
    is_unread: AtomicBool,
    fault: OnceLock<Problem>,
}

impl BodyProgress {
    /// The record of a request whose body has not been read yet.
    pub(super) fn begin(is_unread: bool) -> Self {
        Self {
            began: Instant::now(),
            wire_bytes: AtomicU64::new(0),
            last_byte_ms: AtomicU64::new(0),
            is_unread: AtomicBool::new(is_unread),
            fault: OnceLock::new(),
        }
    }

    /// The record that the outermost layer added to `request`.
    pub(super) fn of(request: &Request) -> Arc<Self> {
        let progress = request.extensions().get::<Arc<Self>>();
        progress.map_or_else(|| unreachable!("the outermost layer adds the record"), Arc::clone)
    }

    /// Adds received bytes.
    fn add_wire_bytes(&self, bytes: u64) {
        // 2^64 ms are half a billion years.
        let elapsed = u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.last_byte_ms.store(elapsed, Ordering::Relaxed);
        self.wire_bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    pub(super) fn wire_bytes(&self) -> u64 {
        self.wire_bytes.load(Ordering::Relaxed)
    }

    /// The time of the last bytes; before the first, the time of the request's head.
    fn last_byte(&self) -> Instant {
        self.began + Duration::from_millis(self.last_byte_ms.load(Ordering::Relaxed))
    }

    /// Records that the body has been read to its end.
    fn note_end(&self) {
        self.is_unread.store(false, Ordering::Relaxed);
    }

    pub(super) fn is_unread(&self) -> bool {
        self.is_unread.load(Ordering::Relaxed)
    }

    /// Records that the body broke a rule. Only the first fault is kept: later ones follow from it.
    fn note_fault(&self, fault: Problem) -> Problem {
        self.fault.get_or_init(|| fault).clone()
    }

    fn fault(&self) -> Option<&Problem> {
        self.fault.get()
    }
}

/// A body as it arrives, before decompression, whose progress is recorded.
pub(super) struct RecordedBody {
    pub(super) body: Body,
    pub(super) progress: Arc<BodyProgress>,
}

impl HttpBody for RecordedBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let frame = ready!(Pin::new(&mut self.body).poll_frame(context));
        if let Some(Ok(frame)) = &frame {
            self.progress.add_wire_bytes(frame.data_ref().map_or(0, |data| data.len() as u64));
        }
        if frame.is_none() || self.body.is_end_stream() {
            self.progress.note_end();
        }
        Poll::Ready(frame)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

/// How many times the longest pause a body's arrival may take in all: a trickle does not hold a connection for ever.
const MAX_PAUSES: u32 = 20;

/// The rules for requests to the routes of one class.
#[derive(Debug)]
pub(super) struct BodyRules {
    /// The largest body, in decompressed bytes.
    max_bytes: u64,
    pub(super) request_timeout: Duration,
    client_timeout: Duration,
}

impl BodyRules {
    pub(super) fn new(class: RouteClass, settings: &Settings) -> Self {
        Self {
            max_bytes: class.max_body_bytes(settings),
            request_timeout: settings.request_timeout_s,
            client_timeout: settings.client_timeout_s,
        }
    }

    /// Rejects a request whose head already shows that its body breaks a rule.
    #[expect(clippy::result_large_err, reason = "the response is returned as it is, once")]
    pub(super) fn check_head(&self, headers: &HeaderMap) -> Result<(), Response> {
        let max_bytes = self.max_bytes;
        match is_gzip(headers) {
            Some(false) if stated_length(headers).is_some_and(|length| length > max_bytes) => Err(too_large(max_bytes).into_response()),
            Some(_) => Ok(()),
            None => Err(unsupported_encoding()),
        }
    }

    /// Limits the body's arrival and its decompressed size, and decompresses it.
    pub(super) fn limit(&self, request: Request) -> Request {
        let progress = BodyProgress::of(&request);
        if !progress.is_unread() {
            return request;
        }
        let pause = self.client_timeout;
        let timed = request.map(|body| Body::new(DeadlineBody::new(MAX_PAUSES * pause, TimeoutBody::new(pause, body))));
        decompressed(timed).map(|body| limited(body, self.max_bytes, progress))
    }
}

/// Returns `answer` if it is ready within `longest` of the request's last byte and the body broke no rule; otherwise
/// the problem. The time of the upload does not count, because it depends on the client's connection.
pub(super) async fn answer_in_time(longest: Duration, progress: Arc<BodyProgress>, answer: impl Future<Output = Response>) -> Response {
    let mut answer = std::pin::pin!(answer);
    let answer = loop {
        let deadline = progress.last_byte() + longest;
        match timeout_at(deadline, answer.as_mut()).await {
            Ok(response) => break Some(response),
            Err(_) if progress.last_byte() + longest > Instant::now() => {}
            Err(_) => break None,
        }
    };
    match (progress.fault(), answer) {
        (Some(fault), _) => fault.clone().into_response(),
        (None, Some(response)) => response,
        (None, None) => took_too_long(longest),
    }
}

fn stated_length(headers: &HeaderMap) -> Option<u64> {
    headers.get(header::CONTENT_LENGTH)?.to_str().ok()?.parse().ok()
}

fn unsupported_encoding() -> Response {
    let detail = "send the body plain or with the header content-encoding: gzip".to_owned();
    let mut response = Problem::new(ServiceProblem::UnsupportedEncoding, detail).into_response();
    response.headers_mut().insert(header::ACCEPT_ENCODING, HeaderValue::from_static("gzip"));
    response
}

fn took_too_long(longest: Duration) -> Response {
    let detail = format!("no answer within {} s of the request's last byte", longest.as_secs());
    Problem::new(ServiceProblem::Timeout, detail).into_response()
}

/// A decompressed body of at most `max_bytes`. Its first error is recorded.
fn limited(body: Body, max_bytes: u64, progress: Arc<BodyProgress>) -> Body {
    let most = usize::try_from(max_bytes).unwrap_or(usize::MAX);
    Body::new(Limited::new(body, most).map_err(move |error| progress.note_fault(problem_of(&*error, max_bytes))))
}

/// The problem of a body of more than `max_bytes`.
fn too_large(max_bytes: u64) -> Problem {
    Problem::new(ServiceProblem::TooLarge, format!("the body, counted decompressed, is larger than {max_bytes} bytes"))
}

/// The problem of a body of at most `max_bytes` that ends with `error`.
fn problem_of(error: &(dyn Error + 'static), max_bytes: u64) -> Problem {
    let is = |kind: fn(&(dyn Error + 'static)) -> bool| std::iter::successors(Some(error), |&error| error.source()).any(kind);
    if is(<dyn Error>::is::<LengthLimitError>) {
        too_large(max_bytes)
    } else if is(<dyn Error>::is::<TimeoutError>) {
        Problem::new(ServiceProblem::Timeout, "the body arrived too slowly, or no data of it for too long")
    } else {
        Problem::new(ServiceProblem::UnreadableBody, format!("the body could not be read: {error}"))
    }
}

/// The largest part of a body that is decompressed at once, in bytes.
const PART: usize = 16 * 1024;

/// Whether the headers name gzip as the coding of the body; `None` for another coding and for several. Names are
/// case-insensitive, and `x-gzip` is another name of gzip (RFC 9110, section 8.4.1).
fn is_gzip(headers: &HeaderMap) -> Option<bool> {
    let mut names = headers.get_all(header::CONTENT_ENCODING).iter();
    let Some(name) = names.next() else { return Some(false) };
    let is = |coding: &[u8]| name.as_bytes().eq_ignore_ascii_case(coding);
    match names.next() {
        None if is(b"gzip") || is(b"x-gzip") => Some(true),
        None if is(b"identity") => Some(false),
        _ => None,
    }
}

/// The request with its body decompressed, all members of it. `tower_http::decompression` 0.7.1 ends a body after the first
/// member of a gzip file and drops the others without an error; `pigz`, `bgzip` and `cat` write files of several members.
fn decompressed(mut request: Request) -> Request {
    if is_gzip(request.headers()) != Some(true) {
        return request;
    }
    request.headers_mut().remove(header::CONTENT_ENCODING);
    request.headers_mut().remove(header::CONTENT_LENGTH);
    request.map(|body| {
        let compressed = body.map_err(std::io::Error::other).into_data_stream();
        let mut decoder = GzipDecoder::new(StreamReader::new(compressed));
        decoder.multiple_members(true);
        Body::from_stream(ReaderStream::with_capacity(decoder, PART))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    async fn read(bytes: usize, max_bytes: u64) -> Result<usize, String> {
        let progress = Arc::new(BodyProgress::begin(true));
        let body = limited(Body::from(vec![b'x'; bytes]), max_bytes, Arc::clone(&progress));
        let read = body.collect().await.map(|whole| whole.to_bytes().len()).map_err(|fault| fault.to_string());
        assert_eq!(read.as_ref().err(), progress.fault().map(Problem::to_string).as_ref());
        read
    }

    #[tokio::test]
    async fn the_limit_itself_is_accepted_and_one_byte_more_is_not() {
        assert_eq!(read(100, 100).await, Ok(100));
        assert_eq!(read(101, 100).await, Err(too_large(100).to_string()));
    }

    fn member(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    async fn decompressed_to_end(body: Vec<u8>) -> Result<Vec<u8>, String> {
        let request = Request::builder().header(header::CONTENT_ENCODING, "gzip").body(Body::from(body)).unwrap();
        let body = decompressed(request).into_body().collect().await;
        body.map(|body| body.to_bytes().to_vec()).map_err(|error| error.to_string())
    }

    #[tokio::test]
    async fn all_members_are_decompressed() {
        let long = vec![b'x'; 100_000];
        let bodies = [b"first,".as_slice(), &[], &long, b"last"];
        let file: Vec<u8> = bodies.iter().flat_map(|body| member(body)).collect();
        assert_eq!(decompressed_to_end(file.clone()).await.unwrap(), bodies.concat());
        for end in [file.len() - 1, file.len() - 9, file.len() - 20] {
            decompressed_to_end(file[..end].to_vec()).await.unwrap_err();
        }
        decompressed_to_end([file, b"no gzip member".to_vec()].concat()).await.unwrap_err();
    }

    #[test]
    fn names_of_codings_have_no_case() {
        let of = |names: &[&'static str]| {
            let headers = names.iter().map(|name| (header::CONTENT_ENCODING, HeaderValue::from_static(name)));
            is_gzip(&headers.collect())
        };
        assert_eq!(of(&[]), Some(false));
        assert_eq!(["gzip", "GZIP", "x-gzip"].map(|name| of(&[name])), [Some(true); 3]);
        assert_eq!(of(&["Identity"]), Some(false));
        assert_eq!(["br", "gzip, gzip", ""].map(|name| of(&[name])), [None; 3]);
        assert_eq!(of(&["gzip", "br"]), None);
    }
}
