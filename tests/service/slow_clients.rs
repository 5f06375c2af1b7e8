//! Clients that send slowly or not at all, or do not read their answers.

use std::time::{Duration, Instant};

use axum::routing::{get, post};
use scallopd::http::{RouteClass, Routes};
use tokio::io::AsyncWriteExt;

use crate::app::defaults;
use crate::service::server::{self, read_all, send};

fn routes() -> Routes {
    Routes::new()
        .undocumented(RouteClass::Single, "/length", post(|body: axum::body::Bytes| async move { body.len().to_string() }))
        .undocumented(RouteClass::Single, "/large", get(|| async { vec![b'x'; 64 << 20] }))
        .undocumented(RouteClass::Single, "/never", get(std::future::pending::<()>))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn idle_and_trickling_connections_do_not_stop_a_request() {
    let server = server::start(defaults(), routes()).await;
    let mut idle = Vec::new();
    for _ in 0..500 {
        idle.push(server.connect().await);
    }
    let mut trickling = Vec::new();
    for _ in 0..50 {
        let mut stream = server.connect().await;
        send(&mut stream, "POST /length HTTP/1.1\r\nhost: test\r\ncontent-length: 1000\r\n\r\n").await;
        trickling.push(tokio::spawn(async move {
            while stream.write_all(b"x").await.is_ok() {
                tokio::time::sleep(Duration::from_secs(1)).await;
            }
        }));
    }
    for _ in 0..20 {
        let began = Instant::now();
        let answer = server.client.post(server.url("/length")).body("1234").send().await.unwrap();
        assert_eq!(answer.text().await.unwrap(), "4");
        // A request takes about a millisecond; if the slow clients delayed it, it would take seconds.
        assert!(began.elapsed() < Duration::from_secs(2), "{:?}", began.elapsed());
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    trickling.iter().for_each(tokio::task::JoinHandle::abort);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn silent_connections_and_unfinished_heads_are_closed() {
    let mut settings = defaults();
    settings.client_timeout_s = Duration::from_secs(1);
    let server = server::start(settings, routes()).await;
    for begin in ["", "GET /length HTTP/1.1\r\nhost"] {
        let mut stream = server.connect().await;
        send(&mut stream, begin).await;
        let answer = read_all(&mut stream).await;
        assert_eq!(answer, "");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stalled_body_is_answered_with_408() {
    let mut settings = defaults();
    settings.client_timeout_s = Duration::from_secs(1);
    let server = server::start(settings, routes()).await;
    let mut stream = server.connect().await;
    send(&mut stream, "POST /length HTTP/1.1\r\nhost: test\r\ncontent-length: 1000\r\n\r\n0123").await;
    let answer = read_all(&mut stream).await;
    assert!(answer.starts_with("HTTP/1.1 408"), "{answer}");
    assert!(answer.contains("application/problem+json"), "{answer}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_handler_that_takes_too_long_is_answered_with_408() {
    let mut settings = defaults();
    settings.request_timeout_s = Duration::from_secs(1);
    let server = server::start(settings, routes()).await;
    let answer = server.get("/never").await;
    assert_eq!(answer.status(), 408);
    assert_eq!(answer.headers()["content-type"], "application/problem+json");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_connection_of_a_client_that_leaves_its_answer_unread_is_closed() {
    let mut settings = defaults();
    settings.client_timeout_s = Duration::from_secs(1);
    let mut server = server::start(settings, routes()).await;
    let mut stream = server.connect().await;
    // 64 MB do not fit the system's buffers: the server waits for the client.
    send(&mut stream, "GET /large HTTP/1.1\r\nhost: test\r\n\r\n").await;
    let began = Instant::now();
    tokio::time::sleep(Duration::from_millis(200)).await;
    server.stop();
    server.stopped().await;
    // Without the time-out the server would have waited for the whole grace.
    assert!(began.elapsed() < defaults().shutdown_grace() / 2, "{:?}", began.elapsed());
    drop(stream);
}
