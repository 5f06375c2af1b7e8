//! What requests share while the service runs. It holds no result: the service has no state of its own.

use axum::extract::FromRef;

use super::heavy::Heavy;
use super::metrics::Metrics;
use super::readiness::Readiness;
use crate::settings::HttpSettings;

/// Handles to what requests share; a clone is the same handles.
#[derive(Debug, Clone)]
pub struct Operations {
    /// What is counted.
    pub metrics: Metrics,
    /// Whether requests are still wanted.
    pub readiness: Readiness,
    /// The threads and places for uploads and batches.
    pub heavy: Heavy,
}

impl Operations {
    /// Operations within the settings' bounds.
    ///
    /// # Errors
    /// Where the system gives no threads.
    pub fn start(settings: &HttpSettings) -> std::io::Result<Self> {
        let metrics = Metrics::new();
        let heavy = Heavy::start(settings.max_heavy, &metrics)?;
        Ok(Self { metrics, readiness: Readiness::default(), heavy })
    }
}

impl FromRef<Operations> for Metrics {
    fn from_ref(operations: &Operations) -> Self {
        operations.metrics.clone()
    }
}

impl FromRef<Operations> for Readiness {
    fn from_ref(operations: &Operations) -> Self {
        operations.readiness.clone()
    }
}

impl FromRef<Operations> for Heavy {
    fn from_ref(operations: &Operations) -> Self {
        operations.heavy.clone()
    }
}
