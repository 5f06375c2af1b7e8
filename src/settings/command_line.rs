//! The command line: flags, variables, defaults and help. Values stay text here; [`Settings`](super::Settings) parses
//! them.

use std::ffi::OsString;
use std::fmt;
use std::net::SocketAddr;

use clap::{Arg, ArgAction, ArgMatches};

use super::{ROWS, Row, SettingFaults, Settings, flag, value, variable};

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
                let listen = faults.take("listen", &|name| of(healthcheck, name), value::address);
                let health = faults.take("health_listen", &|name| of(healthcheck, name), value::optional_address);
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
