//! The memory budget for all data whose size a client determines: heads, bodies, vertices, unsent answers. Code
//! reserves bytes before it allocates them, and returns them by dropping the reservation.

mod input_queue;

pub use input_queue::InputPlace;

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use input_queue::InputQueue;
use tokio::sync::Notify;
use tokio::sync::futures::Notified;

/// A limit on the bytes reserved at the same time. Clones share it.
#[derive(Debug, Clone)]
pub struct MemoryBudget(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    total: u64,
    reserved: AtomicU64,
    /// The part of `reserved` for inputs.
    inputs: AtomicU64,
    refusals: AtomicU64,
    /// Notified when bytes return, of which at least `least_wanted` are then free.
    returned: Notify,
    /// At most the least number of bytes that a request waits for. Without it, each of thousands of returns in a second
    /// would wake dozens of requests that wait for far more.
    least_wanted: AtomicU64,
    /// The inputs that are being read.
    queue: Mutex<InputQueue>,
}

/// The reason why bytes were not reserved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BudgetExceeded {
    /// Other requests hold too much of the budget at this moment.
    Now,
    /// The reservation would be larger than [`MemoryBudget::largest`].
    Always,
}

impl fmt::Display for BudgetExceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Now => write!(f, "the memory for requests is used up by others at this moment"),
            Self::Always => write!(f, "the request needs more memory than one request may use"),
        }
    }
}

impl std::error::Error for BudgetExceeded {}

impl MemoryBudget {
    /// A budget of `total` bytes.
    #[must_use]
    pub fn new(total: u64) -> Self {
        Self(Arc::new(Shared {
            total,
            reserved: AtomicU64::new(0),
            inputs: AtomicU64::new(0),
            refusals: AtomicU64::new(0),
            returned: Notify::new(),
            least_wanted: AtomicU64::new(u64::MAX),
            queue: Mutex::default(),
        }))
    }

    /// The largest reservation, three quarters of the budget. The rest is for the other memory of a request, such as
    /// the end of its body, so that a request that is too large fails with `Always` and not with `Now`.
    #[must_use]
    pub fn largest(&self) -> u64 {
        self.0.total - self.0.total / 4
    }

    /// The most that inputs and the work on them may reserve. The rest, a sixteenth, is for bodies that arrive while
    /// those fill the budget: without it, each of them would be refused.
    fn most_for_work(&self) -> u64 {
        self.0.total - self.0.total / 16
    }

    /// The most that inputs may hold when another one grows: as much as the largest reservation leaves of the memory for
    /// work, so that the work on one of the inputs is always possible.
    fn most_for_inputs(&self) -> u64 {
        self.most_for_work() - self.largest()
    }

    /// The bytes reserved at this moment.
    #[must_use]
    pub fn reserved(&self) -> u64 {
        self.0.reserved.load(Ordering::SeqCst)
    }

    /// The number of refused reservations.
    #[must_use]
    pub fn refusals(&self) -> u64 {
        self.0.refusals.load(Ordering::Relaxed)
    }

    /// Counts a refused reservation, and returns its reason.
    pub(crate) fn refuse(&self, exceeded: BudgetExceeded) -> BudgetExceeded {
        self.0.refusals.fetch_add(1, Ordering::Relaxed);
        exceeded
    }

    /// Whether an input that holds `held` bytes may grow, if it is not the first.
    fn has_room_for_inputs(&self, held: u64) -> bool {
        self.0.inputs.load(Ordering::Relaxed).saturating_sub(held) <= self.most_for_inputs()
    }

    /// Ready when bytes return after this call and `wanted` bytes may be free.
    pub fn returned(&self, wanted: u64) -> Notified<'_> {
        let returned = self.0.returned.notified();
        self.0.least_wanted.fetch_min(wanted, Ordering::SeqCst);
        returned
    }

    /// Wakes the requests that wait for memory, if the free bytes may suffice for one of them.
    fn notify_returned(&self) {
        // A request states the bytes that it wants before it looks for free ones, and this looks for wanted ones after
        // bytes were freed. In sequentially consistent order, at least one of them finds the other's.
        if self.0.total.saturating_sub(self.reserved()) >= self.0.least_wanted.load(Ordering::SeqCst) {
            self.notify_all();
        }
    }

    /// Wakes all requests that wait for memory; those that continue to wait state again the bytes that they want.
    fn notify_all(&self) {
        self.0.least_wanted.store(u64::MAX, Ordering::SeqCst);
        self.0.returned.notify_waiters();
    }

    /// An empty reservation.
    pub fn open(&self) -> Reservation {
        Reservation { budget: self.clone(), bytes: 0, is_input: false }
    }

    /// An empty reservation for an input that is stored until its request can be processed. It grows only while the
    /// other inputs have at most three sixteenths of the budget. Without this limit, inputs that arrive together could fill
    /// the budget, and none of their requests would get the memory for its work.
    pub fn open_for_input(&self) -> Reservation {
        Reservation { budget: self.clone(), bytes: 0, is_input: true }
    }

    /// A reservation of `bytes`.
    ///
    /// # Errors
    /// [`BudgetExceeded`]; nothing is reserved then.
    pub fn reserve(&self, bytes: u64) -> Result<Reservation, BudgetExceeded> {
        let mut reservation = self.open();
        reservation.grow(bytes)?;
        Ok(reservation)
    }
}

/// Bytes in memory with their reservation.
#[derive(Debug)]
pub struct Reserved<B> {
    pub(crate) bytes: B,
    pub(crate) reservation: Reservation,
}

impl<B: AsRef<[u8]>> AsRef<[u8]> for Reserved<B> {
    fn as_ref(&self) -> &[u8] {
        self.bytes.as_ref()
    }
}

/// Bytes of a budget, which return to it when this is dropped.
#[derive(Debug)]
#[must_use = "dropped, it returns its bytes"]
pub struct Reservation {
    budget: MemoryBudget,
    bytes: u64,
    is_input: bool,
}

impl Reservation {
    /// The bytes reserved.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Reserves `bytes` more.
    ///
    /// # Errors
    /// [`BudgetExceeded`]; the reservation is unchanged then.
    pub fn grow(&mut self, bytes: u64) -> Result<(), BudgetExceeded> {
        self.try_grow(bytes).map_err(|exceeded| self.budget.refuse(exceeded))
    }

    /// The same on a thread that may block: waits at most `longest` for bytes to return, and ends once `stop` returns true.
    ///
    /// # Errors
    /// [`BudgetExceeded`]; the reservation is unchanged then.
    pub fn grow_blocking(&mut self, bytes: u64, longest: Duration, stop: &dyn Fn() -> bool) -> Result<(), BudgetExceeded> {
        /// Bytes return within milliseconds unless the load persists.
        const PAUSE: Duration = Duration::from_millis(2);
        let begun = std::time::Instant::now();
        loop {
            match self.try_grow(bytes) {
                Err(BudgetExceeded::Now) if begun.elapsed() < longest && !stop() => std::thread::sleep(PAUSE),
                Ok(()) => return Ok(()),
                Err(exceeded) => return Err(self.budget.refuse(exceeded)),
            }
        }
    }

    /// Reserves `bytes` more. A failure is not counted as a refusal.
    ///
    /// # Errors
    /// [`BudgetExceeded`]; the reservation is unchanged then.
    pub fn try_grow(&mut self, bytes: u64) -> Result<(), BudgetExceeded> {
        self.try_grow_beside(bytes, self.budget.most_for_inputs())
    }

    /// The same for the first of the inputs that are being read, however much the others hold.
    fn try_grow_first(&mut self, bytes: u64) -> Result<(), BudgetExceeded> {
        self.try_grow_beside(bytes, u64::MAX)
    }

    /// Reserves `bytes` more. For an input, the other inputs may hold `most_of_others` bytes.
    fn try_grow_beside(&mut self, bytes: u64, most_of_others: u64) -> Result<(), BudgetExceeded> {
        if bytes == 0 {
            return Ok(());
        }
        let Shared { total, reserved, inputs, .. } = &*self.budget.0;
        let own = self.bytes.checked_add(bytes).filter(|own| *own <= self.budget.largest()).ok_or(BudgetExceeded::Always)?;
        // No overflow: `reserved` and `bytes` are at most `total`, and a sum beyond it is not stored.
        let most = if self.is_input { self.budget.most_for_work() } else { *total };
        let add = |reserved: u64| reserved.checked_add(bytes).filter(|sum| *sum <= most);
        if self.is_input {
            // No underflow: `inputs` includes this reservation.
            let add = |inputs: u64| (inputs - self.bytes <= most_of_others).then(|| inputs.saturating_add(bytes));
            inputs.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add).map_err(|_| BudgetExceeded::Now)?;
        }
        if reserved.fetch_update(Ordering::SeqCst, Ordering::SeqCst, add).is_err() {
            if self.is_input {
                inputs.fetch_sub(bytes, Ordering::Relaxed);
            }
            return Err(BudgetExceeded::Now);
        }
        self.bytes = own;
        Ok(())
    }

    /// Begins the time in which the request waits for its work. In this time the reservation counts as that of an
    /// input.
    ///
    /// # Errors
    /// [`BudgetExceeded::Now`] if the other inputs hold more than three sixteenths of the budget.
    pub fn begin_wait(&mut self) -> Result<(), BudgetExceeded> {
        if self.is_input {
            return Ok(());
        }
        let (inputs, most) = (&self.budget.0.inputs, self.budget.most_for_inputs());
        let add = |inputs: u64| (inputs <= most).then(|| inputs.saturating_add(self.bytes));
        let added = inputs.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
        added.map_err(|_| self.budget.refuse(BudgetExceeded::Now))?;
        self.is_input = true;
        Ok(())
    }

    /// The largest size to which the reservation of an input's work can grow now. Other requests may reserve the bytes
    /// first.
    #[must_use]
    pub fn attainable(&self) -> u64 {
        let free = self.budget.most_for_work().saturating_sub(self.budget.reserved());
        self.bytes.saturating_add(free).min(self.budget.largest())
    }

    /// Records that the input's request has the memory for its work, so that the input no longer counts among the
    /// waiting inputs.
    pub fn begin_work(&mut self) {
        if std::mem::take(&mut self.is_input) {
            self.budget.0.inputs.fetch_sub(self.bytes, Ordering::Relaxed);
            self.budget.notify_all();
        }
    }

    /// Returns all but `bytes`; a smaller reservation is kept.
    pub fn shrink_to(&mut self, bytes: u64) {
        let returned = self.bytes.saturating_sub(bytes);
        self.bytes -= returned;
        if returned > 0 {
            self.budget.0.reserved.fetch_sub(returned, Ordering::SeqCst);
            if self.is_input {
                self.budget.0.inputs.fetch_sub(returned, Ordering::Relaxed);
                self.budget.notify_all();
            } else {
                self.budget.notify_returned();
            }
        }
    }

    /// Grows or shrinks to `bytes`.
    ///
    /// # Errors
    /// [`BudgetExceeded`]; the reservation is unchanged then.
    pub fn resize(&mut self, bytes: u64) -> Result<(), BudgetExceeded> {
        self.shrink_to(bytes);
        self.grow(bytes - self.bytes)
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.shrink_to(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use tokio::time::Instant;

    #[test]
    fn bytes_of_dropped_reservations_can_be_reserved_again() {
        let budget = MemoryBudget::new(100);
        let first = budget.reserve(60).unwrap();
        assert_eq!(budget.reserve(41).unwrap_err(), BudgetExceeded::Now);
        assert_eq!(budget.reserve(101).unwrap_err(), BudgetExceeded::Always);
        drop(first);
        assert_eq!(budget.reserve(75).unwrap().bytes(), 75);
        assert_eq!(budget.reserved(), 0);
    }

    #[test]
    fn a_reservation_larger_than_three_quarters_of_the_budget_is_refused_for_good() {
        let mut reservation = MemoryBudget::new(100).reserve(70).unwrap();
        assert_eq!(reservation.grow(6), Err(BudgetExceeded::Always));
        assert_eq!(reservation.grow(u64::MAX), Err(BudgetExceeded::Always));
        assert_eq!(reservation.bytes(), 70);
    }

    #[test]
    fn inputs_grow_while_the_others_hold_at_most_three_sixteenths() {
        let budget = MemoryBudget::new(100);
        let (mut first, mut second, mut work) = (budget.open_for_input(), budget.open_for_input(), budget.open());
        first.grow(30).unwrap();
        assert_eq!(second.grow(1), Err(BudgetExceeded::Now));
        first.grow(30).unwrap();
        work.grow(40).unwrap();
        assert_eq!(first.grow(1), Err(BudgetExceeded::Now));
        // What is reserved stays reserved.
        second.resize(0).unwrap();
        first.shrink_to(19);
        second.grow(10).unwrap();
        assert_eq!(budget.reserved(), 69);
        let mut waiting = budget.open_for_input();
        second.grow(20).unwrap();
        assert_eq!(waiting.grow(1), Err(BudgetExceeded::Now));
        second.begin_work();
        waiting.grow(1).unwrap();
        drop((first, second, waiting));
        let mut third = budget.open_for_input();
        third.grow(54).unwrap();
        assert_eq!((third.grow(1), budget.reserved()), (Err(BudgetExceeded::Now), 94));
        // The rest is for bodies.
        work.grow(6).unwrap();
    }

    #[test]
    fn requests_that_wait_for_their_work_leave_memory_for_one_of_them() {
        let budget = MemoryBudget::new(100);
        let (mut first, mut second, mut third) = (budget.reserve(19).unwrap(), budget.reserve(19).unwrap(), budget.reserve(25).unwrap());
        assert_eq!([&first, &second].map(Reservation::attainable), [50, 50]);
        first.begin_wait().unwrap();
        first.begin_wait().unwrap();
        second.begin_wait().unwrap();
        assert_eq!(third.begin_wait(), Err(BudgetExceeded::Now));
        drop(third);
        assert_eq!(first.attainable(), 75);
        first.grow(50).unwrap();
        first.begin_work();
        drop(first);
        second.grow(50).unwrap();
        drop(second);
        assert_eq!((budget.reserved(), budget.refusals()), (0, 1));
        budget.open_for_input().grow(75).unwrap();
    }

    /// Reserves `bytes` more as soon as they have returned.
    async fn grow_when_free(reservation: &mut Reservation, bytes: u64) {
        let budget = reservation.budget.clone();
        loop {
            let returned = budget.returned(bytes);
            if reservation.try_grow(bytes).is_ok() {
                return;
            }
            returned.await;
        }
    }

    #[tokio::test]
    async fn a_reservation_can_wait_for_bytes_that_return() {
        let budget = MemoryBudget::new(100);
        let first = budget.reserve(60).unwrap();
        let mut second = budget.open();
        tokio::join!(grow_when_free(&mut second, 50), async { drop(first) });
        assert_eq!(second.bytes(), 50);
    }

    #[tokio::test(start_paused = true)]
    async fn of_those_that_wait_each_is_woken_when_its_bytes_are_free() {
        let budget = MemoryBudget::new(100);
        let (mut held, mut large, mut small) = (budget.reserve(75).unwrap(), budget.open(), budget.open());
        let release = async {
            for bytes in [65, 50, 45, 0] {
                tokio::time::sleep(Duration::from_secs(1)).await;
                held.shrink_to(bytes);
            }
        };
        let small = async {
            grow_when_free(&mut small, 45).await;
            tokio::time::sleep(Duration::from_secs(5)).await;
            drop(small);
            Instant::now()
        };
        let large = async {
            grow_when_free(&mut large, 60).await;
            Instant::now()
        };
        let began = Instant::now();
        let (small, large, ()) = tokio::join!(small, large, release);
        assert_eq!([small - began, large - began].map(|time| time.as_secs()), [7, 7]);
    }

    proptest! {
        #[test]
        fn the_reserved_bytes_are_the_sum_of_the_reservations_and_never_exceed_the_total(
            steps in proptest::collection::vec((0_usize..4, 0_u64..80), 0..200),
        ) {
            let budget = MemoryBudget::new(100);
            let mut reservations: Vec<_> = (0..4).map(|_| budget.open()).collect();
            for (index, bytes) in steps {
                let before = reservations[index].bytes();
                let outcome = reservations[index].resize(bytes);
                prop_assert_eq!(reservations[index].bytes(), if outcome.is_ok() { bytes } else { before });
                let sum: u64 = reservations.iter().map(Reservation::bytes).sum();
                prop_assert_eq!(budget.reserved(), sum);
                prop_assert!(sum <= 100);
            }
            reservations.clear();
            prop_assert_eq!(budget.reserved(), 0);
        }
    }
}
