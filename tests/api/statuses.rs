//! Every status that the document lists for an operation occurs, and errors are problems.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, batch_of, shortest};
use crate::app::{PATIENCE, TestApp, defaults};
use axum::routing::{get, post};
use scallopd::http::{RouteClass, Routes};
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// A request whose body does not arrive.
async fn half_a_request(app: &TestApp, path: &str) -> TcpStream {
    let mut stream = TcpStream::connect(app.address).await.unwrap();
    let head = format!("POST {path} HTTP/1.1\r\nhost: test\r\ncontent-type: application/json\r\ncontent-length: 1000\r\n\r\n{{");
    stream.write_all(head.as_bytes()).await.unwrap();
    stream
}

/// Waits until `count` requests have been admitted. A request before that could take the place of one of them.
async fn until_in_flight(app: &TestApp, count: usize) {
    // The request for the metrics counts, too.
    let line = format!("scallopd_http_requests_in_flight {}\n", count + 1);
    let deadline = tokio::time::Instant::now() + PATIENCE;
    while !app.metrics().await.contains(&line) {
        assert!(tokio::time::Instant::now() < deadline, "{count} requests are not in flight");
    }
}

/// The status of an operation's answer under conditions that must give the status `wanted`.
async fn obtain(wanted: u16, path: &str) -> u16 {
    let single = path.trim_end_matches("/batch");
    let body = if single == path { shortest(single) } else { batch_of(shortest(single)) };
    match wanted {
        200 => TestApp::start().await.post(path, &body).await.status,
        400 => TestApp::start().await.post_text(path, "{").await.status,
        408 => {
            let app = TestApp::start_with(|settings| settings.http.body_idle_timeout = Duration::from_millis(50)).await;
            status_of(half_a_request(&app, path).await).await
        }
        413 => {
            let app = TestApp::start_with(|settings| settings.http.max_json_bytes = 64 * 1024).await;
            app.post_text(path, format!("{body}{}", " ".repeat(64 * 1024))).await.status
        }
        415 => {
            let app = TestApp::start().await;
            app.client.post(app.url(path)).body(body.to_string()).send().await.unwrap().status().as_u16()
        }
        422 => TestApp::start().await.post_text(path, "{}").await.status,
        500 => {
            // No request causes this status, only a panic in a handler, so a handler that panics replaces the
            // operation.
            let failing = post(async || -> &'static str { panic!("a fault, on purpose") });
            let app = TestApp::serve(defaults(), Routes::new().undocumented(RouteClass::Single, path, failing)).await;
            app.send(path, body.to_string()).await.status().as_u16()
        }
        503 => {
            let app = TestApp::start_with(|settings| settings.http.max_in_flight = 1).await;
            let _occupies_the_only_place = half_a_request(&app, path).await;
            until_in_flight(&app, 1).await;
            let answer = app.send(path, body.to_string()).await;
            assert!(answer.headers().contains_key("retry-after"));
            answer.status().as_u16()
        }
        other => panic!("the test cannot obtain {other} from {path}"),
    }
}

async fn status_of(mut stream: TcpStream) -> u16 {
    let mut head = [0; 12];
    tokio::time::timeout(PATIENCE, stream.read_exact(&mut head)).await.expect("an answer comes").unwrap();
    std::str::from_utf8(&head[9..]).unwrap().parse().unwrap()
}

fn document() -> Value {
    serde_json::from_str(&scallopd::http::openapi_json()).unwrap()
}

fn documented(operation: &Value) -> BTreeSet<u16> {
    operation["responses"].as_object().unwrap().keys().map(|status| status.parse().unwrap()).collect()
}

#[tokio::test]
async fn every_documented_status_of_the_calculations_is_obtained() {
    let document = document();
    for single in [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS] {
        for path in [single.to_owned(), format!("{single}/batch")] {
            let statuses = documented(&document["paths"][&path]["post"]);
            assert!(statuses.contains(&200) && statuses.contains(&422), "{path}: {statuses:?}");
            for status in statuses {
                assert_eq!(obtain(status, &path).await, status, "{path}");
            }
        }
    }
}

#[tokio::test]
async fn every_documented_status_of_the_service_operations_is_obtained() {
    let (app, document) = (TestApp::start().await, document());
    let obtained = async |path: &str| app.get(path).await.status().as_u16();
    for path in ["/livez", "/metrics", "/openapi.json"] {
        assert_eq!(documented(&document["paths"][path]["get"]), BTreeSet::from([obtained(path).await]), "{path}");
    }
    let mut readyz = BTreeSet::from([obtained("/readyz").await]);
    app.state.readiness.drain();
    readyz.insert(obtained("/readyz").await);
    assert_eq!(documented(&document["paths"]["/readyz"]["get"]), readyz);
}

/// A query that is answered, and one without an answer.
const QUERY: &str = "cutter=toroidal&diameter_mm=10&corner_radius_mm=2&slope_deg=40&feed_angle_deg=30";

#[tokio::test]
async fn every_documented_status_of_the_queries_is_obtained() {
    let document = document();
    for path in [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS] {
        assert_eq!(documented(&document["paths"][path]["get"]), BTreeSet::from([200, 422, 500, 503]), "{path}");
        let app = TestApp::start_with(|settings| settings.http.max_in_flight = 2).await;
        let parameters = match path {
            SCALLOP_HEIGHT => "step_over_mm=0.687",
            MAX_FEED => "step_over_mm=0.687&scallop_tolerance_mm=0.013",
            _ => "scallop_tolerance_mm=0.013",
        };
        let obtained = async |query: &str| app.get(&format!("{path}?{query}")).await.status().as_u16();
        assert_eq!(obtained(&format!("{QUERY}&{parameters}")).await, 200, "{path}");
        assert_eq!(obtained("").await, 422, "{path}");
        let _occupy_both_places = (half_a_request(&app, path).await, half_a_request(&app, path).await);
        until_in_flight(&app, 2).await;
        assert_eq!(obtained("").await, 503, "{path}");
        let failing = get(async || -> &'static str { panic!("a fault, on purpose") });
        let app = TestApp::serve(defaults(), Routes::new().undocumented(RouteClass::Single, path, failing)).await;
        assert_eq!(app.get(path).await.status(), 500, "{path}");
    }
}
