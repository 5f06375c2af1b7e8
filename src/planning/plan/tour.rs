//! The path of a plan: its runs in the order and senses in which they are cut, with every link and lift between them as moves.

use super::link::{Link, Linker};
use super::runs::{Run, RunTip};
use super::settings::{Pattern, PlanSettings};
use super::spacing::Prepared;
use super::travel;
use super::workpiece::Workpiece;
use crate::motion::{Machine, TimedMove};
use crate::numerics::vector::mixed;
use crate::path::{Move, MoveKind};
use crate::quantity::Speed;
use rayon::prelude::*;

/// A run in its place of the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Leg {
    pub(super) run: usize,
    /// Whether it is cut from its last tip to its first.
    pub(super) reversed: bool,
    /// The tip of a closed run at which it begins and ends.
    start: usize,
}

impl Leg {
    /// The tips in the order in which they are cut.
    pub(super) fn tips<'a>(&self, runs: &'a [Run]) -> Vec<&'a RunTip> {
        let run = &runs[self.run];
        match (run.closed, self.reversed) {
            (true, _) => run.tips[self.start..].iter().chain(&run.tips[..=self.start]).collect(),
            (false, true) => run.tips.iter().rev().collect(),
            (false, false) => run.tips.iter().collect(),
        }
    }

    /// Where it begins.
    pub(super) fn begin(&self, runs: &[Run]) -> [f64; 3] {
        let run = &runs[self.run];
        if run.closed { run.tips[self.start].tip } else { run.end(self.reversed) }
    }

    /// Where it ends.
    fn end(&self, runs: &[Run]) -> [f64; 3] {
        let run = &runs[self.run];
        if run.closed { run.tips[self.start].tip } else { run.end(!self.reversed) }
    }
}

/// Two tips of a run up to this many mm apart are twins.
const TWINS: f64 = 2e-3;

/// The tips of a run without those that lie beside a twin and on the path of the others: where targets begin and end, and where stretches
/// are cut off, tips may be a micrometre apart, and controls slow down there.
fn without_twins(tips: Vec<&RunTip>) -> Vec<&RunTip> {
    let mut is_needed = vec![true; tips.len()];
    for at in 1..tips.len().saturating_sub(1) {
        is_needed[at] = !(is_needed[at - 1] && is_needless([tips[at - 1], tips[at], tips[at + 1]]));
    }
    tips.into_iter().zip(is_needed).filter_map(|(tip, is_needed)| is_needed.then_some(tip)).collect()
}

/// Whether a tip has a twin before or after it, the path is the same without it, and the moves at the feed rate of a target become no
/// longer than by the distance of twins.
fn is_needless([before, tip, after]: [&RunTip; 3]) -> bool {
    let [to_before, to_after] = [before, after].map(|other| travel::distance(tip.tip, other.tip));
    let straight = mixed(before.tip, after.tip, to_before / (to_before + to_after).max(f64::MIN_POSITIVE));
    let [twin, other] = if to_before < to_after { [before, after] } else { [after, before] };
    let keeps_rates = other.target.is_some() || tip.target.is_some() == twin.target.is_some();
    keeps_rates && to_before.min(to_after) <= TWINS && travel::distance(tip.tip, straight) <= travel::NEGLIGIBLE
}

/// How the next run is chosen. Which of the two has the shorter links differs from part to part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// On a neighbouring line, the nearest end within reach, ahead before behind; where there is none, the nearest end of all.
    ByLines,
    /// The nearest end of all.
    ByEnds,
}

/// The runs in an order with few lifts; links up to `near` mm may be on the surface. One way, every run begins at its first tip.
///
/// `runs` are sorted by line; runs over what lines miss, without a line, follow.
pub(super) fn in_order(runs: &[Run], by: Order, pattern: Pattern, near: f64) -> Vec<Leg> {
    let mut order = Vec::with_capacity(runs.len());
    if runs.is_empty() {
        return order;
    }
    let mut open: Vec<bool> = vec![true; runs.len()];
    let lines = Lines::of(runs);
    let mut ahead = true;
    let mut next = Some(Leg { run: 0, reversed: false, start: 0 });
    while let Some(leg) = next {
        open[leg.run] = false;
        order.push(leg);
        let from = leg.end(runs);
        let neighbour = runs[leg.run].line.filter(|_| by == Order::ByLines).and_then(|line| {
            let sides = if ahead { [line.checked_add(1), line.checked_sub(1)] } else { [line.checked_sub(1), line.checked_add(1)] };
            sides.into_iter().enumerate().find_map(|(turned, side)| {
                let (leg, _) = nearest(runs, &open, lines.of_line(side?), pattern, from)?;
                let end = leg.begin(runs);
                let is_near = pattern == Pattern::OneWay || (end[0] - from[0]).hypot(end[1] - from[1]) <= near;
                is_near.then_some((leg, turned == 1))
            })
        });
        next = match neighbour {
            Some((leg, turned)) => {
                ahead ^= turned;
                Some(leg)
            }
            None => nearest(runs, &open, 0..runs.len(), pattern, from).map(|found| found.0),
        };
    }
    order
}

/// The millimetres across that a millimetre up or down counts for.
const LEVELS_APART: f64 = 2.0;

/// A link up or down a wall costs more than one of its length on a level.
fn link_length(to: [f64; 3], from: [f64; 3]) -> f64 {
    (to[0] - from[0]).hypot(to[1] - from[1]) + LEVELS_APART * (to[2] - from[2]).abs()
}

/// The tip of a closed run that is nearest, or nearly so, and its distance: first of some tips around it, then of those beside
/// the nearest of them.
fn nearest_tip(tips: &[RunTip], from: [f64; 3]) -> (usize, f64) {
    const AROUND: usize = 32;
    let count = tips.len();
    let step = count.div_ceil(AROUND).max(1);
    let of = |at: usize| (at, link_length(tips[at].tip, from));
    let nearer = |a: (usize, f64), b: (usize, f64)| if b.1 < a.1 { b } else { a };
    let coarse = (0..count).step_by(step).map(of).reduce(nearer).map_or(0, |found| found.0);
    (0..2 * step).map(|offset| of((coarse + count + offset - step) % count)).reduce(nearer).unwrap_or((0, f64::INFINITY))
}

/// The open run with the nearest end, and its distance.
fn nearest(runs: &[Run], open: &[bool], among: std::ops::Range<usize>, pattern: Pattern, from: [f64; 3]) -> Option<(Leg, f64)> {
    let senses: &[bool] = if pattern == Pattern::OneWay { &[false] } else { &[false, true] };
    let mut best: Option<(Leg, f64)> = None;
    for run in among.filter(|run| open[*run]) {
        if runs[run].closed {
            let (start, distance) = nearest_tip(&runs[run].tips, from);
            if best.is_none_or(|best| distance < best.1) {
                best = Some((Leg { run, reversed: false, start }, distance));
            }
            continue;
        }
        for &reversed in senses {
            let distance = link_length(runs[run].end(reversed), from);
            if best.is_none_or(|best| distance < best.1) {
                best = Some((Leg { run, reversed, start: 0 }, distance));
            }
        }
    }
    best
}

/// Where the runs of each line are.
struct Lines(Vec<std::ops::Range<usize>>);

impl Lines {
    fn of(runs: &[Run]) -> Self {
        let count = runs.iter().filter_map(|run| run.line).max().map_or(0, |last| last + 1);
        let mut ranges = vec![0..0; count];
        for (index, line) in runs.iter().enumerate().filter_map(|(index, run)| run.line.map(|line| (index, line))) {
            if ranges[line].is_empty() {
                ranges[line] = index..index + 1;
            } else {
                ranges[line].end = index + 1;
            }
        }
        Self(ranges)
    }

    fn of_line(&self, line: usize) -> std::ops::Range<usize> {
        self.0.get(line).cloned().unwrap_or(0..0)
    }
}

/// How the tool gets to a point of the path, and what it does there.
#[derive(Debug, Clone, Copy)]
pub(super) struct TourPoint {
    /// On links it finishes nothing.
    pub(super) at: RunTip,
    pub(super) kind: MoveKind,
    /// The feed rate of the move to this point in mm/s.
    pub(super) rate: f64,
}

/// Times, lengths and counts of a path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TourFigures {
    /// The time of all runs and links, in s.
    pub seconds: f64,
    /// The number of runs.
    pub runs: usize,
    /// The length of all runs, in mm.
    pub run_length: f64,
    /// The number of links.
    pub links: usize,
    /// The length of all links, the approach to the first run and the retreat from the last, in mm.
    pub link_length: f64,
    /// The number of links over the clearance height.
    pub lifts: usize,
    /// The time that runs and links would take without acceleration, in s.
    pub moving_seconds: f64,
    /// The time that the runs would take without stops, in s.
    pub cutting_seconds: f64,
}

/// A path and its figures.
#[derive(Debug, Clone, Default)]
pub(super) struct Tour {
    pub(super) points: Vec<TourPoint>,
    /// The points at which runs begin.
    pub(super) run_starts: Vec<usize>,
    pub(super) figures: TourFigures,
}

impl Tour {
    /// The path of runs, from the clearance height and back to it. Short links without steps stay on the surface where that is
    /// sooner than over the clearance height.
    pub(super) fn of(
        workpiece: &Workpiece,
        prepared: &Prepared,
        settings: &PlanSettings,
        runs: &[Run],
        order: Order,
        chord_tolerance: f64,
    ) -> Self {
        let linker = Linker::new(workpiece, prepared, settings, chord_tolerance);
        let order = in_order(runs, order, settings.pattern, linker.near());
        let runs: Vec<Vec<&RunTip>> = order.iter().map(|leg| without_twins(leg.tips(runs))).collect();
        let mut tour = Self::default();
        let Some((first, last)) = runs.first().and_then(|run| run.first()).zip(runs.last().and_then(|run| run.last())) else { return tour };
        let links: Vec<Link> = runs.par_windows(2).map(|pair| linker.between(&pair[0], &pair[1])).collect();
        tour.figures.links = links.len();
        tour.figures.lifts = links.iter().filter(|link| !link.rapid.is_empty()).count();
        let of_links: usize = links.iter().map(|link| link.rapid.len() + link.fed.len()).sum();
        tour.points.reserve(of_links + runs.iter().map(Vec::len).sum::<usize>());
        for (link, run) in std::iter::once(linker.approach(first.tip)).chain(links).zip(&runs) {
            tour.add_link(&link, prepared, settings);
            tour.add_run(workpiece, prepared, settings, run);
        }
        tour.add_link(&linker.retreat(last.tip), prepared, settings);
        if settings.machine.path_tolerance.is_some() {
            tour.figures.seconds = settings.machine.time_of(tour.timed_moves()).seconds();
        }
        tour
    }

    /// The time in s on a control without path tolerance that also stops in corners of more than 45 deg.
    pub(super) fn seconds_with_stops(&self, machine: &Machine) -> f64 {
        machine.time_of(self.timed_moves()).seconds()
    }

    /// The moves with their feed rates.
    fn timed_moves(&self) -> impl Iterator<Item = TimedMove> {
        self.points.windows(2).map(|pair| TimedMove {
            from: pair[0].at.tip,
            to: pair[1].at.tip,
            feed_rate: (pair[1].kind != MoveKind::Rapid).then(|| Speed::computed(pair[1].rate)),
        })
    }

    /// The moves of the path.
    pub(super) fn moves(&self) -> Vec<Move> {
        self.points.windows(2).map(|pair| Move { from: pair[0].at.tip, to: pair[1].at.tip, kind: pair[1].kind }).collect()
    }

    fn add_run(&mut self, workpiece: &Workpiece, prepared: &Prepared, settings: &PlanSettings, tips: &[&RunTip]) {
        self.run_starts.push(self.points.len());
        let (mut length, mut seconds) = (0.0, 0.0);
        let mut last: Option<&RunTip> = None;
        for &tip in tips {
            let (step, rate) = match last {
                None => (0.0, prepared.link_rate),
                Some(last) => (travel::distance(last.tip, tip.tip), rate_of_move(workpiece, prepared, last, tip)),
            };
            length += step;
            seconds += step / rate;
            match self.points.last_mut() {
                Some(point) if last.is_none() && travel::distance(point.at.tip, tip.tip) <= travel::NEGLIGIBLE => point.at = *tip,
                _ => self.points.push(TourPoint { at: *tip, kind: MoveKind::Cut, rate }),
            }
            last = Some(tip);
        }
        if let Some(start) = self.run_starts.last_mut() {
            *start = (*start).min(self.points.len().saturating_sub(tips.len()));
        }
        self.figures.runs += 1;
        self.figures.run_length += length;
        self.figures.cutting_seconds += seconds;
        self.figures.moving_seconds += seconds;
        self.figures.seconds += travel::run(length, seconds, &settings.machine);
    }

    fn add_link(&mut self, link: &Link, prepared: &Prepared, settings: &PlanSettings) {
        let point = |&tip: &[f64; 3], kind: MoveKind, rate: f64| TourPoint { at: RunTip { tip, target: None, contact: tip }, kind, rate };
        let rapid_rate = settings.machine.rapid_rate.mm_s();
        self.points.extend(link.rapid.iter().map(|tip| point(tip, MoveKind::Rapid, rapid_rate)));
        self.points.extend(link.fed.iter().map(|tip| point(tip, MoveKind::Link, prepared.link_rate)));
        self.figures.link_length += link.length;
        self.figures.seconds += link.seconds;
        self.figures.moving_seconds += link.moving_seconds;
    }
}

/// The feed rate in mm/s of the move between two tips of a run: the lower of both ends'.
fn rate_of_move(workpiece: &Workpiece, prepared: &Prepared, from: &RunTip, to: &RunTip) -> f64 {
    let along = [to.tip[0] - from.tip[0], to.tip[1] - from.tip[1]];
    let length = along[0].hypot(along[1]);
    let rate = |tip: &RunTip| {
        tip.target.filter(|_| length > 0.0).map(|target| {
            let tangent = &workpiece.tangents[target];
            let (cos_alpha, _) = tangent.alpha(along.map(|part| part / length));
            prepared.feeds.rate(tangent, cos_alpha, 1.0)
        })
    };
    match (rate(from), rate(to)) {
        (Some(a), Some(b)) => a.min(b),
        (Some(a), None) | (None, Some(a)) => a,
        (None, None) => prepared.link_rate,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tip_beside_its_twin_is_left_out_where_the_path_stays_the_same() {
        let needed = |line: &[(f64, f64, bool)]| -> Vec<f64> {
            let tip =
                |&(x, z, is_target): &(f64, f64, bool)| RunTip { tip: [x, 0.0, z], target: is_target.then_some(0), contact: [0.0; 3] };
            let tips: Vec<RunTip> = line.iter().map(tip).collect();
            without_twins(tips.iter().collect()).iter().map(|tip| tip.tip[0]).collect()
        };
        let gap = |height: f64| {
            [(0.0, 0.0, true), (1.0, 0.0, true), (1.001, height, false), (2.0, 0.0, false), (2.001, 0.0, true), (3.0, 0.0, true)]
        };
        assert_eq!(needed(&gap(0.0)), [0.0, 1.001, 2.0, 3.0]);
        assert_eq!(needed(&gap(0.001)), [0.0, 1.0, 1.001, 2.0, 3.0]);
        // A target between two gaps stays one, and a run keeps its ends.
        assert_eq!(needed(&[(0.0, 0.0, false), (1.0, 0.0, false), (1.001, 0.0, true), (2.0, 0.0, false)]), [0.0, 1.0, 1.001, 2.0]);
        assert_eq!(needed(&[(0.0, 0.0, true), (0.001, 0.0, true), (1.0, 0.0, true)]), [0.0, 1.0]);
        assert_eq!(needed(&[(0.0, 0.0, true), (1.0, 0.0, true), (1.001, 0.0, true)]), [0.0, 1.001]);
        // Of many tips close together, no two neighbours are left out.
        let close: Vec<(f64, f64, bool)> = (0..7).map(|at| (0.001 * f64::from(at), 0.0, true)).collect();
        assert_eq!(needed(&close), [0.0, 0.002, 0.004, 0.006]);
    }
}
