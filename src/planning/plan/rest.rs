//! The places that another cutter cannot reach: what a plan of the rest machines.

use super::drawn_places::{DrawnPlace, drawn_from};
use super::stations::{Station, stations};
use super::workpiece::Workpiece;
use crate::milling::Profile;

/// The most places that are looked at to find enough that are left.
const MOST_LOOKED_AT: usize = 200_000;

/// The places at which `profile` stands more than `height` mm over the surface, and by more than coarse facets are off it. Once `stop` returns true, the result must be
/// discarded.
pub(super) fn left_by(
    workpiece: &Workpiece,
    profile: &Profile,
    places: &[DrawnPlace],
    height: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<DrawnPlace> {
    let on = stations(workpiece, profile, places, height, stop);
    let is_left = |station: &&Station| station.lift > height + workpiece.sagitta_of(station.place.target);
    on.iter().filter(is_left).map(|station| station.place).collect()
}

/// About `count` places of the targets that `belongs` accepts, of those that `is_left` leaves, or as many as are found.
pub(super) fn drawn_until(
    workpiece: &Workpiece,
    count: usize,
    seed: u64,
    belongs: &dyn Fn(usize) -> bool,
    left: &dyn Fn(Vec<DrawnPlace>) -> Vec<DrawnPlace>,
) -> Vec<DrawnPlace> {
    let first = left(drawn_from(workpiece, count, seed, belongs));
    if first.is_empty() || first.len() >= count / 2 {
        return first;
    }
    left(drawn_from(workpiece, (count * count / first.len()).min(MOST_LOOKED_AT), seed, belongs))
}
