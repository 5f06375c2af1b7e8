//! Slivers: parts of a strip at which the passes on both its sides have left the surface.
//!
//! A pass at a small angle to a border, or across a narrow face, leaves the surface before its strip does. Where the
//! neighbouring pass is still on the surface, it cuts what lies between. Where it is not, nothing would: the nearer pass
//! then runs on over the sliver.

use super::spaced::Spaced;

/// Whether runs, widened by `reach` at both ends, contain an interval along the passes. The runs are sorted and do not
/// overlap; `along` returns their intervals.
pub(super) fn is_covered<R>([from, to]: [f64; 2], runs: &[R], along: impl Fn(&R) -> [f64; 2], reach: f64) -> bool {
    let first = runs.partition_point(|run| along(run)[1] + reach < from);
    let mut covered = from;
    for run in &runs[first..] {
        let [start, end] = along(run);
        if covered >= to || start - reach > covered {
            break;
        }
        covered = covered.max(end + reach);
    }
    first < runs.len() && covered >= to
}

/// The parts of slivers over which a pass runs on, each with the place of its facet: those outside of its runs, and of
/// slivers beside each other those of the first. Slivers are places with their intervals along the pass; runs are sorted
/// and do not overlap.
pub(super) fn parts_to_cut(mut slivers: Vec<(u32, [f64; 2])>, runs: &[[f64; 2]]) -> Vec<(u32, [f64; 2])> {
    slivers.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let mut parts = Vec::new();
    let (mut reached, mut next) = (f64::NEG_INFINITY, 0);
    for (place, [from, to]) in slivers {
        let mut from = from.max(reached);
        while runs.get(next).is_some_and(|run| run[1] <= from) {
            next += 1;
        }
        for run in runs[next..].iter().take_while(|run| run[0] < to) {
            if run[0] > from {
                parts.push((place, [from, run[0]]));
            }
            from = from.max(run[1]);
        }
        if to > from {
            parts.push((place, [from, to]));
        }
        reached = reached.max(to);
    }
    parts
}

/// The number of facets that are searched for slivers at once, so that these take little memory.
pub(super) const AT_ONCE: usize = 1024;

/// A strip between two planes, or between a plane and the border of a band.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strip<P> {
    /// Its ends across the passes.
    pub(super) ends: [f64; 2],
    /// The planes before and after it; `None` at a border.
    pub(super) beside: [Option<P>; 2],
}

impl<P: Copy> Strip<P> {
    /// The plane before (0) or after (1) it, and the part of the strip that is nearer to it: half of it, or the whole strip
    /// at a border.
    pub(super) fn part(self, side: usize) -> Option<(P, [f64; 2])> {
        let plane = self.beside[side]?;
        let mut part = self.ends;
        if self.beside[1 - side].is_some() {
            part[1 - side] = f64::midpoint(part[0], part[1]);
        }
        Some((plane, part))
    }

    /// The slivers among the facets at these places, in the part of the strip that belongs to one of its planes: what the
    /// runs of neither plane cover, each with its place and its interval along the passes. Facets too steep to set a
    /// spacing need no pass, and the extension of a wall to a plane beside it is far from the surface.
    pub(super) fn slivers<'r, R: 'r>(
        self,
        side: usize,
        places: &[u32],
        spaced: &Spaced,
        runs: impl Fn(P) -> &'r [R],
        along: impl Fn(&R) -> [f64; 2] + Copy,
    ) -> Vec<(u32, [f64; 2])> {
        let Some((_, part)) = self.part(side) else { return Vec::new() };
        let reach = self.reach_beyond_ends(spaced);
        let beside: Vec<&[R]> = self.beside.into_iter().flatten().map(runs).collect();
        let with_interval = |&place: &u32| (place, spaced.sweep.slices[place as usize].along_between(part));
        let tangent = |place: u32| &spaced.workpiece.tangents[spaced.sweep.covered[place as usize].facet as usize];
        let is_sliver = |&(place, interval): &(u32, [f64; 2])| {
            interval[0] < interval[1] && !tangent(place).is_steep && !beside.iter().any(|runs| is_covered(interval, runs, along, reach))
        };
        places.iter().map(with_interval).filter(is_sliver).collect()
    }

    /// The distance along the passes over which a cutter cuts beyond the end of a run: half the width of the strip, as
    /// it cuts beside the run. Ends of runs on sampled facets are as uncertain as the gaps between these.
    pub(super) fn reach_beyond_ends(self, spaced: &Spaced) -> f64 {
        (0.5 * (self.ends[1] - self.ends[0])).max(spaced.workpiece.sampling_gap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUNS: [[f64; 2]; 2] = [[0.0, 10.0], [20.0, 30.0]];

    #[test]
    fn an_interval_is_covered_within_reach_of_the_runs() {
        let covered = |interval, reach| is_covered(interval, &RUNS, |&run| run, reach);
        assert!(covered([2.0, 10.0], 0.0) && covered([-1.0, 11.0], 1.0) && covered([22.0, 31.0], 1.0));
        assert!(!covered([31.5, 31.5], 1.0) && !covered([2.0, 11.5], 1.0) && !covered([-2.0, 5.0], 1.0) && !covered([13.0, 14.0], 1.0));
        // Over the gap between both only if they reach each other.
        assert!(covered([5.0, 25.0], 5.0) && !covered([5.0, 25.0], 4.9));
        assert!(!is_covered([0.0, 1.0], &RUNS[..0], |&run| run, 9.0));
    }

    #[test]
    fn each_plane_has_its_half_of_a_strip_and_the_whole_at_a_border() {
        let parts = |beside| [0, 1].map(|side| Strip { ends: [2.0, 6.0], beside }.part(side));
        assert_eq!(parts([Some('a'), Some('b')]), [Some(('a', [2.0, 4.0])), Some(('b', [4.0, 6.0]))]);
        assert_eq!(parts([Some('a'), None]), [Some(('a', [2.0, 6.0])), None]);
        assert_eq!(parts([None, Some('b')]), [None, Some(('b', [2.0, 6.0]))]);
        assert_eq!(parts([None; 2]), [None; 2]);
    }

    #[test]
    fn a_pass_runs_over_the_gaps_once() {
        let parts = |slivers: &[[f64; 2]]| parts_to_cut((0..).zip(slivers.iter().copied()).collect(), &RUNS);
        assert_eq!(parts(&[[-5.0, 35.0]]), [(0, [-5.0, 0.0]), (0, [10.0, 20.0]), (0, [30.0, 35.0])]);
        assert_eq!(parts(&[[5.0, 22.0], [25.0, 33.0], [31.0, 36.0]]), [(0, [10.0, 20.0]), (1, [30.0, 33.0]), (2, [33.0, 36.0])]);
        // Sorted along the pass; one contains the other.
        assert_eq!(parts(&[[15.0, 16.0], [12.0, 18.0]]), [(1, [12.0, 18.0])]);
        assert!(parts(&[[1.0, 9.0], [20.0, 30.0]]).is_empty());
    }
}
