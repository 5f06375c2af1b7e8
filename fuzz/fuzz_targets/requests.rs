//! JSON requests to every operation that takes one: whatever is sent, the answer is JSON and the fault is not the server's.

#![no_main]

use std::sync::LazyLock;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, header};
use scallopd::http::{AppState, layers, router};
use scallopd::settings::{Command, HttpSettings};
use tokio::runtime::Runtime;
use tower::ServiceExt;

const PATHS: [&str; 8] = [
    "/v1/scallop-height",
    "/v1/max-feed",
    "/v1/step-over",
    "/v1/scallop-height/batch",
    "/v1/max-feed/batch",
    "/v1/step-over/batch",
    "/v1/critical-slope",
    "/v1/cutter-recommendation",
];

fn defaults() -> HttpSettings {
    match Command::read(["scallopd"]) {
        Ok(Command::Serve(settings)) => settings.http,
        _ => panic!("the defaults cannot be used"),
    }
}

static SERVICE: LazyLock<(Runtime, Router)> = LazyLock::new(|| {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let settings = defaults();
    let state = AppState::start(&settings).expect("threads");
    (runtime, layers::apply(router(&state), &settings, &state))
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((first, body)) = bytes.split_first() else { return };
    let path = PATHS[usize::from(*first) % PATHS.len()];
    let (runtime, service) = &*SERVICE;
    runtime.block_on(async {
        let request = Request::post(path).header(header::CONTENT_TYPE, "application/json").body(Body::from(body.to_vec())).expect("a request");
        let response = service.clone().oneshot(request).await.unwrap_or_else(|never| match never {});
        let status = response.status();
        assert!(status.is_success() || status.is_client_error(), "{path} answers {status}");
        let answer = to_bytes(response.into_body(), usize::MAX).await.expect("an answer");
        assert!(serde_json::from_slice::<serde_json::Value>(&answer).is_ok(), "{path} answers no JSON");
    });
});
