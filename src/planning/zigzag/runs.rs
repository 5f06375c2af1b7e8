//! Where a plane cuts the facets: runs along it, joined over narrow gaps.

use super::march::{Reached, Spaced};
use super::spacing::FeedLaw;

/// A stretch along a plane that is cut without leaving the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    /// Both ends, along the pass and in height, the lower one along the pass first.
    pub(super) ends: [[f64; 2]; 2],
    /// The length of its cuts in space.
    pub(super) length: f64,
    /// The time it would take without stops.
    pub(super) seconds: f64,
}

/// The part of a plane between two gaps, at least; its ends and the lengths in it.
#[derive(Debug, Clone, Copy)]
struct Cell {
    ends: [[f64; 2]; 2],
    length: f64,
    seconds: f64,
}

const EMPTY: Cell = Cell { ends: [[f64::INFINITY, 0.0], [f64::NEG_INFINITY, 0.0]], length: 0.0, seconds: 0.0 };

/// The runs of one plane after the other.
///
/// A plane is divided into cells as wide as the gaps over which runs are joined. Two cuts that begin in one cell are therefore in one run, so
/// that sums by cells give the same runs as sorting all cuts.
#[derive(Debug)]
pub(super) struct RunFinder {
    cells: Vec<Cell>,
    origin: f64,
    gap: f64,
    pub(super) runs: Vec<Run>,
}

impl RunFinder {
    /// For gaps up to `gap`.
    pub(super) fn new(spaced: &Spaced, gap: f64) -> Self {
        let [low, high] = spaced.sweep.along;
        // A part of a kilometre and a cutter of a micrometre would make 1e9 cells; wider cells join wider gaps.
        let gap = gap.max((high - low) / 100_000.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "up to 1e5")]
        let count = ((high - low) / gap) as usize + 2;
        Self { cells: vec![EMPTY; count], origin: low, gap, runs: Vec::new() }
    }

    /// Finds the runs of the plane at `at`, whose neighbours are `spacing` away.
    pub(super) fn find(&mut self, spaced: &Spaced, reached: &[Reached], at: f64, spacing: f64, feeds: &FeedLaw) {
        let workpiece = spaced.workpiece;
        let constant_pace = if let FeedLaw::Constant { rate } = feeds { Some(rate.recip()) } else { None };
        for reached in reached {
            if at < reached.low || at >= reached.high {
                continue;
            }
            let place = reached.place as usize;
            let slice = &spaced.sweep.slices[place];
            let [from, to] = slice.cut(at);
            let facet = spaced.sweep.covered[place].facet as usize;
            let length = workpiece.weights[facet] * (to - from) * slice.stretch();
            let pace = constant_pace.unwrap_or_else(|| {
                let tangent = &workpiece.tangents[facet];
                let taken = spacing * spacing / f64::from(spaced.squared[facet]);
                feeds.rate(tangent, tangent.alpha(spaced.sweep.heading.e).0, taken).recip()
            });
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the cells")]
            let cell = ((from - self.origin) / self.gap) as usize;
            let last = self.cells.len() - 1;
            let cell = &mut self.cells[cell.min(last)];
            if from < cell.ends[0][0] {
                cell.ends[0] = [from, slice.height(from, at)];
            }
            if to > cell.ends[1][0] {
                cell.ends[1] = [to, slice.height(to, at)];
            }
            cell.length += length;
            cell.seconds += length * pace;
        }
        self.join();
    }

    /// Joins the cells' cuts to runs, and empties the cells.
    fn join(&mut self) {
        self.runs.clear();
        let mut run: Option<Cell> = None;
        for cell in &mut self.cells {
            if cell.length <= 0.0 {
                continue;
            }
            let cell = std::mem::replace(cell, EMPTY);
            match &mut run {
                Some(run) if cell.ends[0][0] - run.ends[1][0] <= self.gap => {
                    if cell.ends[1][0] > run.ends[1][0] {
                        run.ends[1] = cell.ends[1];
                    }
                    run.length += cell.length;
                    run.seconds += cell.seconds;
                }
                _ => {
                    self.runs.extend(run.replace(cell).map(Run::from));
                }
            }
        }
        self.runs.extend(run.map(Run::from));
    }
}

impl From<Cell> for Run {
    /// Gaps over which a run is joined add nothing to its length.
    fn from(cell: Cell) -> Self {
        Self { ends: cell.ends, length: cell.length, seconds: cell.seconds }
    }
}
