//! What a reader collects: points and faults.

use super::program_faults::{ProgramFault, ProgramFaultKind};
use super::program_points::ProgramPoint;

/// The most faults that are kept.
const MOST_FAULTS: usize = 100;

/// The points and faults that a reader collects.
pub(super) struct Collected {
    pub(super) points: Vec<ProgramPoint>,
    pub(super) faults: Vec<ProgramFault>,
    pub(super) most_points: usize,
    is_full: bool,
}

impl Collected {
    /// Nothing yet; at most so many points.
    pub(super) fn new(most_points: usize) -> Self {
        Self { points: Vec::new(), faults: Vec::new(), most_points, is_full: false }
    }

    pub(super) fn fault(&mut self, line: u32, kind: ProgramFaultKind, word: impl Into<String>) {
        if self.faults.len() < MOST_FAULTS {
            let word: String = word.into().chars().take(40).collect();
            self.faults.push(ProgramFault { line, kind, word });
        }
    }

    /// Adds a point; past the limit it is a fault, once.
    pub(super) fn push(&mut self, point: ProgramPoint) {
        if self.points.len() < self.most_points {
            self.points.push(point);
        } else if !self.is_full {
            self.is_full = true;
            self.fault(point.line, ProgramFaultKind::TooManyPoints, "the path");
        }
    }

    /// Whether a point was refused: the rest need not be read. An arc in chords may have 10^5.
    pub(super) fn is_full(&self) -> bool {
        self.is_full
    }
}
