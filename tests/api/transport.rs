//! HTTP itself, for all operations: syntax, media types, methods, sizes, encodings, request ids.

use std::io::Write;

use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, batch_of, shortest};
use crate::app::{Answer, TestApp, faults};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;

fn every_post() -> impl Iterator<Item = (String, Value)> {
    [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS]
        .into_iter()
        .flat_map(|path| [(path.to_owned(), shortest(path)), (format!("{path}/batch"), batch_of(shortest(path)))])
}

#[tokio::test]
async fn text_that_is_not_json_is_malformed() {
    let app = TestApp::start().await;
    for (path, _) in every_post() {
        for text in [
            "",
            " ",
            "{",
            "{\"cutter\":}",
            "{\"step_over_mm\": nan}",
            "{\"step_over_mm\": NaN",
            "{\"step_over_mm\": 01}",
            "{} {}",
            "{'a': 1}",
        ] {
            let Answer { status, body: problem } = app.post_text(&path, text).await;
            assert_eq!((status, problem["type"].as_str()), (400, Some("malformed-json")), "{text:?}");
            assert_eq!(problem.get("errors"), None);
        }
        let Answer { status, .. } = app.post_text(&path, b"{\"\xff\": 1}".to_vec()).await;
        assert_eq!(status, 400);
    }
}

#[tokio::test]
async fn a_byte_order_mark_before_the_json_is_ignored() {
    let app = TestApp::start().await;
    for (path, body) in every_post() {
        assert_eq!(app.post_text(&path, format!("\u{feff}{body}")).await.status, 200, "{path}");
    }
}

#[tokio::test]
async fn json_that_is_not_an_object_is_refused() {
    let app = TestApp::start().await;
    for (path, body) in every_post() {
        for text in [format!("[{body}]"), "null".into(), "7".into(), "\"x\"".into(), "true".into()] {
            assert_eq!(faults(&app.refusal_of_text(&path, text).await), [("", "wrong-type")]);
        }
    }
}

#[tokio::test]
async fn very_deep_nesting_is_refused_and_the_server_continues() {
    let app = TestApp::start().await;
    for (path, body) in every_post() {
        for open in ["[", "{\"a\":"] {
            let Answer { status, .. } = app.post_text(&path, open.repeat(8_000)).await;
            assert_eq!(status, 400);
        }
        let nested = format!("{{\"cutter\":{}1{}}}", "[".repeat(20_000), "]".repeat(20_000));
        let Answer { status, .. } = app.post_text(&path, nested).await;
        assert!(status == 400 || status == 422, "{status}");
        app.answer(&path, &body).await;
    }
}

#[tokio::test]
async fn other_media_types_than_json_are_refused() {
    let app = TestApp::start().await;
    for (path, body) in every_post() {
        for media_type in [None, Some("text/plain"), Some("application/x-www-form-urlencoded"), Some("application/jsonx")] {
            let request = app.client.post(app.url(&path)).body(body.to_string());
            let request = media_type.into_iter().fold(request, |request, media_type| request.header("content-type", media_type));
            let answer = request.send().await.unwrap();
            assert_eq!(answer.status(), 415, "{media_type:?}");
            assert_eq!(answer.headers()["content-type"], "application/problem+json");
        }
        for media_type in ["application/json; charset=utf-8", "Application/JSON", "application/vnd.cam+json"] {
            let request = app.client.post(app.url(&path)).header("content-type", media_type).body(body.to_string());
            assert_eq!(request.send().await.unwrap().status(), 200, "{media_type}");
        }
    }
}

#[tokio::test]
async fn unknown_paths_are_not_found() {
    let app = TestApp::start().await;
    for path in ["/v1", "/v1/scallop-heights", "/v2/scallop-height", "/v1/scallop-height/", "/v1/max-feed/batch/1"] {
        let Answer { status, body: problem } = app.post_text(path, "{}").await;
        assert_eq!((status, problem["type"].as_str()), (404, Some("not-found")));
    }
}

#[tokio::test]
async fn other_methods_are_refused_with_those_that_are_allowed() {
    let app = TestApp::start().await;
    for (path, _) in every_post() {
        let (method, allowed) =
            if path.ends_with("/batch") { (reqwest::Method::GET, "POST") } else { (reqwest::Method::PUT, "POST,GET,HEAD") };
        let answer = app.client.request(method, app.url(&path)).send().await.unwrap();
        assert_eq!((answer.status().as_u16(), answer.headers()["allow"].to_str().unwrap()), (405, allowed));
        let problem: Value = answer.json().await.unwrap();
        assert_eq!(problem["type"], "method-not-allowed");
    }
    for path in ["/livez", "/readyz", "/metrics", "/openapi.json"] {
        let answer = app.send(path, "{}").await;
        assert_eq!((answer.status().as_u16(), answer.headers()["allow"].to_str().unwrap()), (405, "GET,HEAD"));
    }
}

#[tokio::test]
async fn compressed_bodies_are_read_like_plain_ones() {
    let app = TestApp::start().await;
    for (path, body) in every_post() {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(body.to_string().as_bytes()).unwrap();
        let request = app.client.post(app.url(&path)).header("content-type", "application/json").header("content-encoding", "gzip");
        let answer = request.body(encoder.finish().unwrap()).send().await.unwrap();
        assert_eq!(answer.status(), 200);
        assert_eq!(answer.json::<Value>().await.unwrap(), app.answer(&path, &body).await);
    }
}

#[tokio::test]
async fn a_request_id_is_returned_and_a_missing_one_is_created() {
    let app = TestApp::start().await;
    for (path, body) in every_post() {
        for (text, status) in [(body.to_string(), 200), ("{}".to_owned(), 422), ("{".to_owned(), 400)] {
            let request = app.client.post(app.url(&path)).header("content-type", "application/json").body(text.clone());
            let answer = request.header("x-request-id", "cam-7/42").send().await.unwrap();
            assert_eq!((answer.status().as_u16(), &answer.headers()["x-request-id"]), (status, &"cam-7/42".parse().unwrap()));
            if status != 200 {
                assert_eq!(answer.json::<Value>().await.unwrap()["request_id"], "cam-7/42");
            }
            assert!(!app.send(&path, text).await.headers()["x-request-id"].is_empty());
        }
    }
}

#[tokio::test]
async fn pages_for_people_are_served() {
    let app = TestApp::start().await;
    for path in ["/", "/docs/"] {
        let answer = app.get(path).await;
        assert_eq!(answer.status(), 200, "{path}");
        assert!(answer.headers()["content-type"].to_str().unwrap().starts_with("text/html"));
        let page = answer.text().await.unwrap();
        assert!(page.contains("<html") && !page.contains("src=\"http"), "{path} needs no other server");
    }
}
