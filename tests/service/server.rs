//! A server in-process, on a free port, with routes of a test's own.

use std::net::SocketAddr;
use std::time::Duration;

use axum::routing::get;
use scallopd::http::{self, AppState, RouteClass, Routes, metrics, readiness};
use scallopd::server::{self, App};
use scallopd::settings::{Command, Settings};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// Longer than anything here takes on a slow machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);

pub(crate) fn defaults() -> Settings {
    let Ok(Command::Serve(settings)) = Command::read(["scallopd"]) else { panic!("the defaults cannot be used") };
    *settings
}

pub(crate) struct TestServer {
    pub(crate) address: SocketAddr,
    pub(crate) state: AppState,
    pub(crate) client: reqwest::Client,
    stop: Option<oneshot::Sender<()>>,
    served: JoinHandle<std::io::Result<()>>,
}

impl TestServer {
    /// Serves `routes` and the probes.
    pub(crate) async fn start(settings: Settings, routes: Routes) -> Self {
        let state = AppState::start(&settings.http).unwrap();
        let routes = routes
            .undocumented(RouteClass::Probe, "/livez", get(readiness::livez))
            .undocumented(RouteClass::Probe, "/readyz", get(readiness::readyz))
            .undocumented(RouteClass::Probe, "/metrics", get(metrics::show));
        let app =
            App { router: http::service(routes, &settings.http, &state), refuse: http::refusals(&state), budget: state.budget.clone() };
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = oneshot::channel();
        let served = tokio::spawn(async move {
            let stop = async {
                let _ = stopped.await;
            };
            server::serve(listener, app, &settings.server, stop).await
        });
        let client = reqwest::Client::builder().no_gzip().timeout(PATIENCE).build().unwrap();
        Self { address, state, client, stop: Some(stop), served }
    }

    pub(crate) fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    pub(crate) async fn get(&self, path: &str) -> reqwest::Response {
        self.client.get(self.url(path)).send().await.unwrap()
    }

    pub(crate) async fn metrics(&self) -> String {
        self.get("/metrics").await.text().await.unwrap()
    }

    /// A connection of the test's own.
    pub(crate) async fn connect(&self) -> TcpStream {
        TcpStream::connect(self.address).await.unwrap()
    }

    /// Asks the server to stop.
    pub(crate) fn stop(&mut self) {
        self.stop.take().expect("stopped once").send(()).unwrap();
    }

    /// Waits until it has.
    pub(crate) async fn stopped(self) {
        tokio::time::timeout(PATIENCE, self.served).await.expect("the server stops").unwrap().unwrap();
    }
}

pub(crate) async fn send(stream: &mut TcpStream, text: &str) {
    stream.write_all(text.as_bytes()).await.unwrap();
}

/// What comes until the server closes the stream.
pub(crate) async fn read_all(stream: &mut TcpStream) -> String {
    let mut bytes = Vec::new();
    tokio::time::timeout(PATIENCE, stream.read_to_end(&mut bytes)).await.expect("the server closes the stream").unwrap();
    String::from_utf8(bytes).unwrap()
}

/// Waits until `condition` holds.
pub(crate) async fn until(what: &str, condition: impl AsyncFn() -> bool) {
    let deadline = tokio::time::Instant::now() + PATIENCE;
    while !condition().await {
        assert!(tokio::time::Instant::now() < deadline, "in vain: {what}");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
}
