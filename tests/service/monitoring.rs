//! Alert rules and the dashboard use only metrics that the server has.

use std::collections::BTreeSet;
use std::path::Path;

use scallopd::http::Routes;
use scallopd::http::overload::Overload;

use crate::app::defaults;
use crate::service::server;

/// The names of this server's metrics in a text.
fn named(text: &str) -> BTreeSet<&str> {
    text.split(|character: char| !character.is_ascii_alphanumeric() && character != '_')
        .filter(|word| word.starts_with("process_") || (word.starts_with("scallopd_") && word.len() > "scallopd_".len()))
        .collect()
}

#[tokio::test]
async fn rules_and_dashboard_use_existing_metrics() {
    let server = server::start(defaults(), Routes::new()).await;
    server.state.metrics.upload_facets("stl", 2);
    server.state.metrics.shed(Overload::Workers);
    assert_eq!(server.get("/livez").await.status(), 200);
    let page = server.metrics().await;
    let there = named(&page);
    for file in ["deploy/prometheus/alerts.yaml", "deploy/grafana/dashboards/scallopd.json"] {
        let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
        let asked = named(&text);
        assert!(asked.len() >= 4, "{file} asks for nothing: {asked:?}");
        let missing: Vec<_> = asked.difference(&there).collect();
        assert!(missing.is_empty(), "{file} asks for {missing:?}");
    }
}
