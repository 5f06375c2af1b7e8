//! Slivers: parts of a strip that neither neighbouring pass reaches.
//!
//! A pass at a small angle to a border, or across a narrow face, leaves the surface before its strip does. Where the
//! neighbouring pass is still on the surface, it cuts what lies between. Elsewhere the nearer pass continues over the
//! sliver, on the extended plane of its facet.

use super::march::Plane;
use super::spaced::Spaced;

/// A part of a facet beside a plane, over which the pass continues.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sliver {
    /// The index of the plane.
    pub(super) plane: u32,
    /// The index of the facet in the workpiece.
    pub(super) facet: u32,
    /// Both ends along the pass.
    pub(super) ends: [f64; 2],
}

/// Adds the parts of an interval that lie outside of all runs, widened by `reach` at both ends. The runs are sorted and do
/// not overlap; `along` returns their intervals.
pub(super) fn outside<R>([from, to]: [f64; 2], runs: &[R], along: impl Fn(&R) -> [f64; 2], reach: f64, mut add: impl FnMut([f64; 2])) {
    let first = runs.partition_point(|run| along(run)[1] + reach < from);
    let mut from = from;
    for run in &runs[first..] {
        let [start, end] = along(run);
        if start - reach >= to {
            break;
        }
        if start - reach > from {
            add([from, start - reach]);
        }
        from = from.max(end + reach);
    }
    if from < to {
        add([from, to]);
    }
}

/// A plane, and the index of the first of its runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pass {
    pub(super) number: usize,
    pub(super) plane: Plane,
    pub(super) first: usize,
}

/// A strip between two planes, or between a plane and the border of a band.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strip {
    /// Its ends across the passes.
    pub(super) ends: [f64; 2],
    /// The planes before and after it; `None` at a border.
    pub(super) beside: [Option<Pass>; 2],
}

impl Strip {
    /// The plane before (0) or after (1) it, and the part of the strip that is nearer to it: half of it, or the whole strip
    /// at a border.
    pub(super) fn part(&self, side: usize) -> Option<(Pass, [f64; 2])> {
        let plane = self.beside[side]?;
        let mut part = self.ends;
        if self.beside[1 - side].is_some() {
            part[1 - side] = f64::midpoint(part[0], part[1]);
        }
        Some((plane, part))
    }

    /// The distance along the passes over which a cutter cuts beyond the end of a run: as far as beside the run, which is
    /// the width of its part of the strip. Ends of runs on sampled facets are uncertain by a cell of the footprint.
    pub(super) fn reach_beyond_ends(&self, spaced: &Spaced) -> f64 {
        self.reach_within(if self.beside.iter().all(Option::is_some) { 2.0 } else { 1.0 }, spaced)
    }

    /// The same with a given number of parts.
    pub(super) fn reach_within(&self, parts: f64, spaced: &Spaced) -> f64 {
        let uncertain = spaced.workpiece.footprint.as_ref().map_or(0.0, |footprint| footprint.cell());
        ((self.ends[1] - self.ends[0]) / parts).max(uncertain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUNS: [[f64; 2]; 2] = [[0.0, 10.0], [20.0, 30.0]];

    fn parts(interval: [f64; 2], reach: f64) -> Vec<[f64; 2]> {
        let mut parts = Vec::new();
        outside(interval, &RUNS, |&run| run, reach, |part| parts.push(part));
        parts
    }

    #[test]
    fn what_lies_outside_of_runs_is_found_once() {
        assert_eq!(parts([-5.0, 35.0], 0.0), [[-5.0, 0.0], [10.0, 20.0], [30.0, 35.0]]);
        assert_eq!(parts([-5.0, 35.0], 2.0), [[-5.0, -2.0], [12.0, 18.0], [32.0, 35.0]]);
        assert_eq!(parts([5.0, 25.0], 4.5), [[14.5, 15.5]]);
        assert_eq!(parts([13.0, 14.0], 1.0), [[13.0, 14.0]]);
        assert_eq!(parts([31.0, 40.0], 0.0), [[31.0, 40.0]]);
        assert_eq!(parts([-9.0, -3.0], 1.0), [[-9.0, -3.0]]);
    }

    #[test]
    fn what_runs_reach_is_left_out() {
        for (interval, reach) in [([2.0, 10.0], 0.0), ([-1.0, 11.0], 1.0), ([22.0, 31.0], 1.0), ([5.0, 25.0], 5.0)] {
            assert!(parts(interval, reach).is_empty(), "{interval:?}");
        }
        // A facet that does not meet the strip has the empty interval.
        assert!(parts([f64::INFINITY, f64::NEG_INFINITY], 1.0).is_empty());
    }

    #[test]
    fn each_plane_has_its_half_of_a_strip_and_the_whole_at_a_border() {
        let pass = |number| Some(Pass { number, plane: Plane { at: 0.0, before: 1.0, after: 1.0, binding: None }, first: 0 });
        let parts = |beside| [0, 1].map(|side| Strip { ends: [2.0, 6.0], beside }.part(side).map(|(pass, part)| (pass.number, part)));
        assert_eq!(parts([pass(7), pass(8)]), [Some((7, [2.0, 4.0])), Some((8, [4.0, 6.0]))]);
        assert_eq!(parts([pass(7), None]), [Some((7, [2.0, 6.0])), None]);
        assert_eq!(parts([None, pass(8)]), [None, Some((8, [2.0, 6.0]))]);
        assert_eq!(parts([None; 2]), [None; 2]);
    }
}
