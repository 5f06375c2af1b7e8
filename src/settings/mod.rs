//! The settings: one table, a row for each with its type, default, parser and line of help. The row's name gives the flag
//! (`--max-json`) and the variable (`SCALLOPD_MAX_JSON`). All values are checked together, so that the program reports
//! every fault at its start.

mod command_line;
mod value;

use std::fmt;
use std::net::SocketAddr;
use std::time::Duration;

use http::Uri;
use tracing::level_filters::LevelFilter;

pub use command_line::{Command, CommandLineError, OpenApiVersion};
pub use value::{CorsOrigins, LogFormat, SettingReason};

/// The prefix of all variables.
const PREFIX: &str = "SCALLOPD_";

/// A row of the table: a setting as the command line knows it.
struct Row {
    name: &'static str,
    value_name: &'static str,
    default: &'static str,
    help: &'static str,
}

/// The text given for the setting of a name.
type Given<'a> = &'a dyn Fn(&'static str) -> String;

macro_rules! settings {
    ($($(#[doc = $help:literal])+ $name:ident: $type:ty, $value_name:literal = $default:literal, $read:path;)+) => {
        /// All settings.
        #[derive(Debug, Clone, PartialEq)]
        pub struct Settings {
            $($(#[doc = $help])+ pub $name: $type,)+
        }

        const ROWS: &[Row] = &[
            $(Row { name: stringify!($name), value_name: $value_name, default: $default, help: concat!($($help),+) },)+
        ];

        impl Settings {
            /// Parses and checks all values.
            ///
            /// # Errors
            /// Every fault, each with its flag and variable.
            fn read(given: Given<'_>) -> Result<Self, SettingFaults> {
                let mut faults = SettingFaults(Vec::new());
                $(let $name = faults.take(stringify!($name), given, $read);)+
                let read = || Some(Self { $($name: $name?,)+ });
                read().ok_or(faults)
            }
        }
    };
}

settings! {
    /// IP address and port to listen on; port 0 picks a free one, which is logged
    listen: SocketAddr, "ADDR" = "127.0.0.1:8080", value::address;
    /// IP address and port for probes and metrics only, on a separate thread; empty to serve them on the listening
    /// address
    health_listen: Option<SocketAddr>, "ADDR" = "", value::optional_address;
    /// Format of the log lines on standard output: pretty or json
    log_format: LogFormat, "FORMAT" = "json", value::log_format;
    /// Least severe log line that is written: off, error, warn, info, debug or trace
    log_level: LevelFilter, "LEVEL" = "info", value::level;
    /// Base address of a collector of OTLP traces over HTTP, such as http://collector:4318
    otlp_endpoint: Option<Uri>, "URL" = "", value::collector;
    /// Origins of pages that may call the service, separated by commas, or * for any
    cors_origins: CorsOrigins, "ORIGINS" = "", value::origins;
    /// Requests in flight at once, without probes and metrics; further ones are shed with 503. Four times as many
    /// connections may be open; further ones wait until one closes
    max_in_flight: usize, "COUNT" = "1024", value::count;
    /// Uploads and batches computed at once; further ones are shed with 503
    max_concurrent_work: usize, "COUNT" = "16", value::count;
    /// Largest JSON body of a batch or a recommendation, decompressed; that of a single calculation is at most 64 KiB
    max_json: u64, "SIZE" = "64MiB", value::size;
    /// Largest upload, decompressed
    max_upload: u64, "SIZE" = "1GiB", value::size;
    /// Memory for all data whose size clients determine: bodies, vertices, unsent answers; requests beyond it get 503
    memory_budget: u64, "SIZE" = "512MiB", value::budget;
    /// Longest time for a client to send a head, between its requests, between two parts of a body, and before an
    /// answer that it does not read
    client_timeout_s: Duration, "SECONDS" = "30", value::seconds_from_1;
    /// Longest time from a request's last byte to its answer
    request_timeout_s: Duration, "SECONDS" = "60", value::seconds_from_1;
    /// After SIGTERM, time with /readyz at 503 before the server stops accepting connections
    drain_delay_s: Duration, "SECONDS" = "0", value::seconds;
    /// After that, time for the requests in flight to finish; empty for the request time-out
    shutdown_grace_s: Option<Duration>, "SECONDS" = "", value::optional_seconds;
}

impl Settings {
    /// The largest number of open connections. Clients keep connections between their requests.
    #[must_use]
    pub fn max_connections(&self) -> usize {
        self.max_in_flight.saturating_mul(4)
    }

    /// The longest time for requests in flight to finish when the server stops.
    #[must_use]
    pub fn shutdown_grace(&self) -> Duration {
        self.shutdown_grace_s.unwrap_or(self.request_timeout_s)
    }
}

/// The names of the environment's variables that have the prefix of settings and belong to none.
#[must_use]
pub fn unknown_variables() -> Vec<String> {
    let names = std::env::vars_os().filter_map(|(name, _)| name.into_string().ok());
    names.filter(|name| name.starts_with(PREFIX) && ROWS.iter().all(|row| variable(row.name) != *name)).collect()
}

fn variable(name: &str) -> String {
    format!("{PREFIX}{}", name.to_uppercase())
}

fn flag(name: &str) -> String {
    name.replace('_', "-")
}

/// A setting with an invalid value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettingFault {
    /// The setting's name in the table.
    pub name: &'static str,
    /// The value given by the flag or the variable.
    pub given: String,
    /// The reason why the value is invalid.
    pub reason: SettingReason,
}

impl fmt::Display for SettingFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "--{} or {}: {:?} {}", flag(self.name), variable(self.name), self.given, self.reason)
    }
}

/// All settings with invalid values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettingFaults(pub Vec<SettingFault>);

impl SettingFaults {
    /// Parses the value given for the setting `name`. If that fails, adds the fault and returns `None`.
    fn take<T>(&mut self, name: &'static str, given: Given<'_>, read: impl FnOnce(&str) -> Result<T, SettingReason>) -> Option<T> {
        let given = given(name);
        read(given.trim()).map_err(|reason| self.0.push(SettingFault { name, given, reason })).ok()
    }
}

impl fmt::Display for SettingFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "these settings are invalid:")?;
        self.0.iter().try_for_each(|fault| write!(f, "\n  {fault}"))
    }
}

impl std::error::Error for SettingFaults {}
