//! The JSON bodies of requests and answers: the extractor of a request's JSON, answers that worker threads write, and their
//! compression with gzip.
//!
//! Large answers are compressed by the worker that writes them, all others by the layer [`compress`] in short pieces of work:
//! never on a thread that serves connections, which could answer nobody meanwhile.

use super::codes::ServiceProblem;
use super::problem::Problem;
use super::reading::{Faulted, Faults, Object, mark_not_finite};
use super::request_body::collect;
use crate::budget::{Budget, Held};
use crate::cancellation::CancelFlag;
use crate::json::JsonError;
use crate::worker_pool::WorkerPool;
use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{FromRef, FromRequest, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use http_body::{Frame, SizeHint};
use http_body_util::{BodyExt, Full};
use serde::Serialize;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::io::{self, Write};
use std::pin::Pin;
use std::task::{Context, Poll};

/// A body declared as JSON, not parsed yet. It replaces the framework's extractor, which answers with plain text and
/// stops at the first fault.
pub(crate) struct JsonBody {
    json: Bytes,
}

impl<S: Send + Sync> FromRequest<S> for JsonBody
where
    Budget: FromRef<S>,
{
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        if !is_json(request.headers()) {
            let detail = "send JSON with the header content-type: application/json; forms with a file go to paths that end in /upload";
            return Err(Problem::new(ServiceProblem::UnsupportedMediaType, detail));
        }
        let stated = request.headers().get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
        let json = collect(request.into_body(), stated, &Budget::from_ref(state)).await?;
        Ok(Self { json })
    }
}

/// The initial capacity of an answer, in bytes; few answers for one contact are larger.
const USUAL_ANSWER: usize = 1024;

/// An answer as JSON text, written by the thread that computed it.
pub(crate) struct WrittenJson {
    pieces: VecDeque<Bytes>,
    /// The bytes in the pieces.
    length: u64,
    is_compressed: bool,
    /// The memory of the answer until it is sent.
    held: Option<Held>,
}

impl WrittenJson {
    pub(crate) fn of(answer: &impl Serialize) -> Result<Self, Problem> {
        Self::until(&CancelFlag::default(), answer)
    }

    /// Writes a large answer. Once `cancel` is set, writing ends early, and the result must be discarded.
    pub(crate) fn until(cancel: &CancelFlag, answer: &impl Serialize) -> Result<Self, Problem> {
        let mut text = Cancellable { text: Vec::with_capacity(USUAL_ANSWER), cancel };
        match serde_json::to_writer(&mut text, answer) {
            Ok(()) => Ok(Self::in_pieces([text.text])),
            Err(error) => {
                if !cancel.is_cancelled() {
                    tracing::error!(%error, "an answer could not be written");
                }
                Err(Problem::of_status(StatusCode::INTERNAL_SERVER_ERROR))
            }
        }
    }

    /// An answer that is sent piece by piece: joining the pieces of a large answer would double its memory.
    pub(crate) fn in_pieces(pieces: impl IntoIterator<Item = Vec<u8>>) -> Self {
        let pieces: VecDeque<Bytes> = pieces.into_iter().map(Bytes::from).filter(|piece| !piece.is_empty()).collect();
        let length = pieces.iter().map(|piece| piece.len() as u64).sum();
        Self { pieces, length, is_compressed: false, held: None }
    }

    /// The same answer, compressed if the client accepts that. Once `cancel` is set, compression ends early, and the
    /// result must be discarded.
    pub(crate) fn compressed(self, is_accepted: bool, cancel: &CancelFlag) -> Self {
        if !is_accepted || !is_worthwhile(self.length) {
            return self;
        }
        let mut compressor = Compressor::new();
        let mut compressed = Vec::new();
        // Each piece is dropped when it is compressed.
        for piece in self.pieces {
            compressor.add(&piece, || cancel.is_cancelled());
            compressed.push(compressor.take());
        }
        compressed.push(compressor.finish());
        Self { is_compressed: true, ..Self::in_pieces(compressed) }
    }

    /// The same answer with the memory of its job, which is returned but for the answer's bytes, and then as these are
    /// sent.
    pub(crate) fn holding(mut self, mut held: Held) -> Self {
        held.shrink_to(self.length);
        self.held = Some(held);
        self
    }
}

/// A text whose writing fails once the flag is set.
struct Cancellable<'a> {
    text: Vec<u8>,
    cancel: &'a CancelFlag,
}

impl io::Write for Cancellable<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.cancel.is_cancelled() {
            return Err(io::Error::other("the answer is no longer needed"));
        }
        self.text.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    // The provided method loops, which takes longer than the writing of a short text.
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write(bytes).map(drop)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl HttpBody for WrittenJson {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        /// Large pieces are sent in frames of this size, because the connection stores a frame until the client has
        /// received it.
        const FRAME: usize = 64 * 1024;
        let Some(first) = self.pieces.front_mut() else { return Poll::Ready(None) };
        let frame = first.split_to(first.len().min(FRAME));
        let is_piece_sent = first.is_empty();
        self.length -= frame.len() as u64;
        if is_piece_sent {
            self.pieces.pop_front();
            let left = self.length;
            if let Some(held) = &mut self.held {
                held.shrink_to(left);
            }
        }
        Poll::Ready(Some(Ok(Frame::data(frame))))
    }

    fn is_end_stream(&self) -> bool {
        self.pieces.is_empty()
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::with_exact(self.length)
    }
}

impl IntoResponse for WrittenJson {
    fn into_response(self) -> Response {
        let coding = self.is_compressed.then_some([(header::CONTENT_ENCODING, GZIP)]);
        ([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], coding, Body::new(self)).into_response()
    }
}

/// Whether the media type is `application/json` or ends in `+json`, whatever its parameters.
fn is_json(headers: &HeaderMap) -> bool {
    let Some(media_type) = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()) else {
        return false;
    };
    let essence = media_type.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    essence == "application/json" || (essence.starts_with("application/") && essence.ends_with("+json"))
}

impl JsonBody {
    /// The body as received.
    pub(crate) fn json(&self) -> &[u8] {
        &self.json
    }

    /// Reads the body, an object, with `read`. Recorded faults take precedence over a result. Members that `read` does
    /// not take are faults.
    pub(crate) fn read<T>(&self, read: impl FnOnce(&mut Object<'_, '_>, &mut Faults) -> Result<T, Faulted>) -> Result<T, Problem> {
        self.read_until(&CancelFlag::default(), read)
    }

    /// Reads a body with large arrays, as [`Self::read`]. Once `cancel` is set, reading ends early, and the result must be
    /// discarded.
    pub(crate) fn read_until<T>(
        &self,
        cancel: &CancelFlag,
        read: impl FnOnce(&mut Object<'_, '_>, &mut Faults) -> Result<T, Faulted>,
    ) -> Result<T, Problem> {
        read_text(&self.json, cancel, read)
    }
}

/// The mark with which some programs begin UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// Reads JSON from any source, as [`JsonBody::read_until`]. A byte-order mark before it is skipped.
pub(crate) fn read_text<T>(
    json: &[u8],
    cancel: &CancelFlag,
    read: impl FnOnce(&mut Object<'_, '_>, &mut Faults) -> Result<T, Faulted>,
) -> Result<T, Problem> {
    let json = json.strip_prefix(BYTE_ORDER_MARK).unwrap_or(json);
    let mut faults = Faults::until(cancel);
    let marked;
    let object = match Object::open_body(json, &mut faults) {
        Ok(object) => object,
        Err(error) => {
            marked = mark_not_finite(json).ok_or_else(|| malformed(&error))?;
            Object::open_body(&marked, &mut faults).map_err(|error| malformed(&error))?
        }
    };
    match object.and_then(|object| object.read(&mut faults, read)) {
        Ok(result) if faults.is_empty() => Ok(result),
        _ => Err(Problem::faulty_request(faults)),
    }
}

/// The problem of a text that is not JSON.
pub(crate) fn malformed(error: &JsonError) -> Problem {
    Problem::new(ServiceProblem::MalformedJson, format!("the JSON cannot be read: {error}"))
}

/// Answers up to this size fit one packet: compressing them costs time and saves nothing.
const MIN_BYTES: u64 = 1024;

/// The number of bytes that are compressed between two checks whether the answer is still needed: a millisecond or two.
const CHUNK: usize = 64 * 1024;

/// The name of the coding.
pub(super) const GZIP: HeaderValue = HeaderValue::from_static("gzip");

/// Whether the client accepts gzip: it names `gzip` or `*` with a weight other than 0 (RFC 9110, section 12.5.3).
pub(super) fn accepts_gzip(headers: &HeaderMap) -> bool {
    let values = || headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    let weight_of = |name: &str| {
        values().flat_map(|value| value.split(',')).find_map(|item| {
            let (coding, parameters) = item.split_once(';').unwrap_or((item, "q=1"));
            let weight = parameters.trim().strip_prefix("q=").and_then(|weight| weight.parse::<f32>().ok());
            coding.trim().eq_ignore_ascii_case(name).then(|| weight.unwrap_or(0.0))
        })
    };
    weight_of("gzip").or_else(|| weight_of("*")).is_some_and(|weight| weight > 0.0)
}

/// Whether an answer of this size is compressed for clients that accept it.
pub(super) fn is_worthwhile(bytes: u64) -> bool {
    bytes > MIN_BYTES
}

/// An answer being compressed.
pub(super) struct Compressor(GzEncoder<Vec<u8>>);

impl Compressor {
    pub(super) fn new() -> Self {
        // Level 1 takes a third of the time of the default level, and its text of numbers is a tenth larger.
        Self(GzEncoder::new(Vec::new(), Compression::fast()))
    }

    /// Adds `bytes`; stops early once `is_cancelled`. Writing to memory does not fail.
    pub(super) fn add(&mut self, bytes: &[u8], is_cancelled: impl Fn() -> bool) {
        for chunk in bytes.chunks(CHUNK).take_while(|_| !is_cancelled()) {
            let _infallible = self.0.write_all(chunk);
        }
    }

    /// The compressed bytes that are ready.
    pub(super) fn take(&mut self) -> Vec<u8> {
        std::mem::take(self.0.get_mut())
    }

    /// The last compressed bytes.
    pub(super) fn finish(self) -> Vec<u8> {
        self.0.finish().unwrap_or_default()
    }
}

/// The layer: compresses answers of the media types for which that helps, unless they are compressed.
pub(super) async fn compress(State(workers): State<WorkerPool>, request: Request, next: Next) -> Response {
    let accepts = accepts_gzip(request.headers());
    let mut response = next.run(request).await;
    let is_whole = response.body().size_hint().exact().is_some_and(is_worthwhile);
    if !is_whole || !is_text(response.headers()) {
        return response;
    }
    response.headers_mut().append(header::VARY, HeaderValue::from_name(header::ACCEPT_ENCODING));
    if !accepts || response.headers().contains_key(header::CONTENT_ENCODING) {
        return response;
    }
    let (mut parts, body) = response.into_parts();
    // Bodies with a known length are in memory.
    let plain = match body.collect().await {
        Ok(plain) => plain.to_bytes(),
        Err(error) => {
            tracing::error!(%error, "an answer could not be read");
            return axum::http::StatusCode::INTERNAL_SERVER_ERROR.into_response();
        }
    };
    let body = compressed(&workers, plain).await;
    parts.headers.insert(header::CONTENT_ENCODING, GZIP);
    parts.headers.remove(header::CONTENT_LENGTH);
    parts.headers.remove(header::ACCEPT_RANGES);
    Response::from_parts(parts, Body::new(Full::new(body)))
}

/// `plain`, compressed in pieces of work. Dropping the future leaves out the pieces that follow.
async fn compressed(workers: &WorkerPool, mut plain: Bytes) -> Bytes {
    let mut compressor = Compressor::new();
    while !plain.is_empty() {
        let chunk = plain.split_to(plain.len().min(CHUNK));
        compressor = workers
            .run_piece(move |_| {
                compressor.add(&chunk, || false);
                compressor
            })
            .await;
    }
    compressor.finish().into()
}

/// Whether an answer is text: images and archives are compressed already.
fn is_text(headers: &HeaderMap) -> bool {
    let media_type = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let essence = media_type.split(';').next().unwrap_or_default().trim();
    essence.starts_with("text/") || ["json", "javascript", "xml", "openmetrics-text"].iter().any(|end| essence.ends_with(end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::GzDecoder;
    use std::io::Read;

    #[test]
    fn weights_and_wildcards_of_codings_are_read() {
        let accepts =
            |value: &'static str| accepts_gzip(&HeaderMap::from_iter([(header::ACCEPT_ENCODING, HeaderValue::from_static(value))]));
        assert!(!accepts_gzip(&HeaderMap::new()));
        for value in ["gzip", "GZIP", "br, gzip", "gzip, deflate, br", "gzip;q=0.1", "gzip; q=1", "*", "br;q=1, *;q=0.5"] {
            assert!(accepts(value), "{value}");
        }
        for value in ["", "br", "identity", "gzip;q=0", "*;q=1, gzip;q=0", "gzip;q=x", "*;q=0"] {
            assert!(!accepts(value), "{value}");
        }
    }

    #[test]
    fn bytes_come_back_whole_and_a_cancelled_compression_stops() {
        let plain: Vec<u8> = (0..1_000_000_u32).flat_map(u32::to_le_bytes).collect();
        let mut compressor = Compressor::new();
        let mut file = Vec::new();
        for half in plain.chunks(plain.len() / 2) {
            compressor.add(half, || false);
            file.extend(compressor.take());
        }
        file.extend(compressor.finish());
        let mut back = Vec::new();
        GzDecoder::new(&file[..]).read_to_end(&mut back).unwrap();
        assert!(back == plain);

        let mut cancelled = Compressor::new();
        cancelled.add(&plain, || true);
        assert!(cancelled.finish().len() < 100);
    }

    #[tokio::test]
    async fn pieces_of_work_compress_a_body() {
        let plain = vec![b'7'; 300_000];
        let file = compressed(&WorkerPool::start(1).unwrap(), plain.clone().into()).await;
        let mut back = Vec::new();
        GzDecoder::new(&file[..]).read_to_end(&mut back).unwrap();
        assert!(back == plain);
    }
}
