//! Metrics of requests, and headers of answers.

use axum::extract::Path;
use axum::response::Html;
use axum::routing::get;
use scallopd::http::{RouteClass, Routes};
use scallopd::settings::CorsOrigins;

use crate::app::defaults;
use crate::service::server;

fn routes() -> Routes {
    Routes::new()
        .undocumented(RouteClass::Single, "/items/{name}", get(|Path(name): Path<String>| async move { name }))
        .undocumented(RouteClass::Single, "/page", get(|| async { Html("<p>") }))
        .undocumented(RouteClass::Single, "/long", get(|| async { "scallop ".repeat(1000) }))
}

#[tokio::test]
async fn requests_are_counted_by_route_not_by_path() {
    let server = server::start(defaults(), routes()).await;
    for path in ["/items/a", "/items/b", "/nothing", "/nothing/else"] {
        server.get(path).await.text().await.unwrap();
    }
    let brew = reqwest::Method::from_bytes(b"BREW").unwrap();
    assert_eq!(server.client.request(brew, server.url("/items/a")).send().await.unwrap().status(), 405);
    let metrics = server.metrics().await;
    for line in [
        "scallopd_http_requests_total{method=\"GET\",route=\"/items/{name}\",status=\"200\"} 2",
        "scallopd_http_requests_total{method=\"GET\",route=\"unmatched\",status=\"404\"} 2",
        "scallopd_http_requests_total{method=\"other\",route=\"/items/{name}\",status=\"405\"} 1",
        "scallopd_http_request_duration_seconds_count{route=\"/items/{name}\",status=\"200\"} 2",
    ] {
        assert!(metrics.contains(line), "{line} is not in\n{metrics}");
    }
    assert!(!metrics.contains("BREW") && !metrics.contains("nothing"), "{metrics}");
}

#[tokio::test]
async fn the_callers_request_id_is_returned_and_a_missing_one_is_created() {
    let server = server::start(defaults(), routes()).await;
    let named = server.client.get(server.url("/nothing")).header("x-request-id", "order-66").send().await.unwrap();
    assert_eq!(named.headers()["x-request-id"], "order-66");
    let first = server.get("/livez").await.headers()["x-request-id"].clone();
    assert_ne!(server.get("/livez").await.headers()["x-request-id"], first);
}

#[tokio::test]
async fn pages_have_a_policy_and_media_types_are_not_guessed() {
    let server = server::start(defaults(), routes()).await;
    let page = server.get("/page").await;
    assert!(page.headers()["content-security-policy"].to_str().unwrap().contains("frame-ancestors 'none'"));
    let text = server.get("/items/a").await;
    assert!(!text.headers().contains_key("content-security-policy"));
    assert_eq!(text.headers()["x-content-type-options"], "nosniff");
}

#[tokio::test]
async fn long_answers_are_compressed_on_request() {
    let server = server::start(defaults(), routes()).await;
    let ask = |codings: &'static str| server.client.get(server.url("/long")).header("accept-encoding", codings).send();
    let asked = ask("gzip, deflate").await.unwrap();
    assert_eq!(asked.headers()["content-encoding"], "gzip");
    assert!(asked.bytes().await.unwrap().len() < 1000);
    let identity = ask("identity").await.unwrap();
    assert!(!identity.headers().contains_key("content-encoding"));
    // Caches must keep both apart.
    assert_eq!(identity.headers()["vary"], "accept-encoding");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn compressed_batches_and_recommendations_are_those_that_are_sent_plain() {
    let server = crate::app::TestApp::start().await;
    let slopes: Vec<_> = (0..20_000).map(|index| f64::from(index % 60) + 5.0).collect();
    let cutter = serde_json::json!({"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2});
    let contacts = serde_json::json!({"slope_deg": slopes, "feed_angle_deg": vec![30; slopes.len()]});
    let batch = serde_json::json!({"cutter": cutter, "step_over_mm": 0.5, "contacts": contacts});
    let points: Vec<_> = (0..400).map(|i| [f64::from(i % 20), f64::from(i / 20), f64::from(i % 20) / 4.0]).collect();
    let recommendation = serde_json::json!({
        "surface": {"points": points}, "cutters": [{"type": "ball_end", "diameter_mm": 6}], "scallop_height_mm": 0.01,
        "machine": {"preset": "five_axis_vmc"}, "include": ["map", "passes"],
    });
    for (path, body) in [("/v1/scallop-height/batch", batch), ("/v1/cutter-recommendation", recommendation)] {
        let plain = server.client.post(server.url(path)).json(&body).send().await.unwrap().bytes().await.unwrap();
        let asked = server.client.post(server.url(path)).header("accept-encoding", "gzip").json(&body).send().await.unwrap();
        assert_eq!((asked.status().as_u16(), asked.headers()["content-encoding"].as_bytes()), (200, &b"gzip"[..]), "{path}");
        assert_eq!(asked.headers().get_all("vary").iter().count(), 1);
        let file = asked.bytes().await.unwrap();
        assert!(2 * file.len() < plain.len(), "{path}: {} of {}", file.len(), plain.len());
        let mut back = Vec::new();
        std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&file[..]), &mut back).unwrap();
        assert!(back == plain, "{path}");
    }
}

#[tokio::test]
async fn only_listed_origins_may_call() {
    let mut settings = defaults();
    settings.cors_origins = CorsOrigins::Listed(vec!["https://panel.example".parse().unwrap()]);
    let server = server::start(settings, routes()).await;
    let ask = |origin: &'static str| server.client.get(server.url("/items/a")).header("origin", origin).send();
    assert_eq!(ask("https://panel.example").await.unwrap().headers()["access-control-allow-origin"], "https://panel.example");
    assert!(!ask("https://other.example").await.unwrap().headers().contains_key("access-control-allow-origin"));
    let preflight = server.client.request(reqwest::Method::OPTIONS, server.url("/items/a"));
    let preflight =
        preflight.header("origin", "https://panel.example").header("access-control-request-method", "POST").send().await.unwrap();
    assert!(preflight.status().is_success());
    assert!(preflight.headers()["access-control-allow-methods"].to_str().unwrap().contains("POST"));
}
