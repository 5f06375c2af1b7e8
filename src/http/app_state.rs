//! The application state: what requests share while the service runs. It holds no result: the service has no state of its own.

use axum::extract::FromRef;

use super::metrics::Metrics;
use super::readiness::Readiness;
use super::worker_pool::WorkerPool;
use crate::settings::HttpSettings;

/// Handles shared by all requests; a clone is the same handles.
#[derive(Debug, Clone)]
pub struct AppState {
    /// What is counted.
    pub metrics: Metrics,
    /// Whether requests are still wanted.
    pub readiness: Readiness,
    /// The threads and places for uploads and batches.
    pub workers: WorkerPool,
}

impl AppState {
    /// The state within the settings' bounds.
    ///
    /// # Errors
    /// Where the system gives no threads.
    pub fn start(settings: &HttpSettings) -> std::io::Result<Self> {
        let metrics = Metrics::new();
        let workers = WorkerPool::start(settings.max_heavy, &metrics)?;
        Ok(Self { metrics, readiness: Readiness::default(), workers })
    }
}

impl FromRef<AppState> for Metrics {
    fn from_ref(state: &AppState) -> Self {
        state.metrics.clone()
    }
}

impl FromRef<AppState> for Readiness {
    fn from_ref(state: &AppState) -> Self {
        state.readiness.clone()
    }
}

impl FromRef<AppState> for WorkerPool {
    fn from_ref(state: &AppState) -> Self {
        state.workers.clone()
    }
}
