//! The server: accepts connections, bounds slow clients, and shuts down gracefully. It serves any router until the caller's stop signal.

mod signal;
mod stream;

use std::io;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::{GracefulShutdown, Watcher};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{sleep, timeout};

pub use signal::stop_signal;

use crate::settings::ServerSettings;
use stream::ClientStream;

/// After an error of accepting that will not pass by itself, such as too many open files.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Between the last accepted connection and the word to all to end: what a client sent right after connecting is read by then.
const SETTLING: Duration = Duration::from_millis(100);

/// Serves `router` on `listener` until `stop` is ready; then accepts no more connections and gives those that have a request in
/// flight the settings' grace to finish it.
///
/// # Errors
/// None that a client or a shortage of resources can cause; those are logged, and serving goes on.
pub async fn serve(listener: TcpListener, router: Router, settings: &ServerSettings, stop: impl Future<Output = ()>) -> io::Result<()> {
    let mut protocol = http1::Builder::new();
    protocol.timer(TokioTimer::new()).header_read_timeout(settings.header_timeout);
    let connections = Connections {
        protocol,
        router,
        write_timeout: settings.write_timeout,
        places: Arc::new(Semaphore::new(settings.max_connections)),
        ending: GracefulShutdown::new(),
    };
    let mut stop = std::pin::pin!(stop);
    loop {
        tokio::select! {
            biased;
            () = &mut stop => break,
            (accepted, place) = connections.accept(&listener) => connections.open(accepted, place).await,
        }
    }
    connections.sweep(&listener).await;
    drop(listener);
    connections.end(settings.shutdown_grace).await;
    Ok(())
}

struct Connections {
    protocol: http1::Builder,
    router: Router,
    write_timeout: Duration,
    places: Arc<Semaphore>,
    ending: GracefulShutdown,
}

impl Connections {
    /// The next connection, once there is a place for it: beyond the limit they wait in the system's queue, which is bounded.
    async fn accept(&self, listener: &TcpListener) -> (io::Result<TcpStream>, OwnedSemaphorePermit) {
        let place = Arc::clone(&self.places).acquire_owned().await;
        let place = place.unwrap_or_else(|_| unreachable!("the semaphore is never closed"));
        (listener.accept().await.map(|(stream, _)| stream), place)
    }

    async fn open(&self, accepted: io::Result<TcpStream>, place: OwnedSemaphorePermit) {
        match accepted {
            Ok(stream) => self.spawn(stream, place),
            Err(error) if is_of_the_connection(&error) => tracing::debug!(%error, "a connection ended before it was accepted"),
            Err(error) => {
                tracing::error!(%error, "no connection can be accepted");
                sleep(ACCEPT_PAUSE).await;
            }
        }
    }

    fn spawn(&self, stream: TcpStream, place: OwnedSemaphorePermit) {
        // An answer is written whole: waiting for more of it would only delay it. Without the option it is still an answer.
        if let Err(error) = stream.set_nodelay(true) {
            tracing::debug!(%error, "TCP_NODELAY could not be set");
        }
        let stream = TokioIo::new(ClientStream::new(stream, self.write_timeout));
        let connection = self.protocol.serve_connection(stream, TowerToHyperService::new(self.router.clone()));
        let watcher: Watcher = self.ending.watcher();
        tokio::spawn(async move {
            // Errors here are clients that left or were too slow; their requests have their own log lines.
            if let Err(error) = watcher.watch(connection).await {
                tracing::debug!(%error, "a connection ended early");
            }
            drop(place);
        });
    }

    /// Takes the connections that the system accepted before the listener closes: their clients may have sent a request already.
    async fn sweep(&self, listener: &TcpListener) {
        while let Ok(place) = Arc::clone(&self.places).try_acquire_owned() {
            // One turn of the scheduler is enough for what is there already.
            let Ok(Ok((stream, _))) = timeout(Duration::ZERO, listener.accept()).await else { return };
            self.spawn(stream, place);
        }
    }

    async fn end(self, grace: Duration) {
        sleep(SETTLING).await;
        let left = self.ending.count();
        tracing::info!(connections = left, "no more connections are accepted");
        let places = self.places;
        let all = places.available_permits() + left;
        if timeout(grace, self.ending.shutdown()).await.is_err() {
            let cut = all.saturating_sub(places.available_permits());
            tracing::warn!(connections = cut, grace_s = grace.as_secs(), "the grace is over: connections are cut");
        }
    }
}

/// Errors of the connection that was about to be accepted, not of accepting.
fn is_of_the_connection(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionAborted | io::ErrorKind::ConnectionReset)
}
