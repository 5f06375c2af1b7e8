//! Runs: the intersections of a plane with facets, joined over narrow gaps.

use super::march::{Plane, Reached};
use super::regions::Stretch;
use super::spaced::Spaced;
use super::spacing::FeedLaw;

/// A part of a pass that is cut without leaving the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    pub(super) stretch: Stretch,
    /// The length of its cuts in space.
    pub(super) length: f64,
    /// The time it would take without stops.
    pub(super) seconds: f64,
}

/// The cuts that begin in one cell of a plane: their outer ends, the sum of their lengths and that of their times.
#[derive(Debug, Clone, Copy)]
struct Cell {
    ends: [[f64; 2]; 2],
    length: f64,
    seconds: f64,
}

const EMPTY: Cell = Cell { ends: [[f64::INFINITY, 0.0], [f64::NEG_INFINITY, 0.0]], length: 0.0, seconds: 0.0 };

/// Finds the runs of one plane after another.
///
/// A plane is divided into cells as wide as the gaps over which runs are joined. Two cuts that begin in one cell
/// therefore belong to one run. Sums by cell give the same runs as sorting all cuts, in less time.
#[derive(Debug)]
pub(super) struct RunFinder {
    cells: Vec<Cell>,
    /// The cells with cuts: a part of a kilometre has 1e5 cells, but most planes have few cuts.
    filled: Vec<usize>,
    origin: f64,
    gap: f64,
    pub(super) runs: Vec<Run>,
}

impl RunFinder {
    /// A finder that joins runs over gaps of up to `gap`, in mm.
    pub(super) fn new(spaced: &Spaced, gap: f64) -> Self {
        let [low, high] = spaced.sweep.along;
        // A part of a kilometre and a cutter of a micrometre would need 1e9 cells. Wider cells join wider gaps, which
        // is accurate enough there.
        let gap = gap.max((high - low) / 100_000.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "up to 1e5")]
        let count = ((high - low) / gap) as usize + 2;
        Self { cells: vec![EMPTY; count], filled: Vec::new(), origin: low, gap, runs: Vec::new() }
    }

    /// Adds the runs of the plane with this index, which cuts the facets `cut`.
    pub(super) fn find(&mut self, spaced: &Spaced, cut: &[Reached], number: usize, plane: &Plane, feeds: &FeedLaw) {
        let workpiece = spaced.workpiece;
        let (at, spacing) = (plane.at, plane.spacing());
        let constant_pace = if let FeedLaw::Constant { rate } = feeds { Some(rate.recip()) } else { None };
        let per_gap = self.gap.recip();
        for cut in cut {
            let place = cut.place as usize;
            let slice = &spaced.sweep.slices[place];
            let [from, to] = slice.cut(at);
            let length = (to - from) * slice.stretch();
            let pace = constant_pace.unwrap_or_else(|| {
                let tangent = &workpiece.tangents[spaced.sweep.covered[place].facet as usize];
                let taken = (spacing / f64::from(spaced.allowed[place])).powi(2);
                feeds.rate(tangent, tangent.alpha(spaced.sweep.heading.e).0, taken).recip()
            });
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the cells")]
            let index = (((from - self.origin) * per_gap) as u32 as usize).min(self.cells.len() - 1);
            let cell = &mut self.cells[index];
            if cell.ends[0][0] > cell.ends[1][0] {
                self.filled.push(index);
            }
            if from < cell.ends[0][0] {
                cell.ends[0] = [from, slice.height(from, at)];
            }
            if to > cell.ends[1][0] {
                cell.ends[1] = [to, slice.height(to, at)];
            }
            cell.length += length;
            cell.seconds += length * pace;
        }
        self.join(number, at);
    }

    /// Joins the cells' cuts to runs, and empties the cells.
    fn join(&mut self, plane: usize, at: f64) {
        let mut run: Option<Cell> = None;
        // A gap within a run adds nothing to the run's length.
        let finished = |Cell { ends, length, seconds }: Cell| Run { stretch: Stretch { plane, at, ends }, length, seconds };
        self.filled.sort_unstable();
        for index in self.filled.drain(..) {
            let cell = std::mem::replace(&mut self.cells[index], EMPTY);
            if cell.length <= 0.0 {
                continue;
            }
            match &mut run {
                Some(run) if cell.ends[0][0] - run.ends[1][0] <= self.gap => {
                    if cell.ends[1][0] > run.ends[1][0] {
                        run.ends[1] = cell.ends[1];
                    }
                    run.length += cell.length;
                    run.seconds += cell.seconds;
                }
                _ => {
                    self.runs.extend(run.replace(cell).map(finished));
                }
            }
        }
        self.runs.extend(run.map(finished));
    }
}
