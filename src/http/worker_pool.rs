//! The worker pool: threads for computations of more than about a millisecond, so that probes and single calculations stay fast, and
//! permits that bound how many requests use them at once.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use axum::extract::FromRequestParts;
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

use super::metrics::Metrics;
use super::overload::Overload;

/// The worker threads, one for each core, and the permits to use them. Clones share both.
#[derive(Clone)]
pub struct WorkerPool {
    threads: Arc<rayon::ThreadPool>,
    permits: Arc<Semaphore>,
    metrics: Metrics,
}

impl std::fmt::Debug for WorkerPool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WorkerPool").field("free_permits", &self.permits.available_permits()).finish_non_exhaustive()
    }
}

impl WorkerPool {
    /// Threads for as many cores as the process may use, and permits for `most` requests at once.
    ///
    /// # Errors
    /// The system starts no threads.
    pub fn start(most: usize, metrics: &Metrics) -> std::io::Result<Self> {
        let threads =
            rayon::ThreadPoolBuilder::new().thread_name(|index| format!("worker-{index}")).build().map_err(std::io::Error::other)?;
        Ok(Self { threads: Arc::new(threads), permits: Arc::new(Semaphore::new(most)), metrics: metrics.clone() })
    }

    /// A permit for one request.
    ///
    /// # Errors
    /// [`Overload::Workers`], at once, when none is free.
    pub fn admit(&self) -> Result<WorkPermit, Overload> {
        let Ok(permit) = Arc::clone(&self.permits).try_acquire_owned() else {
            self.metrics.shed(Overload::Workers);
            return Err(Overload::Workers);
        };
        Ok(WorkPermit { threads: Arc::clone(&self.threads), permit: Arc::new(permit) })
    }
}

/// One request's permit. As a handler's argument before the body it is taken before the body is read. It is free again when the request
/// and all the work that it began have ended.
pub struct WorkPermit {
    threads: Arc<rayon::ThreadPool>,
    permit: Arc<OwnedSemaphorePermit>,
}

impl std::fmt::Debug for WorkPermit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WorkPermit").finish_non_exhaustive()
    }
}

impl WorkPermit {
    /// Runs `work` on a worker thread; parallel iterators in it use the other worker threads. Dropping the future cancels queued work;
    /// running work completes and keeps the permit until then. A panic in `work` continues in the caller.
    pub async fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> T {
        let (sender, receiver) = oneshot::channel();
        let permit = Arc::clone(&self.permit);
        let span = tracing::Span::current();
        self.threads.spawn_fifo(move || {
            if sender.is_closed() {
                return;
            }
            let done = span.in_scope(|| catch_unwind(AssertUnwindSafe(work)));
            // Before the result is sent: the permit of an answered request must be free.
            drop(permit);
            // Without a receiver there is nobody to answer.
            let _ = sender.send(done);
        });
        match receiver.await {
            Ok(Ok(result)) => result,
            Ok(Err(panic)) => resume_unwind(panic),
            Err(_) => unreachable!("the sender lives until it has sent, as long as the receiver does"),
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for WorkPermit {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Response> {
        // The middleware adds the pool to requests for routes whose class allows its use.
        let Some(workers) = parts.extensions.get::<WorkerPool>() else {
            tracing::error!("the route's class does not include the worker pool");
            return Err(StatusCode::INTERNAL_SERVER_ERROR.into_response());
        };
        workers.admit().map_err(IntoResponse::into_response)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::time::Duration;

    use super::*;

    fn workers(permits: usize) -> WorkerPool {
        WorkerPool::start(permits, &Metrics::new()).unwrap()
    }

    #[tokio::test]
    async fn work_runs_on_other_threads_and_returns_its_result() {
        let here = std::thread::current().id();
        assert_ne!(workers(1).admit().unwrap().run(move || std::thread::current().id()).await, here);
    }

    #[tokio::test]
    async fn a_request_without_a_permit_is_shed_at_once_and_a_dropped_permit_is_free() {
        let workers = workers(1);
        let permit = workers.admit().unwrap();
        assert_eq!(workers.admit().unwrap_err(), Overload::Workers);
        drop(permit);
        assert_eq!(workers.admit().unwrap().run(|| 7).await, 7);
    }

    #[tokio::test]
    async fn work_of_a_dropped_future_keeps_its_permit_until_it_ends() {
        let workers = workers(1);
        let (begin, begun) = mpsc::channel();
        let (release, wait) = mpsc::channel::<()>();
        let work = move || {
            begin.send(()).unwrap();
            wait.recv().unwrap();
        };
        let task = tokio::spawn({
            let permit = workers.admit().unwrap();
            async move { permit.run(work).await }
        });
        tokio::task::spawn_blocking(move || begun.recv().unwrap()).await.unwrap();
        task.abort();
        assert!(task.await.unwrap_err().is_cancelled());
        assert_eq!(workers.admit().unwrap_err(), Overload::Workers);
        release.send(()).unwrap();
        let mut waited = 0;
        while workers.admit().is_err() {
            tokio::time::sleep(Duration::from_millis(5)).await;
            waited += 1;
            assert!(waited < 2000, "the permit did not come free in ten seconds");
        }
    }

    #[tokio::test]
    async fn a_panic_continues_in_the_caller_and_leaves_the_threads_alive() {
        let workers = workers(1);
        let panicked = tokio::spawn({
            let permit = workers.admit().unwrap();
            async move { permit.run(|| panic!("on purpose")).await }
        });
        assert!(panicked.await.unwrap_err().is_panic());
        assert_eq!(workers.admit().unwrap().run(|| 7).await, 7);
    }
}
