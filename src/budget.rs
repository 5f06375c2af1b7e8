//! The memory budget: what one request may cost, and where that is decided.
//!
//! The budget is two semaphores in MiB: `inputs` for what clients send, `work` for what is computed from it. A request
//! takes its share of each before it begins, by the formula of its [`Job`], and holds it until its answer is sent. The
//! formulas are near what is used, not bounds to the byte; a request that would need more than a semaphore has takes
//! all of it, so that every request can be answered when its turn comes.
//!
//! Recommendations and checks of paths use at most three quarters of the work, however many wait: batches find the rest.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, timeout_at};

const MIB: u64 = 1 << 20;

/// The largest input in bytes that needs no share: the requests in flight bound the memory of small ones.
pub(crate) const FREE_INPUT: u64 = 64 * 1024;

/// The largest batch in bytes that needs no share, so that it does not wait behind long ones: the permits for work bound
/// their memory.
const FREE_BATCH: u64 = 2 * MIB;

/// The longest time that a body, a batch or another request waits for memory and for a permit. Dozens of batches sent
/// at the same time are answered within it.
pub(crate) const LONGEST_WAIT: Duration = Duration::from_secs(5);

/// The longest time that an upload, a recommendation or the check of a path waits. After a refusal, a client would have to
/// send its file again. Of dozens of recommendations at the same time, each of some 0.1 s, the last waits a few seconds.
pub(crate) const LONGEST_WAIT_OF_PLAN: Duration = Duration::from_secs(20);

/// A kind of job with the figures that determine its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Job {
    /// A body of this many bytes, which is collected before it is read.
    Body {
        /// The bytes of the body, decompressed.
        bytes: u64,
    },
    /// A form with a surface file, which is read as it arrives.
    Upload {
        /// The bytes of the form; the largest number if they are unknown.
        bytes: u64,
    },
    /// A calculation at many contacts.
    Batch {
        /// The number of contacts.
        contacts: usize,
    },
    /// A recommendation.
    Plan {
        /// The bytes of JSON from which the surface is still to be read; 0 for a file, which has been read.
        json: usize,
        /// The number of facets, or what is known of it.
        facets: usize,
        /// The number of cutters.
        cutters: usize,
        /// The threads that compute it.
        threads: usize,
    },
    /// The check of a path on a surface.
    PathCheck {
        /// The bytes of JSON that are still to be read.
        json: usize,
        /// The number of facets, or what is known of it.
        facets: usize,
        /// The number of points of the path, or what is known of it.
        points: usize,
        /// The threads that compute it.
        threads: usize,
    },
}

impl Job {
    /// The memory of the job in bytes.
    ///
    /// | job | bytes |
    /// |---|---|
    /// | body | its length |
    /// | upload | its length up to 56 MiB for facets, and twice its length up to 128 MiB for vertices |
    /// | batch | 1 MiB, and 400 for each contact, half of it the answer |
    /// | recommendation | 4 MiB, 3 MiB a thread, 64 KiB a cutter, 800 for each facet, and 3 for each byte of JSON |
    /// | check of a path | 20 MiB, 3 MiB a thread, 800 for each facet, 400 for each point, and 3 for each byte of JSON |
    #[must_use]
    pub fn bytes(self) -> u64 {
        let saturating = |count: usize, each: u64| (count as u64).saturating_mul(each);
        match self {
            Self::Body { bytes } => bytes,
            Self::Upload { bytes } => bytes.min(56 * MIB) + bytes.saturating_mul(2).min(128 * MIB),
            Self::Batch { contacts } => MIB + saturating(contacts, 400),
            Self::PathCheck { json, facets, points, threads } => [(threads, 3 * MIB), (facets, 800), (points, 400), (json, 3)]
                .into_iter()
                .fold(20 * MIB, |sum, (count, each)| sum.saturating_add(saturating(count, each))),
            Self::Plan { json, facets, cutters, threads } => [(threads, 3 * MIB), (cutters, 64 * 1024), (facets, 800), (json, 3)]
                .into_iter()
                .fold(4 * MIB, |sum, (count, each)| sum.saturating_add(saturating(count, each))),
        }
    }
}

/// A semaphore in MiB.
#[derive(Debug)]
struct Pool {
    free: Arc<Semaphore>,
    size: u32,
}

impl Pool {
    fn new(bytes: u64) -> Self {
        // Settings are at most a TiB.
        let size = u32::try_from(bytes / MIB).unwrap_or(u32::MAX).max(1);
        Self { free: Arc::new(Semaphore::new(size as usize)), size }
    }

    /// The share of `bytes` in MiB, at most all.
    fn share(&self, bytes: u64) -> u32 {
        u32::try_from(bytes.div_ceil(MIB)).unwrap_or(u32::MAX).min(self.size)
    }

    /// Waits in turn for the share of `bytes`.
    async fn take(&self, bytes: u64, deadline: Instant) -> Option<OwnedSemaphorePermit> {
        timeout_at(deadline, Arc::clone(&self.free).acquire_many_owned(self.share(bytes))).await.ok()?.ok()
    }
}

/// The memory budget. Clones share it.
#[derive(Debug, Clone)]
pub struct Budget(Arc<Pools>);

#[derive(Debug)]
struct Pools {
    inputs: Pool,
    work: Pool,
    /// The part of `work` that recommendations and checks of paths may use together.
    plans: Pool,
    refusals: AtomicU64,
}

/// No memory became free in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoMemory;

/// A request's share of the budget, which is returned when this is dropped.
#[derive(Debug)]
pub struct Held {
    /// A share of each semaphore that the job needs; none for a small input.
    shares: Vec<OwnedSemaphorePermit>,
    budget: Budget,
}

impl Budget {
    /// A budget of `bytes`: three eighths for inputs, the rest for work.
    #[must_use]
    pub fn new(bytes: u64) -> Self {
        let inputs = bytes / 8 * 3;
        let work = bytes - inputs;
        let pools = Pools { inputs: Pool::new(inputs), work: Pool::new(work), plans: Pool::new(work / 4 * 3), refusals: AtomicU64::new(0) };
        Self(Arc::new(pools))
    }

    /// The share of `job`, for which it waits in turn and at most `longest`.
    ///
    /// # Errors
    /// [`NoMemory`], which is counted.
    pub async fn take(&self, job: Job, longest: Duration) -> Result<Held, NoMemory> {
        let deadline = Instant::now() + longest;
        let Pools { inputs, work, plans, .. } = &*self.0;
        let (pools, bytes) = match job {
            Job::Body { bytes } if bytes <= FREE_INPUT => (&[][..], 0),
            Job::Body { .. } => (&[inputs][..], job.bytes()),
            // One upload never takes all, so that others and bodies arrive beside it.
            Job::Upload { .. } => (&[inputs][..], job.bytes().min(u64::from(inputs.size) * MIB / 2)),
            Job::Batch { .. } if job.bytes() <= FREE_BATCH => (&[][..], 0),
            Job::Batch { .. } => (&[work][..], job.bytes()),
            // First its turn among plans, so that it does not wait before batches in the queue for work. None takes more than
            // their part.
            Job::Plan { .. } | Job::PathCheck { .. } => (&[plans, work][..], job.bytes().min(u64::from(plans.size) * MIB)),
        };
        let mut held = Held { shares: Vec::with_capacity(pools.len()), budget: self.clone() };
        for pool in pools {
            held.shares.push(pool.take(bytes, deadline).await.ok_or_else(|| self.refuse())?);
        }
        Ok(held)
    }

    fn refuse(&self) -> NoMemory {
        self.0.refusals.fetch_add(1, Ordering::Relaxed);
        NoMemory
    }

    /// The memory held by requests, in bytes.
    #[must_use]
    pub fn held(&self) -> u64 {
        let held = |pool: &Pool| u64::from(pool.size).saturating_sub(pool.free.available_permits() as u64);
        (held(&self.0.inputs) + held(&self.0.work)) * MIB
    }

    /// The number of refusals so far.
    #[must_use]
    pub fn refusals(&self) -> u64 {
        self.0.refusals.load(Ordering::Relaxed)
    }
}

impl Held {
    /// Grows the share of an input whose length was not known, without waiting: inputs that wait for each other's
    /// memory would all come to a stop.
    ///
    /// # Errors
    /// [`NoMemory`], which is counted.
    pub(crate) fn grow_input(&mut self, bytes: u64) -> Result<(), NoMemory> {
        let inputs = &self.budget.0.inputs;
        let held: usize = self.shares.iter().map(OwnedSemaphorePermit::num_permits).sum();
        let wanted = if bytes <= FREE_INPUT { 0 } else { inputs.share(bytes) };
        // At most a million MiB, the largest size of a semaphore here.
        let more = wanted.saturating_sub(u32::try_from(held).unwrap_or(u32::MAX));
        if more > 0 {
            let share = Arc::clone(&inputs.free).try_acquire_many_owned(more);
            self.shares.push(share.map_err(|_| self.budget.refuse())?);
        }
        Ok(())
    }

    /// Returns what exceeds `bytes` in each share.
    pub(crate) fn shrink_to(&mut self, bytes: u64) {
        let kept = usize::try_from(bytes.div_ceil(MIB)).unwrap_or(usize::MAX);
        for share in &mut self.shares {
            let surplus = share.num_permits().saturating_sub(kept);
            drop(share.split(surplus));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Duration = Duration::ZERO;
    const SOON: Duration = Duration::from_secs(10);

    fn plan(facets: usize) -> Job {
        Job::Plan { json: 0, facets, cutters: 2, threads: 2 }
    }

    #[tokio::test]
    async fn a_share_is_held_until_it_is_dropped_and_can_shrink() {
        let budget = Budget::new(512 * MIB);
        let mut held = budget.take(Job::Batch { contacts: 250_000 }, NOW).await.unwrap();
        // 1 MiB and 250 000 times 400 bytes, 95.4 MiB.
        assert_eq!(budget.held(), 97 * MIB);
        held.shrink_to(3 * MIB + 1);
        assert_eq!(budget.held(), 4 * MIB);
        drop(held);
        assert_eq!(budget.held(), 0);
    }

    #[tokio::test]
    async fn a_job_larger_than_all_takes_all_in_its_turn() {
        let budget = Budget::new(64 * MIB);
        let all = budget.take(Job::Body { bytes: 1 << 40 }, NOW).await.unwrap();
        assert_eq!(budget.held(), 24 * MIB);
        assert_eq!(budget.take(Job::Body { bytes: 1 << 20 }, NOW).await.unwrap_err(), NoMemory);
        assert_eq!(budget.refusals(), 1);
        let (next, ()) = tokio::join!(budget.take(Job::Body { bytes: 1 << 20 }, SOON), async { drop(all) });
        assert!(next.is_ok());
    }

    #[tokio::test]
    async fn batches_find_a_quarter_of_the_work_whatever_plans_wait() {
        let budget = Budget::new(512 * MIB);
        let largest = budget.take(plan(usize::MAX), NOW).await.unwrap();
        let waiting = tokio::spawn({
            let budget = budget.clone();
            async move { budget.take(plan(500_000), SOON).await }
        });
        tokio::task::yield_now().await;
        // A quarter of 320 MiB.
        let batch = budget.take(Job::Batch { contacts: 100_000 }, NOW).await.unwrap();
        assert_eq!(batch.budget.held(), (240 + 40) * MIB);
        // A short batch does not wait behind others.
        let rest = budget.take(Job::Batch { contacts: 100_000 }, NOW).await.unwrap();
        assert!(budget.take(Job::Batch { contacts: 100_000 }, NOW).await.is_err());
        assert!(budget.take(Job::Batch { contacts: 1000 }, NOW).await.is_ok());
        drop((largest, rest));
        assert!(waiting.await.unwrap().is_ok());
    }

    #[tokio::test]
    async fn small_inputs_are_free_and_others_grow_only_into_free_memory() {
        let budget = Budget::new(64 * MIB);
        let mut held = budget.take(Job::Body { bytes: 0 }, NOW).await.unwrap();
        held.grow_input(FREE_INPUT).unwrap();
        assert_eq!(budget.held(), 0);
        held.grow_input(5 * MIB).unwrap();
        held.grow_input(4 * MIB).unwrap();
        assert_eq!(budget.held(), 5 * MIB);
        let other = budget.take(Job::Body { bytes: 19 * MIB }, NOW).await.unwrap();
        assert_eq!(held.grow_input(6 * MIB), Err(NoMemory));
        drop(other);
        held.grow_input(6 * MIB).unwrap();
        assert_eq!(budget.held(), 6 * MIB);
    }

    #[test]
    fn the_formulas_are_near_what_was_measured() {
        // Measured with two cutters on two threads: 7 MB for 200 facets, 14 MB for 12 000, 390 MB for 500 000.
        for (facets, measured) in [(200, 7), (12_000, 14), (500_000, 390)] {
            let bytes = plan(facets).bytes() / 1_000_000;
            assert!((measured..=2 * measured).contains(&bytes), "{facets}: {bytes}");
        }
    }
}
