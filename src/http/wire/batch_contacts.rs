//! The contacts of a batch: an array of objects, or an object of columns.

use super::contact_object::{self, StatedContact};
use super::contact_parameters::{ContactParameters, StatedParameters};
use crate::http::codes::RequestFault;
use crate::http::reading::{AnyMember, Columns, Components, Faulted, Faults, JsonPath, Object, describe, items};
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, OneOfBuilder};
use utoipa::openapi::{RefOr, Schema};

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
    contact_object::members().chain(stated.members().map(|declared| declared.member))
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
        let contact = contact_object::read(&mut object, faults);
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
    contact_object::forms(names.each_ref().map(String::as_str), "A contact with its own parameters", components, &|schema| {
        schema.with_members(stated.members())
    })
}
