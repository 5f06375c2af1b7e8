//! The contacts of a batch as an object of columns, which is parsed directly into numbers.

use super::batch_contact::BatchContact;
use super::contact::{AngleColumns, VectorColumns, VectorSlots};
use super::parameters::{ContactParameters, ParameterColumns, ParameterSlots, StatedParameters};
use crate::http::codes::RequestFault;
use crate::http::reading::{Columns, Components, Faulted, Faults, Object, ObjectSchema, PlainColumns, RowText, Rows};
use crate::json_text::{JsonPath, JsonText};
use utoipa::openapi::{RefOr, Schema};

/// Columns of the two forms of a contact.
type FormColumns = (AngleColumns, VectorColumns);

/// Columns of contacts and of their own parameters, all of one length. null means the default.
#[derive(Debug)]
pub(crate) struct ContactColumns {
    columns: (FormColumns, ParameterColumns),
    /// Whether there are columns of vectors and of parameters.
    has_vectors: bool,
    has_parameters: bool,
    first_column: &'static str,
    /// The number of contacts.
    pub(crate) count: usize,
}

impl ContactColumns {
    /// Reads columns of at most `most` contacts. Faults of a contact are found when it is read.
    pub(crate) fn read(
        raw: JsonText<'_>,
        stated: StatedParameters,
        most: usize,
        path: JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<Self, Faulted> {
        // Columns are read even if another part of the request has faults.
        let faults_before = faults.count();
        let mut object = Object::open(raw, path, faults)?;
        let columns = (FormColumns::take(&mut object, most, faults), stated.take_columns(&mut object, most, faults));
        object.close(faults)?;
        let mut rows = Rows::default();
        columns.check_rows(&path, &mut rows, faults);
        if faults.count() > faults_before {
            return Err(Faulted);
        }
        let Some((first_column, count)) = rows.first else {
            let detail = "give the columns slope_deg and feed_angle_deg, or normal and feed";
            return Err(faults.add(&path, RequestFault::MissingField, detail));
        };
        Ok(Self::of_rows(columns, first_column, count))
    }

    /// Reads columns whose syntax has not been checked. `None` if only the general reader can read them, or if it
    /// finds faults of the columns as a whole.
    pub(crate) fn read_plain(mut given: PlainColumns<'_>, stated: StatedParameters, most: usize) -> Option<Self> {
        let columns = (FormColumns::take_plain(&mut given, most)?, stated.take_plain_columns(&mut given, most)?);
        let (mut rows, mut faults) = (Rows::default(), Faults::default());
        columns.check_rows(&JsonPath::Root, &mut rows, &mut faults);
        let (first_column, count) = rows.first?;
        (given.is_empty() && faults.is_empty()).then(|| Self::of_rows(columns, first_column, count))
    }

    fn of_rows(columns: (FormColumns, ParameterColumns), first_column: &'static str, count: usize) -> Self {
        let ((_, vectors), parameters) = &columns;
        let (has_vectors, has_parameters) = (!vectors.are_absent(), !parameters.are_absent());
        Self { columns, has_vectors, has_parameters, first_column, count }
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
        match self.accept(index, defaults) {
            Some(contact) => Ok(contact),
            None => BatchContact::read_faulty(JsonText::known(&self.text(index)), defaults, path, faults),
        }
    }

    /// The path of the row `index` in the columns at `path`.
    pub(crate) fn path<'p>(&self, index: usize, path: &'p JsonPath<'p>) -> JsonPath<'p> {
        JsonPath::Row(path, self.first_column, index)
    }

    /// The contact in a row; `None` if there is a fault.
    #[inline]
    fn accept(&self, index: usize, defaults: &ContactParameters) -> Option<BatchContact> {
        let ((angles, vectors), parameters) = &self.columns;
        let angles = angles.row(index).ok()?;
        let vectors = if self.has_vectors { vectors.row(index).ok()? } else { VectorSlots::default() };
        let parameters = if self.has_parameters { parameters.row(index).ok()? } else { ParameterSlots::default() };
        BatchContact::accept(&((angles, vectors), parameters), defaults)
    }

    /// The row as the JSON of a contact, for the reader that collects faults.
    fn text(&self, index: usize) -> String {
        let mut text = RowText::default();
        self.columns.write_row(index, &mut text);
        text.written()
    }
}

/// The schema of columns of at most `most` contacts, with the parameters that `stated` allows.
pub(crate) fn contact_columns_schema(stated: StatedParameters, most: usize, components: &mut Components) -> RefOr<Schema> {
    let name = match (stated.step_over, stated.feed_per_tooth) {
        (true, true) => "ContactColumnsWithParameters",
        (true, false) => "ContactColumnsWithStepOver",
        (false, true) => "ContactColumnsWithFeed",
        (false, false) => "ContactColumnsWithCurvature",
    };
    components.refer(name, "", |components| {
        let about =
            "Contacts as columns of one length, by angles or by vectors; null means the value that the request states for all contacts";
        stated.describe_columns(FormColumns::describe(ObjectSchema::new(about, components), most), most).build()
    })
}
