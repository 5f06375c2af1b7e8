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

use rayon::{ThreadPool, ThreadPoolBuilder};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::time::timeout;

use crate::cancellation::{CancelFlag, CancelOnDrop};

/// The largest number of threads for each permit. More would hardly reduce the time.
const MAX_THREADS_PER_REQUEST: usize = 8;

/// The largest number of recommendations and checks of paths that are computed at once.
const MAX_PLANS: usize = 4;

/// The largest number of files that are read at once. A thread waits for the data of its file, so that there are more
/// of them than cores.
const READERS: usize = 32;

/// The worker threads and the permits to use them. Clones share both.
#[derive(Debug, Clone)]
pub struct WorkerPool(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    /// The threads of free permits.
    free: Mutex<Vec<ThreadPool>>,
    permits: Arc<Semaphore>,
    /// The permits that recommendations and checks of paths may use. Each uses all cores, so that few suffice; batches find
    /// the others.
    plans: Arc<Semaphore>,
    /// The threads for short pieces, one for each core.
    pieces: ThreadPool,
    /// The threads on which files are read, and their permits.
    readers: ThreadPool,
    reader_permits: Arc<Semaphore>,
    threads_of_a_permit: usize,
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
        .start_handler(|_| lower_priority())
        .build()
        .map_err(std::io::Error::other)
}

impl WorkerPool {
    /// Permits for `most` requests at once, each with a thread for each core that the process may use.
    ///
    /// # Errors
    /// The system cannot start the threads.
    pub fn start(most: usize) -> std::io::Result<Self> {
        let cores = std::thread::available_parallelism()?.get();
        let threads_of_a_permit = cores.min(MAX_THREADS_PER_REQUEST);
        let free = (0..most).map(|_| threads("worker", threads_of_a_permit)).collect::<Result<_, _>>()?;
        let shared = Shared {
            free: Mutex::new(free),
            permits: Arc::new(Semaphore::new(most)),
            plans: Arc::new(Semaphore::new(most.div_ceil(2).min(MAX_PLANS))),
            pieces: threads("piece", cores)?,
            readers: threads("reader", READERS)?,
            reader_permits: Arc::new(Semaphore::new(READERS)),
            threads_of_a_permit,
        };
        Ok(Self(Arc::new(shared)))
    }

    /// A permit for one request; `None` if none becomes free within `longest`.
    pub async fn admit(&self, longest: Duration) -> Option<WorkPermit> {
        let permit = acquire(&self.0.permits, longest).await?;
        // A free permit always has free threads: `Drop` of `PermitThreads` returns the threads before the permit.
        let threads = self.0.free().pop();
        let held = PermitThreads { threads, _permit: permit, pool: self.clone() };
        Some(WorkPermit { held: Arc::new(held), cancel: CancelOnDrop::default() })
    }

    /// The right of a recommendation or of the check of a path to ask for a permit; `None` if none becomes free within `longest`.
    pub async fn admit_plan(&self, longest: Duration) -> Option<OwnedSemaphorePermit> {
        acquire(&self.0.plans, longest).await
    }

    /// The number of threads of a permit.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.0.threads_of_a_permit
    }

    /// Runs a piece of work of a few milliseconds, without a permit. Pieces run in the order of the calls. Dropping the
    /// future cancels the piece.
    pub async fn run_piece<T: Send + 'static>(&self, piece: impl FnOnce(&CancelFlag) -> T + Send + 'static) -> T {
        let dropped = CancelOnDrop::default();
        let cancel = CancelFlag::clone(&dropped);
        run_on(&self.0.pieces, (), move || piece(&cancel)).await
    }

    /// Runs `reading` on a thread that may wait for data; `None` if no thread becomes free within `longest`. Its source
    /// must end with an error when the future is dropped.
    pub async fn run_reader<T: Send + 'static>(&self, longest: Duration, reading: impl FnOnce() -> T + Send + 'static) -> Option<T> {
        let permit = acquire(&self.0.reader_permits, longest).await?;
        Some(run_on(&self.0.readers, permit, reading).await)
    }
}

async fn acquire(semaphore: &Arc<Semaphore>, longest: Duration) -> Option<OwnedSemaphorePermit> {
    timeout(longest, Arc::clone(semaphore).acquire_owned()).await.ok()?.ok()
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

/// The niceness of worker threads: the scheduler gives them a third of the weight of threads that serve connections.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 5;

/// Gives the calling thread a lower priority than the threads that serve connections have. If the system refuses, the
/// priority stays.
fn lower_priority() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::nice(NICENESS) {
        tracing::debug!(%error, "a thread keeps its priority");
    }
}
