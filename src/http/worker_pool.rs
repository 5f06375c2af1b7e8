//! Computations that take more than about a millisecond: they run on threads of their own, so that probes and single calculations
//! stay fast, and only so many requests have one at a time.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use axum::extract::{FromRef, FromRequestParts};
use axum::http::request::Parts;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

use super::layers::overloaded;
use super::metrics::{Metrics, ShedReason};

/// The threads for heavy work, one a core, and the places of the requests that may use them. Clones share both.
#[derive(Clone)]
pub struct WorkerPool {
    threads: Arc<rayon::ThreadPool>,
    places: Arc<Semaphore>,
    metrics: Metrics,
}

impl std::fmt::Debug for WorkerPool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WorkerPool").field("places", &self.places.available_permits()).finish_non_exhaustive()
    }
}

/// Every permit is taken: the request is to come back later.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shed;

impl std::fmt::Display for Shed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "as many uploads and batches as are accepted at once are being worked on")
    }
}

impl std::error::Error for Shed {}

impl axum::response::IntoResponse for Shed {
    fn into_response(self) -> axum::response::Response {
        overloaded(self.to_string())
    }
}

impl WorkerPool {
    /// Threads for as many cores as the process may use, and `places` requests at once.
    ///
    /// # Errors
    /// Where the system gives no threads.
    pub fn start(places: usize, metrics: &Metrics) -> std::io::Result<Self> {
        let threads =
            rayon::ThreadPoolBuilder::new().thread_name(|index| format!("heavy-{index}")).build().map_err(std::io::Error::other)?;
        Ok(Self { threads: Arc::new(threads), places: Arc::new(Semaphore::new(places)), metrics: metrics.clone() })
    }

    /// A permit for one request.
    ///
    /// # Errors
    /// [`Shed`] at once where none is free.
    pub fn admit(&self) -> Result<WorkPermit, Shed> {
        let Ok(permit) = Arc::clone(&self.places).try_acquire_owned() else {
            self.metrics.shed(ShedReason::Heavy);
            return Err(Shed);
        };
        Ok(WorkPermit { threads: Arc::clone(&self.threads), permit: Arc::new(permit) })
    }

    /// What `work` returns, done in a permit of its own.
    ///
    /// # Errors
    /// [`Shed`] at once where no permit is free.
    pub async fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Shed> {
        Ok(self.admit()?.run(work).await)
    }
}

/// One request's permit. As an argument of a handler, before the body, it is taken before the body is read; it is free again when the
/// request and all the work that it began have ended.
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
    /// What `work` returns, done on a thread for heavy work; parallel iterators in it use the other such threads. When the future is
    /// dropped, work that has not begun is not begun, and work that has ends first and keeps the permit until then. A panic in `work` goes
    /// on in the caller.
    pub async fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> T {
        let (sender, receiver) = oneshot::channel();
        let permit = Arc::clone(&self.permit);
        let span = tracing::Span::current();
        self.threads.spawn_fifo(move || {
            if sender.is_closed() {
                return;
            }
            let done = span.in_scope(|| catch_unwind(AssertUnwindSafe(work)));
            // Before the result is there, or the permit of an answered request would still be taken.
            drop(permit);
            // A receiver that is gone wants no result.
            let _ = sender.send(done);
        });
        match receiver.await {
            Ok(Ok(result)) => result,
            Ok(Err(panic)) => resume_unwind(panic),
            Err(_) => unreachable!("the sender lives until it has sent, as long as the receiver does"),
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for WorkPermit
where
    WorkerPool: FromRef<S>,
{
    type Rejection = Shed;

    async fn from_request_parts(_: &mut Parts, state: &S) -> Result<Self, Shed> {
        WorkerPool::from_ref(state).admit()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::time::Duration;

    use super::*;

    fn heavy(places: usize) -> WorkerPool {
        WorkerPool::start(places, &Metrics::new()).unwrap()
    }

    #[tokio::test]
    async fn work_is_done_on_other_threads_and_its_result_comes_back() {
        let here = std::thread::current().id();
        assert_ne!(heavy(1).run(move || std::thread::current().id()).await.unwrap(), here);
    }

    #[tokio::test]
    async fn a_request_without_a_place_is_shed_at_once_and_a_place_comes_free() {
        let heavy = heavy(1);
        let permit = heavy.admit().unwrap();
        assert_eq!(heavy.run(|| ()).await, Err(Shed));
        drop(permit);
        assert_eq!(heavy.run(|| 7).await, Ok(7));
    }

    #[tokio::test]
    async fn work_that_nobody_waits_for_keeps_its_place_until_it_ends() {
        let heavy = heavy(1);
        let (begin, begun) = mpsc::channel();
        let (release, wait) = mpsc::channel::<()>();
        let work = move || {
            begin.send(()).unwrap();
            wait.recv().unwrap();
        };
        let task = tokio::spawn({
            let heavy = heavy.clone();
            async move { heavy.run(work).await }
        });
        tokio::task::spawn_blocking(move || begun.recv().unwrap()).await.unwrap();
        task.abort();
        assert!(task.await.unwrap_err().is_cancelled());
        assert_eq!(heavy.admit().unwrap_err(), Shed);
        release.send(()).unwrap();
        let mut waited = 0;
        while heavy.admit().is_err() {
            tokio::time::sleep(Duration::from_millis(5)).await;
            waited += 1;
            assert!(waited < 2000, "the permit did not come free in ten seconds");
        }
    }

    #[tokio::test]
    async fn a_panic_goes_on_in_the_caller_and_leaves_the_threads_alive() {
        let heavy = heavy(1);
        let panicked = tokio::spawn({
            let heavy = heavy.clone();
            async move { heavy.run(|| panic!("on purpose")).await }
        });
        assert!(panicked.await.unwrap_err().is_panic());
        assert_eq!(heavy.run(|| 7).await, Ok(7));
    }
}
