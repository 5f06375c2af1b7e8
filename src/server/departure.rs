//! Detection of clients that close the connection before their answer is ready, so that their computation is cancelled.
//! The HTTP library does not read a connection while an answer is computed, and it cannot distinguish a client that has
//! closed only its sending side from one that has closed the connection.

use std::pin::{Pin, pin};
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{Interest, ReadBuf};
use tokio::time::{Sleep, sleep};

use super::state::{ConnectionState, Phase};
use super::stream::{SharedStream, lock};

/// How long the server still answers a client that has closed its sending side.
const HALF_CLOSED: Duration = Duration::from_secs(1);

/// The interval of checks if the client has sent more than the request. The system reports the end of the stream only
/// after those bytes.
const RECHECK: Duration = Duration::from_millis(250);

/// The interval of checks for a reset while a body arrives: the service reads no more of it while it works on a part.
const RECEIVING_RECHECK: Duration = Duration::from_millis(20);

/// The watch on one connection.
pub(super) struct Departure {
    stream: SharedStream,
    state: Arc<ConnectionState>,
    half_closed: Option<Pin<Box<Sleep>>>,
    recheck: Option<Pin<Box<Sleep>>>,
}

impl Departure {
    pub(super) fn new(stream: SharedStream, state: Arc<ConnectionState>) -> Self {
        Self { stream, state, half_closed: None, recheck: None }
    }

    /// Ready when the client has closed the connection before its answer was ready.
    pub(super) fn poll(&mut self, context: &mut Context<'_>) -> Poll<()> {
        if self.state.is_in(Phase::Receiving) {
            return self.poll_reset(context);
        }
        if !self.state.is_in(Phase::Working) {
            (self.half_closed, self.recheck) = (None, None);
            return Poll::Pending;
        }
        loop {
            if let Some(end) = &mut self.half_closed {
                return end.as_mut().poll(context);
            }
            if let Some(next) = &mut self.recheck {
                ready!(next.as_mut().poll(context));
                self.recheck = None;
            }
            match ready!(self.poll_end(context)) {
                End::Reset => return Poll::Ready(()),
                End::HalfClosed => self.half_closed = Some(Box::pin(sleep(HALF_CLOSED))),
                End::Unknown => self.recheck = Some(Box::pin(sleep(RECHECK))),
            }
        }
    }

    /// Ready when the connection was reset. Unread bytes do not hide a reset, as they hide the end of the stream.
    fn poll_reset(&mut self, context: &mut Context<'_>) -> Poll<()> {
        loop {
            if let Some(next) = &mut self.recheck {
                ready!(next.as_mut().poll(context));
            }
            let stream = lock(&self.stream);
            if let Poll::Ready(Ok(ready)) = pin!(stream.ready(Interest::WRITABLE)).poll(context)
                && ready.is_write_closed()
            {
                return Poll::Ready(());
            }
            drop(stream);
            self.recheck = Some(Box::pin(sleep(RECEIVING_RECHECK)));
        }
    }

    fn poll_end(&self, context: &mut Context<'_>) -> Poll<End> {
        let stream = lock(&self.stream);
        let mut byte = [0];
        let peeked = ready!(stream.poll_peek(context, &mut ReadBuf::new(&mut byte)));
        Poll::Ready(match peeked {
            Err(_) => End::Reset,
            Ok(0) => End::HalfClosed,
            Ok(_) => match pin!(stream.ready(Interest::READABLE)).poll(context) {
                Poll::Ready(Ok(ready)) if ready.is_read_closed() => End::HalfClosed,
                _ => End::Unknown,
            },
        })
    }
}

enum End {
    /// The client closed or broke the connection.
    Reset,
    /// The client closed its sending side.
    HalfClosed,
    /// Unread bytes come before the end, so the state is not known.
    Unknown,
}
