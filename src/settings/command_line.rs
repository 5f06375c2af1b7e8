//! The command line: flags, variables, defaults and help. Values stay text here; [`Settings`](super::Settings) parses
//! them.

use std::ffi::OsString;
use std::fmt;
use std::net::SocketAddr;

use clap::{Args, Parser};

use super::fault::{address, optional_address, take};
use super::{Faults, Settings};

/// The command that the command line selects.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Serve requests.
    Serve(Box<Settings>),
    /// Print the OpenAPI document.
    OpenApi(OpenApiVersion),
    /// Check whether the server that listens at this address is ready.
    Healthcheck(SocketAddr),
}

/// A version of the OpenAPI specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OpenApiVersion {
    /// 3.1, the document in full.
    V3_1,
    /// 3.0.3, for generators that do not read 3.1.
    V3_0,
}

/// The reason why the command line gives no [`Command`].
#[derive(Debug)]
pub enum CommandLineError {
    /// Help or the version was requested, or a flag is unknown or malformed.
    Usage(clap::Error),
    /// Settings with invalid values.
    Faults(Faults),
}

impl fmt::Display for CommandLineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(usage) => write!(f, "{usage}"),
            Self::Faults(faults) => write!(f, "{faults}"),
        }
    }
}

impl std::error::Error for CommandLineError {}

impl Command {
    /// Reads the command from `arguments` (the program's name first) and the environment.
    ///
    /// # Errors
    /// [`CommandLineError`], with every fault of every value.
    pub fn read(arguments: impl IntoIterator<Item: Into<OsString> + Clone>) -> Result<Self, CommandLineError> {
        let line = CommandLine::try_parse_from(arguments).map_err(CommandLineError::Usage)?;
        match line.subcommand {
            None => Settings::read(&line.given).map(Box::new).map(Self::Serve).map_err(CommandLineError::Faults),
            Some(Subcommand::Openapi { is_3_0 }) => Ok(Self::OpenApi(if is_3_0 { OpenApiVersion::V3_0 } else { OpenApiVersion::V3_1 })),
            Some(Subcommand::Healthcheck) => {
                let mut faults = Vec::new();
                let listen = take(&mut faults, "SCALLOPD_LISTEN", &line.given.listen, address);
                let health = take(&mut faults, "SCALLOPD_HEALTH_LISTEN", &line.given.health_listen, optional_address);
                let asked = listen.zip(health).map(|(listen, health)| health.unwrap_or(listen));
                asked.map(Self::Healthcheck).ok_or(CommandLineError::Faults(Faults(faults)))
            }
        }
    }
}

/// Scallop heights, feeds and step-overs of ball-end and toroidal finish milling, over HTTP
#[derive(Parser)]
#[command(name = "scallopd", version)]
struct CommandLine {
    #[command(flatten)]
    given: RawSettings,
    #[command(subcommand)]
    subcommand: Option<Subcommand>,
}

#[derive(clap::Subcommand)]
enum Subcommand {
    /// Print the OpenAPI document
    Openapi {
        /// In version 3.0.3, for generators that do not read 3.1; without the operations that take forms
        #[arg(long = "3.0")]
        is_3_0: bool,
    },
    /// Request /readyz from the running server; exit with 0 if it is ready, 1 otherwise
    Healthcheck,
}

/// The settings as text, before they are parsed.
#[derive(Args)]
pub(super) struct RawSettings {
    /// IP address and port to listen on; port 0 picks a free one, which is logged
    #[arg(long, env = "SCALLOPD_LISTEN", value_name = "ADDR", default_value = "127.0.0.1:8080", global = true)]
    pub(super) listen: String,
    /// IP address and port for probes and metrics only; empty to serve them on the listening address
    #[arg(long, env = "SCALLOPD_HEALTH_LISTEN", value_name = "ADDR", default_value = "", global = true)]
    pub(super) health_listen: String,
    /// Format of the log lines on standard output: pretty or json
    #[arg(long, env = "SCALLOPD_LOG_FORMAT", value_name = "FORMAT", default_value = "json")]
    pub(super) log_format: String,
    /// Least severe log line that is written: off, error, warn, info, debug or trace
    #[arg(long, env = "SCALLOPD_LOG_LEVEL", value_name = "LEVEL", default_value = "info")]
    pub(super) log_level: String,
    /// Largest JSON body of a batch or a recommendation, decompressed; that of a single calculation is at most 64 KiB
    #[arg(long, env = "SCALLOPD_MAX_JSON_BYTES", value_name = "BYTES", default_value = "67108864")]
    pub(super) max_json_bytes: String,
    /// Largest upload, decompressed
    #[arg(long, env = "SCALLOPD_MAX_UPLOAD_BYTES", value_name = "BYTES", default_value = "1073741824")]
    pub(super) max_upload_bytes: String,
    /// Longest time for a request's head to arrive, and for a new connection to send one
    #[arg(long, env = "SCALLOPD_HEADER_TIMEOUT_S", value_name = "SECONDS", default_value = "10")]
    pub(super) header_timeout_s: String,
    /// Longest time that a connection may be idle between requests
    #[arg(long, env = "SCALLOPD_IDLE_TIMEOUT_S", value_name = "SECONDS", default_value = "75")]
    pub(super) idle_timeout_s: String,
    /// Longest time from a request's last byte to its answer
    #[arg(long, env = "SCALLOPD_REQUEST_TIMEOUT_S", value_name = "SECONDS", default_value = "60")]
    pub(super) request_timeout_s: String,
    /// Longest pause within a request's body
    #[arg(long, env = "SCALLOPD_BODY_IDLE_TIMEOUT_S", value_name = "SECONDS", default_value = "15")]
    pub(super) body_idle_timeout_s: String,
    /// Least average rate of a request's body in bytes a second, from its first byte; 0 for any
    #[arg(long, env = "SCALLOPD_MIN_BODY_BYTES_S", value_name = "BYTES", default_value = "1024")]
    pub(super) min_body_bytes_s: String,
    /// Longest time that a client may leave an answer unread
    #[arg(long, env = "SCALLOPD_WRITE_TIMEOUT_S", value_name = "SECONDS", default_value = "15")]
    pub(super) write_timeout_s: String,
    /// Requests in flight at once, without probes and metrics; further ones are shed with 503
    #[arg(long, env = "SCALLOPD_MAX_IN_FLIGHT", value_name = "COUNT", default_value = "1024")]
    pub(super) max_in_flight: String,
    /// Uploads and batches processed at once; further ones are shed with 503
    #[arg(long, env = "SCALLOPD_MAX_CONCURRENT_WORK", value_name = "COUNT", default_value = "16")]
    pub(super) max_concurrent_work: String,
    /// Memory for all data whose size clients determine: bodies, vertices, unsent answers; requests beyond it get 503
    #[arg(long, env = "SCALLOPD_MEMORY_BUDGET_BYTES", value_name = "BYTES", default_value = "536870912")]
    pub(super) memory_budget_bytes: String,
    /// Connections open at once; further ones close idle ones
    #[arg(long, env = "SCALLOPD_MAX_CONNECTIONS", value_name = "COUNT", default_value = "4096")]
    pub(super) max_connections: String,
    /// After SIGTERM, time with /readyz at 503 before the server stops accepting connections
    #[arg(long, env = "SCALLOPD_DRAIN_DELAY_S", value_name = "SECONDS", default_value = "0")]
    pub(super) drain_delay_s: String,
    /// After that, time for the requests in flight to finish
    #[arg(long, env = "SCALLOPD_SHUTDOWN_GRACE_S", value_name = "SECONDS", default_value = "30")]
    pub(super) shutdown_grace_s: String,
    /// Origins of pages that may call the service, separated by commas, or * for any
    #[arg(long, env = "SCALLOPD_CORS_ORIGINS", value_name = "ORIGINS", default_value = "")]
    pub(super) cors_origins: String,
    /// Base address of a collector of OTLP traces over HTTP, such as http://collector:4318
    #[arg(long, env = "SCALLOPD_OTLP_ENDPOINT", value_name = "URL", default_value = "")]
    pub(super) otlp_endpoint: String,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn every_setting_has_a_flag_a_variable_of_the_same_name_a_default_and_a_help_line() {
        let command = CommandLine::command();
        command.clone().debug_assert();
        for argument in command.get_arguments() {
            let flag = argument.get_long().expect("a flag");
            let variable = argument.get_env().expect("a variable").to_str().unwrap();
            assert_eq!(variable, format!("SCALLOPD_{}", flag.to_uppercase().replace('-', "_")));
            assert_eq!(argument.get_default_values().len(), 1, "{flag}");
            assert!(argument.get_help().is_some(), "{flag}");
        }
    }

    #[test]
    fn defaults_are_valid() {
        let Ok(Command::Serve(settings)) = Command::read(["scallopd"]) else { panic!("the defaults are refused") };
        assert_eq!(settings.listen.to_string(), "127.0.0.1:8080");
        assert_eq!(settings.http.max_json_bytes, 64 << 20);
        assert_eq!(settings.http.max_upload_bytes, 1 << 30);
        assert_eq!(settings.telemetry.otlp_endpoint, None);
    }

    #[test]
    fn all_faults_are_reported_together() {
        let line = ["scallopd", "--listen", "here", "--max-in-flight", "0", "--log-format", "xml", "--otlp-endpoint", "nowhere"];
        let Err(CommandLineError::Faults(faults)) = Command::read(line) else { panic!("faults are accepted") };
        let flags: Vec<_> = faults.0.iter().map(super::super::Fault::flag).collect();
        assert_eq!(flags, ["--listen", "--log-format", "--otlp-endpoint", "--max-in-flight"]);
    }

    #[test]
    fn the_document_is_printed_in_version_3_1_unless_3_0_is_requested() {
        assert!(matches!(Command::read(["scallopd", "openapi"]), Ok(Command::OpenApi(OpenApiVersion::V3_1))));
        assert!(matches!(Command::read(["scallopd", "openapi", "--3.0"]), Ok(Command::OpenApi(OpenApiVersion::V3_0))));
    }

    #[test]
    fn a_health_check_reads_the_address_and_no_other_setting() {
        let checked = Command::read(["scallopd", "healthcheck", "--listen", "127.0.0.1:9"]);
        assert!(matches!(checked, Ok(Command::Healthcheck(address)) if address.port() == 9));
        assert!(matches!(Command::read(["scallopd", "healthcheck", "--listen", "x"]), Err(CommandLineError::Faults(_))));
    }
}
