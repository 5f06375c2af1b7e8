//! Runs: the intersections of a plane with facets, joined over narrow gaps.

use super::footprint::{CoveredPart, Outline};
use super::march::{Plane, Reached};
use super::regions::Stretch;
use super::slivers::{Pass, Sliver, Strip, outside};
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

/// Sums over cuts.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// Of their lengths seen from above.
    seen: f64,
    /// Of their lengths in space.
    length: f64,
    /// Of their times.
    seconds: f64,
}

impl Sums {
    fn add(&mut self, other: Self) {
        self.seen += other.seen;
        self.length += other.length;
        self.seconds += other.seconds;
    }
}

/// The cuts that begin in one cell of a plane: their outer ends, and their sums.
#[derive(Debug, Clone, Copy)]
struct Cell {
    ends: [[f64; 2]; 2],
    sums: Sums,
}

const EMPTY: Cell = Cell { ends: [[f64::INFINITY, 0.0], [f64::NEG_INFINITY, 0.0]], sums: Sums { seen: 0.0, length: 0.0, seconds: 0.0 } };

/// A part of a plane over sampled facets, from the outline or from a cell.
struct Covered {
    ends: CoveredPart,
    /// The length that the surface covers, seen from above; 0 if only cuts are known.
    seen: f64,
    cuts: Sums,
}

impl Covered {
    /// Adds a part that begins later, unless there is a wider gap before it.
    fn join(&mut self, later: &Self, gap: f64) -> bool {
        if later.ends[0][0] - self.ends[1][0] > gap {
            return false;
        }
        if later.ends[1][0] > self.ends[1][0] {
            self.ends[1] = later.ends[1];
        }
        self.seen += later.seen;
        self.cuts.add(later.cuts);
        true
    }
}

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
    /// The sums over all planes so far.
    total: Sums,
    pub(super) runs: Vec<Run>,
    /// The last strip, and the places of its facets that are beyond the reach of the plane before it.
    strip: Strip,
    beyond_reach: Vec<u32>,
    /// The parts of facets over which runs were extended.
    pub(super) slivers: Vec<Sliver>,
}

/// The number of facets that are examined for slivers at once, so that these take little memory.
const EXAMINED_AT_ONCE: usize = 1024;

impl<'a> RunFinder<'a> {
    /// A finder that joins runs over gaps of up to the cutter's diameter.
    pub(super) fn new(spaced: &'a Spaced, feeds: &'a FeedLaw) -> Self {
        let [low, high] = spaced.sweep.along;
        // A part of a kilometre and a cutter of a micrometre would need 1e9 cells. Wider cells join wider gaps, which
        // is accurate enough there.
        let gap = spaced.widest.max((high - low) / 100_000.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "up to 1e5")]
        let count = ((high - low) / gap) as usize + 2;
        Self {
            spaced,
            feeds,
            cells: vec![EMPTY; count],
            filled: Vec::new(),
            origin: low,
            gap,
            total: Sums::default(),
            runs: Vec::new(),
            strip: Strip { ends: [0.0; 2], beside: [None; 2] },
            beyond_reach: Vec::new(),
            slivers: Vec::new(),
        }
    }

    /// Adds the runs of the plane with this index, which cuts the facets `cut`.
    pub(super) fn find(&mut self, cut: &[Reached], number: usize, plane: Plane) {
        let constant_pace = if let FeedLaw::Constant { rate } = self.feeds { Some(rate.recip()) } else { None };
        let per_gap = self.gap.recip();
        for cut in cut {
            let slice = &self.spaced.sweep.slices[cut.place as usize];
            let [from, to] = slice.cut(plane.at);
            let seen = (to - from) * slice.weight;
            let length = seen * slice.stretch();
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
            cell.sums.add(Sums { seen, length, seconds: length * pace });
        }
        self.strip.beside[1] = Some(Pass { number, plane, first: self.runs.len() });
        self.filled.sort_unstable();
        match &self.spaced.sweep.outline {
            Some(outline) => self.take_ends(outline, number, plane.at),
            None => self.join(number, plane.at),
        }
        self.cut_slivers();
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
        let finished = |Cell { ends, sums }: Cell| Run { stretch: Stretch { plane, at, ends }, length: sums.length, seconds: sums.seconds };
        for index in self.filled.drain(..) {
            let cell = std::mem::replace(&mut self.cells[index], EMPTY);
            if cell.sums.length <= 0.0 {
                continue;
            }
            match &mut run {
                Some(run) if cell.ends[0][0] - run.ends[1][0] <= self.gap => {
                    if cell.ends[1][0] > run.ends[1][0] {
                        run.ends[1] = cell.ends[1];
                    }
                    run.sums.add(cell.sums);
                }
                _ => {
                    self.runs.extend(run.replace(cell).map(finished));
                }
            }
        }
        self.runs.extend(run.map(finished));
    }

    /// Adds the runs of a plane over sampled facets, and empties the cells. The runs end where the surface does; the cuts
    /// in them state their mean slope and rate. Facets between the lines of the outline have only cuts.
    fn take_ends(&mut self, outline: &Outline, plane: usize, at: f64) {
        let of_outline = outline.parts(at).iter().map(|&ends| Covered { ends, seen: ends[1][0] - ends[0][0], cuts: Sums::default() });
        let mut covered: Vec<Covered> = of_outline.collect();
        let mut of_plane = Sums::default();
        for index in self.filled.drain(..) {
            let Cell { ends, sums } = std::mem::replace(&mut self.cells[index], EMPTY);
            of_plane.add(sums);
            covered.push(Covered { ends, seen: 0.0, cuts: sums });
        }
        self.total.add(of_plane);
        covered.sort_by(|a, b| a.ends[0][0].total_cmp(&b.ends[0][0]));
        let mut covered = covered.into_iter();
        let mut run = covered.next();
        while let Some(mut current) = run {
            run = covered.find(|next| !current.join(next, self.gap));
            let seen = if current.seen > 0.0 { current.seen } else { current.cuts.seen };
            // Short runs may be without a cut, and a cut through a corner has no length.
            let sums = [current.cuts, of_plane, self.total].into_iter().find(|sums| sums.length > 0.0);
            if let Some(sums) = sums.filter(|_| seen > 0.0) {
                let (share, stretch) = (seen / sums.seen, Stretch { plane, at, ends: current.ends });
                self.runs.push(Run { stretch, length: share * sums.length, seconds: share * sums.seconds });
            }
        }
    }

    /// Collects the facets of the strip after the last plane, or before the first one of a band, that this plane does not
    /// reach. The next plane decides which of them are slivers.
    pub(super) fn look_for_slivers(&mut self, ends: [f64; 2], facets: &[Reached]) {
        // Two strips without a plane between them are the last one of a band and the first one of the next.
        self.cut_slivers();
        let before = self.strip.beside[1];
        self.strip = Strip { ends, beside: [before, None] };
        let mut beyond_reach = std::mem::take(&mut self.beyond_reach);
        // Whether there is a plane after the strip, which halves the reach of the one before it, is not known yet.
        let (runs, reach) = (self.runs_of(before), self.strip.reach_within(2.0, self.spaced));
        let is_beyond = |interval: [f64; 2]| {
            let mut is_beyond = false;
            outside(interval, runs, Run::along, reach, |_| is_beyond = true);
            is_beyond
        };
        let is_candidate = |place: &u32| {
            let slice = &self.spaced.sweep.slices[*place as usize];
            // Steep facets set no spacing and need no pass; the extension of a wall is far from the surface. The whole
            // facet is compared first, which is quicker.
            self.spaced.allowed[*place as usize].is_finite() && is_beyond(slice.along()) && is_beyond(slice.along_between(ends))
        };
        beyond_reach.extend(facets.iter().map(|facet| facet.place).filter(is_candidate));
        self.beyond_reach = beyond_reach;
    }

    /// The runs of a plane; none at a border.
    fn runs_of(&self, pass: Option<Pass>) -> &[Run] {
        let Some(pass) = pass else { return &[] };
        let own = &self.runs[pass.first..];
        &own[..own.partition_point(|run| run.stretch.plane == pass.number)]
    }

    /// Extends the runs beside the last strip over its slivers: what neither of both planes reaches.
    pub(super) fn cut_slivers(&mut self) {
        let mut facets = std::mem::take(&mut self.beyond_reach);
        for places in facets.chunks(EXAMINED_AT_ONCE) {
            // The runs of the plane after the strip are stored behind those of the plane before it, and move last.
            for side in [1, 0] {
                self.extend(side, places);
            }
        }
        self.complete();
        facets.clear();
        self.beyond_reach = facets;
    }

    /// Extends the runs of the plane on this side of the strip over the slivers in its part.
    fn extend(&mut self, side: usize, places: &[u32]) {
        let Some((pass, part)) = self.strip.part(side) else { return };
        let slivers = self.slivers_of(part, places);
        if slivers.is_empty() {
            return;
        }
        let own = self.runs_of(Some(pass));
        let count = own.len();
        // Slivers may overlap along the pass, which is extended once. Narrow gaps are closed, between two slivers and between
        // a sliver and a run, which is one reach from it.
        let narrow = 2.0 * self.strip.reach_beyond_ends(self.spaced);
        let (mut parts, mut reached) = (Vec::new(), f64::NEG_INFINITY);
        for (place, [from, to]) in slivers {
            let from = if from <= reached + narrow { reached } else { from };
            outside([from - narrow, to + narrow], own, Run::along, 0.0, |[start, end]| {
                let start = if start <= from - narrow { from } else { start.max(reached) };
                let end = if end >= to + narrow { to } else { end };
                if start < end {
                    parts.push((place, [start, end]));
                    reached = end;
                }
            });
        }
        let mut runs = own.to_vec();
        runs.extend(parts.iter().map(|&(place, ends)| self.run_over(place, ends, &pass)));
        #[expect(clippy::cast_possible_truncation, reason = "planes are bounded")]
        let plane = pass.number as u32;
        let facet = |place: u32| self.spaced.sweep.covered[place as usize].facet;
        self.slivers.extend(parts.into_iter().map(|(place, ends)| Sliver { plane, facet: facet(place), ends }));
        runs.sort_by(|a, b| a.along()[0].total_cmp(&b.along()[0]));
        // Wider gaps are kept until all slivers are known, because there may be others in them.
        self.replace(side, pass, count, &joined(&runs, 0.0));
    }

    /// Joins the runs of the plane before the last strip, which is complete now, over gaps.
    fn complete(&mut self) {
        let Some(pass) = self.strip.beside[0] else { return };
        let runs = self.runs_of(Some(pass));
        if runs.windows(2).any(|pair| pair[1].along()[0] - pair[0].along()[1] <= self.gap) {
            let (count, joined) = (runs.len(), joined(runs, self.gap));
            self.replace(0, pass, count, &joined);
        }
    }

    /// Replaces the first `count` runs of the plane on this side of the strip.
    fn replace(&mut self, side: usize, pass: Pass, count: usize, runs: &[Run]) {
        self.runs.splice(pass.first..pass.first + count, runs.iter().copied());
        if let Some(next) = self.strip.beside[1].as_mut().filter(|_| side == 0) {
            next.first = pass.first + runs.len();
        }
    }

    /// The slivers of these facets in a part of the strip, sorted along the passes, each with the place of its facet.
    fn slivers_of(&self, part: [f64; 2], places: &[u32]) -> Vec<(u32, [f64; 2])> {
        let reach = self.strip.reach_beyond_ends(self.spaced);
        let [before, after] = self.strip.beside.map(|pass| self.runs_of(pass));
        let mut slivers = Vec::new();
        for &place in places {
            let interval = self.spaced.sweep.slices[place as usize].along_between(part);
            outside(interval, before, Run::along, reach, |left| {
                outside(left, after, Run::along, reach, |sliver| slivers.push((place, sliver)));
            });
        }
        slivers.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]));
        slivers
    }

    /// A run of a plane over a part of a facet beside it.
    fn run_over(&self, place: u32, ends: [f64; 2], pass: &Pass) -> Run {
        let (slice, at) = (&self.spaced.sweep.slices[place as usize], pass.plane.at);
        let length = (ends[1] - ends[0]) * slice.stretch();
        let ends = ends.map(|along| [along, slice.height(along, at)]);
        Run { stretch: Stretch { plane: pass.number, at, ends }, length, seconds: length * self.pace(place, &pass.plane) }
    }
}

/// Sorted runs of one plane, joined over gaps of up to `gap`.
fn joined(runs: &[Run], gap: f64) -> Vec<Run> {
    let mut joined: Vec<Run> = Vec::with_capacity(runs.len());
    for run in runs {
        match joined.last_mut() {
            Some(last) if run.along()[0] - last.along()[1] <= gap => last.join(run),
            _ => joined.push(*run),
        }
    }
    joined
}
