//! The server: it accepts connections, limits slow clients, and shuts down gracefully. It serves any router until the
//! caller's stop signal is ready.

mod signal;
mod stream;

use std::io;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use http::StatusCode;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

pub use signal::stop_signal;

use crate::settings::Settings;
use stream::ClientStream;

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
