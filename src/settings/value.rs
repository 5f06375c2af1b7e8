//! The parsers of single values.

use std::fmt;
use std::net::SocketAddr;
use std::time::Duration;

use bytesize::ByteSize;
use http::{HeaderValue, Uri};
use tracing::level_filters::LevelFilter;

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

pub(super) fn address(given: &str) -> Result<SocketAddr, SettingReason> {
    given.parse().map_err(|_| SettingReason::Address)
}

/// An address; `None` for an empty text.
pub(super) fn optional_address(given: &str) -> Result<Option<SocketAddr>, SettingReason> {
    if given.is_empty() { Ok(None) } else { address(given).map(Some) }
}

/// Sizes up to a tebibyte, in bytes or with a unit: `64MB`, `1.5 GiB`.
pub(super) fn size(given: &str) -> Result<u64, SettingReason> {
    size_from(1, given)
}

/// The smallest memory budget that leaves room for one ordinary request of each kind.
const MIN_BUDGET: u64 = 64 << 20;

pub(super) fn budget(given: &str) -> Result<u64, SettingReason> {
    size_from(MIN_BUDGET, given)
}

fn size_from(minimum: u64, given: &str) -> Result<u64, SettingReason> {
    let size = given.parse().map(|ByteSize(bytes)| bytes).ok();
    size.filter(|bytes| (minimum..=1 << 40).contains(bytes)).ok_or(SettingReason::Size { minimum })
}

/// A count, from 1 to a million.
pub(super) fn count(given: &str) -> Result<usize, SettingReason> {
    // A million fits `usize` on every supported platform.
    whole(given, 1, 1_000_000).map(|number| usize::try_from(number).unwrap_or(usize::MAX))
}

/// Whole seconds, up to a day.
pub(super) fn seconds(given: &str) -> Result<Duration, SettingReason> {
    whole(given, 0, 86_400).map(Duration::from_secs)
}

pub(super) fn seconds_from_1(given: &str) -> Result<Duration, SettingReason> {
    whole(given, 1, 86_400).map(Duration::from_secs)
}

/// Whole seconds; `None` for an empty text.
pub(super) fn optional_seconds(given: &str) -> Result<Option<Duration>, SettingReason> {
    if given.is_empty() { Ok(None) } else { seconds(given).map(Some) }
}

pub(super) fn log_format(given: &str) -> Result<LogFormat, SettingReason> {
    match given {
        "pretty" => Ok(LogFormat::Pretty),
        "json" => Ok(LogFormat::Json),
        _ => Err(SettingReason::Word("pretty, json")),
    }
}

pub(super) fn level(given: &str) -> Result<LevelFilter, SettingReason> {
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
pub(super) fn origins(given: &str) -> Result<CorsOrigins, SettingReason> {
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
pub(super) fn collector(given: &str) -> Result<Option<Uri>, SettingReason> {
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
}
