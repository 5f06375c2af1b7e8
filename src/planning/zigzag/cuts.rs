//! The cuts of facets by the planes of a plan.

use super::march::Plane;
use super::plan::ZigzagPlan;
use super::slivers::{AT_ONCE, Strip, is_covered, parts_to_cut};
use super::spaced::Spaced;
use rayon::prelude::*;

/// The cut of a facet: both ends, along the pass and in height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    pub(super) facet: u32,
    pub(super) ends: [[f64; 2]; 2],
}

/// The number of facets and cuts between two checks for cancellation.
const TURN: usize = 16_384;

/// The cuts of each plane of a plan, and the parts of facets over which its runs are extended, if there are any. Once
/// `stop` returns true, it returns early, with fewer of them.
pub(super) fn cuts_by_plane(plan: &ZigzagPlan, spaced: &Spaced, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Vec<Cut>> {
    let mut by_plane = intersections(&plan.passes, spaced, stop);
    if plan.slivers > 0 {
        add_slivers(&mut by_plane, &plan.passes, spaced, stop);
    }
    by_plane
}

/// The intersections of facets with each plane; none once `stop` returns true.
fn intersections(planes: &[Plane], spaced: &Spaced, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Vec<Cut>> {
    let mut by_plane = vec![Vec::new(); planes.len()];
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
                let ends = [[from, slice.height(from, plane.at)], [to, slice.height(to, plane.at)]];
                cuts.push(Cut { facet: covered.facet, ends });
            }
        }
    }
    by_plane
}

/// Adds to the cuts of each plane the parts of facets over which its runs are extended, strip by strip.
fn add_slivers(by_plane: &mut [Vec<Cut>], planes: &[Plane], spaced: &Spaced, stop: &(dyn Fn() -> bool + Sync)) {
    let sweep = spaced.sweep;
    let mut runs: Vec<Vec<[f64; 2]>> = by_plane.par_iter().map(|cuts| joined(intervals(cuts), spaced.widest)).collect();
    for (strip, places) in uncovered(planes, &runs, spaced, stop) {
        for places in places.chunks(AT_ONCE).take_while(|_| !stop()) {
            for side in [1, 0] {
                let Some((plane, _)) = strip.part(side) else { continue };
                let beside = |plane: usize| runs[plane].as_slice();
                let parts = parts_to_cut(strip.slivers(side, places, spaced, beside, |&run| run), &runs[plane]);
                runs[plane] = joined(runs[plane].iter().copied().chain(parts.iter().map(|&(_, ends)| ends)), spaced.widest);
                by_plane[plane].extend(parts.into_iter().map(|(place, ends)| {
                    let slice = &sweep.slices[place as usize];
                    let ends = ends.map(|along| [along, slice.height(along, planes[plane].at)]);
                    Cut { facet: sweep.covered[place as usize].facet, ends }
                }));
            }
        }
    }
}

/// The strips with the places of the facets that the runs of neither plane cover, in their order.
fn uncovered(planes: &[Plane], runs: &[Vec<[f64; 2]>], spaced: &Spaced, stop: &(dyn Fn() -> bool + Sync)) -> Vec<(Strip<usize>, Vec<u32>)> {
    let sweep = spaced.sweep;
    let mut strips = Vec::new();
    for band in sweep.bands(spaced.widest) {
        let of_band = planes.partition_point(|plane| plane.at < band.low)..planes.partition_point(|plane| plane.at <= band.high);
        let first = strips.len();
        for number in of_band.start..=of_band.end {
            let [before, after] = [number.checked_sub(1), Some(number)].map(|plane| plane.filter(|plane| of_band.contains(plane)));
            let at = |plane: Option<usize>, border: f64| plane.map_or(border, |plane| planes[plane].at);
            strips.push((Strip { ends: [at(before, band.low), at(after, band.high)], beside: [before, after] }, Vec::new()));
        }
        for (place, covered) in (band.start..band.end).zip(&sweep.covered[band.start..band.end]) {
            if place % TURN == 0 && stop() {
                return Vec::new();
            }
            let of_band = &mut strips[first..];
            let met = of_band.partition_point(|(strip, _)| strip.ends[1] <= covered.low);
            for (strip, places) in of_band[met..].iter_mut().take_while(|(strip, _)| strip.ends[0] < covered.high) {
                let along = sweep.slices[place].along_between(strip.ends);
                let reach = strip.reach_beyond_ends(spaced);
                let is_covered = |plane: usize| is_covered(along, &runs[plane], |&run| run, reach);
                if covered.high > covered.low && !strip.beside.into_iter().flatten().any(is_covered) {
                    #[expect(clippy::cast_possible_truncation, reason = "as many as facets")]
                    places.push(place as u32);
                }
            }
        }
    }
    strips
}

/// The intervals of cuts along their plane.
fn intervals(cuts: &[Cut]) -> impl Iterator<Item = [f64; 2]> {
    cuts.iter().map(|cut| cut.ends.map(|[along, _]| along))
}

/// Intervals along a plane, joined over gaps of up to `gap`.
fn joined(intervals: impl Iterator<Item = [f64; 2]>, gap: f64) -> Vec<[f64; 2]> {
    let mut intervals: Vec<[f64; 2]> = intervals.collect();
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut runs: Vec<[f64; 2]> = Vec::new();
    for [from, to] in intervals {
        match runs.last_mut() {
            Some(run) if from - run[1] <= gap => run[1] = run[1].max(to),
            _ => runs.push([from, to]),
        }
    }
    runs
}
