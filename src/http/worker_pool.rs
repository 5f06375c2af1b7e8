//! The worker pool: threads for computations that take more than about a millisecond, so that probes and single
//! calculations stay fast.
//!
//! A whole computation needs a permit, of which there are few. Each permit has its own threads, so that the kernel
//! divides the cores between requests and a short batch does not wait for a long one. Tasks of a few milliseconds, such
//! as a block of an upload, need no permit; they run in turn on threads that all requests share. Worker threads have a
//! lower priority than the threads that serve connections.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::extract::FromRequestParts;
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use rayon::{ThreadPool, ThreadPoolBuilder};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::time::{Instant, timeout, timeout_at};

use super::metrics::Metrics;
use super::overload::Overload;
use super::problem::Problem;
use crate::cancellation::{CancelFlag, CancelOnDrop};
use crate::memory_budget::{BudgetExceeded, MemoryBudget, Reservation};
use crate::priority;

/// The largest number of threads for each permit. More would hardly reduce the time.
const MAX_THREADS_PER_REQUEST: usize = 8;

/// The worker threads and the permits to use them. Clones share both.
#[derive(Debug, Clone)]
pub struct WorkerPool(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    /// The threads of free permits.
    free: Mutex<Vec<ThreadPool>>,
    permits: Arc<Semaphore>,
    /// The permits that recommendations may use: half of all. That many at once keep all cores busy, and batches still
    /// find a permit.
    plans: Arc<Semaphore>,
    /// The threads for short pieces, one for each core.
    pieces: ThreadPool,
    threads_of_a_permit: usize,
    metrics: Metrics,
}

impl Shared {
    fn free(&self) -> MutexGuard<'_, Vec<ThreadPool>> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn threads(name: &'static str, count: usize) -> std::io::Result<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(count)
        .thread_name(move |index| format!("{name}-{index}"))
        .start_handler(|_| priority::lower())
        .build()
        .map_err(std::io::Error::other)
}

impl WorkerPool {
    /// Permits for `most` requests at once, each with a thread for each core that the process may use.
    ///
    /// # Errors
    /// The system cannot start the threads.
    pub fn start(most: usize, metrics: &Metrics) -> std::io::Result<Self> {
        let cores = std::thread::available_parallelism()?.get();
        let threads_of_a_permit = cores.min(MAX_THREADS_PER_REQUEST);
        let free = (0..most).map(|_| threads("worker", threads_of_a_permit)).collect::<Result<_, _>>()?;
        let shared = Shared {
            free: Mutex::new(free),
            permits: Arc::new(Semaphore::new(most)),
            plans: Arc::new(Semaphore::new(most.div_ceil(2))),
            pieces: threads("piece", cores)?,
            threads_of_a_permit,
            metrics: metrics.clone(),
        };
        Ok(Self(Arc::new(shared)))
    }

    /// A permit for one request. Waits at most `longest` for one to become free.
    ///
    /// # Errors
    /// [`Overload::Workers`] if none becomes free.
    pub async fn admit(&self, longest: Duration) -> Result<WorkPermit, Overload> {
        let permit = self.acquire(&self.0.permits, longest).await?;
        // A free permit always has free threads: `Drop` of `PermitThreads` returns the threads before the permit.
        let threads = self.0.free().pop();
        let held = PermitThreads { threads, _permit: permit, pool: self.clone() };
        Ok(WorkPermit { held: Arc::new(held), cancel: CancelOnDrop::default() })
    }

    async fn acquire(&self, semaphore: &Arc<Semaphore>, longest: Duration) -> Result<OwnedSemaphorePermit, Overload> {
        let Ok(Ok(permit)) = timeout(longest, Arc::clone(semaphore).acquire_owned()).await else {
            self.0.metrics.shed(Overload::Workers);
            return Err(Overload::Workers);
        };
        Ok(permit)
    }
}

/// The threads of one permit, which return to the pool when this is dropped.
#[derive(Debug)]
struct PermitThreads {
    threads: Option<ThreadPool>,
    _permit: OwnedSemaphorePermit,
    pool: WorkerPool,
}

impl Drop for PermitThreads {
    // The fields, and with them the permit, are dropped after this.
    fn drop(&mut self) {
        self.pool.0.free().extend(self.threads.take());
    }
}

/// One request's permit and its threads. Dropping it cancels the work; the threads become free when the work has ended.
#[derive(Debug)]
pub struct WorkPermit {
    held: Arc<PermitThreads>,
    cancel: CancelOnDrop,
}

impl WorkPermit {
    /// Runs `work` on a thread of the permit; parallel iterators in it use the permit's other threads. `work` gets a
    /// flag that is set when the future is dropped. A panic in `work` continues in the caller.
    pub async fn run<T: Send + 'static>(self, work: impl FnOnce(&CancelFlag) -> T + Send + 'static) -> T {
        let held = Arc::clone(&self.held);
        let cancel = CancelFlag::clone(&self.cancel);
        let threads = self.held.threads.as_ref().unwrap_or_else(|| unreachable!("each permit has threads"));
        run_on(threads, held, move || work(&cancel)).await
    }
}

/// Runs `work` on one of `threads` and drops `held` before it returns the result.
async fn run_on<T, H>(threads: &ThreadPool, held: H, work: impl FnOnce() -> T + Send + 'static) -> T
where
    T: Send + 'static,
    H: Send + 'static,
{
    let (sender, receiver) = oneshot::channel();
    let span = tracing::Span::current();
    threads.spawn_fifo(move || {
        if sender.is_closed() {
            return;
        }
        let done = span.in_scope(|| catch_unwind(AssertUnwindSafe(work)));
        // Dropped before the result is sent, because the permit of an answered request must be free.
        drop(held);
        // If the receiver is gone, the result is not needed.
        let _ = sender.send(done);
    });
    match receiver.await {
        Ok(Ok(result)) => result,
        Ok(Err(panic)) => resume_unwind(panic),
        Err(_) => unreachable!("the sender sends before it is dropped, and the receiver exists"),
    }
}

/// One request's access to the worker pool and to the memory budget, for handlers of routes whose class uses workers.
#[derive(Debug, Clone)]
pub struct Work {
    workers: WorkerPool,
    budget: MemoryBudget,
}

impl Work {
    /// The longest time that a request whose body has arrived waits for a permit. Permits are held for milliseconds
    /// unless the load persists.
    const LONGEST_WAIT: Duration = Duration::from_millis(500);

    /// The longest time that an upload or a recommendation waits. After a refusal, a client would have to send its file
    /// again. Of dozens of recommendations at the same time, each of some 0.1 s, the last waits a few seconds.
    pub(crate) const LONGEST_WAIT_OF_PLAN: Duration = Duration::from_secs(20);

    pub(crate) fn new(workers: WorkerPool, budget: MemoryBudget) -> Self {
        Self { workers, budget }
    }

    /// Runs `work` with a permit. Call it when the body has arrived, so that a slow client does not occupy a permit.
    ///
    /// # Errors
    /// [`Overload::Workers`] if no permit becomes free.
    pub async fn run<T: Send + 'static>(&self, work: impl FnOnce(&CancelFlag) -> T + Send + 'static) -> Result<T, Overload> {
        Ok(self.workers.admit(Self::LONGEST_WAIT).await?.run(work).await)
    }

    /// The same for the work that follows an upload.
    ///
    /// # Errors
    /// [`Overload::Workers`] if no permit becomes free.
    pub async fn run_after_upload<T: Send + 'static>(&self, work: impl FnOnce(&CancelFlag) -> T + Send + 'static) -> Result<T, Overload> {
        Ok(self.workers.admit(Self::LONGEST_WAIT_OF_PLAN).await?.run(work).await)
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
                let plan = self.workers.acquire(&self.workers.0.plans, left()).await?;
                let permit = self.workers.admit(left()).await?;
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

    /// Runs `work` on `count` new threads instead of the permit's, because each thread takes memory.
    ///
    /// # Errors
    /// The system cannot start the threads.
    pub fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> std::io::Result<T> {
        if count >= rayon::current_num_threads() { Ok(work()) } else { Ok(threads("few", count)?.install(work)) }
    }

    /// The number of threads of a permit.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.workers.0.threads_of_a_permit
    }

    /// Runs a piece of work of a few milliseconds, without a permit. Pieces run in the order of the calls. Dropping the
    /// future cancels a piece that has not started.
    pub async fn run_piece<T: Send + 'static>(&self, piece: impl FnOnce() -> T + Send + 'static) -> T {
        run_on(&self.workers.0.pieces, (), piece).await
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
        Work::new(WorkerPool::start(permits, &Metrics::new(&MemoryBudget::new(1))).unwrap(), MemoryBudget::new(1))
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
        let permit = work.workers.admit(Duration::ZERO).await.unwrap();
        assert_eq!(work.run(|_| ()).await, Err(Overload::Workers));
        // Short pieces need no permit.
        assert_eq!(work.run_piece(|| 7).await, 7);
        drop(permit);
        assert_eq!(work.run(|_| 7).await, Ok(7));
    }

    #[tokio::test]
    async fn a_request_waits_for_a_permit_that_becomes_free() {
        let work = work(1);
        let permit = work.workers.admit(Duration::ZERO).await.unwrap();
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
        assert_eq!(work.workers.admit(Duration::ZERO).await.unwrap_err(), Overload::Workers);
        let dropped = Instant::now();
        task.abort();
        assert!(task.await.unwrap_err().is_cancelled());
        let ended = tokio::task::spawn_blocking(move || ended.recv().unwrap()).await.unwrap();
        // The cancellation takes microseconds, but a loaded machine may schedule the thread late.
        assert!(ended - dropped < Duration::from_secs(5), "{:?}", ended - dropped);
        assert!(work.workers.admit(Duration::from_secs(10)).await.is_ok());
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
