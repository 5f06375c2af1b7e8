//! The member `select`: which facets of a surface are machined.

use super::surface::OnePoint;
use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, JsonPath, List, Quantity, Whole, members};
use crate::quantity::Angle;
use crate::surface::mesh::{Selection, SelectionError};

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
        let mut selection = Selection::all();
        let mut narrow =
            |by: &dyn Fn(Selection) -> Result<Selection, SelectionError>| by(selection.clone()).map(|narrowed| selection = narrowed);
        // Each condition is checked, even if another has a fault.
        let conditions = [
            (SLOPES.name, self.slopes.map(|band| band.map(|band| narrow(&|all| all.with_slopes(band[0], band[1]))))),
            (BOX.name, self.bounds.map(|bounds| bounds.map(|[min, max]| narrow(&|all| all.with_box(min, max))))),
            (PIECES.name, self.pieces.map(|pieces| pieces.map(|pieces| narrow(&|all| all.with_pieces(pieces.clone()))))),
            (FACETS.name, self.facets.map(|ranges| ranges.map(|ranges| narrow(&|all| all.with_facets(pairs(&ranges)))))),
        ];
        let checked = conditions.map(|(name, narrowed)| match narrowed? {
            Some(Err(error)) => Err(faults.add(&path.member(name), RequestFault::OutOfRange, error)),
            _ => Ok(()),
        });
        checked.into_iter().collect::<Result<(), Faulted>>().map(|()| selection)
    }
}

fn pairs(ranges: &[Vec<u32>]) -> Vec<[u32; 2]> {
    ranges.iter().map(|range| [range[0], range[1]]).collect()
}

members! {
    /// The corners of a box.
    pub(crate) struct Corners for BoxKind ("Box", "A box, given by two opposite corners") -> [[f64; 3]; 2] {
        min: required MIN: OnePoint = ("min", OnePoint, "the smallest x, y and z"),
        max: required MAX: OnePoint = ("max", OnePoint, "the largest x, y and z"),
    }
}

impl Corners {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<[[f64; 3]; 2], Faulted> {
        Ok([self.min?, self.max?])
    }
}
