//! The JSON bodies of requests and answers: the extractor of a request's JSON, and answers that worker threads write.

use super::codes::ServiceProblem;
use super::collected_body::collect;
use super::middleware::memory_budget;
use super::problem::Problem;
use super::reading::{Faulted, Faults, Object};
use crate::cancellation::CancelFlag;
use crate::json_text::JsonError;
use crate::json_text::not_finite::mark_not_finite;
use crate::memory_budget::{MemoryBudget, Reservation};
use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{FromRequest, Request};
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
    budget: MemoryBudget,
}

impl<S: Send + Sync> FromRequest<S> for JsonBody {
    type Rejection = Problem;

    async fn from_request(request: Request, _: &S) -> Result<Self, Problem> {
        if !is_json(request.headers()) {
            let detail = "send JSON with the header content-type: application/json";
            return Err(Problem::new(ServiceProblem::UnsupportedMediaType, detail));
        }
        let budget = memory_budget(&request);
        let json = collect(request.into_body(), &budget).await?;
        Ok(Self { json, budget })
    }
}

/// The initial capacity of an answer, in bytes; few answers for one contact are larger.
const USUAL_ANSWER: usize = 1024;

/// An answer as JSON text, written by the thread that computed it.
pub(crate) struct WrittenJson {
    pieces: VecDeque<Bytes>,
    /// The bytes in the pieces.
    length: u64,
    /// The memory reserved for the answer until it is sent.
    reservation: Option<Reservation>,
}

impl WrittenJson {
    pub(crate) fn of(answer: &impl Serialize) -> Result<Self, Problem> {
        Self::until(&CancelFlag::default(), answer)
    }

    /// The same for a large answer. Once `cancel` is set, writing ends early, and the result must be discarded.
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
        Self { pieces, length, reservation: None }
    }

    /// The same answer with `reservation`, which is resized to the answer and released when the answer has been sent.
    pub(crate) fn holding(mut self, mut reservation: Reservation) -> Result<Self, Problem> {
        reservation.resize(self.length)?;
        self.reservation = Some(reservation);
        Ok(self)
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
            if let Some(reservation) = &mut self.reservation {
                reservation.shrink_to(left);
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
        ([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], Body::new(self)).into_response()
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

    /// The same for a large body. Once `cancel` is set, reading ends early, and the result must be discarded.
    pub(crate) fn read_until<T>(
        &self,
        cancel: &CancelFlag,
        read: impl FnOnce(&mut Object<'_, '_>, &mut Faults) -> Result<T, Faulted>,
    ) -> Result<T, Problem> {
        read_text(&self.json, &self.budget, cancel, read)
    }
}

/// [`JsonBody::read_until`] for JSON from another source.
pub(crate) fn read_text<T>(
    json: &[u8],
    budget: &MemoryBudget,
    cancel: &CancelFlag,
    read: impl FnOnce(&mut Object<'_, '_>, &mut Faults) -> Result<T, Faulted>,
) -> Result<T, Problem> {
    let mut faults = Faults::until(cancel);
    let marked;
    let object = match Object::open_body(json, &mut faults) {
        Ok(object) => object,
        Err(error) => {
            marked = mark_not_finite(json, budget, cancel)?.ok_or_else(|| malformed(&error))?;
            Object::open_body(marked.as_ref(), &mut faults).map_err(|error| malformed(&error))?
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
