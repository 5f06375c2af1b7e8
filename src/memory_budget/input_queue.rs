//! The order in which inputs that are read at the same time get memory: that of their arrival.
//!
//! Without an order, inputs that arrive together would each take some memory until none could be read to its end. With
//! it, the first one can always be read to its end, whatever the others hold.

use super::{BudgetExceeded, MemoryBudget, Reservation};
use std::collections::BTreeSet;
use std::sync::{MutexGuard, PoisonError};
use std::time::Duration;
use tokio::time::{Instant, timeout_at};

/// The inputs that are being read, by the numbers of their arrival.
#[derive(Debug, Default)]
pub(super) struct InputQueue {
    next: u64,
    reading: BTreeSet<u64>,
    /// Those of `reading` that wait for memory.
    waiting: BTreeSet<u64>,
}

/// The place of an input in the queue. Drop it when the input has been read.
#[derive(Debug)]
#[must_use = "dropped, it leaves the queue"]
pub struct InputPlace {
    budget: MemoryBudget,
    number: u64,
}

impl MemoryBudget {
    /// A place behind all inputs that are being read.
    pub fn queue_input(&self) -> InputPlace {
        let mut queue = self.queue();
        let number = queue.next;
        queue.next += 1;
        queue.reading.insert(number);
        InputPlace { budget: self.clone(), number }
    }

    fn notify_waiting_inputs(&self) {
        let is_any_waiting = !self.queue().waiting.is_empty();
        if is_any_waiting {
            self.notify_all();
        }
    }

    fn queue(&self) -> MutexGuard<'_, InputQueue> {
        self.0.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl InputPlace {
    /// Adds `bytes` to the input's reservation. Waits at most `longest` until no earlier input waits for memory, and
    /// until the bytes are free and the other inputs hold at most three sixteenths of the budget. The first input needs only
    /// free bytes.
    ///
    /// # Errors
    /// [`BudgetExceeded`]; the reservation is unchanged then.
    pub async fn grow(&self, memory: &mut Reservation, bytes: u64, longest: Duration) -> Result<(), BudgetExceeded> {
        self.wait(bytes, longest, |is_first| if is_first { memory.try_grow_first(bytes) } else { memory.try_grow(bytes) }).await
    }

    /// Waits at most `longest` until the input, which holds `held` bytes, may grow. Data that arrive before would take
    /// memory while they wait.
    ///
    /// # Errors
    /// [`BudgetExceeded::Now`] if the time is over.
    pub async fn may_grow(&self, held: u64, longest: Duration) -> Result<(), BudgetExceeded> {
        let may_grow = |is_first| if is_first || self.budget.has_room_for_inputs(held) { Ok(()) } else { Err(BudgetExceeded::Now) };
        self.wait(u64::MAX, longest, may_grow).await
    }

    /// Repeats `attempt` in the order of the queue, when memory returns. Its argument is whether no earlier input is
    /// being read.
    async fn wait(
        &self,
        bytes: u64,
        longest: Duration,
        mut attempt: impl FnMut(bool) -> Result<(), BudgetExceeded>,
    ) -> Result<(), BudgetExceeded> {
        let deadline = Instant::now() + longest;
        let waiting = Waiting::begin(self);
        loop {
            // Registered before the attempt, so that bytes returned after it are not missed.
            let returned = self.budget.returned(bytes);
            let outcome = match waiting.turn() {
                Some(is_first) => attempt(is_first),
                None => Err(BudgetExceeded::Now),
            };
            match outcome {
                Err(BudgetExceeded::Now) if timeout_at(deadline, returned).await.is_ok() => {}
                outcome => return outcome.map_err(|exceeded| self.budget.refuse(exceeded)),
            }
        }
    }
}

impl Drop for InputPlace {
    fn drop(&mut self) {
        self.budget.queue().reading.remove(&self.number);
        self.budget.notify_waiting_inputs();
    }
}

/// The time in which an input waits. Later inputs wait until it is dropped.
struct Waiting<'a>(&'a InputPlace);

impl<'a> Waiting<'a> {
    fn begin(place: &'a InputPlace) -> Self {
        place.budget.queue().waiting.insert(place.number);
        Self(place)
    }

    /// Whether no earlier input is being read; `None` if an earlier one waits.
    fn turn(&self) -> Option<bool> {
        let queue = self.0.budget.queue();
        let is_first_of = |inputs: &BTreeSet<u64>| inputs.first() == Some(&self.0.number);
        is_first_of(&queue.waiting).then(|| is_first_of(&queue.reading))
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.budget.queue().waiting.remove(&self.0.number);
        self.0.budget.notify_waiting_inputs();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A_MINUTE: Duration = Duration::from_mins(1);

    #[tokio::test]
    async fn the_first_input_grows_whatever_the_others_hold() {
        let budget = MemoryBudget::new(100);
        let (first, second) = (budget.queue_input(), budget.queue_input());
        let (mut of_first, mut of_second) = (budget.open_for_input(), budget.open_for_input());
        second.grow(&mut of_second, 30, A_MINUTE).await.unwrap();
        first.grow(&mut of_first, 40, A_MINUTE).await.unwrap();
        assert_eq!(second.grow(&mut of_second, 1, Duration::ZERO).await, Err(BudgetExceeded::Now));
        assert_eq!(first.grow(&mut of_first, 60, Duration::ZERO).await, Err(BudgetExceeded::Always));
        assert_eq!((budget.reserved(), budget.refusals()), (70, 2));
    }

    #[tokio::test(start_paused = true)]
    async fn inputs_get_memory_in_the_order_of_their_arrival() {
        let budget = MemoryBudget::new(100);
        let mut held = budget.open_for_input();
        held.grow(60).unwrap();
        let slow = budget.queue_input();
        let order = std::sync::Mutex::new(Vec::new());
        let input = |number: u64, bytes: u64| {
            let (place, mut memory, order) = (budget.queue_input(), budget.open_for_input(), &order);
            async move {
                place.may_grow(0, A_MINUTE).await.unwrap();
                place.grow(&mut memory, bytes, A_MINUTE).await.unwrap();
                order.lock().unwrap().push(number);
                tokio::time::sleep(Duration::from_secs(1)).await;
            }
        };
        let (large, small, last) = (input(0, 70), input(1, 10), input(2, 5));
        let release = async {
            tokio::time::sleep(Duration::from_secs(1)).await;
            drop(slow);
            held.shrink_to(35);
            tokio::time::sleep(Duration::from_secs(1)).await;
            assert_eq!(budget.reserved(), 35);
            drop(held);
        };
        tokio::join!(last, small, large, release);
        assert_eq!((order.into_inner().unwrap(), budget.reserved()), (vec![0, 1, 2], 0));
    }

    #[tokio::test(start_paused = true)]
    async fn an_input_that_no_longer_waits_does_not_keep_the_next_from_growing() {
        let budget = MemoryBudget::new(100);
        let _work = budget.reserve(70).unwrap();
        let (first, second, third) = (budget.queue_input(), budget.queue_input(), budget.queue_input());
        let [mut a, mut b, mut c] = [(); 3].map(|()| budget.open_for_input());
        let began = Instant::now();
        let (waited, left, grown) = tokio::join!(
            first.grow(&mut a, 50, Duration::from_secs(20)),
            timeout_at(began + Duration::from_secs(30), second.grow(&mut b, 40, A_MINUTE)),
            third.grow(&mut c, 10, A_MINUTE),
        );
        assert_eq!((waited, grown), (Err(BudgetExceeded::Now), Ok(())));
        assert!(left.is_err());
        assert_eq!((began.elapsed().as_secs(), budget.reserved()), (30, 80));
    }
}
