//! The server: it accepts connections, limits slow clients, and shuts down gracefully. It serves any router until the
//! caller's stop signal is ready.

use crate::settings::Settings;
use axum::Router;
use http::StatusCode;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use std::io::{self, IoSlice};
use std::pin::{Pin, pin};
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Sleep, sleep, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// The pause after an error that persists, such as too many open files, before the next connection is accepted.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// The time from the last accepted connection to the end of keep-alive. The requests of new connections are read in
/// this time.
const SETTLING: Duration = Duration::from_millis(100);

/// The largest head of a request: about twice the largest that browsers send, which includes cookies of other services.
const MAX_HEAD_BYTES: usize = 16 * 1024;

/// The largest number of bytes read or written at once.
const MAX_BUFFER_BYTES: usize = 64 * 1024;

/// Writes the answer to a request head that cannot be parsed, for which there is no handler.
pub type Refuse = Arc<dyn Fn(StatusCode) -> Vec<u8> + Send + Sync>;

/// The application that a server serves.
#[derive(Clone)]
pub struct App {
    /// The routes.
    pub router: Router,
    /// The answers to heads that cannot be parsed.
    pub refuse: Refuse,
}

impl std::fmt::Debug for App {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("App").field("router", &self.router).finish_non_exhaustive()
    }
}

/// The connections that are still open at the end of the grace.
#[must_use = "`cut` closes them"]
#[derive(Debug)]
pub struct Remaining {
    tasks: TaskTracker,
    cut: CancellationToken,
}

impl Remaining {
    /// Whether no connection is open.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tasks.is_empty()
    }

    /// Closes the connections. Requests in flight are dropped.
    pub async fn cut(self) {
        self.cut.cancel();
        self.tasks.wait().await;
    }
}

/// Serves `app` on `listener` until `stop` is ready; then accepts no more connections and lets requests in flight
/// finish within the settings' grace.
pub async fn serve(listener: TcpListener, app: App, settings: &Settings, stop: impl Future<Output = ()>) -> Remaining {
    let mut protocol = http1::Builder::new();
    // The time-out covers the pause before a head, too: hyper starts it when the previous request has ended.
    protocol.timer(TokioTimer::new()).header_read_timeout(settings.client_timeout_s);
    protocol.max_header_size(MAX_HEAD_BYTES).max_buf_size(MAX_BUFFER_BYTES);
    let connections = Connections {
        protocol,
        app,
        write_timeout: settings.client_timeout_s,
        ending: GracefulShutdown::new(),
        remaining: Remaining { tasks: TaskTracker::new(), cut: CancellationToken::new() },
    };
    let places = Arc::new(Semaphore::new(settings.max_connections()));
    let mut stop = pin!(stop);
    loop {
        // Connections beyond the limit wait in the system's queue.
        let accepted = async {
            let place = Arc::clone(&places).acquire_owned().await.ok();
            (listener.accept().await, place)
        };
        let (accepted, place) = tokio::select! {
            biased;
            () = &mut stop => break,
            accepted = accepted => accepted,
        };
        match accepted {
            Ok((stream, _)) => connections.spawn(stream, place),
            Err(error) if is_of_the_connection(&error) => tracing::debug!(%error, "a connection ended before it was accepted"),
            Err(error) => {
                tracing::error!(%error, "no connection can be accepted");
                sleep(ACCEPT_PAUSE).await;
            }
        }
    }
    connections.sweep(&listener).await;
    drop(listener);
    connections.end(settings.shutdown_grace()).await
}

struct Connections {
    protocol: http1::Builder,
    app: App,
    write_timeout: Duration,
    ending: GracefulShutdown,
    remaining: Remaining,
}

impl Connections {
    /// Serves a connection, which holds its place among the connections until it ends.
    fn spawn(&self, stream: TcpStream, place: Option<OwnedSemaphorePermit>) {
        // An answer is written as a whole, so waiting for more data would only delay it. If the option fails, the
        // answer is still sent.
        if let Err(error) = stream.set_nodelay(true) {
            tracing::debug!(%error, "TCP_NODELAY could not be set");
        }
        let App { router, refuse } = self.app.clone();
        let client = TokioIo::new(ClientStream::new(stream, self.write_timeout, refuse));
        let connection = self.ending.watch(self.protocol.serve_connection(client, TowerToHyperService::new(router)));
        let cut = self.remaining.cut.clone();
        self.remaining.tasks.spawn(async move {
            // Clients that closed the connection or were too slow; their requests have their own log lines.
            if let Some(Err(error)) = cut.run_until_cancelled(connection).await {
                tracing::debug!(%error, "a connection ended early");
            }
            drop(place);
        });
    }

    /// Accepts the connections in the system's queue before the listener closes, because their clients may have sent a
    /// request.
    async fn sweep(&self, listener: &TcpListener) {
        // One turn of the scheduler suffices for connections in the queue.
        while let Ok(Ok((stream, _))) = timeout(Duration::ZERO, listener.accept()).await {
            self.spawn(stream, None);
        }
    }

    async fn end(self, grace: Duration) -> Remaining {
        sleep(SETTLING).await;
        tracing::info!(connections = self.ending.count(), "no more connections are accepted");
        self.remaining.tasks.close();
        if timeout(grace, self.ending.shutdown()).await.is_err() {
            tracing::warn!(
                connections = self.remaining.tasks.len(),
                grace_s = grace.as_secs(),
                "the grace is over: connections are closed"
            );
        }
        self.remaining
    }
}

/// Whether an error concerns the connection that was about to be accepted, not the listener.
fn is_of_the_connection(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionAborted | io::ErrorKind::ConnectionReset)
}

/// Ready at the first SIGTERM, SIGHUP or Ctrl-C. Later signals are ignored, because the grace limits the time to stop.
///
/// # Errors
/// The system cannot install the signal handlers.
#[cfg(unix)]
pub fn stop_signal() -> io::Result<impl Future<Output = &'static str>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut terminate, mut interrupt) = (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
    let mut hangup = signal(SignalKind::hangup())?;
    Ok(async move {
        tokio::select! {
            _ = terminate.recv() => "SIGTERM",
            _ = interrupt.recv() => "SIGINT",
            _ = hangup.recv() => "SIGHUP",
        }
    })
}

/// Ready at the first Ctrl-C.
///
/// # Errors
/// Never fails on this system; the type is that of Unix.
#[cfg(not(unix))]
pub fn stop_signal() -> io::Result<impl Future<Output = &'static str>> {
    Ok(async {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
        "Ctrl-C"
    })
}

/// The time and the number of bytes for which a stream is still read after it was closed for writing. If bytes remain
/// unread, the system resets the connection and the client loses the answer. A client that does not stop sending is
/// reset after these limits.
const LINGER: Duration = Duration::from_secs(2);
const LINGER_BYTES: usize = 1 << 20;

/// The first bytes of a client that speaks HTTP/2 without asking.
const HTTP_2: &[u8] = b"PRI * HTTP/2.0\r\n";

/// A client's stream with three promises that the HTTP library does not make: an answer that is left unread ends the
/// connection; a head that cannot be parsed is answered with a problem; and a client receives the answer to a request that was
/// not read to its end.
struct ClientStream {
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
    fn new(stream: TcpStream, write_timeout: Duration, refuse: Refuse) -> Self {
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
