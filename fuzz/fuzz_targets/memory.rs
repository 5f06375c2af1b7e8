//! The bound on the memory that one input may take. libFuzzer's `-malloc_limit_mb` needs a sanitizer, and
//! `-rss_limit_mb` counts the memory that all inputs left behind.

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Runs `work`, which must not take more than `most` bytes at once.
pub fn bounded<T>(most: usize, work: impl FnOnce() -> T) -> T {
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    let result = work();
    let peak = ALLOCATOR.peak_usage().saturating_sub(before);
    assert!(peak <= most, "{peak} bytes for one input");
    result
}
