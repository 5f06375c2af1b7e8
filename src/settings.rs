//! The settings: one table, a row for each with its type, default, parser and line of help. The row's name gives the flag
//! (`--max-json`) and the variable (`SCALLOPD_MAX_JSON`). All values are checked together, so that the program reports
//! every fault at its start.

use bytesize::ByteSize;
use clap::{Arg, ArgAction, ArgMatches};
use http::{HeaderValue, Uri};
use std::ffi::OsString;
use std::fmt;
use std::net::SocketAddr;
use std::time::Duration;
use tracing::level_filters::LevelFilter;

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
    listen: SocketAddr, "ADDR" = "127.0.0.1:8080", address;
    /// IP address and port for probes and metrics only, on a separate thread; empty to serve them on the listening
    /// address
    health_listen: Option<SocketAddr>, "ADDR" = "", optional_address;
    /// Format of the log lines on standard output: pretty or json
    log_format: LogFormat, "FORMAT" = "json", log_format;
    /// Least severe log line that is written: off, error, warn, info, debug or trace
    log_level: LevelFilter, "LEVEL" = "info", level;
    /// Base address of a collector of OTLP traces over HTTP, such as http://collector:4318
    otlp_endpoint: Option<Uri>, "URL" = "", collector;
    /// Origins of pages that may call the service, separated by commas, or * for any
    cors_origins: CorsOrigins, "ORIGINS" = "", origins;
    /// Requests in flight at once, without probes and metrics; further ones are shed with 503. Four times as many
    /// connections may be open; further ones wait until one closes
    max_in_flight: usize, "COUNT" = "1024", count;
    /// Uploads and batches computed at once; further ones are shed with 503
    max_concurrent_work: usize, "COUNT" = "16", count;
    /// Largest JSON body of a batch or a recommendation, decompressed; that of a single calculation is at most 64 KiB
    max_json: u64, "SIZE" = "64MiB", size;
    /// Largest upload, decompressed
    max_upload: u64, "SIZE" = "1GiB", size;
    /// Memory for all data whose size clients determine: bodies, vertices, unsent answers; requests beyond it get 503
    memory_budget: u64, "SIZE" = "512MiB", budget;
    /// Longest time for a client to send a head, between its requests, between two parts of a body, and before an
    /// answer that it does not read
    client_timeout_s: Duration, "SECONDS" = "30", seconds_from_1;
    /// Longest time from a request's last byte to its answer
    request_timeout_s: Duration, "SECONDS" = "60", seconds_from_1;
    /// After SIGTERM, time with /readyz at 503 before the server stops accepting connections
    drain_delay_s: Duration, "SECONDS" = "0", seconds;
    /// After that, time for the requests in flight to finish; empty for the request time-out
    shutdown_grace_s: Option<Duration>, "SECONDS" = "", optional_seconds;
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

/// The form of a log line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogFormat {
    /// For people at a terminal.
    Pretty,
    /// One JSON object on each line, for a log collector.
    Json,
}

/// The origins whose pages may call the service.
#[derive(Debug, Clone, PartialEq)]
pub enum CorsOrigins {
    /// Any page.
    Any,
    /// Pages of these origins; none in an empty list.
    Listed(Vec<HeaderValue>),
}

/// The reason why a value is invalid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SettingReason {
    /// It is not an IP address with a port.
    Address,
    /// It is not a whole number within the bounds.
    WholeNumber {
        /// The smallest number accepted.
        minimum: u64,
        /// The largest number accepted.
        maximum: u64,
    },
    /// It is not a size in bytes within the bounds.
    Size {
        /// The smallest size accepted, in bytes.
        minimum: u64,
    },
    /// It is not one of these words.
    Word(&'static str),
    /// This item of the list is not an origin.
    Origin(String),
    /// It is not an `http://` address.
    Collector,
    /// The setting belongs to a feature without which this executable was built.
    NotBuiltIn,
}

impl fmt::Display for SettingReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Address => write!(f, "is not an IP address with a port, such as 0.0.0.0:8080 or [::1]:8080"),
            Self::WholeNumber { minimum, maximum } => write!(f, "is not a whole number from {minimum} to {maximum}"),
            Self::Size { minimum } => write!(f, "is not a size such as 64MB or 1GiB, from {} to 1 TiB", ByteSize(*minimum)),
            Self::Word(words) => write!(f, "is not one of {words}"),
            Self::Origin(item) => write!(f, "contains {item:?}, which is not an origin such as https://panel.example:8443"),
            Self::Collector => write!(f, "is not an address such as http://collector:4318 (http only: TLS belongs to a local collector)"),
            Self::NotBuiltIn => write!(f, "needs a build with the feature `otlp`"),
        }
    }
}

fn whole(given: &str, minimum: u64, maximum: u64) -> Result<u64, SettingReason> {
    given.parse().ok().filter(|number| (minimum..=maximum).contains(number)).ok_or(SettingReason::WholeNumber { minimum, maximum })
}

fn address(given: &str) -> Result<SocketAddr, SettingReason> {
    given.parse().map_err(|_| SettingReason::Address)
}

/// An address; `None` for an empty text.
fn optional_address(given: &str) -> Result<Option<SocketAddr>, SettingReason> {
    if given.is_empty() { Ok(None) } else { address(given).map(Some) }
}

/// Sizes up to a tebibyte, in bytes or with a unit: `64MB`, `1.5 GiB`.
fn size(given: &str) -> Result<u64, SettingReason> {
    size_from(1, given)
}

/// The smallest memory budget that leaves room for one ordinary request of each kind.
const MIN_BUDGET: u64 = 64 << 20;

fn budget(given: &str) -> Result<u64, SettingReason> {
    size_from(MIN_BUDGET, given)
}

fn size_from(minimum: u64, given: &str) -> Result<u64, SettingReason> {
    let size = given.parse().map(|ByteSize(bytes)| bytes).ok();
    size.filter(|bytes| (minimum..=1 << 40).contains(bytes)).ok_or(SettingReason::Size { minimum })
}

/// A count, from 1 to a million.
fn count(given: &str) -> Result<usize, SettingReason> {
    // A million fits `usize` on every supported platform.
    whole(given, 1, 1_000_000).map(|number| usize::try_from(number).unwrap_or(usize::MAX))
}

/// Whole seconds, up to a day.
fn seconds(given: &str) -> Result<Duration, SettingReason> {
    whole(given, 0, 86_400).map(Duration::from_secs)
}

fn seconds_from_1(given: &str) -> Result<Duration, SettingReason> {
    whole(given, 1, 86_400).map(Duration::from_secs)
}

/// Whole seconds; `None` for an empty text.
fn optional_seconds(given: &str) -> Result<Option<Duration>, SettingReason> {
    if given.is_empty() { Ok(None) } else { seconds(given).map(Some) }
}

fn log_format(given: &str) -> Result<LogFormat, SettingReason> {
    match given {
        "pretty" => Ok(LogFormat::Pretty),
        "json" => Ok(LogFormat::Json),
        _ => Err(SettingReason::Word("pretty, json")),
    }
}

fn level(given: &str) -> Result<LevelFilter, SettingReason> {
    match given {
        "off" => Ok(LevelFilter::OFF),
        "error" => Ok(LevelFilter::ERROR),
        "warn" => Ok(LevelFilter::WARN),
        "info" => Ok(LevelFilter::INFO),
        "debug" => Ok(LevelFilter::DEBUG),
        "trace" => Ok(LevelFilter::TRACE),
        _ => Err(SettingReason::Word("off, error, warn, info, debug, trace")),
    }
}

/// A comma-separated list of origins. `*` alone allows any, an empty list none.
fn origins(given: &str) -> Result<CorsOrigins, SettingReason> {
    if given == "*" {
        return Ok(CorsOrigins::Any);
    }
    given.split(',').map(str::trim).filter(|item| !item.is_empty()).map(origin).collect::<Result<_, _>>().map(CorsOrigins::Listed)
}

/// An origin as browsers send it: scheme, host and port. An address with a path would never match.
fn origin(item: &str) -> Result<HeaderValue, SettingReason> {
    let wrong = || SettingReason::Origin(item.to_owned());
    let uri: Uri = item.parse().map_err(|_| wrong())?;
    let (Some(scheme), Some(authority)) = (uri.scheme(), uri.authority()) else { return Err(wrong()) };
    if format!("{scheme}://{authority}") != item {
        return Err(wrong());
    }
    HeaderValue::from_str(item).map_err(|_| wrong())
}

/// The collector's address; `None` for an empty text.
fn collector(given: &str) -> Result<Option<Uri>, SettingReason> {
    if given.is_empty() {
        return Ok(None);
    }
    if !cfg!(feature = "otlp") {
        return Err(SettingReason::NotBuiltIn);
    }
    let uri: Uri = given.parse().map_err(|_| SettingReason::Collector)?;
    let usable = uri.scheme_str() == Some("http") && uri.authority().is_some() && uri.query().is_none();
    usable.then_some(Some(uri)).ok_or(SettingReason::Collector)
}

/// The subcommands and their flag.
const OPENAPI: &str = "openapi";
const VERSION_3_0: &str = "3.0";
const HEALTHCHECK: &str = "healthcheck";

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
    Faults(SettingFaults),
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
        let line = command_line().try_get_matches_from(arguments).map_err(CommandLineError::Usage)?;
        let of = |matches: &ArgMatches, name| matches.get_one::<String>(name).cloned().unwrap_or_default();
        match line.subcommand() {
            Some((OPENAPI, version)) => {
                Ok(Self::OpenApi(if version.get_flag(VERSION_3_0) { OpenApiVersion::V3_0 } else { OpenApiVersion::V3_1 }))
            }
            Some((_, healthcheck)) => {
                let mut faults = SettingFaults(Vec::new());
                let listen = faults.take("listen", &|name| of(healthcheck, name), address);
                let health = faults.take("health_listen", &|name| of(healthcheck, name), optional_address);
                let asked = listen.zip(health).map(|(listen, health)| health.unwrap_or(listen));
                asked.map(Self::Healthcheck).ok_or(CommandLineError::Faults(faults))
            }
            None => Settings::read(&|name| of(&line, name)).map(Box::new).map(Self::Serve).map_err(CommandLineError::Faults),
        }
    }
}

/// The command line: the settings of the table, and the subcommands.
fn command_line() -> clap::Command {
    // Subcommands read the addresses, no other setting.
    let argument = |row: &Row| {
        let is_address = row.value_name == "ADDR";
        Arg::new(row.name)
            .long(flag(row.name))
            .env(variable(row.name))
            .value_name(row.value_name)
            .default_value(row.default)
            .help(row.help.trim())
            .global(is_address)
    };
    clap::Command::new(env!("CARGO_PKG_NAME"))
        .version(env!("CARGO_PKG_VERSION"))
        .about("Scallop heights, feeds, step-overs and plans of finish milling, over HTTP")
        .args(ROWS.iter().map(argument))
        .subcommand(
            clap::Command::new(OPENAPI).about("Print the OpenAPI document").arg(
                Arg::new(VERSION_3_0)
                    .long(VERSION_3_0)
                    .action(ArgAction::SetTrue)
                    .help("In version 3.0.3, for generators that do not read 3.1; without the operations that take forms"),
            ),
        )
        .subcommand(
            clap::Command::new(HEALTHCHECK).about("Request /readyz from the running server; exit with 0 if it is ready, 1 otherwise"),
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_inclusive_and_nothing_is_clamped() {
        assert_eq!(count("1"), Ok(1));
        assert_eq!(count("1000000"), Ok(1_000_000));
        for wrong in ["0", "1000001", "-1", "1.5", "", "1e3"] {
            assert_eq!(count(wrong), Err(SettingReason::WholeNumber { minimum: 1, maximum: 1_000_000 }), "{wrong}");
        }
        assert_eq!(seconds("0"), Ok(Duration::ZERO));
        assert!(seconds_from_1("0").is_err());
        assert_eq!((optional_seconds(""), optional_seconds("7")), (Ok(None), Ok(Some(Duration::from_secs(7)))));
    }

    #[test]
    fn sizes_have_units_of_thousands_and_of_1024() {
        for (given, bytes) in [("64MB", 64_000_000), ("64 MiB", 64 << 20), ("1gib", 1 << 30), ("1.5kB", 1500), ("7", 7), ("1TiB", 1 << 40)]
        {
            assert_eq!(size(given), Ok(bytes), "{given}");
        }
        for wrong in ["", "0", "MB", "-1MB", "1 parsec", "2TiB", "1e400MB", "99999999999999999999"] {
            assert_eq!(size(wrong), Err(SettingReason::Size { minimum: 1 }), "{wrong}");
        }
        assert!(budget("1MB").is_err());
    }

    #[test]
    fn origins_have_the_form_that_browsers_send() {
        let listed = CorsOrigins::Listed(vec!["https://a.example".parse().unwrap(), "http://b:8080".parse().unwrap()]);
        assert_eq!(origins("https://a.example, http://b:8080"), Ok(listed));
        assert_eq!(origins(""), Ok(CorsOrigins::Listed(Vec::new())));
        assert_eq!(origins("*"), Ok(CorsOrigins::Any));
        for wrong in ["https://a.example/", "a.example", "https://a.example/path", "*,https://a.example"] {
            assert!(origins(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    #[cfg(feature = "otlp")]
    fn a_collector_is_reached_over_plain_http() {
        assert_eq!(collector(""), Ok(None));
        assert_eq!(collector("http://collector:4318"), Ok(Some("http://collector:4318".parse().unwrap())));
        for wrong in ["https://collector:4318", "collector:4318", "grpc://collector:4317", "/v1/traces"] {
            assert_eq!(collector(wrong), Err(SettingReason::Collector), "{wrong}");
        }
    }

    #[test]
    fn every_setting_has_a_flag_and_a_variable_of_the_same_name() {
        let command = command_line();
        command.clone().debug_assert();
        for argument in command.get_arguments() {
            let flag = argument.get_long().expect("a flag");
            let variable = argument.get_env().expect("a variable").to_str().unwrap();
            assert_eq!(variable, format!("SCALLOPD_{}", flag.to_uppercase().replace('-', "_")));
        }
    }

    #[test]
    fn defaults_are_valid() {
        let Ok(Command::Serve(settings)) = Command::read(["scallopd"]) else { panic!("the defaults are refused") };
        assert_eq!(settings.listen.to_string(), "127.0.0.1:8080");
        assert_eq!(settings.max_json, 64 << 20);
        assert_eq!(settings.max_upload, 1 << 30);
        assert_eq!(settings.otlp_endpoint, None);
        assert_eq!(settings.shutdown_grace(), settings.request_timeout_s);
    }

    #[test]
    fn all_faults_are_reported_together() {
        let line = ["scallopd", "--listen", "here", "--max-in-flight", "0", "--log-format", "xml", "--otlp-endpoint", "nowhere"];
        let Err(CommandLineError::Faults(faults)) = Command::read(line) else { panic!("faults are accepted") };
        let names: Vec<_> = faults.0.iter().map(|fault| fault.name).collect();
        assert_eq!(names, ["listen", "log_format", "otlp_endpoint", "max_in_flight"]);
        let text = faults.to_string();
        for part in ["--max-in-flight or SCALLOPD_MAX_IN_FLIGHT", "\"0\"", "from 1 to 1000000"] {
            assert!(text.contains(part), "{part} is not in {text}");
        }
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
