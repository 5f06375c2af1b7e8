//! Set-up of log lines and traces: their destinations and formats, and the metrics of the process. Events are logged by
//! the modules that raise them.

mod json;
mod lines;
#[cfg(feature = "otlp")]
mod otlp;
#[cfg(target_os = "linux")]
pub(crate) mod process_metrics;

use std::io::{self, IsTerminal};
use std::thread::JoinHandle;

use http::HeaderMap;
use tracing::level_filters::LevelFilter;
use tracing::{Span, Subscriber};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::LookupSpan;
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
    /// Starts logs and traces for the whole process. Must be called on a tokio runtime, which the exporter uses.
    ///
    /// # Errors
    /// The process has telemetry already, or the collector's address is invalid.
    pub fn start(settings: &TelemetrySettings) -> io::Result<Self> {
        let lines = lines::Lines::default();
        let writer = lines.write_to(io::stdout())?;
        #[cfg(feature = "otlp")]
        let telemetry = {
            let traces = settings.otlp_endpoint.as_ref().map(otlp::Traces::start).transpose()?;
            match &traces {
                None => log_alone(settings, &lines)?,
                Some(traces) => {
                    let log = log_layer(settings, &lines).with_filter(level_filter(settings.log_level));
                    let layer = traces.layer().with_filter(level_filter(LevelFilter::INFO));
                    tracing::subscriber::set_global_default(Registry::default().with(log).with(layer)).map_err(io::Error::other)?;
                }
            }
            Self { lines, writer, traces }
        };
        #[cfg(not(feature = "otlp"))]
        let telemetry = {
            log_alone(settings, &lines)?;
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

/// Starts logs without traces. The filter applies to the whole subscriber, where it is evaluated once for each span or
/// event; a filter of a layer is evaluated several times.
fn log_alone(settings: &TelemetrySettings, lines: &lines::Lines) -> io::Result<()> {
    let subscriber = Registry::default().with(level_filter(settings.log_level)).with(log_layer(settings, lines));
    tracing::subscriber::set_global_default(subscriber).map_err(io::Error::other)
}

/// Writes events as lines in the format of the settings.
fn log_layer<S>(settings: &TelemetrySettings, lines: &lines::Lines) -> Box<dyn Layer<S> + Send + Sync>
where
    S: Subscriber + for<'a> LookupSpan<'a>,
{
    let form = || fmt::layer().with_writer(lines.clone());
    match settings.log_format {
        LogFormat::Pretty => form().with_target(false).with_ansi(io::stdout().is_terminal()).boxed(),
        LogFormat::Json => form().event_format(json::JsonLine).fmt_fields(json::JsonMembers).boxed(),
    }
}

/// Events of this program from `level` up, of other crates from warnings up.
fn level_filter(level: LevelFilter) -> Targets {
    Targets::new().with_target(env!("CARGO_CRATE_NAME"), level).with_default(level.min(LevelFilter::WARN))
}

/// Logs panics as events, with the request's id if there is one.
fn log_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let cause = panic.payload_as_str().unwrap_or("a payload that is not text");
        let location = panic.location().map(ToString::to_string).unwrap_or_default();
        let backtrace = std::backtrace::Backtrace::capture();
        tracing::error!(cause, location, %backtrace, "panic");
    }));
}

/// Adds the request's `span` to its caller's trace, if the headers name one (W3C Trace Context).
#[cfg_attr(not(feature = "otlp"), expect(unused_variables, reason = "without the feature there are no traces"))]
pub(crate) fn continue_trace(span: &Span, headers: &HeaderMap) {
    #[cfg(feature = "otlp")]
    otlp::continue_trace(span, headers);
}
