//! The order in which runs are cut, and their senses.

use super::runs::{Run, RunTip};
use super::settings::Pattern;

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
