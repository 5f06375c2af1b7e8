//! The priority of threads.

/// The niceness of threads beside those that serve connections: a third of their weight.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 5;

/// Gives the calling thread a lower priority than the threads that serve connections have. Where the system refuses,
/// it keeps its own.
pub(crate) fn lower() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::nice(NICENESS) {
        tracing::debug!(%error, "a thread keeps its priority");
    }
}
