//! The JSON bodies of requests and answers: the extractor of a request's JSON, and answers that worker threads write.

use super::codes::ServiceProblem;
use super::compression::{Compressor, GZIP, is_worthwhile};
use super::problem::Problem;
use super::reading::{Faulted, Faults, Object, mark_not_finite};
use super::request_body::collect;
use crate::budget::{Budget, Held};
use crate::cancellation::CancelFlag;
use crate::json::JsonError;
use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{FromRef, FromRequest, Request};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use http_body::{Frame, SizeHint};
use serde::Serialize;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::io;
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
            let detail = "send JSON with the header content-type: application/json";
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
