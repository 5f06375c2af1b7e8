//! The record of a request body's progress, which the log and the limits of time and size share, and the body that
//! keeps it.

use std::pin::Pin;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody};
use axum::extract::Request;
use http_body::{Frame, SizeHint};
use tokio::time::Instant;

use crate::http::problem::Problem;

/// The progress of one request's body. The outermost layer adds it to the request's extensions.
#[derive(Debug)]
pub(in super::super) struct BodyProgress {
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
    pub(in super::super) fn begin(is_unread: bool) -> Self {
        Self {
            began: Instant::now(),
            wire_bytes: AtomicU64::new(0),
            last_byte_ms: AtomicU64::new(0),
            is_unread: AtomicBool::new(is_unread),
            fault: OnceLock::new(),
        }
    }

    /// The record that the outermost layer added to `request`.
    pub(in super::super) fn of(request: &Request) -> Arc<Self> {
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

    pub(in super::super) fn wire_bytes(&self) -> u64 {
        self.wire_bytes.load(Ordering::Relaxed)
    }

    /// The time of the last bytes; before the first, the time of the request's head.
    pub(super) fn last_byte(&self) -> Instant {
        self.began + Duration::from_millis(self.last_byte_ms.load(Ordering::Relaxed))
    }

    /// Records that the body has been read to its end.
    fn note_end(&self) {
        self.is_unread.store(false, Ordering::Relaxed);
    }

    pub(in super::super) fn is_unread(&self) -> bool {
        self.is_unread.load(Ordering::Relaxed)
    }

    /// Records that the body broke a rule. Only the first fault is kept: later ones follow from it.
    pub(super) fn note_fault(&self, fault: Problem) -> Problem {
        self.fault.get_or_init(|| fault).clone()
    }

    pub(super) fn fault(&self) -> Option<&Problem> {
        self.fault.get()
    }
}

/// A body as it arrives, before decompression, whose progress is recorded.
pub(in super::super) struct RecordedBody {
    pub(in super::super) body: Body,
    pub(in super::super) progress: Arc<BodyProgress>,
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
