//! Set-up of log lines and traces: their destinations and formats. Events are logged by the modules that raise them.

mod json;
mod lines;
#[cfg(feature = "otlp")]
mod otlp;

use std::io::{self, IsTerminal};
use std::thread::JoinHandle;

use http::HeaderMap;
use tracing::Span;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::{Layer, Registry, fmt};

use crate::settings::{LogFormat, TelemetrySettings};

/// The log writer and the trace exporter of the running program.
#[must_use = "the last lines and traces are written by `stop`"]
#[derive(Debug)]
pub struct Telemetry {
    lines: lines::Lines,
    writer: JoinHandle<()>,
    #[cfg(feature = "otlp")]
    traces: Option<otlp::Traces>,
}

impl Telemetry {
    /// Starts logs and traces for the whole process. It must be called on a tokio runtime, which the exporter uses.
    ///
    /// # Errors
    /// The process has telemetry already, or the collector's address is invalid.
    pub fn start(settings: &TelemetrySettings) -> io::Result<Self> {
        let filter = || level_filter(settings.log_level);
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
            let layer = traces.as_ref().map(|traces| traces.layer().with_filter(level_filter(LevelFilter::INFO)));
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

    /// Sends the remaining traces and writes the remaining lines.
    pub fn stop(self) {
        #[cfg(feature = "otlp")]
        if let Some(traces) = self.traces {
            traces.stop();
        }
        self.lines.stop(&self.writer);
    }
}

/// Events of this program from `level` up, of other crates from warnings up.
fn level_filter(level: LevelFilter) -> Targets {
    Targets::new().with_target(env!("CARGO_CRATE_NAME"), level).with_default(level.min(LevelFilter::WARN))
}

/// Logs panics as events, with the request's id where there is one.
fn log_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let cause = panic.payload_as_str().unwrap_or("a payload that is not text");
        let location = panic.location().map(ToString::to_string).unwrap_or_default();
        let backtrace = std::backtrace::Backtrace::capture();
        tracing::error!(cause, location, %backtrace, "panic");
    }));
}

/// Makes the request's `span` part of its caller's trace, where the headers name one (W3C Trace Context).
#[cfg_attr(not(feature = "otlp"), expect(unused_variables, reason = "without the feature there are no traces"))]
pub(crate) fn continue_trace(span: &Span, headers: &HeaderMap) {
    #[cfg(feature = "otlp")]
    otlp::continue_trace(span, headers);
}
