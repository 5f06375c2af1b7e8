//! Limits on the planes and runs of a plan, so that its memory stays within the reservation.

use super::march::{MOST_PLANES, NoPlanes};
use std::sync::atomic::{AtomicBool, Ordering};

/// The largest number of runs of a zigzag, somewhat more than the largest number of planes. A run takes some 200 bytes
/// with its order, and a comb of thin strips has thousands of runs in each plane.
pub(super) const MOST_RUNS: usize = 65_536;

/// The number of slivers, of 24 bytes each in a vector that doubles, that take the memory of one run.
pub(super) const SLIVERS_OF_A_RUN: usize = 4;

/// The largest numbers of planes and runs of each candidate's plan. Most plans have a few hundred of each. Memory for
/// more is reserved only if a plan needs it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanRoom {
    /// The most planes.
    pub planes: usize,
    /// The most runs.
    pub runs: usize,
}

impl PlanRoom {
    /// Enough for a part of 200 mm with passes 0.1 mm apart.
    pub const USUAL: Self = Self { planes: 2_000, runs: 6_000 };

    /// The limits of every plan: a direction that needs more planes or runs has no plan.
    pub const LARGEST: Self = Self { planes: MOST_PLANES, runs: MOST_RUNS };

    /// The next larger room: five times this one, at most the largest.
    #[must_use]
    pub fn larger(self) -> Self {
        Self { planes: (5 * self.planes).min(MOST_PLANES), runs: (5 * self.runs).min(MOST_RUNS) }
    }
}

/// The room of one ranking, and whether a plan needed more.
#[derive(Debug)]
pub(super) struct Room {
    room: PlanRoom,
    is_exceeded: AtomicBool,
}

impl Room {
    pub(super) fn new(room: PlanRoom) -> Self {
        Self { room, is_exceeded: AtomicBool::new(false) }
    }

    /// Checks that a plan with these planes and runs fits, and records it if it does not.
    ///
    /// # Errors
    /// [`NoPlanes::TooManyPlanes`] and [`NoPlanes::TooManyRuns`] if even the largest room is exceeded,
    /// [`NoPlanes::NoRoom`] if a larger room would suffice.
    pub(super) fn check(&self, planes: usize, runs: usize) -> Result<(), NoPlanes> {
        let most = PlanRoom::LARGEST;
        if planes > most.planes {
            Err(NoPlanes::TooManyPlanes)
        } else if runs > most.runs {
            Err(NoPlanes::TooManyRuns)
        } else if planes > self.room.planes || runs > self.room.runs {
            self.is_exceeded.store(true, Ordering::Relaxed);
            Err(NoPlanes::NoRoom)
        } else {
            Ok(())
        }
    }

    /// Whether a plan did not fit.
    pub(super) fn is_exceeded(&self) -> bool {
        self.is_exceeded.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_over_the_room_needs_a_larger_one_and_one_over_the_largest_has_no_plan() {
        let room = Room::new(PlanRoom { planes: 100, runs: 300 });
        assert_eq!(room.check(100, 300), Ok(()));
        assert!(!room.is_exceeded());
        assert_eq!(room.check(MOST_PLANES + 1, 0), Err(NoPlanes::TooManyPlanes));
        assert_eq!(room.check(100, MOST_RUNS + 1), Err(NoPlanes::TooManyRuns));
        assert!(!room.is_exceeded());
        assert_eq!(room.check(100, 301), Err(NoPlanes::NoRoom));
        assert!(room.is_exceeded());
    }

    #[test]
    fn rooms_grow_to_the_largest() {
        let mut room = PlanRoom::USUAL;
        for _ in 0..3 {
            room = room.larger();
        }
        assert_eq!(room, PlanRoom::LARGEST);
        assert_eq!(Room::new(room).check(MOST_PLANES, MOST_RUNS), Ok(()));
    }
}
