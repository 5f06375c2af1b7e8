//! Irregular connections: malformed heads, clients that close the connection, idle connections, and connections beyond
//! the limit.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use axum::http::HeaderMap;
use axum::response::IntoResponse;
use axum::routing::{get, post};
use scallopd::http::work::Work;
use scallopd::http::{RouteClass, Routes};
use tokio::io::AsyncReadExt;

use crate::app::{TestApp, defaults};
use crate::service::server::{self, read_all, send, until};

/// A route that works until it is cancelled, and records its start and its cancellation.
#[derive(Clone, Default)]
struct Endless {
    has_begun: Arc<AtomicBool>,
    was_cancelled: Arc<AtomicBool>,
}

impl Endless {
    fn routes(&self) -> Routes {
        let endless = self.clone();
        let work = move |work: Work, _body: axum::body::Bytes| endless.work(work);
        Routes::new().undocumented(RouteClass::Batch, "/endless", post(work))
    }

    async fn work(self, work: Work) -> impl IntoResponse {
        let work = work.run(move |cancel| {
            self.has_begun.store(true, Ordering::SeqCst);
            while !cancel.is_cancelled() {
                std::thread::sleep(Duration::from_millis(1));
            }
            self.was_cancelled.store(true, Ordering::SeqCst);
        });
        work.await.map(|()| "cancelled")
    }

    async fn begun(&self) {
        until("the work begins", async || self.has_begun.load(Ordering::SeqCst)).await;
    }

    async fn cancelled(&self) -> Duration {
        let began = Instant::now();
        until("the work is cancelled", async || self.was_cancelled.load(Ordering::SeqCst)).await;
        began.elapsed()
    }
}

fn routes() -> Routes {
    let slow = || async {
        tokio::time::sleep(Duration::from_millis(300)).await;
        "slow"
    };
    Routes::new()
        .undocumented(RouteClass::Single, "/length", post(|body: axum::body::Bytes| async move { body.len().to_string() }))
        .undocumented(RouteClass::Single, "/headers", get(|headers: HeaderMap| async move { headers.len().to_string() }))
        .undocumented(RouteClass::Single, "/slow", get(slow))
        .undocumented(RouteClass::Single, "/never", get(std::future::pending::<()>))
}

async fn answer_to(server: &TestApp, request: &str) -> String {
    let mut stream = server.connect().await;
    send(&mut stream, request).await;
    read_all(&mut stream).await
}

fn assert_problem(answer: &str, status: u16) {
    assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{answer}");
    assert!(answer.contains("content-type: application/problem+json\r\n"), "{answer}");
    assert!(answer.contains("x-request-id: "), "{answer}");
    let body = answer.split_once("\r\n\r\n").unwrap().1;
    let problem: serde_json::Value = serde_json::from_str(body).unwrap();
    assert_eq!(problem["status"], status);
    assert!(answer.contains(problem["request_id"].as_str().unwrap()));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn malformed_heads_are_answered_with_a_problem_and_an_id_and_are_counted() {
    let server = server::start(defaults(), routes()).await;
    let long = "x".repeat(20_000);
    for (status, head) in [
        (400, "no request at all\r\n\r\n".to_owned()),
        (400, "GET /headers HTTP/1.1\r\nhost: test\r\nbad header\r\n\r\n".to_owned()),
        (400, "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_owned()),
        (431, format!("GET /headers HTTP/1.1\r\nhost: test\r\nx: {long}\r\n\r\n")),
        (431, format!("GET /headers HTTP/1.1\r\nhost: test\r\nx: {long}")),
    ] {
        assert_problem(&answer_to(&server, &head).await, status);
        let line = format!("scallopd_http_requests_total{{method=\"unread\",route=\"unread\",status=\"{status}\"}}");
        assert!(server.metrics().await.contains(&line), "{line}");
    }
    // The parser reports a long URI as such, or as a long head.
    let answer = answer_to(&server, &format!("GET /{} HTTP/1.1\r\nhost: test\r\n\r\n", "x".repeat(70_000))).await;
    assert_problem(&answer, if answer.starts_with("HTTP/1.1 414") { 414 } else { 431 });
    let large = format!("GET /headers HTTP/1.1\r\nhost: test\r\nconnection: close\r\nx: {}\r\n\r\n", "x".repeat(15_000));
    assert!(answer_to(&server, &large).await.starts_with("HTTP/1.1 200"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_malformed_head_after_a_request_is_answered_with_a_problem() {
    let server = server::start(defaults(), routes()).await;
    let mut stream = server.connect().await;
    send(&mut stream, "GET /nothing HTTP/1.1\r\nhost: test\r\n\r\n").await;
    let mut first = vec![0; 4096];
    let length = stream.read(&mut first).await.unwrap();
    let first = String::from_utf8_lossy(&first[..length]).into_owned();
    // The service's own answer with status 404 is not replaced.
    assert!(first.starts_with("HTTP/1.1 404") && first.contains("not-found"), "{first}");
    send(&mut stream, "no request at all\r\n\r\n").await;
    assert_problem(&read_all(&mut stream).await, 400);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_request_has_exactly_one_host_header() {
    let server = server::start(defaults(), routes()).await;
    for hosts in ["", "host: a\r\nhost: b\r\n"] {
        assert_problem(&answer_to(&server, &format!("GET /headers HTTP/1.1\r\n{hosts}connection: close\r\n\r\n")).await, 400);
    }
    assert!(answer_to(&server, "GET /headers HTTP/1.0\r\n\r\n").await.starts_with("HTTP/1.0 200"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn work_ends_at_once_after_a_reset_and_after_the_time_out() {
    let endless = Endless::default();
    let mut settings = defaults();
    settings.request_timeout_s = Duration::from_secs(1);
    let server = server::start(settings, endless.routes()).await;
    let request = "POST /endless HTTP/1.1\r\nhost: test\r\ncontent-length: 2\r\n\r\n{}";
    let mut stream = server.connect().await;
    send(&mut stream, request).await;
    endless.begun().await;
    stream.set_zero_linger().unwrap();
    drop(stream);
    // The request time-out would take a second.
    let took = endless.cancelled().await;
    assert!(took < Duration::from_millis(800), "{took:?}");

    endless.was_cancelled.store(false, Ordering::SeqCst);
    let mut stream = server.connect().await;
    send(&mut stream, request).await;
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).await.unwrap();
    assert_eq!(&answer, b"HTTP/1.1 408");
    endless.cancelled().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_connection_beyond_the_limit_waits_until_another_closes() {
    let mut settings = defaults();
    // Four connections.
    settings.max_in_flight = 1;
    let server = server::start(settings, routes()).await;
    let mut open = Vec::new();
    for _ in 0..4 {
        let mut stream = server.connect().await;
        send(&mut stream, "GET /livez HTTP/1.1\r\nhost: test\r\n\r\n").await;
        assert!(stream.read(&mut [0; 4096]).await.unwrap() > 0);
        open.push(stream);
    }
    let mut waiting = server.connect().await;
    send(&mut waiting, "GET /livez HTTP/1.1\r\nhost: test\r\nconnection: close\r\n\r\n").await;
    let early = tokio::time::timeout(Duration::from_millis(300), waiting.readable()).await;
    assert!(early.is_err(), "it was served beside four others");
    drop(open.pop());
    assert!(read_all(&mut waiting).await.starts_with("HTTP/1.1 200"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn bodies_in_chunks_of_one_byte_and_bodies_with_a_byte_order_mark_are_read() {
    let app = TestApp::start().await;
    let body = r#"{"cutter":{"type":"ball_end","diameter_mm":6},"contact":{"slope_deg":40,"feed_angle_deg":30},"step_over_mm":0.5}"#;
    let marked = format!("\u{feff}{body}");
    assert_eq!(app.send("/v1/scallop-height", marked).await.status(), 200);
    let chunks: String = body.chars().flat_map(|byte| ['1', '\r', '\n', byte, '\r', '\n']).collect();
    let head = "POST /v1/scallop-height HTTP/1.1\r\nhost: test\r\nconnection: close\r\ncontent-type: application/json\r\ntransfer-encoding: chunked";
    let answer = answer_to(&app, &format!("{head}\r\n\r\n{chunks}0\r\n\r\n")).await;
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}
