//! The program `scallopd`: reads the command line and starts the server, or runs a subcommand.

use std::io::Write;
use std::net::SocketAddr;
use std::process::ExitCode;
use std::time::Duration;

use scallopd::http::{self, AppState};
use scallopd::server::App;
use scallopd::settings::{Command, CommandLineError, OpenApiVersion, Settings, unknown_variables};
use scallopd::telemetry::Telemetry;
use scallopd::{health, server};
use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::oneshot;

// The static build uses musl, whose allocator is several times slower with threads.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// The length of the queue of connections to accept; the system may allow fewer.
const BACKLOG: u32 = 4096;

/// The largest number of requests in flight at the address for probes and scrapes.
const HEALTH_REQUESTS: usize = 16;

/// The variable of the allocator's delay before it returns freed memory.
#[cfg(unix)]
const PURGE_DELAY: &str = "MIMALLOC_PURGE_DELAY";

/// The exit code for invalid settings; other failures exit with 1.
const EXIT_USAGE: u8 = 2;

fn main() -> ExitCode {
    match Command::read(std::env::args_os()) {
        Ok(Command::Serve(settings)) => {
            return_memory_soon();
            exit(run(&settings))
        }
        Ok(Command::OpenApi(version)) => {
            let document = match version {
                OpenApiVersion::V3_1 => http::openapi_json(),
                OpenApiVersion::V3_0 => http::OPENAPI_3_0_JSON.to_owned(),
            };
            exit(std::io::stdout().write_all(document.as_bytes()).map(|()| true))
        }
        Ok(Command::Healthcheck(listen)) => exit(health::is_ready(listen)),
        Err(CommandLineError::Usage(usage)) => usage.exit(),
        Err(CommandLineError::Faults(faults)) => {
            eprintln!("scallopd: {faults}");
            ExitCode::from(EXIT_USAGE)
        }
    }
}

/// Sets the delay in ms after which the allocator returns freed memory to the system. With the default of a second, the
/// process would keep the memory that several large requests have freed, in addition to the memory budget. The
/// allocator reads the variable when the process begins, so the program is executed again.
fn return_memory_soon() {
    #[cfg(unix)]
    if std::env::var_os(PURGE_DELAY).is_none()
        && let Ok(program) = std::env::current_exe()
    {
        use std::os::unix::process::CommandExt;
        let mut arguments = std::env::args_os();
        let mut again = std::process::Command::new(program);
        again.arg0(arguments.next().unwrap_or_default()).args(arguments).env(PURGE_DELAY, "10");
        // Returns only if it fails; the server then runs with the default.
        let _ = again.exec();
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
    let telemetry = Telemetry::start(settings)?;
    let served = runtime.block_on(serve(settings));
    telemetry.stop();
    served.map(|()| true)
}

async fn serve(settings: &Settings) -> std::io::Result<()> {
    let state = AppState::start(settings)?;
    let app = |routes| App { router: http::service(routes, settings, &state), refuse: http::refusals(&state) };
    let routes = if settings.health_listen.is_some() { http::public_routes() } else { http::routes() };
    let public = app(routes);
    let signal = server::stop_signal()?;
    let listener = listen(settings.listen).map_err(|error| cannot_listen("--listen", settings.listen, &error))?;
    tracing::info!(address = %listener.local_addr()?, version = env!("CARGO_PKG_VERSION"), "listening");
    for variable in unknown_variables() {
        tracing::warn!(variable, "no setting has this variable");
    }
    let health = settings.health_listen.map(|address| serve_health(address, app(http::health_routes()), settings)).transpose()?;
    let stop = async {
        let signal = signal.await;
        tracing::info!(signal, drain_delay_s = settings.drain_delay_s.as_secs(), "draining");
        state.readiness.drain();
        tokio::time::sleep(settings.drain_delay_s).await;
    };
    let remaining = server::serve(listener, public, settings, stop).await;
    if !remaining.is_empty() {
        state.readiness.end();
    }
    remaining.cut().await;
    // Probes are answered until the last request has been answered.
    drop(health);
    Ok(())
}

/// Listens at `address`. The queue absorbs bursts of connections; if it is full, clients try again after a second.
fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    // A restarted server can listen while connections of the previous process are in TIME_WAIT.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

fn cannot_listen(flag: &str, address: SocketAddr, error: &std::io::Error) -> std::io::Error {
    std::io::Error::new(error.kind(), format!("cannot listen on {address} ({flag}): {error}"))
}

/// Serves probes and metrics on a separate thread until the sender is dropped, so that they are answered under any
/// load.
fn serve_health(address: SocketAddr, app: App, settings: &Settings) -> std::io::Result<oneshot::Sender<()>> {
    let settings = Settings { max_in_flight: HEALTH_REQUESTS, shutdown_grace_s: Some(Duration::ZERO), ..settings.clone() };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let listener = std::net::TcpListener::bind(address).map_err(|error| cannot_listen("--health-listen", address, &error))?;
    listener.set_nonblocking(true)?;
    let (stop, stopped) = oneshot::channel::<()>();
    tracing::info!(address = %listener.local_addr()?, "listening for probes");
    let serve = move || {
        runtime.block_on(async {
            let listener = TcpListener::from_std(listener)?;
            // An error means that the sender was dropped.
            server::serve(listener, app, &settings, async { _ = stopped.await }).await.cut().await;
            Ok::<_, std::io::Error>(())
        })
    };
    let log = move || {
        if let Err(error) = serve() {
            tracing::error!(%error, "probes are not served");
        }
    };
    std::thread::Builder::new().name("health".to_owned()).spawn(log)?;
    Ok(stop)
}
