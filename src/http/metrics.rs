//! The metrics, and their text for Prometheus. Every label has few values: routes are templates, and methods and
//! reasons are closed sets.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, EncodeLabelSet, EncodeMetric, text};
use prometheus_client::metrics::MetricType;
use prometheus_client::metrics::counter::{ConstCounter, Counter};
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::{ConstGauge, Gauge};
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::{Registry, Unit};

use super::overload::Overload;
use crate::budget::Budget;
use crate::telemetry;

/// Upper bounds of the histogram's buckets, in s: from a single calculation to the request time-out.
/// Each route and status has a series for each, so that they are few.
const DURATIONS: [f64; 11] = [0.000_1, 0.000_5, 0.001, 0.002_5, 0.01, 0.05, 0.1, 0.5, 2.5, 10.0, 60.0];

/// The label of requests that no route matches, so that arbitrary paths create no new series.
pub(crate) const UNMATCHED: &str = "unmatched";

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct RequestLabels {
    method: &'static str,
    route: Arc<str>,
    status: u16,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct DurationLabels {
    route: Arc<str>,
    status: u16,
}

/// One label: its name and its value.
type Label = [(&'static str, &'static str); 1];

type Durations = Family<DurationLabels, Histogram, fn() -> Histogram>;

/// The counters, behind one handle because each request clones it several times. Clones share the counters.
#[derive(Debug, Clone)]
pub struct Metrics(Arc<Counters>);

#[derive(Debug)]
struct Counters {
    registry: Registry,
    requests: Family<RequestLabels, Counter>,
    durations: Durations,
    in_flight: Gauge,
    shed: Family<Label, Counter>,
    upload_bytes: Counter,
    upload_facets: Family<Label, Counter>,
}

impl Metrics {
    /// Counters at zero, and the state of `budget`.
    #[must_use]
    pub fn new(budget: &Budget) -> Self {
        let requests = Family::default();
        let durations = Durations::new_with_constructor(|| Histogram::new(DURATIONS));
        let in_flight = Gauge::default();
        let shed = Family::<Label, Counter>::default();
        for overload in Overload::ALL {
            // The series are created at the start, so that their first increase is visible.
            drop(shed.get_or_create(&[("reason", overload.label())]));
        }
        let upload_bytes = Counter::default();
        let upload_facets = Family::default();
        let mut registry = Registry::default();
        registry.register("scallopd_http_requests", "Requests answered", requests.clone());
        registry.register("scallopd_http_request_duration_seconds", "From a request's head to the end of its answer", durations.clone());
        registry.register("scallopd_http_requests_in_flight", "Requests being answered", in_flight.clone());
        registry.register("scallopd_http_requests_shed", "Requests refused under load", shed.clone());
        registry.register("scallopd_upload_bytes", "Bytes of uploads, decompressed", upload_bytes.clone());
        registry.register("scallopd_upload_facets", "Facets and points read from uploads", upload_facets.clone());
        let version = option_env!("CARGO_PKG_VERSION").unwrap_or("unknown");
        let revision = option_env!("SCALLOPD_REVISION").filter(|revision| !revision.is_empty()).unwrap_or("unknown");
        registry.register(
            "scallopd_build",
            "Version and revision of the program",
            Info::new([("version", version), ("revision", revision)]),
        );
        registry.register_collector(Box::new(BudgetMetrics(budget.clone())));
        registry.register_collector(Box::new(LogMetrics));
        #[cfg(target_os = "linux")]
        registry.register_collector(Box::new(crate::telemetry::process_metrics::ProcessMetrics));
        Self(Arc::new(Counters { registry, requests, durations, in_flight, shed, upload_bytes, upload_facets }))
    }

    /// Counts a request in flight.
    pub(crate) fn began(&self) {
        self.0.in_flight.inc();
    }

    /// Counts a request that was answered, or whose client closed the connection.
    pub(crate) fn ended(&self, method: &'static str, route: &Arc<str>, status: u16, duration: Duration) {
        self.0.in_flight.dec();
        self.0.requests.get_or_create(&RequestLabels { method, route: Arc::clone(route), status }).inc();
        self.0.durations.get_or_create(&DurationLabels { route: Arc::clone(route), status }).observe(duration.as_secs_f64());
    }

    /// Counts a request that was refused under load.
    pub fn shed(&self, overload: Overload) {
        self.0.shed.get_or_create(&[("reason", overload.label())]).inc();
    }

    /// Counts bytes of an upload, decompressed.
    pub fn upload_bytes(&self, bytes: u64) {
        self.0.upload_bytes.inc_by(bytes);
    }

    /// Counts the facets of an upload in this format, or its points if the format has no facets.
    pub fn upload_facets(&self, format: &'static str, facets: u64) {
        self.0.upload_facets.get_or_create(&[("format", format)]).inc_by(facets);
    }

    /// The counters as OpenMetrics text.
    fn text(&self) -> Result<String, std::fmt::Error> {
        let mut page = String::new();
        text::encode(&mut page, &self.0.registry)?;
        Ok(page)
    }
}

/// The state of the memory budget at each scrape.
#[derive(Debug)]
struct BudgetMetrics(Budget);

impl Collector for BudgetMetrics {
    fn encode(&self, mut encoder: DescriptorEncoder) -> Result<(), std::fmt::Error> {
        let reserved =
            encoder.encode_descriptor("scallopd_memory_held", "Memory held by requests", Some(&Unit::Bytes), MetricType::Gauge)?;
        ConstGauge::new(self.0.held()).encode(reserved)?;
        let refusals =
            encoder.encode_descriptor("scallopd_memory_refusals", "Requests refused for lack of memory", None, MetricType::Counter)?;
        ConstCounter::new(self.0.refusals()).encode(refusals)
    }
}

/// The state of the log at each scrape.
#[derive(Debug)]
struct LogMetrics;

impl Collector for LogMetrics {
    fn encode(&self, mut encoder: DescriptorEncoder) -> Result<(), std::fmt::Error> {
        let help = "Log lines dropped because their reader was too slow";
        let dropped = encoder.encode_descriptor("scallopd_log_lines_dropped", help, None, MetricType::Counter)?;
        ConstCounter::new(telemetry::dropped_lines()).encode(dropped)
    }
}

/// OpenMetrics text in the format 0.0.4, in which the names of counters end in `_total` in comments, too, and
/// informations are gauges.
fn in_older_format(page: &str) -> String {
    let mut older = String::with_capacity(page.len());
    let mut help = "";
    for line in page.lines().filter(|line| !line.starts_with("# UNIT") && *line != "# EOF") {
        let words: Vec<&str> = line.splitn(4, ' ').collect();
        match words[..] {
            ["#", "HELP", _, text] => help = text,
            ["#", "TYPE", name, kind] => {
                let (suffix, kind) = match kind {
                    "counter" => ("_total", kind),
                    "info" => ("_info", "gauge"),
                    _ => ("", kind),
                };
                older.extend(["# HELP ", name, suffix, " ", help, "\n# TYPE ", name, suffix, " ", kind, "\n"]);
            }
            _ => {
                older += line;
                older.push('\n');
            }
        }
    }
    older
}

/// The label of a method; unknown methods create no new series.
pub(crate) fn method_label(method: &Method) -> &'static str {
    static KNOWN: [Method; 7] = [Method::GET, Method::POST, Method::HEAD, Method::OPTIONS, Method::PUT, Method::DELETE, Method::PATCH];
    KNOWN.iter().find(|known| *known == method).map_or("other", Method::as_str)
}

/// The metrics
///
/// The server's metrics as OpenMetrics text for Prometheus.
#[utoipa::path(
    get, path = "/metrics", tag = "service", operation_id = "metrics",
    responses((status = 200, description = "The metrics", body = String, content_type = "application/openmetrics-text", example = json!("scallopd_http_requests_in_flight 0\n# EOF\n"))),
)]
pub async fn show(State(metrics): State<Metrics>, headers: HeaderMap) -> Response {
    let accept = headers.get(header::ACCEPT).and_then(|accept| accept.to_str().ok()).unwrap_or_default();
    let is_older = accept.contains("text/plain") && !accept.contains("application/openmetrics-text");
    match metrics.text() {
        Ok(page) if is_older => {
            ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], in_older_format(&page)).into_response()
        }
        Ok(page) => ([(header::CONTENT_TYPE, "application/openmetrics-text; version=1.0.0; charset=utf-8")], page).into_response(),
        Err(error) => {
            tracing::error!(%error, "the metrics cannot be encoded");
            StatusCode::INTERNAL_SERVER_ERROR.into_response()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_contains_the_counts() {
        let metrics = Metrics::new(&Budget::new(1000));
        let route: Arc<str> = Arc::from("/v1/max-feed");
        metrics.began();
        metrics.ended("POST", &route, 200, Duration::from_millis(2));
        metrics.began();
        metrics.shed(Overload::Workers);
        metrics.upload_bytes(84);
        metrics.upload_facets("stl", 2);
        let page = metrics.text().unwrap();
        for line in [
            "scallopd_http_requests_total{method=\"POST\",route=\"/v1/max-feed\",status=\"200\"} 1",
            "scallopd_http_request_duration_seconds_bucket{le=\"0.0025\",route=\"/v1/max-feed\",status=\"200\"} 1",
            "scallopd_http_request_duration_seconds_bucket{le=\"0.001\",route=\"/v1/max-feed\",status=\"200\"} 0",
            "scallopd_http_requests_in_flight 1",
            "scallopd_http_requests_shed_total{reason=\"workers\"} 1",
            "scallopd_http_requests_shed_total{reason=\"in_flight\"} 0",
            "scallopd_memory_held_bytes 0",
            "scallopd_upload_bytes_total 84",
            "scallopd_upload_facets_total{format=\"stl\"} 2",
            concat!("scallopd_build_info{version=\"", env!("CARGO_PKG_VERSION"), "\""),
        ] {
            assert!(page.contains(line), "{line} is not in\n{page}");
        }
        assert!(page.ends_with("# EOF\n"));
        let older = in_older_format(&page);
        for line in [
            "# TYPE scallopd_http_requests_total counter\n",
            "# TYPE scallopd_build_info gauge\n",
            "# TYPE scallopd_http_requests_in_flight gauge\n",
            "scallopd_http_requests_in_flight 1\n",
        ] {
            assert!(older.contains(line), "{line} is not in\n{older}");
        }
        assert!(!older.contains("# UNIT") && !older.contains("# EOF"));
        let samples = |page: &str| page.lines().filter(|line| !line.starts_with('#')).count();
        assert_eq!(samples(&older), samples(&page));
    }

    #[test]
    fn unknown_methods_share_a_label() {
        for invented in ["BREW", "get", "PROPFIND"] {
            assert_eq!(method_label(&invented.parse().unwrap()), "other");
        }
    }
}
