//! The order in which runs are cut: region by region, and within a region plane by plane.
//!
//! A region is a chain of runs in consecutive planes. Each of its runs overlaps exactly one run of the next plane,
//! which overlaps no other run of this plane. A gap that begins or ends divides or joins regions. A region is finished
//! before the cutter leaves it, so that a gap costs one lift for each region and not one for each plane that it
//! crosses. The next region, and the corner at which the cutter enters it, are those with the quickest link.

use super::links::{End, Links};
use super::settings::Pattern;
use std::collections::VecDeque;

/// The position of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    /// The index of its plane, rising across the passes.
    pub(super) plane: usize,
    /// The coordinate of the plane across the passes.
    pub(super) at: f64,
    /// Both ends, each with its coordinate along the pass and its height; the end with the smaller coordinate comes
    /// first.
    pub(super) ends: [[f64; 2]; 2],
}

impl Stretch {
    /// Its first (0) or its second (1) end.
    pub(super) fn end(&self, side: usize) -> End {
        let [along, height] = self.ends[side];
        End { place: [along, self.at, height], along: [self.ends[0][0], self.ends[1][0]], plane: self.plane }
    }
}

/// A run in the order of cutting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Leg {
    /// The index of the run.
    pub(super) run: usize,
    /// Whether it is cut in the direction of the passes.
    pub(super) forward: bool,
}

/// The largest number of links to other regions that are compared, over all regions together. The comparisons take a
/// few milliseconds.
const MOST_COMPARED: usize = 16_384;

/// The order of cutting. `runs` are sorted by plane, and within a plane along it.
pub(super) fn in_order(runs: &[Stretch], pattern: Pattern, links: &Links) -> Vec<Leg> {
    if pattern == Pattern::OneWay {
        return (0..runs.len()).map(|run| Leg { run, forward: true }).collect();
    }
    // The regions that are compared are the first ones, so that removing one moves few others.
    let mut regions = VecDeque::from(regions(runs, links.longest));
    let mut legs: Vec<Leg> = Vec::with_capacity(runs.len());
    let compared = (MOST_COMPARED / regions.len().max(1)).clamp(1, 64);
    while !regions.is_empty() {
        let (index, from_last, forward) = match legs.last() {
            None => (0, false, true),
            Some(last) => quickest(regions.iter().take(compared), runs, runs[last.run].end(usize::from(last.forward)), links),
        };
        let Some(region) = regions.remove(index) else { break };
        let mut forward = forward;
        let mut add = |run: usize| {
            legs.push(Leg { run, forward });
            forward = !forward;
        };
        if from_last { region.into_iter().rev().for_each(&mut add) } else { region.into_iter().for_each(&mut add) }
    }
    legs
}

/// The region with the quickest link from `end`; whether it is entered at its last plane; and whether its first run is
/// cut in the direction of the passes.
fn quickest<'a>(regions: impl Iterator<Item = &'a Vec<usize>>, runs: &[Stretch], end: End, links: &Links) -> (usize, bool, bool) {
    let mut best = (f64::INFINITY, (0, false, true));
    for (index, region) in regions.enumerate() {
        for from_last in [false, true] {
            let first = if from_last { region.last() } else { region.first() };
            for forward in [true, false] {
                let seconds = first.map_or(f64::INFINITY, |&first| links.between(end, runs[first].end(usize::from(!forward))).seconds);
                if seconds < best.0 {
                    best = (seconds, (index, from_last, forward));
                }
            }
        }
    }
    best.1
}

/// The chains of runs, in the order of their first runs.
fn regions(runs: &[Stretch], longest_link: f64) -> Vec<Vec<usize>> {
    /// The runs of the next or the previous plane that overlap a run along the passes.
    #[derive(Clone, Copy)]
    enum Beside {
        None,
        One(usize),
        Several,
    }
    let mut after = vec![Beside::None; runs.len()];
    let mut before = vec![Beside::None; runs.len()];
    let add = |beside: &mut Beside, run: usize| *beside = if matches!(beside, Beside::None) { Beside::One(run) } else { Beside::Several };
    let planes: Vec<&[Stretch]> = runs.chunk_by(|a, b| a.plane == b.plane).collect();
    let mut start = 0;
    for pair in planes.windows(2) {
        let next_start = start + pair[0].len();
        if pair[1][0].plane == pair[0][0].plane + 1 && pair[1][0].at - pair[0][0].at <= longest_link {
            let mut first = 0;
            for (index, run) in pair[0].iter().enumerate() {
                // Runs of a plane are sorted: a run that ends before this one begins also ends before all later ones.
                while first < pair[1].len() && pair[1][first].ends[1][0] <= run.ends[0][0] {
                    first += 1;
                }
                for (other, beside) in pair[1].iter().enumerate().skip(first).take_while(|(_, other)| other.ends[0][0] < run.ends[1][0]) {
                    if beside.ends[1][0] > run.ends[0][0] {
                        add(&mut after[start + index], next_start + other);
                        add(&mut before[next_start + other], start + index);
                    }
                }
            }
        }
        start = next_start;
    }
    let next = |run: usize| match after[run] {
        Beside::One(next) if matches!(before[next], Beside::One(_)) => Some(next),
        _ => None,
    };
    let begins = |run: &usize| match before[*run] {
        Beside::One(previous) => !matches!(after[previous], Beside::One(_)),
        _ => true,
    };
    (0..runs.len()).filter(begins).map(|run| std::iter::successors(Some(run), |&run| next(run)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Machine, Preset};

    fn run(plane: u32, from: f64, to: f64) -> Stretch {
        Stretch { plane: plane as usize, at: f64::from(plane), ends: [[from, 0.0], [to, 0.0]] }
    }

    fn ordered(runs: &[Stretch]) -> Vec<(usize, bool)> {
        let machine = Machine::from(Preset::named("five_axis_vmc").unwrap().limits);
        let links = Links::new(&machine, Pattern::Zigzag, 80.0, 2.0, 10.0);
        in_order(runs, Pattern::Zigzag, &links).into_iter().map(|leg| (leg.run, leg.forward)).collect()
    }

    #[test]
    fn one_region_alternates() {
        let runs: Vec<Stretch> = (0..4).map(|plane| run(plane, 0.0, 30.0)).collect();
        assert_eq!(ordered(&runs), [(0, true), (1, false), (2, true), (3, false)]);
    }

    #[test]
    fn a_hole_makes_two_regions_beside_it_and_each_is_finished_before_the_next() {
        let mut runs = vec![run(0, 0.0, 30.0)];
        for plane in 1..4 {
            runs.extend([run(plane, 0.0, 10.0), run(plane, 20.0, 30.0)]);
        }
        runs.push(run(4, 0.0, 30.0));
        // Up on the right side, where the first run ends, across the last plane, and down on the left side.
        let order: Vec<usize> = ordered(&runs).into_iter().map(|(run, _)| run).collect();
        assert_eq!(order, [0, 2, 4, 6, 7, 5, 3, 1]);
    }

    #[test]
    fn pieces_behind_each_other_are_finished_one_by_one() {
        let runs: Vec<Stretch> = (0..3).flat_map(|plane| [run(plane, 0.0, 10.0), run(plane, 50.0, 60.0)]).collect();
        let order: Vec<usize> = ordered(&runs).into_iter().map(|(run, _)| run).collect();
        assert_eq!(order[..3], [0, 2, 4]);
    }
}
