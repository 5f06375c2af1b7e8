//! A client's stream with the limits for slow clients: the longest time for a head, for an idle connection, and for an
//! unread answer. After the stream is closed for writing it is still read for a while, so that a client receives the
//! answer to a request that was not read to its end.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use http::StatusCode;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::{Instant, Sleep, sleep, sleep_until};

use super::Refuse;
use super::state::{ConnectionState, Phase};
use crate::memory_budget::Reservation;

/// The time and the number of bytes for which a stream is still read after it was closed for writing. If bytes remain
/// unread, the system resets the connection and the client loses the answer. A client that does not stop sending is
/// reset after these limits.
const LINGER: Duration = Duration::from_secs(2);
const LINGER_BYTES: usize = 1 << 20;

/// The TCP stream, shared between the HTTP library and the watch for its end.
pub(super) type SharedStream = Arc<Mutex<TcpStream>>;

pub(super) fn lock(stream: &SharedStream) -> MutexGuard<'_, TcpStream> {
    stream.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The time-outs of a slow client.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClientTimeouts {
    pub(super) header: Duration,
    pub(super) idle: Duration,
    pub(super) write: Duration,
}

/// A client's stream.
pub(super) struct ClientStream {
    stream: SharedStream,
    state: Arc<ConnectionState>,
    timeouts: ClientTimeouts,
    refuse: Refuse,
    opened: Instant,
    head: Head,
    /// Wakes the task at the deadline of a head or earlier.
    alarm: Option<Pin<Box<Sleep>>>,
    write: Option<Pin<Box<Sleep>>>,
    /// The number of answers sent completely.
    answered: u32,
    closing: Closing,
}

/// The part of a request's head that has arrived.
struct Head {
    /// The number of requests before it.
    number: u32,
    bytes: usize,
    began: Option<Instant>,
    /// The memory of heads that arrive in several pieces.
    reservation: Reservation,
}

enum Closing {
    Open,
    Lingering { end: Pin<Box<Sleep>>, bytes: usize },
    Closed,
}

impl ClientStream {
    pub(super) fn new(
        stream: SharedStream,
        state: Arc<ConnectionState>,
        timeouts: ClientTimeouts,
        refuse: Refuse,
        reservation: Reservation,
    ) -> Self {
        let head = Head { number: 0, bytes: 0, began: None, reservation };
        let opened = Instant::now();
        Self { stream, state, timeouts, refuse, opened, head, alarm: None, write: None, answered: 0, closing: Closing::Open }
    }

    /// Returns `polled`, or an error if the client has not read its answer for too long.
    fn bound_write<T>(&mut self, context: &mut Context<'_>, polled: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if polled.is_ready() {
            self.write = None;
            return polled;
        }
        let longest = self.timeouts.write;
        let end = self.write.get_or_insert_with(|| Box::pin(sleep(longest)));
        ready!(end.as_mut().poll(context));
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the client left the answer unread")))
    }

    /// Records `bytes` of a head; false if the memory budget has no room for them.
    fn note_head_bytes(&mut self, bytes: usize) -> bool {
        let head = &mut self.head;
        let requests = self.state.requests();
        if head.number != requests {
            head.reservation.shrink_to(0);
            (head.number, head.bytes, head.began) = (requests, 0, None);
        }
        if bytes == 0 {
            return true;
        }
        if head.began.is_none() {
            head.began = Some(Instant::now());
        } else if head.reservation.grow((head.bytes + bytes) as u64 - head.reservation.bytes()).is_err() {
            return false;
        }
        head.bytes += bytes;
        true
    }

    /// The deadline for a head, or for the rest of one.
    fn head_deadline(&self) -> Instant {
        match (self.head.began, self.state.awaiting_since()) {
            (Some(began), _) => began + self.timeouts.header,
            (None, Some(since)) if self.state.requests() > 0 => Instant::from_std(since) + self.timeouts.idle,
            (None, _) => self.opened + self.timeouts.header,
        }
    }

    /// Ready when the connection must close while it waits for a head.
    fn poll_head_deadline(&mut self, context: &mut Context<'_>) -> Poll<()> {
        if self.state.poll_evicted(context) {
            return Poll::Ready(());
        }
        loop {
            let deadline = self.head_deadline();
            // A timer that fires early costs less than resetting the timer with each request.
            let alarm = match &mut self.alarm {
                Some(alarm) if alarm.deadline() <= deadline && !alarm.is_elapsed() => alarm,
                Some(alarm) => {
                    alarm.as_mut().reset(deadline);
                    alarm
                }
                None => self.alarm.insert(Box::pin(sleep_until(deadline))),
            };
            ready!(alarm.as_mut().poll(context));
            if Instant::now() >= deadline {
                if self.head.began.is_some() {
                    self.refuse(StatusCode::REQUEST_TIMEOUT);
                }
                return Poll::Ready(());
            }
        }
    }

    /// Answers a head that cannot be parsed. The answer fits the system's buffer unless the client has left earlier
    /// answers unread.
    fn refuse(&self, status: StatusCode) {
        let answer = (self.refuse)(status);
        if let Err(error) = lock(&self.stream).try_write(&answer) {
            tracing::debug!(%error, "a client does not take the answer to its malformed request");
        }
    }

    /// The status of the HTTP parser's answer to a malformed head, if `bytes` are that answer. The parser's answer has
    /// no body and no request id, so it is replaced.
    fn parser_status(&self, bytes: &[u8]) -> Option<StatusCode> {
        let is_between_requests = self.answered == self.state.requests();
        let status = bytes.strip_prefix(b"HTTP/1.1 ").filter(|_| is_between_requests)?.get(..3)?;
        StatusCode::from_bytes(status).ok().filter(StatusCode::is_client_error)
    }
}

impl AsyncRead for ClientStream {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, buffer: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let polled = Pin::new(&mut *lock(&self.stream)).poll_read(context, buffer);
        if !self.state.is_in(Phase::AwaitingHead) {
            return polled;
        }
        if !self.note_head_bytes(buffer.filled().len() - before) {
            self.refuse(StatusCode::SERVICE_UNAVAILABLE);
            buffer.set_filled(before);
            return Poll::Ready(Ok(()));
        }
        // No bytes mean the end of the stream.
        if polled.is_pending() { self.poll_head_deadline(context).map(Ok) } else { polled }
    }
}

impl AsyncWrite for ClientStream {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        if let Some(status) = self.parser_status(bytes) {
            self.refuse(status);
            return Poll::Ready(Ok(bytes.len()));
        }
        let polled = Pin::new(&mut *lock(&self.stream)).poll_write(context, bytes);
        self.bound_write(context, polled)
    }

    fn poll_write_vectored(mut self: Pin<&mut Self>, context: &mut Context<'_>, slices: &[io::IoSlice<'_>]) -> Poll<io::Result<usize>> {
        if let Some(status) = slices.first().and_then(|slice| self.parser_status(slice)) {
            self.refuse(status);
            return Poll::Ready(Ok(slices.iter().map(|slice| slice.len()).sum()));
        }
        let polled = Pin::new(&mut *lock(&self.stream)).poll_write_vectored(context, slices);
        self.bound_write(context, polled)
    }

    fn is_write_vectored(&self) -> bool {
        true
    }

    /// Called when all of an answer has been written.
    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let polled = Pin::new(&mut *lock(&self.stream)).poll_flush(context);
        if polled.is_ready() && self.state.is_in(Phase::AwaitingHead) {
            self.answered = self.state.requests();
        }
        polled
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let client = &mut *self;
        loop {
            match &mut client.closing {
                Closing::Open => {
                    ready!(Pin::new(&mut *lock(&client.stream)).poll_shutdown(context))?;
                    if client.state.is_evicted() {
                        // There is no answer that could be lost, and a new connection waits for this entry.
                        client.closing = Closing::Closed;
                        continue;
                    }
                    client.closing = Closing::Lingering { end: Box::pin(sleep(LINGER)), bytes: 0 };
                }
                Closing::Lingering { end, bytes } => {
                    let mut discarded = [0; 4096];
                    let mut buffer = ReadBuf::new(&mut discarded);
                    let read = Pin::new(&mut *lock(&client.stream)).poll_read(context, &mut buffer);
                    *bytes += buffer.filled().len();
                    let has_more = read.is_ready() && !buffer.filled().is_empty() && *bytes < LINGER_BYTES;
                    if read.is_pending() {
                        ready!(end.as_mut().poll(context));
                    }
                    if !has_more {
                        client.closing = Closing::Closed;
                    }
                }
                Closing::Closed => return Poll::Ready(Ok(())),
            }
        }
    }
}
