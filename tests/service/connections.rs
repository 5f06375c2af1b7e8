//! Irregular connections: malformed heads, clients that close the connection, idle connections, and connections beyond
//! the limit.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use axum::http::HeaderMap;
use axum::response::IntoResponse;
use axum::routing::{get, post};
use scallopd::http::worker_pool::Work;
use scallopd::http::{RouteClass, Routes};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

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
    let mut settings = defaults();
    settings.server.header_timeout = Duration::from_secs(1);
    let server = server::start(settings, routes()).await;
    let long = "x".repeat(20_000);
    for (status, head) in [
        (400, "no request at all\r\n\r\n".to_owned()),
        (400, "GET /headers HTTP/1.1\r\nhost: test\r\nbad header\r\n\r\n".to_owned()),
        (408, "GET /headers HTTP/1.1\r\nhost".to_owned()),
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
async fn a_client_that_closes_its_sending_side_gets_its_answer() {
    let server = server::start(defaults(), routes()).await;
    for request in ["POST /length HTTP/1.1\r\nhost: test\r\ncontent-length: 4\r\n\r\n1234", "GET /slow HTTP/1.1\r\nhost: test\r\n\r\n"] {
        let mut stream = server.connect().await;
        send(&mut stream, request).await;
        stream.shutdown().await.unwrap();
        let answer = read_all(&mut stream).await;
        assert!(answer.starts_with("HTTP/1.1 200") && (answer.ends_with("\r\n\r\n4") || answer.ends_with("slow")), "{answer:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn work_for_a_client_that_stays_half_closed_ends_after_a_second() {
    let endless = Endless::default();
    let server = server::start(defaults(), endless.routes()).await;
    for extra in ["", "bytes after the request"] {
        let endless = endless.clone();
        let mut stream = server.connect().await;
        send(&mut stream, &format!("POST /endless HTTP/1.1\r\nhost: test\r\ncontent-length: 2\r\n\r\n{{}}{extra}")).await;
        endless.begun().await;
        stream.shutdown().await.unwrap();
        let took = endless.cancelled().await;
        assert!((Duration::from_millis(900)..Duration::from_secs(10)).contains(&took), "{took:?}");
        endless.has_begun.store(false, Ordering::SeqCst);
        endless.was_cancelled.store(false, Ordering::SeqCst);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn work_ends_at_once_after_a_reset_and_after_the_time_out() {
    let endless = Endless::default();
    let mut settings = defaults();
    settings.http.request_timeout = Duration::from_secs(1);
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
async fn work_on_a_part_of_a_body_ends_after_a_reset_although_the_rest_is_unread() {
    let endless = Endless::default();
    // The work begins before the body is read.
    let work = {
        let endless = endless.clone();
        move |work: Work, unread: axum::body::Body| async move {
            let answer = endless.work(work).await;
            drop(unread);
            answer
        }
    };
    let server = server::start(defaults(), Routes::new().undocumented(RouteClass::Batch, "/unread", post(work))).await;
    let mut stream = server.connect().await;
    send(&mut stream, "POST /unread HTTP/1.1\r\nhost: test\r\ncontent-length: 100000\r\n\r\n").await;
    send(&mut stream, &"x".repeat(50_000)).await;
    endless.begun().await;
    stream.set_zero_linger().unwrap();
    drop(stream);
    endless.cancelled().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn connections_may_be_idle_longer_between_requests_than_before_the_first() {
    let mut settings = defaults();
    settings.server.header_timeout = Duration::from_secs(1);
    settings.server.idle_timeout = Duration::from_secs(3);
    let server = server::start(settings, routes()).await;
    let request = "GET /headers HTTP/1.1\r\nhost: test\r\n\r\n";
    // The service measures from the moment at which it accepts a connection, which can be before `connect` returns.
    let began = Instant::now();
    let (mut used, mut unused) = (server.connect().await, server.connect().await);
    let ask = async |stream: &mut TcpStream| {
        send(stream, request).await;
        stream.read(&mut [0; 4096]).await.unwrap()
    };
    assert!(ask(&mut used).await > 0);
    assert_eq!(read_all(&mut unused).await, "");
    assert!((Duration::from_secs(1)..Duration::from_secs(3)).contains(&began.elapsed()), "{:?}", began.elapsed());
    tokio::time::sleep(Duration::from_millis(500)).await;
    assert!(ask(&mut used).await > 0);
    let began = Instant::now();
    assert_eq!(read_all(&mut used).await, "");
    assert!(began.elapsed() > Duration::from_secs(2), "{:?}", began.elapsed());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_connection_beyond_the_limit_closes_the_one_that_is_idle_longest() {
    let mut settings = defaults();
    settings.server.max_connections = 2;
    let server = server::start(settings, routes()).await;
    let mut first = server.connect().await;
    tokio::time::sleep(Duration::from_millis(20)).await;
    let mut second = server.connect().await;
    tokio::time::sleep(Duration::from_millis(20)).await;
    let probe = "GET /livez HTTP/1.1\r\nhost: test\r\nconnection: close\r\n\r\n";
    assert!(answer_to(&server, probe).await.starts_with("HTTP/1.1 200"));
    assert_eq!(read_all(&mut first).await, "");
    send(&mut second, probe).await;
    assert!(read_all(&mut second).await.starts_with("HTTP/1.1 200"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn probes_are_answered_when_every_connection_has_a_request() {
    let mut settings = defaults();
    settings.server.max_connections = 2;
    let server = server::start(settings, routes()).await;
    let mut busy = Vec::new();
    for _ in 0..2 {
        let mut stream = server.connect().await;
        send(&mut stream, "GET /never HTTP/1.1\r\nhost: test\r\n\r\n").await;
        busy.push(stream);
    }
    until("both have a request", async || server.metrics().await.contains("scallopd_http_requests_in_flight 3\n")).await;
    for _ in 0..3 {
        let answer = answer_to(&server, "GET /livez HTTP/1.1\r\nhost: test\r\n\r\n").await;
        assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("connection: close\r\n"), "{answer}");
    }
}
