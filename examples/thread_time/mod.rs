//! The processor time of this thread, as Linux counts it.

/// Processor time of this thread in us.
#[cfg(target_os = "linux")]
#[expect(clippy::cast_precision_loss, reason = "the thread runs for less than 2^53 ns")]
pub(crate) fn now_us() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 / 1e3
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn now_us() -> f64 {
    panic!("the processor time of a thread is read as Linux counts it");
}
