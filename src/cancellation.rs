//! Cancellation of long computations whose result is no longer needed.

use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that is set once. Clones share it. A computation of more than some 10 ms checks it between steps and returns
/// early; its result is discarded.
#[derive(Debug, Clone, Default)]
pub struct CancelFlag(Arc<AtomicBool>);

impl CancelFlag {
    /// Sets the flag.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the flag is set.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A cancel flag that is set when this is dropped, for example together with the future that waits for the result.
#[derive(Debug, Default)]
pub struct CancelOnDrop(CancelFlag);

impl std::ops::Deref for CancelOnDrop {
    type Target = CancelFlag;

    fn deref(&self) -> &CancelFlag {
        &self.0
    }
}

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

/// The number of values that are computed between two checks for cancellation: some milliseconds at 200 ns each.
const AT_ONCE: usize = 1 << 15;

/// The values of `each` at 0, 1, ... up to `count`, computed on all cores. Once `stop` returns true, the values that are
/// still missing are left out, so that no memory is written for them.
pub(crate) fn collect_until<T: Send>(count: usize, stop: &(dyn Fn() -> bool + Sync), each: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values = Vec::with_capacity(count);
    for first in (0..count).step_by(AT_ONCE).take_while(|_| !stop()) {
        values.par_extend((first..count.min(first + AT_ONCE)).into_par_iter().with_min_len(256).map(&each));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn values_are_collected_in_order_until_the_work_is_cancelled() {
        let count = 3 * AT_ONCE + 5;
        let all: Vec<usize> = (0..count).collect();
        assert_eq!(collect_until(count, &|| false, |index| index), all);
        let checks = AtomicUsize::new(0);
        let third = || checks.fetch_add(1, Ordering::Relaxed) == 2;
        assert_eq!(collect_until(count, &third, |index| index), all[..2 * AT_ONCE]);
    }
}
