//! Runs: the intersections of a plane with facets, joined over narrow gaps.

use super::march::{Plane, Reached};
use super::regions::Stretch;
use super::slivers::{AT_ONCE, Strip, is_covered, parts_to_cut};
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

impl Run {
    /// Its interval along the pass.
    fn along(&self) -> [f64; 2] {
        self.stretch.ends.map(|[along, _]| along)
    }

    /// Joins a run that begins later to this one.
    fn join(&mut self, later: &Self) {
        if later.along()[1] > self.along()[1] {
            self.stretch.ends[1] = later.stretch.ends[1];
        }
        self.length += later.length;
        self.seconds += later.seconds;
    }
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
pub(super) struct RunFinder<'a> {
    spaced: &'a Spaced<'a>,
    feeds: &'a FeedLaw,
    cells: Vec<Cell>,
    /// The cells with cuts: a part of a kilometre has 1e5 cells, but most planes have few cuts.
    filled: Vec<usize>,
    origin: f64,
    gap: f64,
    pub(super) runs: Vec<Run>,
    /// The last strip, and the places of its facets on which the plane before it has no run.
    strip: Strip<Pass>,
    uncovered: Vec<u32>,
    /// The number of parts of facets over which runs were extended.
    pub(super) slivers: usize,
}

/// A plane, and the index of the first of its runs.
#[derive(Debug, Clone, Copy)]
struct Pass {
    number: usize,
    plane: Plane,
    first: usize,
}

impl<'a> RunFinder<'a> {
    /// A finder that joins runs over gaps of up to the cutter's diameter; on sampled facets, over those due to sampling.
    pub(super) fn new(spaced: &'a Spaced, feeds: &'a FeedLaw) -> Self {
        let [low, high] = spaced.sweep.along;
        // A part of a kilometre and a cutter of a micrometre would need 1e9 cells. Wider cells join wider gaps, which
        // is accurate enough there.
        let gap = spaced.widest.max(spaced.workpiece.sampling_gap).max((high - low) / 100_000.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "up to 1e5")]
        let count = ((high - low) / gap) as usize + 2;
        Self {
            spaced,
            feeds,
            cells: vec![EMPTY; count],
            filled: Vec::new(),
            origin: low,
            gap,
            runs: Vec::new(),
            strip: Strip { ends: [0.0; 2], beside: [None; 2] },
            uncovered: Vec::new(),
            slivers: 0,
        }
    }

    /// Adds the runs of the plane with this index, which cuts the facets `cut`.
    pub(super) fn find(&mut self, cut: &[Reached], number: usize, plane: Plane) {
        let constant_pace = if let FeedLaw::Constant { rate } = self.feeds { Some(rate.recip()) } else { None };
        let per_gap = self.gap.recip();
        for cut in cut {
            let slice = &self.spaced.sweep.slices[cut.place as usize];
            let [from, to] = slice.cut(plane.at);
            let length = (to - from) * slice.stretch();
            let pace = constant_pace.unwrap_or_else(|| self.pace(cut.place, &plane));
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the cells")]
            let index = (((from - self.origin) * per_gap) as u32 as usize).min(self.cells.len() - 1);
            let cell = &mut self.cells[index];
            if cell.ends[0][0] > cell.ends[1][0] {
                self.filled.push(index);
            }
            if from < cell.ends[0][0] {
                cell.ends[0] = [from, slice.height(from, plane.at)];
            }
            if to > cell.ends[1][0] {
                cell.ends[1] = [to, slice.height(to, plane.at)];
            }
            cell.length += length;
            cell.seconds += length * pace;
        }
        self.strip.beside[1] = Some(Pass { number, plane, first: self.runs.len() });
        self.join(number, plane.at);
        self.run_over_slivers();
    }

    /// The time per length on a facet with the spacing of a plane.
    fn pace(&self, place: u32, plane: &Plane) -> f64 {
        let sweep = self.spaced.sweep;
        let tangent = &self.spaced.workpiece.tangents[sweep.covered[place as usize].facet as usize];
        let taken = (plane.spacing() / f64::from(self.spaced.allowed[place as usize])).powi(2);
        self.feeds.rate(tangent, tangent.alpha(sweep.heading.e).0, taken).recip()
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

    /// Notes the facets of the strip after the last plane, or before the first one of a band, on which that plane has no
    /// run. The next plane decides which of them are slivers.
    pub(super) fn look_for_slivers(&mut self, ends: [f64; 2], facets: &[Reached]) {
        // Two strips without a plane between them are the last one of a band and the first one of the next.
        self.run_over_slivers();
        let before = self.strip.beside[1];
        self.strip = Strip { ends, beside: [before, None] };
        let mut uncovered = std::mem::take(&mut self.uncovered);
        let is_uncovered = |place: &u32| {
            let slice = &self.spaced.sweep.slices[*place as usize];
            // The whole facet is compared first, which is quicker.
            !self.is_covered(slice.along(), before) && !self.is_covered(slice.along_between(ends), before)
        };
        uncovered.extend(facets.iter().map(|facet| facet.place).filter(is_uncovered));
        self.uncovered = uncovered;
    }

    /// Whether the runs of a plane cover an interval along the last strip.
    fn is_covered(&self, along: [f64; 2], pass: Option<Pass>) -> bool {
        let reach = self.strip.reach_beyond_ends(self.spaced);
        pass.is_some_and(|pass| is_covered(along, self.runs_of(pass), Run::along, reach))
    }

    fn runs_of(&self, pass: Pass) -> &[Run] {
        let own = &self.runs[pass.first..];
        &own[..own.partition_point(|run| run.stretch.plane == pass.number)]
    }

    /// Extends the runs beside the last strip over its slivers: the parts of facets that neither of both planes covers.
    pub(super) fn run_over_slivers(&mut self) {
        let mut facets = std::mem::take(&mut self.uncovered);
        for places in facets.chunks(AT_ONCE) {
            // The runs of the plane after the strip are stored behind those of the plane before it, and move last.
            for side in [1, 0] {
                self.extend(side, places);
            }
        }
        facets.clear();
        self.uncovered = facets;
    }

    /// Extends the runs of the plane on this side of the strip over the slivers in its part.
    fn extend(&mut self, side: usize, places: &[u32]) {
        let Some((pass, _)) = self.strip.part(side) else { return };
        let slivers = self.strip.slivers(side, places, self.spaced, |pass| self.runs_of(pass), Run::along);
        if slivers.is_empty() {
            return;
        }
        let mut runs = self.runs_of(pass).to_vec();
        let count = runs.len();
        let covered: Vec<[f64; 2]> = runs.iter().map(Run::along).collect();
        let parts = parts_to_cut(slivers, &covered);
        runs.extend(parts.into_iter().map(|(place, ends)| self.run_over(place, ends, &pass)));
        self.slivers += runs.len() - count;
        runs.sort_by(|a, b| a.along()[0].total_cmp(&b.along()[0]));
        let mut joined: Vec<Run> = Vec::with_capacity(runs.len());
        for run in runs {
            match joined.last_mut() {
                Some(last) if run.along()[0] - last.along()[1] <= self.gap => last.join(&run),
                _ => joined.push(run),
            }
        }
        let end = pass.first + joined.len();
        self.runs.splice(pass.first..pass.first + count, joined);
        if let Some(next) = self.strip.beside[1].as_mut().filter(|_| side == 0) {
            next.first = end;
        }
    }

    /// A run of a plane over a part of a facet beside it.
    fn run_over(&self, place: u32, ends: [f64; 2], pass: &Pass) -> Run {
        let (slice, at) = (&self.spaced.sweep.slices[place as usize], pass.plane.at);
        let length = (ends[1] - ends[0]) * slice.length_along();
        let ends = ends.map(|along| [along, slice.height(along, at)]);
        Run { stretch: Stretch { plane: pass.number, at, ends }, length, seconds: length * self.pace(place, &pass.plane) }
    }
}
