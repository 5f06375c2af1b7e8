//! Operation of the service: limits, slow clients, shutdown, logs and metrics. Servers run in-process with small
//! routers of the tests, except in tests of the program itself.

mod budget;
#[cfg(target_os = "linux")]
mod cancellation;
mod connections;
mod launch;
mod limits;
#[cfg(target_os = "linux")]
mod memory;
mod monitoring;
mod observability;
mod panics;
mod program;
mod server;
mod shares;
mod shedding;
mod shutdown;
mod slow_clients;
#[cfg(feature = "otlp")]
mod traces;
