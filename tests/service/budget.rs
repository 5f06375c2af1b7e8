//! Refusals of the memory budget.

use std::time::Duration;

use scallopd::budget::Job;
use serde_json::json;

use crate::app::{PATIENCE, TestApp};
use crate::service::server::until;

const BATCH: &str = "/v1/scallop-height/batch";

/// The JSON of a batch of two million bytes.
fn body() -> String {
    let cutter = json!({"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2});
    let batch = json!({"cutter": cutter, "step_over_mm": 0.5, "contacts": [{"slope_deg": 40, "feed_angle_deg": 30}]});
    format!("{batch}{}", " ".repeat(2_000_000))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_body_waits_for_memory_and_is_refused_with_a_retry_if_none_becomes_free() {
    let app = TestApp::start_with(|settings| settings.memory_budget = 64 << 20).await;
    let all = app.state.budget.take(Job::Body { bytes: 1 << 40 }, Duration::ZERO).await.unwrap();
    let refused = app.send(BATCH, body()).await;
    assert_eq!(refused.status(), 503);
    assert_eq!(refused.headers()["retry-after"], "1");
    assert!(app.metrics().await.contains("scallopd_memory_refusals_total 1\n"));
    let waiting = tokio::spawn(app.client.post(app.url(BATCH)).header("content-type", "application/json").body(body()).send());
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert!(!waiting.is_finished());
    // A small request needs no memory of the budget.
    assert_eq!(app.get("/livez").await.status(), 200);
    drop(all);
    assert_eq!(waiting.await.unwrap().unwrap().status(), 200);
    until("its memory is free", async || app.state.budget.held() == 0).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn batches_are_answered_while_recommendations_hold_all_the_memory_they_may() {
    let app = TestApp::start().await;
    let plan = Job::Plan { json: 0, facets: usize::MAX, cutters: 1, threads: 1 };
    let _held = app.state.budget.take(plan, Duration::ZERO).await.unwrap();
    let budget = app.state.budget.clone();
    let waiting = tokio::spawn(async move { budget.take(plan, PATIENCE).await });
    assert_eq!(app.send(BATCH, body()).await.status(), 200);
    waiting.abort();
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
    until("their memory is free", async || app.state.budget.held() == 0).await;
}
