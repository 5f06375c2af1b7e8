//! The state of a connection, shared by its stream, its requests and the table of all connections.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::task::{Context, Waker};
use std::time::{Duration, Instant};

/// The phase of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Phase {
    /// The connection waits for a request's head, of which a part may have arrived.
    AwaitingHead,
    /// A request's body is arriving.
    Receiving,
    /// The whole request has arrived; its answer is not ready.
    Working,
    /// The answer is being sent.
    Answering,
}

/// The state of one connection.
#[derive(Debug)]
pub(super) struct ConnectionState {
    opened: Instant,
    phase: AtomicU8,
    /// The start of the wait for a head, in ms since the connection was opened.
    awaiting_since_ms: AtomicU64,
    /// The number of requests that have started.
    requests: AtomicU32,
    /// Whether the connection must close while it waits for a head.
    evicted: AtomicBool,
    waker: Mutex<Option<Waker>>,
}

impl ConnectionState {
    pub(super) fn new() -> Self {
        Self {
            opened: Instant::now(),
            phase: AtomicU8::new(Phase::AwaitingHead as u8),
            awaiting_since_ms: AtomicU64::new(0),
            requests: AtomicU32::new(0),
            evicted: AtomicBool::new(false),
            waker: Mutex::new(None),
        }
    }

    pub(super) fn is_in(&self, phase: Phase) -> bool {
        self.phase.load(Ordering::Acquire) == phase as u8
    }

    pub(super) fn requests(&self) -> u32 {
        self.requests.load(Ordering::Relaxed)
    }

    pub(super) fn begin_request(&self, has_body: bool) {
        self.requests.fetch_add(1, Ordering::Relaxed);
        self.enter(if has_body { Phase::Receiving } else { Phase::Working });
    }

    /// Records that the body was read to its end or is no longer needed.
    pub(super) fn end_body(&self) {
        // The answer may have started before.
        let _ = self.phase.compare_exchange(Phase::Receiving as u8, Phase::Working as u8, Ordering::AcqRel, Ordering::Relaxed);
    }

    pub(super) fn begin_answer(&self) {
        self.enter(Phase::Answering);
    }

    pub(super) fn end_answer(&self) {
        // No truncation: 2^64 ms are half a billion years.
        let now = u64::try_from(self.opened.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.awaiting_since_ms.store(now, Ordering::Relaxed);
        self.enter(Phase::AwaitingHead);
    }

    fn enter(&self, phase: Phase) {
        self.phase.store(phase as u8, Ordering::Release);
    }

    /// The start of the wait for a head; `None` during a request, and before the connection's task has first read: a
    /// head may have arrived together with the connection.
    pub(super) fn awaiting_since(&self) -> Option<Instant> {
        let since = self.opened + Duration::from_millis(self.awaiting_since_ms.load(Ordering::Relaxed));
        (self.is_in(Phase::AwaitingHead) && self.waker().is_some()).then_some(since)
    }

    fn waker(&self) -> MutexGuard<'_, Option<Waker>> {
        self.waker.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Closes the connection if it still waits for a head when its task runs.
    pub(super) fn evict(&self) {
        self.evicted.store(true, Ordering::Release);
        if let Some(waker) = self.waker().take() {
            waker.wake();
        }
    }

    /// Whether the connection must close.
    pub(super) fn is_evicted(&self) -> bool {
        self.evicted.load(Ordering::Acquire)
    }

    /// Whether the connection must close. If not, the task is woken when it must.
    pub(super) fn poll_evicted(&self, context: &Context<'_>) -> bool {
        let mut waker = self.waker();
        if waker.as_ref().is_none_or(|waker| !waker.will_wake(context.waker())) {
            *waker = Some(context.waker().clone());
        }
        // Checked under the lock, so that no eviction is missed.
        self.is_evicted()
    }
}
