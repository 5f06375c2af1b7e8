//! Graceful shutdown.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::routing::get;
use scallopd::http::{RouteClass, Routes};
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio::sync::Semaphore;

use crate::app::defaults;
use crate::service::server::{self, read_all, send, until};

fn waiting(release: &Arc<Semaphore>) -> Routes {
    let release = Arc::clone(release);
    Routes::new().undocumented(RouteClass::Single, "/wait", get(move || async move { release.acquire().await.map(|_| "done").unwrap() }))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn requests_in_flight_finish_and_new_connections_are_refused() {
    let release = Arc::new(Semaphore::new(0));
    let mut server = server::start(defaults(), waiting(&release)).await;
    let held: Vec<_> = (0..20).map(|_| tokio::spawn(server.client.get(server.url("/wait")).send())).collect();
    until("all in flight", async || server.metrics().await.contains("scallopd_http_requests_in_flight 21\n")).await;
    server.stop();
    let address = server.address;
    until("new connections refused", async || TcpStream::connect(address).await.is_err()).await;
    release.add_permits(20);
    for request in held {
        assert_eq!(request.await.unwrap().unwrap().text().await.unwrap(), "done");
    }
    server.stopped().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_draining_server_is_not_ready_and_announces_the_end_of_connections() {
    let server = server::start(defaults(), Routes::new()).await;
    assert_eq!(server.get("/readyz").await.status(), 200);
    server.state.readiness.drain();
    let answer = server.get("/readyz").await;
    assert_eq!(answer.status(), 503);
    assert_eq!(answer.headers()["connection"], "close");
    assert_eq!(server.get("/livez").await.status(), 200);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn requests_sent_right_before_the_stop_are_answered() {
    let mut server = server::start(defaults(), Routes::new()).await;
    let mut streams = Vec::new();
    for _ in 0..50 {
        let mut stream = server.connect().await;
        send(&mut stream, "GET /livez HTTP/1.1\r\nhost: test\r\n\r\n").await;
        streams.push(stream);
    }
    server.stop();
    for stream in &mut streams {
        let answer = read_all(stream).await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer:?}");
    }
    server.stopped().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_grace_limits_the_time_to_stop() {
    let never = Arc::new(Semaphore::new(0));
    let mut settings = defaults();
    settings.shutdown_grace_s = Some(Duration::from_secs(1));
    let mut server = server::start(settings, waiting(&never)).await;
    let held = tokio::spawn(server.client.get(server.url("/wait")).send());
    until("in flight", async || server.metrics().await.contains("scallopd_http_requests_in_flight 2\n")).await;
    let began = Instant::now();
    server.stop();
    server.stopped().await;
    assert!(began.elapsed() >= Duration::from_secs(1));
    // The client's time-out is 30 s.
    assert!(began.elapsed() < Duration::from_secs(15), "{:?}", began.elapsed());
    held.abort();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_request_whose_body_is_still_arriving_is_finished() {
    let length = axum::routing::post(|body: axum::body::Bytes| async move { body.len().to_string() });
    let mut server = server::start(defaults(), Routes::new().undocumented(RouteClass::Single, "/length", length)).await;
    let mut streams = Vec::new();
    for _ in 0..20 {
        let mut stream = server.connect().await;
        send(&mut stream, "POST /length HTTP/1.1\r\nhost: test\r\ncontent-length: 8\r\nexpect: 100-continue\r\n\r\n").await;
        // The server has asked for the body, so the request is accepted.
        let mut go_on = [0; 25];
        stream.read_exact(&mut go_on).await.unwrap();
        assert_eq!(&go_on, b"HTTP/1.1 100 Continue\r\n\r\n");
        send(&mut stream, "0123").await;
        streams.push(stream);
    }
    server.stop();
    let address = server.address;
    until("new connections refused", async || TcpStream::connect(address).await.is_err()).await;
    for stream in &mut streams {
        send(stream, "4567").await;
        let answer = read_all(stream).await;
        assert!(answer.starts_with("HTTP/1.1 200") && answer.ends_with("\r\n\r\n8"), "{answer:?}");
    }
    server.stopped().await;
}
