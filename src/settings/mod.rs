//! The settings: one structure, each field with a flag, a `SCALLOPD_*` variable, a default and a line of help
//! (`command_line`). All values are checked together, so that the program reports every fault at its start.

mod command_line;
mod fault;

use std::net::SocketAddr;
use std::time::Duration;

pub use command_line::{Command, CommandLineError, OpenApiVersion};
pub use fault::{Fault, Faults, Reason};
use fault::{address, collector, count, level, log_format, optional_address, origins, seconds, take};

/// All settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The address to listen on.
    pub listen: SocketAddr,
    /// The address to listen on for probes and scrapes, on a separate thread; `/metrics` is then served there only.
    pub health_listen: Option<SocketAddr>,
    /// The settings of logs and traces.
    pub telemetry: TelemetrySettings,
    /// The settings of connections.
    pub server: ServerSettings,
    /// The settings of requests.
    pub http: HttpSettings,
}

/// The settings of logs and traces.
#[derive(Debug, Clone, PartialEq)]
pub struct TelemetrySettings {
    /// The form of a log line.
    pub log_format: LogFormat,
    /// The least severe line that is written.
    pub log_level: tracing::level_filters::LevelFilter,
    /// The collector's base address for OTLP over HTTP; no traces without one.
    pub otlp_endpoint: Option<http::Uri>,
}

/// The form of a log line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogFormat {
    /// For people at a terminal.
    Pretty,
    /// One JSON object on each line, for a log collector.
    Json,
}

/// The settings of connections.
#[derive(Debug, Clone, PartialEq)]
pub struct ServerSettings {
    /// The longest time from the first to the last byte of a request's head, and from a new connection to its first
    /// head.
    pub header_timeout: Duration,
    /// The longest time for which a connection may be idle between requests.
    pub idle_timeout: Duration,
    /// The longest time for which a client may leave an answer unread.
    pub write_timeout: Duration,
    /// The largest number of open connections; further ones close idle ones.
    pub max_connections: usize,
    /// The time for which the server still accepts requests after a signal, with `/readyz` at 503, so that load
    /// balancers notice.
    pub drain_delay: Duration,
    /// The longest time for requests in flight to finish after that.
    pub shutdown_grace: Duration,
}

/// The settings of requests.
#[derive(Debug, Clone, PartialEq)]
pub struct HttpSettings {
    /// The largest JSON body of a batch or a recommendation, decompressed.
    pub max_json_bytes: u64,
    /// The largest upload, decompressed.
    pub max_upload_bytes: u64,
    /// The time from a request's last byte to its answer.
    pub request_timeout: Duration,
    /// The longest pause within a body.
    pub body_idle_timeout: Duration,
    /// The least average rate of a body, in bytes a second.
    pub min_body_rate: u64,
    /// The largest number of requests in flight at once, without probes; further ones are shed.
    pub max_in_flight: usize,
    /// The largest number of uploads and batches processed at once; further ones are shed.
    pub max_concurrent_work: usize,
    /// The memory budget for all data whose size clients determine.
    pub memory_budget_bytes: u64,
    /// The origins whose pages may call the service.
    pub cors_origins: CorsOrigins,
}

impl HttpSettings {
    /// The largest body of a single calculation in bytes, some thousand times what one needs. It is less than
    /// [`max_json_bytes`](Self::max_json_bytes), because the bodies of all requests in flight are in memory together.
    pub const MAX_SINGLE_BYTES: u64 = 64 * 1024;
}

/// The origins whose pages may call the service.
#[derive(Debug, Clone, PartialEq)]
pub enum CorsOrigins {
    /// Any page.
    Any,
    /// Pages of these origins; none in an empty list.
    Listed(Vec<http::HeaderValue>),
}

impl Settings {
    /// Parses and checks all values.
    ///
    /// # Errors
    /// Every fault, each with its flag and variable.
    fn read(given: &command_line::RawSettings) -> Result<Self, Faults> {
        let mut faults = Vec::new();
        let listen = take(&mut faults, "SCALLOPD_LISTEN", &given.listen, address);
        let telemetry = TelemetrySettings::read(given, &mut faults);
        let server = ServerSettings::read(given, &mut faults);
        let http = HttpSettings::read(given, &mut faults);
        let health_listen = take(&mut faults, "SCALLOPD_HEALTH_LISTEN", &given.health_listen, optional_address);
        let whole = || Some(Self { listen: listen?, health_listen: health_listen?, telemetry: telemetry?, server: server?, http: http? });
        whole().ok_or(Faults(faults))
    }
}

impl TelemetrySettings {
    fn read(given: &command_line::RawSettings, faults: &mut Vec<Fault>) -> Option<Self> {
        let log_format = take(faults, "SCALLOPD_LOG_FORMAT", &given.log_format, log_format);
        let log_level = take(faults, "SCALLOPD_LOG_LEVEL", &given.log_level, level);
        let otlp_endpoint = take(faults, "SCALLOPD_OTLP_ENDPOINT", &given.otlp_endpoint, collector);
        Some(Self { log_format: log_format?, log_level: log_level?, otlp_endpoint: otlp_endpoint? })
    }
}

impl ServerSettings {
    fn read(given: &command_line::RawSettings, faults: &mut Vec<Fault>) -> Option<Self> {
        let header_timeout = take(faults, "SCALLOPD_HEADER_TIMEOUT_S", &given.header_timeout_s, seconds(1));
        let idle_timeout = take(faults, "SCALLOPD_IDLE_TIMEOUT_S", &given.idle_timeout_s, seconds(1));
        let write_timeout = take(faults, "SCALLOPD_WRITE_TIMEOUT_S", &given.write_timeout_s, seconds(1));
        let max_connections = take(faults, "SCALLOPD_MAX_CONNECTIONS", &given.max_connections, count);
        let drain_delay = take(faults, "SCALLOPD_DRAIN_DELAY_S", &given.drain_delay_s, seconds(0));
        let shutdown_grace = take(faults, "SCALLOPD_SHUTDOWN_GRACE_S", &given.shutdown_grace_s, seconds(0));
        Some(Self {
            header_timeout: header_timeout?,
            idle_timeout: idle_timeout?,
            write_timeout: write_timeout?,
            max_connections: max_connections?,
            drain_delay: drain_delay?,
            shutdown_grace: shutdown_grace?,
        })
    }
}

impl HttpSettings {
    fn read(given: &command_line::RawSettings, faults: &mut Vec<Fault>) -> Option<Self> {
        let max_json_bytes = take(faults, "SCALLOPD_MAX_JSON_BYTES", &given.max_json_bytes, fault::bytes);
        let max_upload_bytes = take(faults, "SCALLOPD_MAX_UPLOAD_BYTES", &given.max_upload_bytes, fault::bytes);
        let request_timeout = take(faults, "SCALLOPD_REQUEST_TIMEOUT_S", &given.request_timeout_s, seconds(1));
        let body_idle_timeout = take(faults, "SCALLOPD_BODY_IDLE_TIMEOUT_S", &given.body_idle_timeout_s, seconds(1));
        let min_body_rate = take(faults, "SCALLOPD_MIN_BODY_BYTES_S", &given.min_body_bytes_s, fault::rate);
        let max_in_flight = take(faults, "SCALLOPD_MAX_IN_FLIGHT", &given.max_in_flight, count);
        let max_concurrent_work = take(faults, "SCALLOPD_MAX_CONCURRENT_WORK", &given.max_concurrent_work, count);
        let memory_budget_bytes = take(faults, "SCALLOPD_MEMORY_BUDGET_BYTES", &given.memory_budget_bytes, fault::bytes);
        let cors_origins = take(faults, "SCALLOPD_CORS_ORIGINS", &given.cors_origins, origins);
        Some(Self {
            max_json_bytes: max_json_bytes?,
            max_upload_bytes: max_upload_bytes?,
            request_timeout: request_timeout?,
            body_idle_timeout: body_idle_timeout?,
            min_body_rate: min_body_rate?,
            max_in_flight: max_in_flight?,
            max_concurrent_work: max_concurrent_work?,
            memory_budget_bytes: memory_budget_bytes?,
            cors_origins: cors_origins?,
        })
    }
}
