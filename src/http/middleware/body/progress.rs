//! The record of a request body's progress, which the log, the minimum rate and the time limit share. The size
//! limit uses only its fault and its memory budget.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use axum::extract::Request;
use tokio::time::Instant;

use crate::http::problem::Problem;
use crate::memory_budget::MemoryBudget;

/// The progress of one request's body. The outermost layer adds it to the request's extensions.
#[derive(Debug)]
pub(in super::super) struct BodyProgress {
    began: Instant,
    /// Bytes received, before decompression.
    wire_bytes: AtomicU64,
    /// The time of the last bytes, in ms since `began`.
    last_byte_ms: AtomicU64,
    /// Whether a part of the body is still unread.
    is_unread: AtomicBool,
    fault: OnceLock<Problem>,
    /// The budget in which the body's bytes are reserved while they are in memory.
    budget: MemoryBudget,
}

impl BodyProgress {
    /// The record of a request whose body has not been read yet.
    pub(in super::super) fn begin(is_unread: bool, budget: MemoryBudget) -> Self {
        Self {
            began: Instant::now(),
            wire_bytes: AtomicU64::new(0),
            last_byte_ms: AtomicU64::new(0),
            is_unread: AtomicBool::new(is_unread),
            fault: OnceLock::new(),
            budget,
        }
    }

    /// The record that the outermost layer added to `request`.
    pub(in super::super) fn of(request: &Request) -> Arc<Self> {
        let progress = request.extensions().get::<Arc<Self>>();
        progress.map_or_else(|| unreachable!("the outermost layer adds the record"), Arc::clone)
    }

    /// Adds received bytes and returns their total.
    pub(super) fn add_wire_bytes(&self, bytes: u64) -> u64 {
        // 2^64 ms are half a billion years.
        let elapsed = u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.last_byte_ms.store(elapsed, Ordering::Relaxed);
        self.wire_bytes.fetch_add(bytes, Ordering::Relaxed) + bytes
    }

    pub(in super::super) fn budget(&self) -> &MemoryBudget {
        &self.budget
    }

    pub(in super::super) fn wire_bytes(&self) -> u64 {
        self.wire_bytes.load(Ordering::Relaxed)
    }

    /// The time of the last bytes; before the first, the time of the request's head.
    pub(super) fn last_byte(&self) -> Instant {
        self.began + Duration::from_millis(self.last_byte_ms.load(Ordering::Relaxed))
    }

    /// Records that the body has been read to its end.
    pub(super) fn note_end(&self) {
        self.is_unread.store(false, Ordering::Relaxed);
    }

    pub(in super::super) fn is_unread(&self) -> bool {
        self.is_unread.load(Ordering::Relaxed)
    }

    /// Records that the body broke a rule. Only the first fault is kept: later ones follow from it.
    pub(super) fn note_fault(&self, fault: Problem) -> Problem {
        self.fault.get_or_init(|| fault).clone()
    }

    pub(super) fn fault(&self) -> Option<&Problem> {
        self.fault.get()
    }
}
