//! How deep a path cuts into the part.

use super::judged::Judged;
use super::stations::Station;
use super::workpiece::Workpiece;
use crate::numerics::vector::{difference, length, mixed};
use crate::path::{self, Milled, Place};
use rayon::prelude::*;

/// About how many places on edges are looked at, corners first.
const ON_EDGES: usize = 20_000;

/// The deepest cut in mm of a path into the part: at the stations, at corners and edges of facets, and where these lead to on their
/// facets. Sharp points and edges are cut deepest, and few stations are near them.
pub(super) fn deepest_cut(workpiece: &Workpiece, stations: &[Station], judged: &[Judged], milled: &Milled) -> f64 {
    let at_stations = stations.iter().zip(judged).filter_map(|(station, judged)| Some((station.place.on(workpiece), judged.left?)));
    let at_edge = |place: Place| milled.left_at(place.point, place.normal).map(|left| (place, left.height));
    let at_edges: Vec<(Place, f64)> = on_edges(workpiece).into_par_iter().with_min_len(64).filter_map(at_edge).collect();
    let corners_of = |facet: u32| workpiece.corners_of(facet).map(Into::into);
    path::deepest_cut(milled, &corners_of, at_stations.chain(at_edges)).map_or(0.0, |spot| -spot.left.height)
}

/// Corners of the targets, evenly of all if they are many, and else places on their edges as well.
fn on_edges(workpiece: &Workpiece) -> Vec<Place> {
    let edges = || {
        (0..).zip(&workpiece.targets).flat_map(|(target, of_target)| {
            let place = Place { point: [0.0; 3], normal: of_target.normal, facet: workpiece.facet_of(target) };
            let corners = of_target.corners;
            [0, 1, 2].map(|first| (Place { point: corners[first], ..place }, corners[(first + 1) % 3]))
        })
    };
    let step = (3 * workpiece.targets.len()).div_ceil(ON_EDGES).max(1);
    let mut places: Vec<Place> = edges().map(|(corner, _)| corner).step_by(step).collect();
    let whole: f64 = edges().map(|(from, to)| length(difference(to, from.point))).sum();
    #[expect(clippy::cast_precision_loss, reason = "thousands")]
    let per_mm = ON_EDGES.saturating_sub(places.len()) as f64 / whole;
    for (from, to) in edges() {
        let count = (per_mm * length(difference(to, from.point))).floor();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "thousands")]
        let indices = 1..=count as u32;
        // The neighbour's edge runs the other way: its places are half-way between these.
        places.extend(indices.map(|index| Place { point: mixed(from.point, to, (f64::from(index) - 0.25) / count), ..from }));
    }
    places
}
