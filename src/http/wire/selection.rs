//! The member `select`: which facets of a surface are machined.

use super::points::{point, point_schema};
use crate::http::codes::RequestFault;
use crate::http::reading::{
    Components, Faulted, Faults, JsonPath, Kind, List, Member, Members, Object, ObjectSchema, Quantity, Whole, WireObject, members,
};
use crate::quantity::{Angle, OutOfRange};
use crate::surface::mesh::Selection;
use serde_json::value::RawValue;
use utoipa::openapi::{RefOr, Schema};

/// The member `select` of a recommendation.
pub(crate) const SELECT: Member<SelectKind> = Member {
    name: "select",
    about: "which facets are machined: those that meet all stated conditions; the other facets still hide those below them and must not be gouged",
    kind: SelectKind,
};

/// The member of `select` that lists pieces, to which the fault of an unknown piece points.
pub(crate) const PIECES_NAME: &str = PIECES.name;

fn slope(degrees: f64) -> Result<Angle, OutOfRange> {
    Angle::from_degrees(OutOfRange::check(degrees, 0.0, 90.0)?)
}

members! {
    /// The members of a selection.
    pub(crate) struct SelectionMembers {
        slopes: optional SLOPES: List<Quantity<Angle>> = ("slope_deg",
            List { item: Quantity::new(slope, 60.0), about_item: "an angle from the horizontal", fewest: 2, most: 2 },
            "the smallest and the largest slope"),
        bounds: optional BOX: BoxKind = ("box_mm", BoxKind, "a box in which the centroid of a facet must lie"),
        pieces: optional PIECES: List<Whole> = ("pieces",
            List { item: Whole { minimum: 0, maximum: 4_000_000_000, example: 0 }, about_item: "a piece's number", fewest: 1, most: 1000 },
            "the numbers of connected pieces, from 0 in the order of their first facets"),
    }
}

/// Conditions on facets.
pub(crate) struct SelectKind;

impl WireObject for SelectKind {
    const NAME: &'static str = "Selection";
    const ABOUT: &'static str = "Conditions that a facet must meet, all of them, to be machined";
    type Members = SelectionMembers;
    type Value = Selection;

    fn build(members: SelectionMembers, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Selection, Faulted> {
        let SelectionMembers { slopes, bounds, pieces } = members;
        let mut selection = Ok(Selection::all());
        let mut narrow =
            |name, result: Result<Selection, _>| result.map_err(|error| faults.add(&path.member(name), RequestFault::OutOfRange, error));
        if let Some(band) = slopes? {
            selection = selection.and_then(|selection: Selection| narrow(SLOPES.name, selection.with_slopes(band[0], band[1])));
        }
        if let Some([min, max]) = bounds? {
            selection = selection.and_then(|selection| narrow(BOX.name, selection.with_box(min, max)));
        }
        if let Some(pieces) = pieces? {
            selection = selection.and_then(|selection| narrow(PIECES.name, selection.with_pieces(pieces)));
        }
        selection
    }
}

/// A box by its corners.
pub(crate) struct BoxKind;

members! {
    /// The corners of a box.
    pub(crate) struct Corners {
        min: required MIN: Corner = ("min", Corner, "the smallest x, y and z"),
        max: required MAX: Corner = ("max", Corner, "the largest x, y and z"),
    }
}

impl Kind for BoxKind {
    type Value = [[f64; 3]; 2];

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted> {
        let mut object = Object::open(raw, path, faults)?;
        let Corners { min, max } = Corners::read(&mut object, faults);
        object.close(faults)?;
        Ok([min?, max?])
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        components.refer("Box", about, |components| ObjectSchema::new("A box by two corners", components).with::<Corners>().build())
    }
}

/// The corner of a box.
pub(crate) struct Corner;

impl Kind for Corner {
    type Value = [f64; 3];

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<[f64; 3], Faulted> {
        point(raw, path, faults)
    }

    fn schema(&self, _: &str, _: &mut Components) -> RefOr<Schema> {
        point_schema()
    }
}
