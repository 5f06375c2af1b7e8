//! The service in this process, and checks of every answer: it is JSON, its status is not 500, and the memory budget is
//! kept.

#[path = "memory.rs"]
mod memory;

use std::sync::LazyLock;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, header};
use scallopd::http::{self, AppState};
use scallopd::settings::{Command, Settings};
use tokio::runtime::Runtime;
use tower::ServiceExt;

fn defaults() -> Settings {
    match Command::read(["scallopd"]) {
        Ok(Command::Serve(settings)) => *settings,
        _ => panic!("the defaults cannot be used"),
    }
}

/// The runtime, the service, and the most bytes that a request may take: twice the memory budget.
static SERVICE: LazyLock<(Runtime, Router, usize)> = LazyLock::new(|| {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    // Requests that take long, such as a million facets, end well before the fuzzer's own time-out.
    let settings = Settings { request_timeout_s: Duration::from_secs(5), ..defaults() };
    let state = AppState::start(&settings).expect("threads");
    let most = usize::try_from(2 * settings.memory_budget).expect("bytes");
    (runtime, http::service(http::routes(), &settings, &state), most)
});

/// Posts a body and checks the answer.
pub fn post(path: &str, media_type: &str, body: &[u8]) {
    let (runtime, service, most) = &*SERVICE;
    memory::bounded(*most, || {
        runtime.block_on(async {
            let request = Request::post(path).header(header::HOST, "fuzz").header(header::CONTENT_TYPE, media_type);
            let request = request.body(Body::from(body.to_vec())).expect("a request");
            let response = service.clone().oneshot(request).await.unwrap_or_else(|never| match never {});
            let status = response.status();
            assert!(status.is_success() || status.is_client_error(), "{path} answers {status}");
            let answer = to_bytes(response.into_body(), usize::MAX).await.expect("an answer");
            assert!(serde_json::from_slice::<serde_json::Value>(&answer).is_ok(), "{path} answers no JSON");
        });
    });
}
