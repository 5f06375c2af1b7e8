//! The wire form of a contact: angles, or vectors.

use crate::http::codes::RequestFault;
use crate::http::reading::member::{Number, Vector};
use crate::http::reading::{Faulted, Faults, Kind, Member, Object, ObjectSchema, Place};
use crate::milling::{Contact, ContactError};
use serde_json::value::RawValue;
use utoipa::openapi::schema::OneOfBuilder;
use utoipa::openapi::{Ref, RefOr, Schema};

const SLOPE: Member<Number> = Member {
    name: "slope_deg",
    about: "slope S, the angle between the surface's normal and the tool axis: 0 on a floor, 90 on a wall",
    kind: Number { minimum: 0.0, maximum: 90.0, example: 40.0 },
};
/// Any finite angle is one; the bound is that of the numbers themselves.
const FEED_ANGLE: Member<Number> = Member {
    name: "feed_angle_deg",
    about: "angle alpha between the feed and the steepest slope, both seen from above (in the horizontal XY plane); its period is 180 and its sign is free",
    kind: Number { minimum: -f64::MAX, maximum: f64::MAX, example: 30.0 },
};
const NORMAL: Member<Vector> = Member {
    name: "normal",
    about: "the surface's normal, out of the part, of any length but zero; z must not be negative",
    kind: Vector { example: [-0.64, 0.0, 0.77] },
};
const FEED: Member<Vector> = Member {
    name: "feed",
    about: "the feed's direction, of any length but zero; its part in the tangent plane counts",
    kind: Vector { example: [1.0, 0.0, 0.84] },
};

/// The member `contact` of a calculation at one contact.
pub(super) const CONTACT: Member<ContactKind> =
    Member { name: "contact", about: "where and how the cutter touches, by angles or by vectors", kind: ContactKind };

/// A contact, and the member of it to which a fault of its slope points.
#[derive(Debug, Clone, Copy)]
pub(super) struct StatedContact {
    pub(super) contact: Contact,
    pub(super) slope_member: &'static str,
}

impl StatedContact {
    pub(super) fn by_angles(contact: Contact) -> Self {
        Self { contact, slope_member: SLOPE.name }
    }

    pub(super) fn by_vectors(contact: Contact) -> Self {
        Self { contact, slope_member: NORMAL.name }
    }
}

/// A contact in either form.
pub(super) struct ContactKind;

impl Kind for ContactKind {
    type Value = StatedContact;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<StatedContact, Faulted> {
        let mut object = Object::open(raw, place, faults)?;
        let contact = read(&mut object, faults);
        object.close(faults)?;
        contact
    }

    fn schema(&self, _: &str) -> RefOr<Schema> {
        RefOr::Ref(Ref::from_schema_name("Contact"))
    }
}

/// Takes the members of a contact out of `object`, which may have others.
pub(super) fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<StatedContact, Faulted> {
    let angles = object.has(SLOPE.name) || object.has(FEED_ANGLE.name);
    let vectors = object.has(NORMAL.name) || object.has(FEED.name);
    match (angles, vectors) {
        (true, false) => {
            let (slope, angle) = (object.required(&SLOPE, faults), object.required(&FEED_ANGLE, faults));
            let contact = Contact::from_degrees(slope?, angle?);
            contact.map(StatedContact::by_angles).map_err(|error| fault(object, error, faults))
        }
        (false, true) => {
            let (normal, feed) = (object.required(&NORMAL, faults), object.required(&FEED, faults));
            let contact = Contact::from_vectors(normal?, feed?);
            contact.map(StatedContact::by_vectors).map_err(|error| fault(object, error, faults))
        }
        (true, true) => {
            // Both forms are read for the faults in them.
            let _ = (object.optional(&SLOPE, faults), object.optional(&FEED_ANGLE, faults));
            let _ = (object.optional(&NORMAL, faults), object.optional(&FEED, faults));
            Err(faults.add(
                &object.place(),
                RequestFault::ConflictingFields,
                "give slope_deg and feed_angle_deg, or normal and feed, not both",
            ))
        }
        (false, false) => {
            Err(faults.add(&object.place(), RequestFault::MissingField, "give slope_deg and feed_angle_deg, or normal and feed"))
        }
    }
}

fn fault(object: &Object<'_, '_>, error: ContactError, faults: &mut Faults) -> Faulted {
    let member = match error {
        ContactError::Slope(_) => SLOPE.name,
        ContactError::FeedAngle(_) => FEED_ANGLE.name,
        ContactError::NormalWithoutDirection | ContactError::NormalPointsDown => NORMAL.name,
        ContactError::FeedWithoutDirection | ContactError::FeedAlongNormal => FEED.name,
    };
    faults.add(&object.place().member(member), RequestFault::NoDirection, error)
}

/// The two forms, each with what else an object of this form may hold.
pub(super) fn forms(names: [&str; 2], about: &str, with: impl Fn(ObjectSchema) -> ObjectSchema) -> [(String, RefOr<Schema>); 2] {
    let angles = ObjectSchema::new(&format!("{about}, by angles")).required(&SLOPE).required(&FEED_ANGLE);
    let vectors = ObjectSchema::new(&format!("{about}, by vectors")).required(&NORMAL).required(&FEED);
    [(names[0].to_owned(), with(angles).build()), (names[1].to_owned(), with(vectors).build())]
}

/// The schemas of a contact, by name.
pub(super) fn schemas() -> Vec<(String, RefOr<Schema>)> {
    let names = ["AngleContact", "VectorContact"];
    let [angles, vectors] = forms(names, "a contact", |schema| schema);
    let any =
        OneOfBuilder::new().description(Some(CONTACT.about)).item(Ref::from_schema_name(names[0])).item(Ref::from_schema_name(names[1]));
    vec![angles, vectors, ("Contact".to_owned(), Schema::OneOf(any.build()).into())]
}
