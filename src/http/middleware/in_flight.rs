//! The limit on requests in flight. Requests beyond it are rejected, not queued, because a queue would delay every
//! request.

use std::sync::Arc;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::http::metrics::Metrics;
use crate::http::overload::Overload;

/// Permits for requests in flight. Clones share them.
#[derive(Clone)]
pub(super) struct InFlight {
    permits: Arc<Semaphore>,
    metrics: Metrics,
}

impl InFlight {
    pub(super) fn new(most: usize, metrics: Metrics) -> Self {
        Self { permits: Arc::new(Semaphore::new(most)), metrics }
    }

    /// The permit that a request holds until its answer is ready to be sent.
    pub(super) fn admit(&self) -> Result<OwnedSemaphorePermit, Overload> {
        Arc::clone(&self.permits).try_acquire_owned().map_err(|_| {
            self.metrics.shed(Overload::InFlight);
            Overload::InFlight
        })
    }
}
