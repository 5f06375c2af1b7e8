//! Log lines and traces: where they go and in which form. What is told is said where it happens.

mod json;
mod lines;
#[cfg(feature = "otlp")]
mod otlp;

use std::io::{self, IsTerminal};
use std::thread::JoinHandle;

use axum::http::HeaderMap;
use tracing::Span;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::{Layer, Registry, fmt};

use crate::settings::{LogFormat, TelemetrySettings};

/// The traces' exporter, while the program runs.
#[must_use = "dropped, it would export nothing"]
#[derive(Debug)]
pub struct Telemetry {
    lines: lines::Lines,
    writer: JoinHandle<()>,
    #[cfg(feature = "otlp")]
    traces: Option<otlp::Traces>,
}

impl Telemetry {
    /// Writes logs and sends traces as set, for the whole process. It must be called on a tokio runtime, which the exporter uses.
    ///
    /// # Errors
    /// Where the process has telemetry already, or the collector's address cannot be used.
    pub fn start(settings: &TelemetrySettings) -> io::Result<Self> {
        let filter = || wanted(settings.log_level);
        let lines = lines::Lines::default();
        let writer = lines.write_to(io::stdout())?;
        let form = || fmt::layer().with_writer(lines.clone());
        let log = match settings.log_format {
            LogFormat::Pretty => form().with_target(false).with_ansi(io::stdout().is_terminal()).with_filter(filter()).boxed(),
            LogFormat::Json => form().event_format(json::JsonLine).fmt_fields(json::JsonMembers).with_filter(filter()).boxed(),
        };
        let subscriber = Registry::default().with(log);
        #[cfg(feature = "otlp")]
        let telemetry = {
            let traces = settings.otlp_endpoint.as_ref().map(otlp::Traces::start).transpose()?;
            let layer = traces.as_ref().map(|traces| traces.layer().with_filter(wanted(LevelFilter::INFO)));
            tracing::subscriber::set_global_default(subscriber.with(layer)).map_err(io::Error::other)?;
            Self { lines, writer, traces }
        };
        #[cfg(not(feature = "otlp"))]
        let telemetry = {
            tracing::subscriber::set_global_default(subscriber).map_err(io::Error::other)?;
            Self { lines, writer }
        };
        log_panics();
        Ok(telemetry)
    }

    /// Sends the traces and writes the lines that are still here.
    pub fn stop(self) {
        #[cfg(feature = "otlp")]
        if let Some(traces) = self.traces {
            traces.stop();
        }
        self.lines.stop(&self.writer);
    }
}

/// This program's own lines at `level`, other crates' only from warnings up.
fn wanted(level: LevelFilter) -> Targets {
    Targets::new().with_target(env!("CARGO_CRATE_NAME"), level).with_default(level.min(LevelFilter::WARN))
}

/// A panic is a log line like any other, with the request's id where there is one.
fn log_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let cause = panic.payload_as_str().unwrap_or("of a kind that is no text");
        let place = panic.location().map(ToString::to_string).unwrap_or_default();
        let backtrace = std::backtrace::Backtrace::capture();
        tracing::error!(cause, place, %backtrace, "a panic");
    }));
}

/// Makes the request that `span` stands for part of its caller's trace, where its headers name one (W3C Trace Context).
#[cfg_attr(not(feature = "otlp"), expect(unused_variables, reason = "there are no traces to be part of"))]
pub(crate) fn continue_trace(span: &Span, headers: &HeaderMap) {
    #[cfg(feature = "otlp")]
    otlp::continue_trace(span, headers);
}
