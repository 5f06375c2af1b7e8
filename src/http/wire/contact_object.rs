//! The contact between cutter and surface, by angles or by vectors.

use crate::http::codes::RequestFault;
use crate::http::reading::{
    AddMembers, AnyMember, Components, Faulted, Faults, Form, JsonPath, Kind, Member, Members, Number, Object, Quantity, Vector, members,
};
use crate::milling::{Contact, ContactError};
use crate::quantity::OutOfRange;
use serde_json::value::RawValue;
use utoipa::openapi::{RefOr, Schema};

members! {
    /// A contact by angles.
    pub(super) struct AngleMembers {
        slope: required SLOPE: Quantity<f64> = ("slope_deg", Quantity::new(Contact::checked_slope_deg, 40.0),
            "slope S, the angle between the surface's normal and the tool axis: 0 on a floor, 90 on a wall"),
        feed_angle: required FEED_ANGLE: Quantity<f64> = ("feed_angle_deg", Quantity::new(|degrees| OutOfRange::check(degrees, -f64::MAX, f64::MAX), 30.0),
            "angle alpha from the uphill line of steepest slope to the feed, counter-clockwise seen from above (against the tool axis); any finite value, the period is 180; the sign matters only if the surface is twisted (twist_per_mm)"),
    }
}
members! {
    /// A contact by vectors.
    pub(super) struct VectorMembers {
        normal: required NORMAL: Vector = ("normal", Vector { of: Number, example: [-0.64, 0.0, 0.77] },
            "the surface's normal, out of the part, with a length above 0; at most 90 deg from the tool axis"),
        feed: required FEED: Vector = ("feed", Vector { of: Number, example: [1.0, 0.0, 0.84] },
            "the feed's direction, with a length above 0; only its component in the tangent plane is used"),
        tool_axis: optional TOOL_AXIS: Vector = ("tool_axis", Vector { of: Number, example: [0.1, 0.0, 0.99] },
            "the tool axis from the tip to the spindle, with a length above 0; absent = +Z; the slope and the view from above refer to it"),
    }
}

/// The member `contact` of a calculation at one contact.
pub(crate) const CONTACT: Member<ContactKind> = Member::new(
    "contact",
    "slope and feed direction at the point where the cutter touches the surface, by angles or by vectors",
    ContactKind,
);

/// A contact, and the member that states its slope, to which faults of the slope point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StatedContact {
    pub(crate) contact: Contact,
    pub(super) slope_member: &'static str,
}

impl StatedContact {
    /// The slope in degrees, if the contact is stated by angles.
    pub(crate) fn stated_slope_deg(&self) -> Option<f64> {
        (self.slope_member == SLOPE.name).then(|| self.contact.slope().degrees())
    }
}

impl AngleMembers {
    fn contact(&self) -> Result<Result<StatedContact, ContactError>, Faulted> {
        let contact = Contact::from_degrees(self.slope?, self.feed_angle?);
        Ok(contact.map(|contact| StatedContact { contact, slope_member: SLOPE.name }))
    }
}

impl VectorMembers {
    fn contact(&self) -> Result<Result<StatedContact, ContactError>, Faulted> {
        let contact = Contact::from_vectors(self.normal?, self.feed?, self.tool_axis?);
        Ok(contact.map(|contact| StatedContact { contact, slope_member: NORMAL.name }))
    }
}

/// A contact in either form.
pub(crate) struct ContactKind;

impl Kind for ContactKind {
    type Value = StatedContact;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<StatedContact, Faulted> {
        Object::open(raw, path, faults)?.read(faults, read)
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let names = ["AngleContact", "VectorContact"];
        components.refer("Contact", about, |components| forms(names, "A contact", components, &|schema| schema))
    }
}

/// The members of a contact, in both forms.
pub(super) fn members() -> impl Iterator<Item = &'static dyn AnyMember> {
    AngleMembers::DECLARED.iter().chain(VectorMembers::DECLARED).map(|declared| declared.member)
}

/// Reads the members of a contact from `object`, which may have others.
pub(super) fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<StatedContact, Faulted> {
    let form =
        object.one_of::<AngleMembers, VectorMembers>("give slope_deg and feed_angle_deg, or normal and feed (and tool_axis)", faults)?;
    let contact = match form {
        Form::First(angles) => angles.contact()?,
        Form::Second(vectors) => vectors.contact()?,
    };
    contact.map_err(|error| {
        let member = match error {
            ContactError::Slope(_) => SLOPE.name,
            ContactError::FeedAngle(_) => FEED_ANGLE.name,
            ContactError::NormalWithoutDirection | ContactError::NormalPointsDown => NORMAL.name,
            ContactError::FeedWithoutDirection | ContactError::FeedAlongNormal => FEED.name,
            ContactError::ToolAxisWithoutDirection => TOOL_AXIS.name,
        };
        faults.add(&object.path().member(member), RequestFault::NoDirection, error)
    })
}

/// The schemas of the two forms, each with the members that `with` adds.
pub(super) fn forms([angles, vectors]: [&str; 2], about: &str, components: &mut Components, with: AddMembers<'_>) -> RefOr<Schema> {
    let (by_angles, by_vectors) = (format!("{about}, by angles"), format!("{about}, by vectors"));
    let forms: [(&str, &str, AddMembers<'_>); 2] = [
        (angles, &by_angles, &|schema| with(AngleMembers::describe(schema))),
        (vectors, &by_vectors, &|schema| with(VectorMembers::describe(schema))),
    ];
    components.one_of(about, &forms).into()
}
