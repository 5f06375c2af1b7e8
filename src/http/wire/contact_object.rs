//! The contact between cutter and surface, by angles or by vectors; the contacts of a batch, an array of objects or an object
//! of columns; and the fault of a contact that has no answer.

use super::contact_parameters::{CUTTER, ContactParameters, FEED_PER_TOOTH, RUNOUT, StatedParameters, TOLERANCE};
use crate::http::codes::RequestFault;
use crate::http::reading::{
    AddMembers, AnyMember, Columns, Components, Fault, Faulted, Faults, Form, JsonPath, Kind, Members, Number, Object, Quantity, Vector,
    describe, items, members,
};
use crate::milling::{Contact, ContactError, NoAnswer};
use crate::quantity::OutOfRange;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, OneOfBuilder};
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

members! {
    /// The contact of a calculation at one contact.
    pub(crate) struct OneContact {
        contact: required CONTACT: ContactKind = ("contact", ContactKind,
            "slope and feed direction at the point where the cutter touches the surface, by angles or by vectors"),
    }
}

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

/// Contacts that are not read yet. Faults of a contact are found when it is read.
pub(crate) enum Contacts<'a> {
    Rows(Vec<&'a RawValue>),
    /// Columns of contacts and of their own parameters. null means the default.
    Columns {
        columns: Columns<'a>,
        first_column: &'static str,
        /// The length of all columns.
        count: usize,
    },
}

impl<'a> Contacts<'a> {
    /// The largest number of contacts in a request. Without this limit, a body of the largest size could hold some ten
    /// million. With it, an answer stays below about 100 MB.
    pub(crate) const MOST: usize = 250_000;

    /// The names of the members of contacts with the parameters that `stated` allows.
    pub(crate) fn names(stated: StatedParameters) -> Vec<&'static str> {
        known(stated).map(AnyMember::name).collect()
    }

    /// Opens an array or an object of columns.
    pub(crate) fn open(raw: &'a RawValue, stated: StatedParameters, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self, Faulted> {
        match raw.get().as_bytes().first() {
            Some(b'[') => items(raw, "an array", Self::MOST, path, faults).map(Self::Rows),
            Some(b'{') => Self::open_columns(raw, stated, path, faults),
            _ => {
                let detail = format_args!("expected an array of contacts or an object of columns, found {}", describe(raw));
                Err(faults.add(&path, RequestFault::WrongType, detail))
            }
        }
    }

    fn open_columns(raw: &'a RawValue, stated: StatedParameters, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self, Faulted> {
        // Columns are read even if another part of the request has faults.
        let faults_before = faults.count();
        let mut object = Object::open(raw, path, faults)?;
        let columns = Columns::take(&mut object, known(stated), Self::MOST, faults);
        object.close(faults)?;
        let mut first = None;
        columns.check_rows(&mut first, &path, faults);
        if faults.count() > faults_before {
            return Err(Faulted);
        }
        first.map(|(first_column, count)| Self::Columns { columns, first_column, count }).ok_or_else(|| {
            let detail = "give the columns slope_deg and feed_angle_deg, or normal and feed";
            faults.add(&path, RequestFault::MissingField, detail)
        })
    }

    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Rows(rows) => rows.len(),
            Self::Columns { count, .. } => *count,
        }
    }

    /// The path of a contact. `path` is that of all contacts.
    pub(crate) fn path<'p>(&self, index: usize, path: &'p JsonPath<'p>) -> JsonPath<'p> {
        match self {
            Self::Rows(_) => path.item(index),
            Self::Columns { first_column, .. } => JsonPath::Row(path, first_column, index),
        }
    }

    /// Reads a contact, whose own parameters override `defaults`.
    pub(crate) fn read(
        &self,
        index: usize,
        defaults: &ContactParameters,
        path: JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<BatchContact, Faulted> {
        let object = match self {
            Self::Rows(rows) => Object::open(rows[index], path, faults)?,
            Self::Columns { columns, .. } => columns.row(index, path),
        };
        BatchContact::read(object, defaults, faults)
    }

    /// The schema of contacts with the parameters that `stated` allows.
    pub(crate) fn schema(stated: StatedParameters, components: &mut Components) -> OneOfBuilder {
        let rows = ArrayBuilder::new().items(batch_contact_schemas(stated, components)).max_items(Some(Self::MOST));
        let about =
            "Contacts as columns of one length, by angles or by vectors; null means the value that the request states for all contacts";
        let columns =
            components.refer_object(&stated.name("ContactColumns"), "", about, &|schema| schema.with_columns(known(stated), Self::MOST));
        let contacts = OneOfBuilder::new().item(rows.description(Some("an object for each contact"))).item(columns);
        contacts.description(Some("the contacts of the tool path, in their order: an array of objects or an object of columns"))
    }
}

/// The columns of contacts with the parameters that `stated` allows.
fn known(stated: StatedParameters) -> impl Iterator<Item = &'static dyn AnyMember> {
    members().chain(stated.members().map(|declared| declared.member))
}

/// A contact and its own parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchContact {
    pub(crate) contact: StatedContact,
    pub(crate) parameters: ContactParameters,
}

impl BatchContact {
    /// Reads a contact whose own parameters override `defaults`. `faults` has no faults but those of this contact.
    fn read(mut object: Object<'_, '_>, defaults: &ContactParameters, faults: &mut Faults) -> Result<Self, Faulted> {
        let path = object.path();
        let contact = read(&mut object, faults);
        let parameters = ContactParameters::read(&mut object, defaults.stated, faults).or(defaults);
        object.close(faults)?;
        parameters.step_over(&path, faults)?;
        // The faults of the defaults are recorded with the request. A contact fails because of them only if it uses
        // them.
        if faults.is_empty() { Ok(Self { contact: contact?, parameters }) } else { Err(Faulted) }
    }
}

/// The schema of a contact with the parameters that `stated` allows.
fn batch_contact_schemas(stated: StatedParameters, components: &mut Components) -> RefOr<Schema> {
    let names = ["AngleContact", "VectorContact"].map(|form| stated.name(form));
    forms(names.each_ref().map(String::as_str), "A contact with its own parameters", components, &|schema| {
        schema.with_members(stated.members())
    })
}

/// The fault for `cause` in the request at `path`. It points to the member by which contact or parameters were stated;
/// `step_over` is the member that bounds the step-over.
pub(crate) fn no_answer(
    cause: NoAnswer,
    path: &JsonPath<'_>,
    contact: StatedContact,
    parameters: &ContactParameters,
    step_over: &'static str,
) -> Fault {
    let in_contact = path.member(CONTACT.name);
    let path = match cause {
        NoAnswer::FlatFloor | NoAnswer::StraightFlank | NoAnswer::TooSteep { .. } => in_contact.member(contact.slope_member),
        NoAnswer::PassesDoNotOverlap { .. } | NoAnswer::PassesCoincideFromAbove | NoAnswer::StepOverUsesUpTolerance { .. } => {
            path.member(step_over)
        }
        NoAnswer::MarksDoNotOverlap { .. } | NoAnswer::FeedUsesUpTolerance { .. } => path.member(FEED_PER_TOOTH.name),
        NoAnswer::Gouges { .. } => path.member(parameters.curvature_member()),
        NoAnswer::SharpEdge => path.member(CUTTER.name),
        NoAnswer::RunoutUsesUpTolerance => path.member(RUNOUT.name),
        NoAnswer::ToleranceLimitsNoStepOver { .. } | NoAnswer::ToleranceLimitsNoFeed { .. } => path.member(TOLERANCE.name),
    };
    Fault::no_answer(cause, &path, cause)
}
