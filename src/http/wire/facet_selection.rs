//! The member `select`: which facets of a surface are machined.

use super::surface::{point, point_schema};
use crate::http::codes::RequestFault;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, List, Quantity, Whole, members};
use crate::quantity::Angle;
use crate::surface::mesh::{Selection, SelectionError};
use serde_json::value::RawValue;
use utoipa::openapi::{RefOr, Schema};

/// The member of `select` that lists pieces. The fault of an unknown piece points to it.
pub(crate) const PIECES_NAME: &str = PIECES.name;
/// The member of `select` that lists facets. The fault of an unknown facet points to it.
pub(crate) const FACETS_NAME: &str = FACETS.name;

members! {
    /// The members of a selection.
    pub(crate) struct SelectionMembers for SelectKind ("Selection", "Conditions that a facet must meet, all of them, to be machined") -> Selection {
        slopes: optional SLOPES: List<Quantity<Angle>> = ("slope_deg",
            List { item: Quantity::slope(60.0), about_item: "an angle from the horizontal", fewest: 2, most: 2 },
            "the smallest and the largest slope"),
        bounds: optional BOX: BoxKind = ("box_mm", BoxKind, "a box in which the centroid of a facet must lie"),
        pieces: optional PIECES: List<Whole> = ("pieces",
            List { item: Whole { minimum: 0, maximum: 4_000_000_000, example: 0 }, about_item: "a piece's number", fewest: 1, most: 1000 },
            "the numbers of connected pieces, from 0 in the order of their first facets"),
        facets: optional FACETS: List<List<Whole>> = ("facets",
            List {
                item: List { item: Whole { minimum: 0, maximum: 4_000_000_000, example: 0 }, about_item: "a facet's number", fewest: 2, most: 2 },
                about_item: "the first and the last facet of a range",
                fewest: 1,
                most: 10_000,
            },
            "ranges of facets, numbered from 0 in the order of the file or the mesh; a polygon is as many facets as triangles"),
    }
}

impl SelectionMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Selection, Faulted> {
        let SelectionMembers { slopes, bounds, pieces, facets } = self;
        let (mut selection, mut refused) = (Selection::all(), Ok(()));
        // Each condition is checked, even if another has a fault.
        let mut narrow =
            |name, narrowed: Result<Option<Result<Selection, SelectionError>>, Faulted>, selection: &mut Selection| match narrowed {
                Ok(None) => {}
                Ok(Some(Ok(narrowed))) => *selection = narrowed,
                Ok(Some(Err(error))) => refused = Err(faults.add(&path.member(name), RequestFault::OutOfRange, error)),
                Err(faulted) => refused = Err(faulted),
            };
        let so_far = selection.clone();
        narrow(SLOPES.name, slopes.map(|slopes| slopes.map(|band| so_far.with_slopes(band[0], band[1]))), &mut selection);
        let so_far = selection.clone();
        narrow(BOX.name, bounds.map(|bounds| bounds.map(|[min, max]| so_far.with_box(min, max))), &mut selection);
        let so_far = selection.clone();
        narrow(PIECES.name, pieces.map(|pieces| pieces.map(|pieces| so_far.with_pieces(pieces))), &mut selection);
        let so_far = selection.clone();
        let pairs = |ranges: Vec<Vec<u32>>| ranges.iter().map(|range| [range[0], range[1]]).collect();
        narrow(FACETS.name, facets.map(|facets| facets.map(|ranges| so_far.with_facets(pairs(ranges)))), &mut selection);
        refused.map(|()| selection)
    }
}

members! {
    /// The corners of a box.
    pub(crate) struct Corners for BoxKind ("Box", "A box, given by two opposite corners") -> [[f64; 3]; 2] {
        min: required MIN: Corner = ("min", Corner, "the smallest x, y and z"),
        max: required MAX: Corner = ("max", Corner, "the largest x, y and z"),
    }
}

impl Corners {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<[[f64; 3]; 2], Faulted> {
        Ok([self.min?, self.max?])
    }
}

/// The corner of a box.
pub(crate) struct Corner;

impl Kind for Corner {
    type Value = [f64; 3];

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<[f64; 3], Faulted> {
        point(raw, path, faults)
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        point_schema().description(Some(about)).into()
    }
}
