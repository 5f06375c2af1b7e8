//! Every status that the document lists for an operation occurs, and errors are problems.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::api::openapi::{FORM, Operation, document, operation, operations};
use crate::app::{PATIENCE, TestApp, defaults};
use axum::routing::any;
use reqwest::Response;
use scallopd::http::{RouteClass, Routes};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// The media type of an operation's bodies, with a boundary if they are forms.
fn content_type(operation: Operation<'_>) -> String {
    let media_type = operation.media_type().unwrap();
    if media_type == FORM { format!("{FORM}; boundary=edge") } else { media_type.to_owned() }
}

/// A request whose body does not arrive.
async fn half_a_request(app: &TestApp, path: &str, content_type: &str) -> TcpStream {
    let mut stream = app.connect().await;
    let head = format!("POST {path} HTTP/1.1\r\nhost: test\r\ncontent-type: {content_type}\r\ncontent-length: 1000\r\n\r\n{{");
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

/// The answer to an operation's example request.
async fn answer_to_example(operation: Operation<'_>, app: &TestApp) -> Response {
    operation.request(app, &operation.example()).send().await.unwrap()
}

/// The answer to `body` with the operation's media type.
async fn answer_to(operation: Operation<'_>, app: &TestApp, body: impl Into<reqwest::Body>) -> Response {
    let post = app.client.post(app.url(operation.path)).header("content-type", content_type(operation));
    post.body(body).send().await.unwrap()
}

/// The status of an operation's answer under conditions that must give the status `wanted`.
async fn obtain(wanted: u16, operation: Operation<'_>) -> u16 {
    let path = operation.path;
    let answer = match wanted {
        200 => answer_to_example(operation, &TestApp::start().await).await,
        400 => answer_to(operation, &TestApp::start().await, "{").await,
        408 => {
            let app = TestApp::start_with(|settings| settings.client_timeout_s = Duration::from_millis(50)).await;
            return status_of(half_a_request(&app, path, &content_type(operation)).await).await;
        }
        413 => {
            let app = TestApp::start_with(|settings| {
                settings.max_json = 64 * 1024;
                settings.max_upload = 64 * 1024;
            })
            .await;
            answer_to(operation, &app, " ".repeat(64 * 1024 + 1)).await
        }
        415 => {
            let app = TestApp::start().await;
            app.client.post(app.url(path)).body("{}").send().await.unwrap()
        }
        422 => {
            let nothing = match operation.media_type() {
                None => "".into(),
                Some(FORM) => json!({"surface": "0,0,0", "parameters": {}}),
                Some(_) => json!({}),
            };
            operation.request(&TestApp::start().await, &nothing).send().await.unwrap()
        }
        500 => {
            // No request causes this status, only a panic in a handler, so a handler that panics replaces the
            // operation.
            let failing = any(async || -> &'static str { panic!("a fault, on purpose") });
            let app = TestApp::serve(defaults(), Routes::new().undocumented(RouteClass::Single, path, failing)).await;
            answer_to_example(operation, &app).await
        }
        503 => {
            let app = TestApp::start_with(|settings| settings.max_in_flight = 1).await;
            let _occupies_the_only_place = half_a_request(&app, "/v1/scallop-height", "application/json").await;
            until_in_flight(&app, 1).await;
            let answer = answer_to_example(operation, &app).await;
            assert!(answer.headers().contains_key("retry-after"));
            answer
        }
        other => panic!("the test cannot obtain {other} from {path}"),
    };
    let media_type = if wanted == 200 { "application/json" } else { "application/problem+json" };
    assert_eq!(answer.headers()["content-type"], media_type, "{path} {wanted}");
    answer.status().as_u16()
}

async fn status_of(mut stream: TcpStream) -> u16 {
    let mut head = [0; 12];
    tokio::time::timeout(PATIENCE, stream.read_exact(&mut head)).await.expect("an answer comes").unwrap();
    std::str::from_utf8(&head[9..]).unwrap().parse().unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_documented_status_of_every_operation_is_obtained() {
    let document = document();
    for operation in operations(&document) {
        assert!(operation.statuses().contains(&200), "{}", operation.id());
        for status in operation.statuses() {
            assert_eq!(obtain(status, operation).await, status, "{}", operation.id());
        }
    }
}

#[tokio::test]
async fn every_documented_status_of_the_service_operations_is_obtained() {
    let (app, document) = (TestApp::start().await, document());
    let documented = |path: &str| operation(&document, "get", path).statuses();
    let obtained = async |path: &str| app.get(path).await.status().as_u16();
    for path in ["/livez", "/metrics", "/openapi.json", "/openapi-3.0.json"] {
        assert_eq!(documented(path), BTreeSet::from([obtained(path).await]), "{path}");
    }
    let mut readyz = BTreeSet::from([obtained("/readyz").await]);
    app.state.readiness.drain();
    readyz.insert(obtained("/readyz").await);
    assert_eq!(documented("/readyz"), readyz);
}
