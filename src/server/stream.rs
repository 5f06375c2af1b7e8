//! A client's stream with three promises that the HTTP library does not make: an answer that is left unread ends the
//! connection; a head that cannot be parsed is answered with a problem; and a client receives the answer to a request
//! that was not read to its end.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use http::StatusCode;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::{Sleep, sleep};

use super::Refuse;

/// The time and the number of bytes for which a stream is still read after it was closed for writing. If bytes remain
/// unread, the system resets the connection and the client loses the answer. A client that does not stop sending is
/// reset after these limits.
const LINGER: Duration = Duration::from_secs(2);
const LINGER_BYTES: usize = 1 << 20;

/// The first bytes of a client that speaks HTTP/2 without asking.
const HTTP_2: &[u8] = b"PRI * HTTP/2.0\r\n";

/// A client's stream.
pub(super) struct ClientStream {
    stream: TcpStream,
    refuse: Refuse,
    /// The longest time for which an answer may be left unread, and its end while one is.
    write_timeout: Duration,
    write: Option<Pin<Box<Sleep>>>,
    is_new: bool,
    lingering: Option<Lingering>,
}

struct Lingering {
    end: Pin<Box<Sleep>>,
    bytes: usize,
}

impl ClientStream {
    pub(super) fn new(stream: TcpStream, write_timeout: Duration, refuse: Refuse) -> Self {
        Self { stream, refuse, write_timeout, write: None, is_new: true, lingering: None }
    }

    /// Returns `polled`, or an error if the client has not read its answer for too long.
    fn bound_write<T>(&mut self, context: &mut Context<'_>, polled: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if polled.is_ready() {
            self.write = None;
            return polled;
        }
        let longest = self.write_timeout;
        let end = self.write.get_or_insert_with(|| Box::pin(sleep(longest)));
        ready!(end.as_mut().poll(context));
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the client left the answer unread")))
    }

    /// Answers a head that cannot be parsed. The answer fits the system's buffer unless the client has left earlier
    /// answers unread.
    fn refuse(&self, status: StatusCode) {
        if let Err(error) = self.stream.try_write(&(self.refuse)(status)) {
            tracing::debug!(%error, "a client does not take the answer to its malformed request");
        }
    }
}

/// The status of the HTTP parser's own answer to a malformed head, if `bytes` are one. It has neither a body nor the
/// request id of the service's answers, and JSON has no line breaks of heads.
fn parser_status(bytes: &[u8]) -> Option<StatusCode> {
    let head = bytes.strip_prefix(b"HTTP/1.1 ")?.strip_suffix(b"\r\n\r\n")?;
    let has_id = memchr::memmem::find(head, b"\r\nx-request-id: ").is_some();
    StatusCode::from_bytes(head.get(..3)?).ok().filter(|status| status.is_client_error() && !has_id)
}

impl AsyncRead for ClientStream {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, buffer: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        ready!(Pin::new(&mut self.stream).poll_read(context, buffer))?;
        if std::mem::take(&mut self.is_new) && buffer.filled().starts_with(HTTP_2) {
            self.refuse(StatusCode::BAD_REQUEST);
            buffer.clear();
        }
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for ClientStream {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        if let Some(status) = parser_status(bytes) {
            self.refuse(status);
            return Poll::Ready(Ok(bytes.len()));
        }
        let polled = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.bound_write(context, polled)
    }

    fn poll_write_vectored(mut self: Pin<&mut Self>, context: &mut Context<'_>, slices: &[IoSlice<'_>]) -> Poll<io::Result<usize>> {
        if let [only] = slices {
            return self.poll_write(context, only);
        }
        let polled = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.bound_write(context, polled)
    }

    fn is_write_vectored(&self) -> bool {
        true
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let client = &mut *self;
        if client.lingering.is_none() {
            ready!(Pin::new(&mut client.stream).poll_shutdown(context))?;
        }
        let Lingering { end, bytes } = client.lingering.get_or_insert_with(|| Lingering { end: Box::pin(sleep(LINGER)), bytes: 0 });
        loop {
            let mut discarded = [0; 4096];
            let mut buffer = ReadBuf::new(&mut discarded);
            let read = Pin::new(&mut client.stream).poll_read(context, &mut buffer);
            if read.is_pending() {
                return end.as_mut().poll(context).map(Ok);
            }
            *bytes += buffer.filled().len();
            if buffer.filled().is_empty() || *bytes >= LINGER_BYTES {
                return Poll::Ready(Ok(()));
            }
        }
    }
}
