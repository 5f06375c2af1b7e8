//! Set-up of log lines and traces: their destinations and formats, and the metrics of the process. Events are logged by
//! the modules that raise them.

#[cfg(feature = "otlp")]
mod otlp;
#[cfg(target_os = "linux")]
pub(crate) mod process_metrics;

use std::io::{self, BufWriter, IsTerminal, Write};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use http::HeaderMap;
use tracing::level_filters::LevelFilter;
use tracing::{Span, Subscriber};
use tracing_appender::non_blocking::{ErrorCounter, NonBlocking, NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::{Layer, Registry, fmt};

use crate::settings::{LogFormat, Settings};

/// The largest number of lines that wait for the reader of the log. Further ones are dropped and counted, because no
/// answer may wait for that reader.
const MAX_LINES: usize = 8192;

/// How long lines are gathered before they are written: one write has the lines of many requests.
const GATHERING: Duration = Duration::from_millis(10);

/// The longest time that `stop` waits for the reader of the log.
const LAST_WRITE: Duration = Duration::from_secs(2);

/// The counter of dropped lines, once this process has a log.
static DROPPED: OnceLock<ErrorCounter> = OnceLock::new();

/// The number of log lines that were dropped because the reader of the log was too slow.
pub(crate) fn dropped_lines() -> u64 {
    DROPPED.get().map_or(0, |counter| counter.dropped_lines() as u64)
}

/// The log writer and the trace exporter of the running program.
#[must_use = "the last lines and traces are written by `stop`"]
#[derive(Debug)]
pub struct Telemetry {
    writer: WorkerGuard,
    #[cfg(feature = "otlp")]
    traces: Option<otlp::Traces>,
}

impl Telemetry {
    /// Starts logs and traces for the whole process.
    ///
    /// # Errors
    /// The process has telemetry already, or the collector's address is invalid.
    pub fn start(settings: &Settings) -> io::Result<Self> {
        let (lines, writer) =
            NonBlockingBuilder::default().buffered_lines_limit(MAX_LINES).thread_name("log").finish(Gathered::new(io::stdout()));
        // An earlier counter belongs to a subscriber that is set, so that the next call fails.
        let _ = DROPPED.set(lines.error_counter());
        #[cfg(feature = "otlp")]
        let telemetry = {
            let traces = settings.otlp_endpoint.as_ref().map(otlp::Traces::start).transpose()?;
            match &traces {
                None => log_alone(settings, lines)?,
                Some(traces) => {
                    let log = log_layer(settings, lines).with_filter(level_filter(settings.log_level));
                    let layer = traces.layer().with_filter(level_filter(LevelFilter::INFO));
                    tracing::subscriber::set_global_default(Registry::default().with(log).with(layer)).map_err(io::Error::other)?;
                }
            }
            Self { writer, traces }
        };
        #[cfg(not(feature = "otlp"))]
        let telemetry = {
            log_alone(settings, lines)?;
            Self { writer }
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
        // The guard writes the lines when it is dropped, which takes as long as the reader of the log does.
        let writer = std::thread::spawn(move || drop(self.writer));
        let deadline = Instant::now() + LAST_WRITE;
        while !writer.is_finished() && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// A writer that is flushed when no more lines wait, and then waits a moment for further ones.
struct Gathered<W: Write>(BufWriter<W>);

impl<W: Write> Gathered<W> {
    fn new(output: W) -> Self {
        Self(BufWriter::with_capacity(64 * 1024, output))
    }
}

impl<W: Write> Write for Gathered<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()?;
        std::thread::sleep(GATHERING);
        Ok(())
    }
}

/// Starts logs without traces. The filter applies to the whole subscriber, where it is evaluated once for each span or
/// event; a filter of a layer is evaluated several times.
fn log_alone(settings: &Settings, lines: NonBlocking) -> io::Result<()> {
    let subscriber = Registry::default().with(level_filter(settings.log_level)).with(log_layer(settings, lines));
    tracing::subscriber::set_global_default(subscriber).map_err(io::Error::other)
}

/// Writes events as lines in the format of the settings.
fn log_layer<S>(settings: &Settings, lines: NonBlocking) -> Box<dyn Layer<S> + Send + Sync>
where
    S: Subscriber + for<'a> LookupSpan<'a>,
{
    let form = fmt::layer().with_writer(lines);
    match settings.log_format {
        LogFormat::Pretty => form.with_target(false).with_ansi(io::stdout().is_terminal()).boxed(),
        LogFormat::Json => form.json().flatten_event(true).with_span_list(false).boxed(),
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
