//! A client's stream that is dropped when the client leaves an answer unread, and that closes so that the client can still read
//! the answer to a request that was not read to its end.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::{Sleep, sleep};

/// How long, and for how many bytes, a closed stream is still read. Where bytes are left unread, the system answers a close with a
/// reset, and the client loses the answer; a client that goes on sending for ever must be reset in the end.
const LINGER: Duration = Duration::from_secs(2);
const LINGER_BYTES: usize = 1 << 20;

/// A client's stream.
pub(super) struct ClientStream {
    stream: TcpStream,
    longest_write: Duration,
    write: Option<Pin<Box<Sleep>>>,
    closing: Closing,
}

enum Closing {
    Open,
    Lingering { end: Pin<Box<Sleep>>, bytes: usize },
    Closed,
}

impl ClientStream {
    pub(super) fn new(stream: TcpStream, longest_write: Duration) -> Self {
        Self { stream, longest_write, write: None, closing: Closing::Open }
    }

    /// `polled`, or an error where writing has been waiting for the client too long.
    fn mind_write<T>(&mut self, context: &mut Context<'_>, polled: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if polled.is_ready() {
            self.write = None;
            return polled;
        }
        let longest = self.longest_write;
        let end = self.write.get_or_insert_with(|| Box::pin(sleep(longest)));
        ready!(end.as_mut().poll(context));
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the client left the answer unread")))
    }
}

impl AsyncRead for ClientStream {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, buffer: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for ClientStream {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, buffer: &[u8]) -> Poll<io::Result<usize>> {
        let polled = Pin::new(&mut self.stream).poll_write(context, buffer);
        self.mind_write(context, polled)
    }

    fn poll_write_vectored(mut self: Pin<&mut Self>, context: &mut Context<'_>, buffers: &[io::IoSlice<'_>]) -> Poll<io::Result<usize>> {
        let polled = Pin::new(&mut self.stream).poll_write_vectored(context, buffers);
        self.mind_write(context, polled)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let client = &mut *self;
        loop {
            match &mut client.closing {
                Closing::Open => {
                    ready!(Pin::new(&mut client.stream).poll_shutdown(context))?;
                    client.closing = Closing::Lingering { end: Box::pin(sleep(LINGER)), bytes: 0 };
                }
                Closing::Lingering { end, bytes } => {
                    let mut scrap = [0; 4096];
                    let mut buffer = ReadBuf::new(&mut scrap);
                    let read = Pin::new(&mut client.stream).poll_read(context, &mut buffer);
                    *bytes += buffer.filled().len();
                    let more = read.is_ready() && !buffer.filled().is_empty() && *bytes < LINGER_BYTES;
                    if read.is_pending() {
                        ready!(end.as_mut().poll(context));
                    }
                    if !more {
                        client.closing = Closing::Closed;
                    }
                }
                Closing::Closed => return Poll::Ready(Ok(())),
            }
        }
    }
}
