//! For each place of the surface, the tip at which a cutter finishes it, and whether the cutter can stand there.

use super::drawn_places::DrawnPlace;
use super::workpiece::Workpiece;
use crate::milling::Profile;
use crate::path::Standing;
use rayon::prelude::*;

/// A place with the tip that finishes it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Station {
    pub(super) place: DrawnPlace,
    /// Where the axis stands, seen from above.
    pub(super) axis: [f64; 2],
    /// The height of the tip that touches the place, in mm.
    pub(super) tip: f64,
    /// The height in mm by which other facets hold the cutter above its contact with the place; 0 where it can touch it.
    pub(super) lift: f64,
}

/// The stations of places for a cutter; `tolerance` is the lift in mm that does not count. Once `stop` returns true, the
/// result must be discarded.
pub(super) fn stations(
    workpiece: &Workpiece,
    profile: &Profile,
    places: &[DrawnPlace],
    tolerance: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<Station> {
    let station = |place: &DrawnPlace| {
        if stop() {
            return None;
        }
        let Standing { axis, tip, lift } = Standing::at(&workpiece.drop, profile, &place.on(workpiece), tolerance);
        Some(Station { place: *place, axis, tip, lift })
    };
    places.par_iter().with_min_len(64).filter_map(station).collect()
}
