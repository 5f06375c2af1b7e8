//! Refusals of the memory budget.

use axum::body::Bytes;
use axum::routing::post;
use scallopd::http::{RouteClass, Routes};

use crate::app::{TestApp, defaults};
use crate::service::server::{self, read_all, send, until};
use serde_json::json;

const KIB: u64 = 1024;

async fn start() -> TestApp {
    let length = |body: Bytes| async move {
        tokio::time::sleep(std::time::Duration::from_millis(300)).await;
        body.len().to_string()
    };
    let mut settings = defaults();
    settings.http.memory_budget_bytes = 256 * KIB;
    server::start(settings, Routes::new().undocumented(RouteClass::Batch, "/length", post(length))).await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_body_larger_than_the_budget_is_refused_without_a_retry() {
    let server = start().await;
    let answer = server.client.post(server.url("/length")).body(vec![b'x'; 300 << 10]).send().await.unwrap();
    // The server may find the budget used up before the body exceeds the largest reservation, so both answers are
    // correct.
    assert!([413, 503].contains(&answer.status().as_u16()), "{}", answer.status());
    assert_eq!(answer.headers()["content-type"], "application/problem+json");
    until("its memory is free", async || server.state.budget.reserved() == 0).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_body_without_memory_at_this_moment_is_refused_with_a_retry() {
    let server = start().await;
    let held = server.state.budget.reserve(190 * KIB).unwrap();
    let send = || server.client.post(server.url("/length")).body(vec![b'x'; 100 << 10]).send();
    let answer = send().await.unwrap();
    assert_eq!(answer.status(), 503);
    assert_eq!(answer.headers()["retry-after"], "1");
    assert!(server.metrics().await.contains("scallopd_memory_refusals_total 1\n"));
    drop(held);
    assert_eq!(send().await.unwrap().status(), 200);
    until("its memory is free", async || server.state.budget.reserved() == 0).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_head_in_pieces_is_reserved_until_it_is_complete() {
    let server = start().await;
    let mut stream = server.connect().await;
    send(&mut stream, "GET /livez HTTP/1.1\r\nhost: test\r\nconnection: close\r\n").await;
    for sent in 1..=2 {
        tokio::time::sleep(std::time::Duration::from_millis(50)).await;
        send(&mut stream, &format!("x-{sent}: {}\r\n", "x".repeat(4000))).await;
        until("the head is reserved", async || server.state.budget.reserved() >= 4000 * sent).await;
    }
    assert!(server.state.budget.reserved() < 9000);
    send(&mut stream, "\r\n").await;
    assert!(read_all(&mut stream).await.starts_with("HTTP/1.1 200"));
    until("its memory is free", async || server.state.budget.reserved() == 0).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_head_in_pieces_without_memory_is_refused_with_a_retry() {
    let server = start().await;
    let held: Vec<_> = (0..2).map(|_| server.state.budget.reserve(127 * KIB).unwrap()).collect();
    let mut stream = server.connect().await;
    send(&mut stream, "GET /livez HTTP/1.1\r\nhost: test\r\nconnection: close\r\n").await;
    tokio::time::sleep(std::time::Duration::from_millis(50)).await;
    send(&mut stream, &format!("x: {}\r\n", "x".repeat(4000))).await;
    let answer = read_all(&mut stream).await;
    assert!(answer.starts_with("HTTP/1.1 503") && answer.contains("retry-after: 1\r\n"), "{answer}");
    drop(held);
    until("its memory is free", async || server.state.budget.reserved() == 0).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn dozens_of_small_recommendations_at_once_are_all_answered() {
    let app = TestApp::start().await;
    let points: Vec<_> = (0..121).map(|place| json!([10 * (place % 11), 10 * (place / 11), f64::from(place % 11) / 4.0])).collect();
    let body = json!({
        "surface": {"grid": {"rows": 11, "columns": 11, "points": points}},
        "cutters": [{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}, {"type": "ball_end", "diameter_mm": 10}],
        "scallop_height_mm": 0.01, "machine": {"preset": "vmc"}, "directions_deg": [30],
    });
    let send = || app.client.post(app.url("/v1/cutter-recommendation")).json(&body).send();
    let requests: Vec<_> = (0..64).map(|_| tokio::spawn(send())).collect();
    for request in requests {
        let answer = request.await.unwrap().unwrap();
        assert_eq!(answer.status(), 200, "{}", answer.text().await.unwrap());
    }
    until("their memory is free", async || app.state.budget.reserved() == 0).await;
}
