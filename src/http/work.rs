//! A request's access to the worker pool and to the memory budget.

use std::time::Duration;

use axum::extract::FromRequestParts;
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use tokio::time::Instant;

use super::json_body::WrittenJson;
use super::metrics::Metrics;
use super::overload::Overload;
use super::problem::Problem;
use crate::budget::{Budget, Job, LONGEST_WAIT, LONGEST_WAIT_OF_PLAN};
use crate::cancellation::CancelFlag;
use crate::worker_pool::{WorkPermit, WorkerPool};

/// One request's access to the worker pool and to the memory budget, for handlers of routes whose class uses workers.
#[derive(Debug, Clone)]
pub struct Work {
    workers: WorkerPool,
    budget: Budget,
    metrics: Metrics,
    /// Whether the client accepts compressed answers.
    compresses: bool,
}

impl Work {
    pub(crate) fn new(workers: WorkerPool, budget: Budget, metrics: Metrics) -> Self {
        Self { workers, budget, metrics, compresses: false }
    }

    /// Work whose answers are compressed, or not.
    pub(crate) fn compressing(self, compresses: bool) -> Self {
        Self { compresses, ..self }
    }

    /// A permit, for which the request waits at most `longest`.
    async fn admit(&self, longest: Duration) -> Result<WorkPermit, Overload> {
        self.workers.admit(longest).await.ok_or_else(|| self.refuse())
    }

    /// Counts a request that gets no permit.
    fn refuse(&self) -> Overload {
        self.metrics.shed(Overload::Workers);
        Overload::Workers
    }

    /// Runs `work` with a permit. Call it when the body has arrived, so that a slow client does not occupy a permit.
    ///
    /// # Errors
    /// [`Overload::Workers`] if no permit becomes free.
    pub async fn run<T: Send + 'static>(&self, work: impl FnOnce(&CancelFlag) -> T + Send + 'static) -> Result<T, Overload> {
        Ok(self.admit(LONGEST_WAIT).await?.run(work).await)
    }

    /// The answer that `compute` writes on a worker. It waits for the memory of `job`, then for a permit. The answer is
    /// compressed before the permit is returned, and holds its memory until it is sent.
    ///
    /// # Errors
    /// [`Overload`] as a problem, or the problem of `compute`.
    pub(crate) async fn answer(
        &self,
        job: Job,
        compute: impl FnOnce(&CancelFlag) -> Result<WrittenJson, Problem> + Send + 'static,
    ) -> Result<WrittenJson, Problem> {
        let is_plan = matches!(job, Job::Plan { .. } | Job::PathCheck { .. });
        let deadline = Instant::now() + if is_plan { LONGEST_WAIT_OF_PLAN } else { LONGEST_WAIT };
        let left = || deadline.saturating_duration_since(Instant::now());
        let plan = if is_plan { Some(self.workers.admit_plan(left()).await.ok_or_else(|| self.refuse())?) } else { None };
        let held = self.budget.take(job, left()).await?;
        let permit = self.admit(left()).await?;
        let compresses = self.compresses;
        let work = move |cancelled: &CancelFlag| {
            let _plan = plan;
            Ok(compute(cancelled)?.compressed(compresses, cancelled).holding(held))
        };
        permit.run(work).await
    }

    /// The number of threads of a permit.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.workers.threads()
    }

    /// Runs a piece of work of a few milliseconds, without a permit, as [`WorkerPool::run_piece`].
    pub async fn run_piece<T: Send + 'static>(&self, piece: impl FnOnce(&CancelFlag) -> T + Send + 'static) -> T {
        self.workers.run_piece(piece).await
    }

    /// Runs `reading`, which may wait for data, as [`WorkerPool::run_reader`].
    ///
    /// # Errors
    /// [`Overload::Workers`] if no thread becomes free.
    pub(crate) async fn run_reader<T: Send + 'static>(&self, reading: impl FnOnce() -> T + Send + 'static) -> Result<T, Overload> {
        self.workers.run_reader(LONGEST_WAIT_OF_PLAN, reading).await.ok_or_else(|| self.refuse())
    }

    /// The memory budget.
    #[must_use]
    pub fn budget(&self) -> &Budget {
        &self.budget
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Work {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Response> {
        // The middleware adds this extension to requests for routes whose class uses workers.
        parts.extensions.get::<Self>().cloned().ok_or_else(|| {
            tracing::error!("the route's class does not include the worker pool");
            StatusCode::INTERNAL_SERVER_ERROR.into_response()
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    fn work(permits: usize) -> Work {
        let budget = Budget::new(1 << 26);
        Work::new(WorkerPool::start(permits).unwrap(), budget.clone(), Metrics::new(&budget))
    }

    #[tokio::test]
    async fn work_runs_on_other_threads_and_returns_its_result() {
        let here = std::thread::current().id();
        assert_ne!(work(1).run(move |_| std::thread::current().id()).await.unwrap(), here);
        assert_ne!(work(1).run_piece(move |_| std::thread::current().id()).await, here);
    }

    #[tokio::test]
    async fn a_request_without_a_permit_is_shed_and_a_dropped_permit_is_free() {
        let work = work(1);
        let permit = work.admit(Duration::ZERO).await.unwrap();
        assert_eq!(work.run(|_| ()).await, Err(Overload::Workers));
        // Short pieces need no permit.
        assert_eq!(work.run_piece(|_| 7).await, 7);
        drop(permit);
        assert_eq!(work.run(|_| 7).await, Ok(7));
    }

    #[tokio::test]
    async fn a_request_waits_for_a_permit_that_becomes_free() {
        let work = work(1);
        let permit = work.admit(Duration::ZERO).await.unwrap();
        let (result, ()) = tokio::join!(work.run(|_| 7), async { drop(permit) });
        assert_eq!(result, Ok(7));
    }

    /// Work that ends when it is cancelled, and when it begins and ends.
    fn endless() -> (impl FnOnce(&CancelFlag) + Send + 'static, mpsc::Receiver<()>, mpsc::Receiver<Instant>) {
        let (begin, begun) = mpsc::channel();
        let (end, ended) = mpsc::channel();
        let work = move |cancel: &CancelFlag| {
            begin.send(()).unwrap();
            while !cancel.is_cancelled() {
                std::thread::yield_now();
            }
            end.send(Instant::now()).unwrap();
        };
        (work, begun, ended)
    }

    /// What is sent, waited for on another thread.
    async fn received<T: Send + 'static>(receiver: mpsc::Receiver<T>) -> T {
        tokio::task::spawn_blocking(move || receiver.recv_timeout(Duration::from_secs(30)).unwrap()).await.unwrap()
    }

    #[tokio::test]
    async fn work_of_a_dropped_future_is_cancelled_and_keeps_its_permit_until_it_ends() {
        let work = work(1);
        let (endless, begun, ended) = endless();
        let task = tokio::spawn({
            let work = work.clone();
            async move { work.run(endless).await }
        });
        received(begun).await;
        assert_eq!(work.admit(Duration::ZERO).await.unwrap_err(), Overload::Workers);
        let dropped = Instant::now();
        task.abort();
        assert!(task.await.unwrap_err().is_cancelled());
        let ended = received(ended).await;
        // The cancellation takes microseconds, but a loaded machine may schedule the thread late.
        assert!(ended - dropped < Duration::from_secs(5), "{:?}", ended - dropped);
        assert!(work.admit(Duration::from_secs(10)).await.is_ok());
    }

    #[tokio::test]
    async fn a_piece_of_a_dropped_future_is_cancelled() {
        let work = work(1);
        let (endless, begun, ended) = endless();
        let task = tokio::spawn(async move { work.run_piece(endless).await });
        received(begun).await;
        task.abort();
        received(ended).await;
    }

    #[tokio::test]
    async fn a_panic_continues_in_the_caller_and_leaves_the_threads_alive() {
        let work = work(1);
        let panicked = tokio::spawn({
            let work = work.clone();
            async move { work.run(|_| panic!("on purpose")).await }
        });
        assert!(panicked.await.unwrap_err().is_panic());
        assert_eq!(work.run(|_| 7).await, Ok(7));
    }

    #[tokio::test]
    async fn requests_run_side_by_side() {
        let work = work(2);
        let (send, receive) = mpsc::channel::<()>();
        // As many tasks as a request has threads wait for the other request.
        let waiting = work.run(move |_| receive.recv().is_ok());
        let other = work.run(move |_| send.send(()).is_ok());
        assert_eq!(tokio::join!(waiting, other), (Ok(true), Ok(true)));
    }
}
