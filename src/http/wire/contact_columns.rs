//! The contacts of a batch as an object of columns, which is parsed directly into numbers.

use super::batch_contact::{BatchContact, ContactSlots};
use super::contact::FormSlots;
use super::parameters::{ContactParameters, StatedParameters};
use crate::http::codes::RequestFault;
use crate::http::reading::{Columns, Components, Faulted, Faults, KnownColumns, Object, PlainColumns, Slots};
use crate::json_text::{JsonPath, JsonText};
use utoipa::openapi::{RefOr, Schema};

/// Columns of contacts and of their own parameters, all of one length. null means the default.
#[derive(Debug)]
pub(crate) struct ContactColumns<'a> {
    columns: Columns<'a>,
    first_column: &'static str,
    /// The number of contacts.
    pub(crate) count: usize,
}

impl<'a> ContactColumns<'a> {
    /// Reads columns of at most `most` contacts. Faults of a contact are found when it is read.
    pub(crate) fn read(
        raw: JsonText<'a>,
        stated: StatedParameters,
        most: usize,
        path: JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<Self, Faulted> {
        // Columns are read even if another part of the request has faults.
        let faults_before = faults.count();
        let mut object = Object::open(raw, path, faults)?;
        let columns = Columns::take(&mut object, &known(stated), most, faults);
        object.close(faults)?;
        let mut first = None;
        columns.check_rows(&mut first, &path, faults);
        if faults.count() > faults_before {
            return Err(Faulted);
        }
        let Some((first_column, count)) = first else {
            let detail = "give the columns slope_deg and feed_angle_deg, or normal and feed";
            return Err(faults.add(&path, RequestFault::MissingField, detail));
        };
        Ok(Self { columns, first_column, count })
    }

    /// Reads columns whose syntax has not been checked. `None` if only the general reader can read them, or if it
    /// finds faults of the columns as a whole.
    pub(crate) fn read_plain(given: PlainColumns<'_>, stated: StatedParameters, most: usize) -> Option<Self> {
        let columns = Columns::of_plain(given, &known(stated), most)?;
        let (mut first, mut faults) = (None, Faults::default());
        columns.check_rows(&mut first, &JsonPath::Root, &mut faults);
        let (first_column, count) = first?;
        faults.is_empty().then_some(Self { columns, first_column, count })
    }

    /// The contact in the row `index`, whose own parameters override `defaults`. `path` is that of the columns.
    #[inline]
    pub(crate) fn contact(
        &self,
        index: usize,
        defaults: &ContactParameters,
        path: JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<BatchContact, Faulted> {
        let mut slots = ContactSlots::default();
        let plain = self.columns.fill(index, &mut slots).ok().and_then(|()| BatchContact::accept(&slots, defaults));
        match plain {
            Some(contact) => Ok(contact),
            None => BatchContact::read_faulty(JsonText::known(&self.columns.text(index)), defaults, path, faults),
        }
    }

    /// The path of the row `index` in the columns at `path`.
    pub(crate) fn path<'p>(&self, index: usize, path: &'p JsonPath<'p>) -> JsonPath<'p> {
        JsonPath::Row(path, self.first_column, index)
    }
}

/// The columns of contacts with the parameters that `stated` allows.
fn known(stated: StatedParameters) -> KnownColumns {
    FormSlots::columns().into_iter().chain(stated.columns()).collect()
}

/// The schema of columns of at most `most` contacts, with the parameters that `stated` allows.
pub(crate) fn contact_columns_schema(stated: StatedParameters, most: usize, components: &mut Components) -> RefOr<Schema> {
    let about = "Contacts as columns of one length, by angles or by vectors; null means the value that the request states for all contacts";
    components.refer_object(&stated.name("ContactColumns"), "", about, &|schema| {
        stated.describe_columns(FormSlots::describe_columns(schema, most), most)
    })
}
