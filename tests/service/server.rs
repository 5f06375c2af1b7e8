//! Servers with the probes and the routes of a test, and TCP streams to them.

use std::time::Duration;

use axum::routing::get;
use scallopd::http::{RouteClass, Routes, metrics, readiness};
use scallopd::settings::Settings;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::app::{PATIENCE, TestApp};

/// Serves `routes` and the probes.
pub(crate) async fn start(settings: Settings, routes: Routes) -> TestApp {
    let routes = routes
        .undocumented(RouteClass::Probe, "/livez", get(readiness::livez))
        .undocumented(RouteClass::Probe, "/readyz", get(readiness::readyz))
        .undocumented(RouteClass::Probe, "/metrics", get(metrics::show));
    TestApp::serve(settings, routes).await
}

pub(crate) async fn send(stream: &mut TcpStream, text: &str) {
    stream.write_all(text.as_bytes()).await.unwrap();
}

/// Reads until the server closes the stream.
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
