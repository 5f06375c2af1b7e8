//! How deep a path cuts into the part.

use super::judged::Judged;
use super::stations::Station;
use super::workpiece::Workpiece;
use crate::path::{self, EdgedFacet, Milled, ON_EDGES, Place, places_on_edges};
use rayon::prelude::*;

/// The deepest cut in mm of a path into the part: at the stations, at corners and edges of facets, and where these lead to on their
/// facets.
pub(super) fn deepest_cut(workpiece: &Workpiece, stations: &[Station], judged: &[Judged], milled: &Milled) -> f64 {
    let at_stations = stations.iter().zip(judged).filter_map(|(station, judged)| Some((station.place.on(workpiece), judged.left?)));
    let targets = (0..).zip(&workpiece.targets);
    let edged =
        targets.map(|(index, target)| EdgedFacet { facet: workpiece.facet_of(index), corners: target.corners, normal: target.normal });
    let at_edge = |place: Place| milled.left_at(place.point, place.normal).map(|left| (place, left.height));
    let on_edges = places_on_edges(edged, ON_EDGES).into_par_iter().with_min_len(64);
    let at_edges: Vec<(Place, f64)> = on_edges.filter_map(at_edge).collect();
    let corners_of = |facet: u32| workpiece.corners_of(facet).map(Into::into);
    path::deepest_cut(milled, &corners_of, at_stations.chain(at_edges)).map_or(0.0, |spot| -spot.left.height)
}
