//! What the layers around a request know of its body while it arrives.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::time::Instant;

use super::fault::BodyFault;

/// One body's arrival.
#[derive(Debug)]
pub(super) struct Reception {
    began: Instant,
    /// When bytes last came, in ms since `began`.
    last_byte_ms: AtomicU64,
    fault: OnceLock<BodyFault>,
}

impl Reception {
    pub(super) fn begin() -> Self {
        Self { began: Instant::now(), last_byte_ms: AtomicU64::new(0), fault: OnceLock::new() }
    }

    /// Bytes came now.
    pub(super) fn note_bytes(&self) {
        // 2^64 ms are half a billion years.
        let elapsed = u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.last_byte_ms.store(elapsed, Ordering::Relaxed);
    }

    /// When bytes last came; before any, when the request's head did.
    pub(super) fn last_byte(&self) -> Instant {
        self.began + Duration::from_millis(self.last_byte_ms.load(Ordering::Relaxed))
    }

    /// The body broke a rule. Only the first fault counts: later ones follow from it.
    pub(super) fn note_fault(&self, fault: BodyFault) -> BodyFault {
        self.fault.get_or_init(|| fault).clone()
    }

    pub(super) fn fault(&self) -> Option<&BodyFault> {
        self.fault.get()
    }
}
