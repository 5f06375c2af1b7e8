//! The service as its operators and its worst clients meet it. Servers run in-process around small routers of the tests' own, except
//! where the program itself is what is tested.

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
