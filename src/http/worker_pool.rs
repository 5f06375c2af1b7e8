//! A request's access to the worker pool and to the memory budget.

use std::time::Duration;

use axum::extract::FromRequestParts;
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use tokio::time::{Instant, timeout_at};

use super::metrics::Metrics;
use super::overload::Overload;
use super::problem::Problem;
use crate::cancellation::CancelFlag;
use crate::memory_budget::{BudgetExceeded, MemoryBudget, Reservation};
use crate::worker_pool::{WorkPermit, WorkerPool};

/// One request's access to the worker pool and to the memory budget, for handlers of routes whose class uses workers.
#[derive(Debug, Clone)]
pub struct Work {
    workers: WorkerPool,
    budget: MemoryBudget,
    metrics: Metrics,
}

impl Work {
    /// The longest time that a request whose body has arrived waits for a permit. Permits are held for milliseconds
    /// unless the load persists.
    const LONGEST_WAIT: Duration = Duration::from_millis(500);

    /// The longest time that an upload or a recommendation waits. After a refusal, a client would have to send its file
    /// again. Of dozens of recommendations at the same time, each of some 0.1 s, the last waits a few seconds.
    pub(crate) const LONGEST_WAIT_OF_PLAN: Duration = Duration::from_secs(20);

    pub(crate) fn new(workers: WorkerPool, budget: MemoryBudget, metrics: Metrics) -> Self {
        Self { workers, budget, metrics }
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
        Ok(self.admit(Self::LONGEST_WAIT).await?.run(work).await)
    }

    /// The same for the work that follows an upload.
    ///
    /// # Errors
    /// [`Overload::Workers`] if no permit becomes free.
    pub async fn run_after_upload<T: Send + 'static>(&self, work: impl FnOnce(&CancelFlag) -> T + Send + 'static) -> Result<T, Overload> {
        Ok(self.admit(Self::LONGEST_WAIT_OF_PLAN).await?.run(work).await)
    }

    /// Runs `work` with a permit and with `bytes` more in `memory`, for both of which it waits at most `longest`.
    /// It holds no permit while it waits for memory, so that requests which need less can run.
    ///
    /// # Errors
    /// [`Overload`] as a problem to answer with.
    pub(crate) async fn run_with_memory<T: Send + 'static>(
        &self,
        mut memory: Reservation,
        bytes: u64,
        longest: Duration,
        work: impl FnOnce(Reservation, &CancelFlag) -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let deadline = Instant::now() + longest;
        let (permit, plan) = loop {
            // Registered before the attempt, so that bytes returned after it are not missed.
            let returned = self.budget.returned(bytes);
            let left = || deadline.saturating_duration_since(Instant::now());
            let needed = memory.bytes().saturating_add(bytes);
            // Dozens of requests may wait: only those whose memory is free ask for a permit.
            if memory.attainable() >= needed || needed > self.budget.largest() {
                let plan = self.workers.admit_plan(left()).await.ok_or_else(|| self.refuse())?;
                let permit = self.admit(left()).await?;
                match memory.try_grow(bytes) {
                    Ok(()) => break (permit, plan),
                    Err(BudgetExceeded::Always) => return Err(self.budget.refuse(BudgetExceeded::Always).into()),
                    Err(BudgetExceeded::Now) => drop((permit, plan)),
                }
            }
            if timeout_at(deadline, returned).await.is_err() {
                return Err(self.budget.refuse(BudgetExceeded::Now).into());
            }
        };
        let work = move |cancelled: &CancelFlag| {
            let result = work(memory, cancelled);
            drop(plan);
            result
        };
        Ok(permit.run(work).await)
    }

    /// The number of threads of a permit.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.workers.threads()
    }

    /// Runs a piece of work of a few milliseconds, without a permit, as [`WorkerPool::run_piece`].
    pub async fn run_piece<T: Send + 'static>(&self, piece: impl FnOnce() -> T + Send + 'static) -> T {
        self.workers.run_piece(piece).await
    }

    /// The memory budget.
    #[must_use]
    pub fn budget(&self) -> &MemoryBudget {
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
        let budget = MemoryBudget::new(1);
        Work::new(WorkerPool::start(permits).unwrap(), budget.clone(), Metrics::new(&budget))
    }

    #[tokio::test]
    async fn work_runs_on_other_threads_and_returns_its_result() {
        let here = std::thread::current().id();
        assert_ne!(work(1).run(move |_| std::thread::current().id()).await.unwrap(), here);
        assert_ne!(work(1).run_piece(move || std::thread::current().id()).await, here);
    }

    #[tokio::test]
    async fn a_request_without_a_permit_is_shed_and_a_dropped_permit_is_free() {
        let work = work(1);
        let permit = work.admit(Duration::ZERO).await.unwrap();
        assert_eq!(work.run(|_| ()).await, Err(Overload::Workers));
        // Short pieces need no permit.
        assert_eq!(work.run_piece(|| 7).await, 7);
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

    #[tokio::test]
    async fn work_of_a_dropped_future_is_cancelled_and_keeps_its_permit_until_it_ends() {
        let work = work(1);
        let (begin, begun) = mpsc::channel();
        let (end, ended) = mpsc::channel();
        let endless = move |cancel: &CancelFlag| {
            begin.send(()).unwrap();
            while !cancel.is_cancelled() {
                std::thread::yield_now();
            }
            end.send(Instant::now()).unwrap();
        };
        let task = tokio::spawn({
            let work = work.clone();
            async move { work.run(endless).await }
        });
        tokio::task::spawn_blocking(move || begun.recv().unwrap()).await.unwrap();
        assert_eq!(work.admit(Duration::ZERO).await.unwrap_err(), Overload::Workers);
        let dropped = Instant::now();
        task.abort();
        assert!(task.await.unwrap_err().is_cancelled());
        let ended = tokio::task::spawn_blocking(move || ended.recv().unwrap()).await.unwrap();
        // The cancellation takes microseconds, but a loaded machine may schedule the thread late.
        assert!(ended - dropped < Duration::from_secs(5), "{:?}", ended - dropped);
        assert!(work.admit(Duration::from_secs(10)).await.is_ok());
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
