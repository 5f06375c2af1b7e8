//! Load shedding: requests beyond the limits are refused.

use std::sync::Arc;

use axum::routing::{get, post};
use scallopd::http::work::Work;
use scallopd::http::{RouteClass, Routes};
use tokio::sync::Semaphore;

use crate::app::defaults;
use crate::service::server::{self, until};

/// Routes that answer when the test releases them.
fn waiting(release: &Arc<Semaphore>) -> Routes {
    let (single, batch) = (Arc::clone(release), Arc::clone(release));
    let single = move || async move { single.acquire().await.map(|_| "done").unwrap() };
    let handle = tokio::runtime::Handle::current();
    let batch = move |work: Work| async move { work.run(move |_| handle.block_on(batch.acquire()).map(|_| "done").unwrap()).await };
    Routes::new()
        .undocumented(RouteClass::Single, "/single", get(single))
        .undocumented(RouteClass::Batch, "/batch", post(batch))
        .undocumented(RouteClass::Single, "/quick", get(|| async { "quick" }))
}

fn problem_of(body: &str) -> serde_json::Value {
    serde_json::from_str(body).unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn requests_beyond_the_limit_are_shed_while_probes_answer() {
    let release = Arc::new(Semaphore::new(0));
    let mut settings = defaults();
    settings.max_in_flight = 3;
    let server = server::start(settings, waiting(&release)).await;
    let held: Vec<_> = (0..3).map(|_| tokio::spawn(server.client.get(server.url("/single")).send())).collect();
    // The three requests, and the scrape itself.
    until("three in flight", async || server.metrics().await.contains("scallopd_http_requests_in_flight 4\n")).await;

    let shed = server.get("/quick").await;
    assert_eq!(shed.status(), 503);
    assert_eq!(shed.headers()["retry-after"], "1");
    assert_eq!(shed.headers()["content-type"], "application/problem+json");
    assert_eq!(problem_of(&shed.text().await.unwrap())["type"], "overloaded");
    for probe in ["/livez", "/readyz", "/metrics"] {
        assert_eq!(server.get(probe).await.status(), 200, "{probe}");
    }
    assert!(server.metrics().await.contains("scallopd_http_requests_shed_total{reason=\"in_flight\"} 1\n"));

    release.add_permits(3);
    for request in held {
        assert_eq!(request.await.unwrap().unwrap().status(), 200);
    }
    assert_eq!(server.get("/quick").await.status(), 200);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn batches_beyond_their_limit_are_shed_while_single_requests_answer() {
    let release = Arc::new(Semaphore::new(0));
    let mut settings = defaults();
    settings.max_concurrent_work = 2;
    let server = server::start(settings, waiting(&release)).await;
    let batch = || server.client.post(server.url("/batch")).body("{}").send();
    let held: Vec<_> = (0..2).map(|_| tokio::spawn(batch())).collect();
    until("two at work", async || server.metrics().await.contains("scallopd_http_requests_in_flight 3\n")).await;

    let shed = batch().await.unwrap();
    assert_eq!(shed.status(), 503);
    assert_eq!(shed.headers()["retry-after"], "1");
    assert_eq!(server.get("/quick").await.status(), 200);
    assert!(server.metrics().await.contains("scallopd_http_requests_shed_total{reason=\"workers\"} 1\n"));

    release.add_permits(2);
    for request in held {
        assert_eq!(request.await.unwrap().unwrap().status(), 200);
    }
    assert_eq!(batch().await.unwrap().status(), 200);
}

#[tokio::test]
async fn only_routes_of_a_class_with_workers_get_a_permit() {
    let work = |work: Work| async move { work.run(|_| "done").await };
    let routes = Routes::new().undocumented(RouteClass::Probe, "/probe", get(work)).undocumented(RouteClass::Upload, "/upload", get(work));
    let server = server::start(defaults(), routes).await;
    assert_eq!(server.get("/probe").await.status(), 500);
    assert_eq!(server.get("/upload").await.status(), 200);
}
