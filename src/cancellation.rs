//! A flag that cancels long computations whose result is no longer needed.

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
