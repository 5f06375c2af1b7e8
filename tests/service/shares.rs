//! Long requests together with others: permits, their order, and answers that clients do not read.

use serde_json::{Value, json};
use tokio::io::AsyncReadExt;

use crate::app::TestApp;
use crate::service::server::{send, until};

const BATCH: &str = "/v1/scallop-height/batch";

fn batch(contacts: usize, model: &str) -> Value {
    let contact = |index: usize| json!({"slope_deg": 5 + index % 60, "feed_angle_deg": index % 180});
    let contacts: Vec<Value> = (0..contacts).map(contact).collect();
    json!({"cutter": {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}, "step_over_mm": 0.5, "model": model, "contacts": contacts})
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn bodies_that_are_awaited_take_no_place_of_those_that_are_there() {
    let server = TestApp::start_with(|settings| settings.max_concurrent_work = 1).await;
    let mut waiting = Vec::new();
    for index in 0..32 {
        let mut stream = server.connect().await;
        // Half of the clients have started to send.
        let begun = if index % 2 == 0 { "" } else { "{\"cutter\": " };
        send(
            &mut stream,
            &format!("POST {BATCH} HTTP/1.1\r\nhost: test\r\ncontent-type: application/json\r\ncontent-length: 1000\r\n\r\n{begun}"),
        )
        .await;
        waiting.push(stream);
    }
    until("all have begun", async || server.metrics().await.contains("scallopd_http_requests_in_flight 33\n")).await;
    for _ in 0..3 {
        assert_eq!(server.answer(BATCH, &batch(10, "analytic")).await["summary"]["count"], 10);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_short_batch_is_answered_before_the_long_ones_that_came_first() {
    let server = TestApp::start().await;
    let long = batch(60_000, "envelope").to_string();
    let long_ones: Vec<_> = (0..2)
        .map(|_| tokio::spawn(server.client.post(server.url(BATCH)).header("content-type", "application/json").body(long.clone()).send()))
        .collect();
    // The two requests and the scrape itself.
    until("both have begun", async || server.metrics().await.contains("scallopd_http_requests_in_flight 3\n")).await;
    let short = batch(20, "envelope");
    assert_eq!(server.answer(BATCH, &short).await["summary"]["count"], 20);
    assert!(long_ones.iter().all(|request| !request.is_finished()), "the long batches are too short for this test");
    for request in long_ones {
        assert_eq!(request.await.unwrap().unwrap().status(), 200);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_answer_that_is_not_read_draws_on_the_memory_budget_until_its_client_is_gone() {
    let server = TestApp::start().await;
    let body = batch(100_000, "analytic").to_string();
    let mut stream = server.connect().await;
    let head = format!("POST {BATCH} HTTP/1.1\r\nhost: test\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\r\n", body.len());
    send(&mut stream, &head).await;
    send(&mut stream, &body).await;
    let mut first = [0; 12];
    stream.read_exact(&mut first).await.unwrap();
    assert_eq!(&first, b"HTTP/1.1 200");
    // The part of the answer that the client has not read, except some MB in the system's buffers.
    assert!(server.state.budget.held() > 1 << 20, "{}", server.state.budget.held());
    drop(stream);
    until("its memory is free", async || server.state.budget.held() == 0).await;
}
