//! The table of open connections: it bounds their number and closes idle ones to make room for new ones.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

use super::state::ConnectionState;

/// The number of connections accepted beyond the limit if none is idle. Each serves one request, so that probes are
/// always answered.
const RESERVE: usize = 32;

/// The longest time for an evicted connection to close.
const EVICTION: Duration = Duration::from_millis(50);

/// At the limit, one sixteenth of the connections is closed at a time, because each search for idle ones visits all of
/// them.
const EVICTED_PART: usize = 16;

/// All open connections. Clones share it.
#[derive(Debug, Clone)]
pub(super) struct ConnectionTable(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    permits: Arc<Semaphore>,
    reserve: Arc<Semaphore>,
    open: Mutex<Open>,
}

#[derive(Debug, Default)]
struct Open {
    next: u64,
    connections: HashMap<u64, Arc<ConnectionState>>,
}

/// One connection's entry, which is removed when this is dropped.
#[derive(Debug)]
pub(super) struct Entry {
    table: ConnectionTable,
    key: u64,
    state: Arc<ConnectionState>,
    is_in_reserve: bool,
    _permit: Option<OwnedSemaphorePermit>,
}

impl Entry {
    pub(super) fn state(&self) -> &Arc<ConnectionState> {
        &self.state
    }

    /// Whether the connection is beyond the limit and closes after one request.
    pub(super) fn is_in_reserve(&self) -> bool {
        self.is_in_reserve
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        self.table.open().connections.remove(&self.key);
    }
}

impl ConnectionTable {
    pub(super) fn new(most: usize) -> Self {
        let (permits, reserve) = (Arc::new(Semaphore::new(most)), Arc::new(Semaphore::new(RESERVE)));
        Self(Arc::new(Shared { permits, reserve, open: Mutex::default() }))
    }

    fn open(&self) -> MutexGuard<'_, Open> {
        self.0.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The number of open connections.
    pub(super) fn count(&self) -> usize {
        self.open().connections.len()
    }

    /// An entry for a new connection. At the limit, idle connections are closed; if none is idle, the entry is taken
    /// from the reserve; if the reserve is used up, the connection waits.
    pub(super) async fn enter(&self) -> Entry {
        let permits = || Arc::clone(&self.0.permits);
        if let Ok(permit) = permits().try_acquire_owned() {
            return self.add(Some(permit), false);
        }
        if self.evict_idle()
            && let Ok(Ok(permit)) = timeout(EVICTION, permits().acquire_owned()).await
        {
            return self.add(Some(permit), false);
        }
        tokio::select! {
            biased;
            Ok(permit) = Arc::clone(&self.0.reserve).acquire_owned() => self.add(Some(permit), true),
            Ok(permit) = permits().acquire_owned() => self.add(Some(permit), false),
            else => unreachable!("the semaphores are never closed"),
        }
    }

    /// An entry for a connection accepted while the server stops, whose request must not be lost.
    pub(super) fn enter_beyond_limit(&self) -> Entry {
        self.add(None, true)
    }

    fn add(&self, permit: Option<OwnedSemaphorePermit>, is_in_reserve: bool) -> Entry {
        let state = Arc::new(ConnectionState::new());
        let mut open = self.open();
        let key = open.next;
        open.next += 1;
        open.connections.insert(key, Arc::clone(&state));
        Entry { table: self.clone(), key, state, is_in_reserve, _permit: permit }
    }

    /// Closes the connections that have waited longest for a head; false if none waits.
    fn evict_idle(&self) -> bool {
        let open = self.open();
        let mut idle: Vec<_> = open.connections.values().filter_map(|state| Some((state.awaiting_since()?, state))).collect();
        if idle.is_empty() {
            return false;
        }
        let evicted = (open.connections.len() / EVICTED_PART).clamp(1, idle.len());
        idle.select_nth_unstable_by_key(evicted - 1, |(since, _)| *since);
        idle[..evicted].iter().for_each(|(_, state)| state.evict());
        tracing::debug!(connections = evicted, "idle connections are closed for new ones");
        true
    }
}
