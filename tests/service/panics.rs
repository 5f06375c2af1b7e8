//! Panics in handlers.

use axum::routing::get;
use scallopd::http::overload::Overload;
use scallopd::http::work::Work;
use scallopd::http::{RouteClass, Routes};

use crate::app::defaults;
use crate::service::server;

async fn fail() -> &'static str {
    panic!("on purpose: a secret of the server")
}

async fn fail_on_a_worker(work: Work) -> Result<&'static str, Overload> {
    work.run(|_| panic!("on purpose: a secret of the server")).await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_panic_gives_status_500_without_detail_and_the_server_continues() {
    let routes = Routes::new().undocumented(RouteClass::Single, "/fail", get(fail)).undocumented(
        RouteClass::Batch,
        "/fail/batch",
        get(fail_on_a_worker),
    );
    let mut settings = defaults();
    settings.max_in_flight = 1;
    settings.max_concurrent_work = 1;
    let server = server::start(settings, routes).await;
    for _ in 0..5 {
        for path in ["/fail", "/fail/batch"] {
            let answer = server.get(path).await;
            assert_eq!(answer.status(), 500);
            assert_eq!(answer.headers()["content-type"], "application/problem+json");
            assert!(answer.headers().contains_key("x-request-id"));
            let body = answer.text().await.unwrap();
            assert!(!body.contains("secret"), "{body}");
        }
    }
    assert_eq!(server.get("/livez").await.status(), 200);
}
