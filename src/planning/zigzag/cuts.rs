//! The cuts of a plan's planes through the facets, and the runs that they form.

use super::heading::Heading;
use super::plan::ZigzagPlan;
use super::regions::Stretch;
use super::spaced::Spaced;
use super::sweep::Slice;
use crate::surface::FinishFacet;
use rayon::prelude::*;

/// The cut of a facet: both ends, along the pass and in height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    pub(super) facet: u32,
    pub(super) ends: [[f64; 2]; 2],
}

/// The number of facets and cuts between two checks for cancellation.
const TURN: usize = 16_384;

/// The cuts of each plane of a plan in the order in which they begin, those over slivers among them; none once `stop` returns
/// true.
pub(super) fn cuts_by_plane(plan: &ZigzagPlan, spaced: &Spaced, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Vec<Cut>> {
    let planes = &plan.passes;
    let mut by_plane = vec![Vec::new(); planes.len()];
    let cut = |facet: u32, slice: &Slice, at: f64, ends: [f64; 2]| Cut { facet, ends: ends.map(|along| [along, slice.height(along, at)]) };
    let mut examined = 0;
    for (covered, slice) in spaced.sweep.covered.iter().zip(&spaced.sweep.slices) {
        examined += 1;
        if examined >= TURN {
            examined = 0;
            if stop() {
                return vec![Vec::new(); planes.len()];
            }
        }
        let first = planes.partition_point(|plane| plane.at < covered.low);
        for (plane, cuts) in planes[first..].iter().zip(&mut by_plane[first..]) {
            if plane.at >= covered.high {
                break;
            }
            examined += 1;
            let [from, to] = slice.cut(plane.at);
            if to > from {
                cuts.push(cut(covered.facet, slice, plane.at, [from, to]));
            }
        }
    }
    for sliver in &plan.slivers {
        let (slice, plane) = (Slice::new(sliver.facet, spaced.workpiece, spaced.sweep.heading), sliver.plane as usize);
        by_plane[plane].push(cut(sliver.facet, &slice, planes[plane].at, sliver.ends));
    }
    by_plane.par_iter_mut().for_each(|cuts| cuts.sort_by(|a, b| a.ends[0][0].total_cmp(&b.ends[0][0])));
    by_plane
}

/// The runs of one plane: its cuts, split at gaps wider than the cutter.
pub(super) fn runs_of(plane: usize, at: f64, cuts: Vec<Cut>, spaced: &Spaced) -> Vec<(Stretch, Vec<Cut>)> {
    let mut runs: Vec<(Stretch, Vec<Cut>)> = Vec::new();
    for cut in cuts {
        let [from, to] = cut.ends;
        match runs.last_mut() {
            Some((stretch, cuts)) if from[0] - stretch.ends[1][0] <= spaced.widest => {
                if to[0] > stretch.ends[1][0] {
                    stretch.ends[1] = to;
                }
                cuts.push(cut);
            }
            _ => runs.push((Stretch { plane, at, ends: [from, to] }, vec![cut])),
        }
    }
    runs
}

/// The largest number of cuts of a plan.
pub(super) fn count_of_cuts(plan: &ZigzagPlan, facets: &[FinishFacet]) -> usize {
    let heading = Heading::new(plan.direction);
    let crossed = |facet: &FinishFacet| {
        let across = facet.corners.map(|[x, y, _]| heading.across(x, y));
        let before = |at: f64| plan.passes.partition_point(|plane| plane.at < at);
        before(across.into_iter().fold(f64::NEG_INFINITY, f64::max)) - before(across.into_iter().fold(f64::INFINITY, f64::min))
    };
    let cuts: usize = facets.par_iter().with_min_len(4096).map(crossed).sum();
    cuts + plan.slivers.len()
}
