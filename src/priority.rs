//! The priority of worker threads.

/// The niceness of worker threads: the scheduler gives them a third of the weight of threads that serve connections.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 5;

/// Gives the calling thread a lower priority than the threads that serve connections have. If the system refuses, the
/// priority stays.
pub(crate) fn lower() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::nice(NICENESS) {
        tracing::debug!(%error, "a thread keeps its priority");
    }
}
