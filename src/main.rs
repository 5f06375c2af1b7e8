//! The server's entry point.

use std::io::Write;
use std::process::ExitCode;

use scallopd::http::{self, AppState, openapi_json};
use scallopd::settings::{Command, Refusal, Settings};
use scallopd::telemetry::Telemetry;
use scallopd::{health, server};

// The allocator of musl, which the static build uses, is several times slower under threads.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// The exit code for invalid settings; other failures exit with 1.
const EXIT_USAGE: u8 = 2;

fn main() -> ExitCode {
    match Command::read(std::env::args_os()) {
        Ok(Command::Serve(settings)) => exit(run(&settings)),
        Ok(Command::OpenApi) => exit(std::io::stdout().write_all(openapi_json().as_bytes()).map(|()| true)),
        Ok(Command::Healthcheck(listen)) => exit(health::is_ready(listen)),
        Err(Refusal::Usage(usage)) => usage.exit(),
        Err(Refusal::Faults(faults)) => {
            eprintln!("scallopd: {faults}");
            ExitCode::from(EXIT_USAGE)
        }
    }
}

fn exit(outcome: std::io::Result<bool>) -> ExitCode {
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("scallopd: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(settings: &Settings) -> std::io::Result<bool> {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let telemetry = runtime.block_on(async { Telemetry::start(&settings.telemetry) })?;
    let served = runtime.block_on(serve(settings));
    telemetry.stop();
    served.map(|()| true)
}

async fn serve(settings: &Settings) -> std::io::Result<()> {
    let state = AppState::start(&settings.http)?;
    let app = http::service(http::routes(), &settings.http, &state);
    let signal = server::stop_signal()?;
    let listener = tokio::net::TcpListener::bind(settings.listen).await?;
    tracing::info!(address = %listener.local_addr()?, version = env!("CARGO_PKG_VERSION"), "listening");
    let stop = async {
        let signal = signal.await;
        tracing::info!(signal, drain_delay_s = settings.server.drain_delay.as_secs(), "draining");
        state.readiness.drain();
        tokio::time::sleep(settings.server.drain_delay).await;
    };
    server::serve(listener, app, &settings.server, stop).await
}
