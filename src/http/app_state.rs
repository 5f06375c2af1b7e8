//! The application state: the handles that all requests share. It has no results of requests.

use super::metrics::Metrics;
use super::readiness::Readiness;
use crate::budget::Budget;
use crate::settings::Settings;
use crate::worker_pool::WorkerPool;
use axum::extract::FromRef;

/// Handles shared by all requests; clones refer to the same objects.
#[derive(Debug, Clone, FromRef)]
pub struct AppState {
    /// The counters for `/metrics`.
    pub metrics: Metrics,
    /// Whether the service accepts requests or is draining.
    pub readiness: Readiness,
    /// The threads for uploads and batches.
    pub workers: WorkerPool,
    /// The memory budget for all data whose size a client determines.
    pub budget: Budget,
    /// The largest bodies in bytes.
    pub body_limits: BodyLimits,
}

/// The largest bodies in decompressed bytes, of JSON and of files.
#[derive(Debug, Clone, Copy)]
pub struct BodyLimits {
    /// Of JSON.
    pub json: u64,
    /// Of a form with files.
    pub upload: u64,
}

impl AppState {
    /// Creates the state with the bounds of `settings`.
    ///
    /// # Errors
    /// The system cannot start the threads.
    pub fn start(settings: &Settings) -> std::io::Result<Self> {
        let budget = Budget::new(settings.memory_budget);
        let metrics = Metrics::new(&budget);
        let workers = WorkerPool::start(settings.max_concurrent_work)?;
        let body_limits = BodyLimits { json: settings.max_json, upload: settings.max_upload };
        Ok(Self { metrics, readiness: Readiness::default(), workers, budget, body_limits })
    }
}
