//! What a reader collects: points and faults.

use super::faults::{FaultKind, ProgramFault};
use super::points::ProgramPoint;

/// The most faults that are kept.
const MOST_FAULTS: usize = 100;

/// The points and faults that a reader collects.
pub(super) struct Collected {
    pub(super) points: Vec<ProgramPoint>,
    pub(super) faults: Vec<ProgramFault>,
    pub(super) most_points: usize,
}

impl Collected {
    pub(super) fn fault(&mut self, line: u32, kind: FaultKind, word: impl Into<String>) {
        if self.faults.len() < MOST_FAULTS {
            let word: String = word.into().chars().take(40).collect();
            self.faults.push(ProgramFault { line, kind, word });
        }
    }

    /// Adds a point; past the limit it is a fault, once.
    pub(super) fn push(&mut self, point: ProgramPoint) {
        if self.points.len() < self.most_points {
            self.points.push(point);
        } else if self.faults.last().is_none_or(|fault| fault.kind != FaultKind::TooManyPoints) {
            self.fault(point.line, FaultKind::TooManyPoints, "the path");
        }
    }
}
