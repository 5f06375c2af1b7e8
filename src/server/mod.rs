//! The server: it accepts connections, limits slow clients, and shuts down gracefully. It serves any router until the
//! caller's stop signal is ready.

mod departure;
mod signal;
mod state;
mod stream;
mod table;
mod tracked;

use std::convert::Infallible;
use std::future::poll_fn;
use std::io;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::{Arc, Mutex};
use std::task::Poll;
use std::time::Duration;

use axum::Router;
use axum::body::HttpBody;
use http::{HeaderValue, Request, StatusCode, header};
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{sleep, timeout};
use tower::ServiceExt;

pub use signal::stop_signal;

use crate::memory_budget::MemoryBudget;
use crate::settings::ServerSettings;
use departure::Departure;
use stream::{ClientStream, ClientTimeouts};
use table::{ConnectionTable, Entry};
use tracked::{AnswerBody, RequestBody};

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
    /// The memory budget of heads that arrive in pieces.
    pub budget: MemoryBudget,
}

impl std::fmt::Debug for App {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("App").field("router", &self.router).field("budget", &self.budget).finish_non_exhaustive()
    }
}

/// Serves `app` on `listener` until `stop` is ready; then accepts no more connections and lets requests in flight
/// finish within the settings' grace.
///
/// # Errors
/// Returns errors of the listener. Errors of clients and shortages of resources are only logged.
pub async fn serve(listener: TcpListener, app: App, settings: &ServerSettings, stop: impl Future<Output = ()>) -> io::Result<()> {
    let mut protocol = http1::Builder::new();
    // `ClientStream` has its own deadlines for heads, and `Departure` detects clients that close the connection.
    protocol.timer(TokioTimer::new()).header_read_timeout(None).half_close(true);
    protocol.max_header_size(MAX_HEAD_BYTES).max_buf_size(MAX_BUFFER_BYTES);
    let timeouts = ClientTimeouts { header: settings.header_timeout, idle: settings.idle_timeout, write: settings.write_timeout };
    let connections =
        Connections { protocol, app, timeouts, table: ConnectionTable::new(settings.max_connections), ending: GracefulShutdown::new() };
    let mut stop = pin!(stop);
    loop {
        let accepted = tokio::select! {
            biased;
            () = &mut stop => break,
            accepted = listener.accept() => accepted,
        };
        let Some(stream) = connections.accepted(accepted).await else { continue };
        tokio::select! {
            biased;
            entry = connections.table.enter() => connections.spawn(stream, entry),
            () = &mut stop => {
                connections.spawn(stream, connections.table.enter_beyond_limit());
                break;
            }
        }
    }
    connections.sweep(&listener).await;
    drop(listener);
    connections.end(settings.shutdown_grace).await;
    Ok(())
}

struct Connections {
    protocol: http1::Builder,
    app: App,
    timeouts: ClientTimeouts,
    table: ConnectionTable,
    ending: GracefulShutdown,
}

impl Connections {
    /// The accepted stream; `None` after an error, which is logged.
    async fn accepted(&self, accepted: io::Result<(TcpStream, SocketAddr)>) -> Option<TcpStream> {
        match accepted {
            Ok((stream, _)) => return Some(stream),
            Err(error) if is_of_the_connection(&error) => tracing::debug!(%error, "a connection ended before it was accepted"),
            Err(error) => {
                tracing::error!(%error, "no connection can be accepted");
                sleep(ACCEPT_PAUSE).await;
            }
        }
        None
    }

    fn spawn(&self, stream: TcpStream, entry: Entry) {
        // An answer is written as a whole, so waiting for more data would only delay it. If the option fails, the
        // answer is still sent.
        if let Err(error) = stream.set_nodelay(true) {
            tracing::debug!(%error, "TCP_NODELAY could not be set");
        }
        let stream = Arc::new(Mutex::new(stream));
        let state = Arc::clone(entry.state());
        let App { router, refuse, budget } = self.app.clone();
        let client = ClientStream::new(Arc::clone(&stream), Arc::clone(&state), self.timeouts, refuse, budget.open());
        let mut departure = Departure::new(stream, Arc::clone(&state));
        let closes = entry.is_in_reserve();
        let service = service_fn(move |request: Request<Incoming>| {
            state.begin_request(!request.body().is_end_stream());
            let request = request.map(|body| RequestBody { body, state: Arc::clone(&state) });
            let answer = router.clone().oneshot(request);
            let state = Arc::clone(&state);
            async move {
                let mut answer = answer.await?;
                state.begin_answer();
                if closes {
                    answer.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
                }
                Ok::<_, Infallible>(answer.map(|body| AnswerBody { body, state }))
            }
        });
        let connection = self.protocol.serve_connection(TokioIo::new(client), service);
        let watcher = self.ending.watcher();
        tokio::spawn(async move {
            let mut served = pin!(watcher.watch(connection));
            let ended = poll_fn(|context| match served.as_mut().poll(context) {
                Poll::Ready(served) => Poll::Ready(Some(served)),
                Poll::Pending => departure.poll(context).map(|()| None),
            });
            // Such clients closed the connection or were too slow; their requests have their own log lines.
            match ended.await {
                Some(Ok(())) => {}
                Some(Err(error)) => tracing::debug!(%error, "a connection ended early"),
                None => tracing::debug!("a client closed its connection before the answer was ready"),
            }
            drop(entry);
        });
    }

    /// Accepts the connections in the system's queue before the listener closes, because their clients may have sent a
    /// request.
    async fn sweep(&self, listener: &TcpListener) {
        // One turn of the scheduler suffices for connections in the queue.
        while let Ok(Ok((stream, _))) = timeout(Duration::ZERO, listener.accept()).await {
            self.spawn(stream, self.table.enter_beyond_limit());
        }
    }

    async fn end(self, grace: Duration) {
        sleep(SETTLING).await;
        tracing::info!(connections = self.ending.count(), "no more connections are accepted");
        let open = self.table;
        if timeout(grace, self.ending.shutdown()).await.is_err() {
            tracing::warn!(connections = open.count(), grace_s = grace.as_secs(), "the grace is over: connections are closed");
        }
    }
}

/// Whether an error concerns the connection that was about to be accepted, not the listener.
fn is_of_the_connection(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionAborted | io::ErrorKind::ConnectionReset)
}
