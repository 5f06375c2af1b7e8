//! Many contacts, a column for each figure. Contacts are read and worked out on all cores; one that has no answer fails alone.

use super::Calculation;
use super::column::{Column, Table};
use super::single::{self, warnings_schema};
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::codes::RequestFault;
use crate::http::problem::Problem;
use crate::http::reading::{Components, Fault, Faulted, Faults, JsonPath, Kind, Members, ObjectSchema, for_runs_of_items, items};
use crate::http::wire::{
    BatchContact, ContactParameters, Failure, Figures, MODEL, SharedParameters, Summary, Warning, batch_contact_schemas, model_name,
    no_answer, warning_code,
};
use crate::milling::{JudgedPass, Model, NoAnswer};
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::sync::{Mutex, PoisonError};
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// Contacts worked out in one go by one thread: some tenths of a millisecond, long against the cost of sharing out.
const CHUNK: usize = 1024;

/// Contacts in one request. A body of the largest size could hold some ten million faulty ones, and the answer names each; with this
/// many an answer stays under some 100 MB.
const MOST_CONTACTS: usize = 250_000;

const CONTACTS: &str = "contacts";

/// Answers a request with many contacts.
pub(super) fn answer<C: Calculation>(body: &JsonBody) -> Result<WrittenJson, Problem> {
    body.read(|object, faults| {
        let path = object.path();
        let shared = SharedParameters::read(object, faults);
        let defaults = ContactParameters::read(object, C::STATES, faults);
        let members = C::Members::read(object, faults);
        let calculation = C::new(members, shared.as_ref().map_err(|faulted| *faulted), &path, faults);
        let path = path.member(CONTACTS);
        let Some(contacts) = object.take(CONTACTS, faults) else {
            return Err(faults.add(&path, RequestFault::MissingField, "the field is missing: the contacts to work out"));
        };
        if !faults.is_empty() {
            // Nothing is worked out, but faults of the array as a whole are recorded, too.
            items(contacts, MOST_CONTACTS, path, faults)?;
            return Err(Faulted);
        }
        let batch = Batch { shared: shared?, defaults, calculation: calculation? };
        batch.work_out(contacts, path, faults)
    })
}

struct Batch<C> {
    shared: SharedParameters,
    defaults: ContactParameters,
    calculation: C,
}

/// What a run of contacts yields.
struct Part<C> {
    columns: Vec<Column>,
    failures: Vec<Failure>,
    warnings: Vec<Warning>,
    calculation: PhantomData<C>,
}

impl<C: Calculation> Batch<C> {
    /// Contacts are worked out on other cores while this one still finds where the next begin.
    fn work_out(&self, contacts: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<WrittenJson, Faulted> {
        let parts = Mutex::new(BTreeMap::new());
        let count = rayon::scope(|scope| {
            for_runs_of_items(contacts, MOST_CONTACTS, CHUNK, path, faults, |first, contacts| {
                let parts = &parts;
                scope.spawn(move |_| {
                    let part = self.work_out_chunk(first, &contacts, &path);
                    parts.lock().unwrap_or_else(PoisonError::into_inner).insert(first, part);
                });
            })
        })?;
        let mut whole = Part::<C>::new(Column::default);
        for part in parts.into_inner().unwrap_or_else(PoisonError::into_inner).into_values() {
            whole.append(part);
        }
        Ok(whole.written(self.shared.model, count))
    }

    fn work_out_chunk(&self, first: usize, contacts: &[&RawValue], path: &JsonPath<'_>) -> Part<C> {
        let mut part = Part::new(|| Column::with_capacity(contacts.len()));
        for (index, raw) in (first..).zip(contacts) {
            let mut faults = Faults::default();
            match self.work_out_contact(raw, path.item(index), &mut faults) {
                Ok((figures, pass)) => part.add(index, &figures, &pass),
                Err(Faulted) => part.fail(index, &faults.into_listed()),
            }
        }
        part
    }

    fn work_out_contact(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<(Figures, JudgedPass), Faulted> {
        let BatchContact { contact, parameters } = BatchContact::read(raw, C::STATES, &self.defaults, path, faults)?;
        let step_over = parameters.step_over(C::STATES, &path, faults)?;
        // A contact without an answer is to blame as a whole: which of its parameters are defaults makes no difference.
        let mut fail = |cause: NoAnswer| {
            faults.push(Fault { pointer: path.to_string(), ..no_answer(cause, &path, contact, &parameters, parameters.step_over_member()) })
        };
        let pass = single::judge(&self.shared, contact, &parameters)?.map_err(&mut fail)?;
        let figures = single::work_out(&self.calculation, &self.shared, &pass, step_over, &parameters)?.map_err(fail)?;
        Ok((figures, pass))
    }
}

impl<C: Calculation> Part<C> {
    fn new(column: impl Fn() -> Column) -> Self {
        Self { columns: C::figures().map(|_| column()).collect(), failures: Vec::new(), warnings: Vec::new(), calculation: PhantomData }
    }

    fn add(&mut self, index: usize, figures: &Figures, pass: &JudgedPass) {
        for (column, figure) in self.columns.iter_mut().zip(C::figures()) {
            column.push(index, (figure.get)(figures));
        }
        for warning in pass.warnings(figures.step_over, figures.feed_per_tooth) {
            match self.warnings.iter_mut().find(|known| known.code == warning_code(warning)) {
                Some(known) => known.contacts = known.contacts.map(|contacts| contacts + 1),
                None => self.warnings.push(Warning { contacts: Some(1), first_index: Some(index), ..Warning::from(warning) }),
            }
        }
    }

    fn fail(&mut self, index: usize, faults: &[Fault]) {
        self.columns.iter_mut().for_each(|column| column.push(index, None));
        self.failures.extend(Failure::new(index, faults));
    }

    fn append(&mut self, mut next: Self) {
        self.columns.iter_mut().zip(next.columns).for_each(|(column, next)| column.append(next));
        self.failures.append(&mut next.failures);
        for warning in next.warnings {
            match self.warnings.iter_mut().find(|known| known.code == warning.code) {
                Some(known) => known.contacts = known.contacts.zip(warning.contacts).map(|(a, b)| a + b),
                None => self.warnings.push(warning),
            }
        }
    }

    fn written(self, model: Model, count: usize) -> WrittenJson {
        let sought = C::figures().position(|figure| figure.name == C::SOUGHT);
        let [minimum, maximum] = sought.map_or([None, None], |sought| self.columns[sought].extremes());
        let mut table = Table::default();
        table.value("model", &model_name(model));
        table.value("summary", &Summary { count, failures: self.failures.len(), minimum, maximum });
        for (figure, column) in C::figures().zip(self.columns) {
            if figure.is_required_column() {
                table.column(figure.name, column);
            } else {
                table.optional_column(figure.name, column);
            }
        }
        table.value("failures", &self.failures);
        table.value("warnings", &self.warnings);
        table.written()
    }
}

/// The schema of a request with many contacts.
pub(super) fn describe_request<C: Calculation>(components: &mut Components) -> RefOr<Schema> {
    let contact = batch_contact_schemas(C::STATES, components);
    let contacts = ArrayBuilder::new().items(contact).max_items(Some(MOST_CONTACTS));
    let contacts = contacts.description(Some("the contacts of the tool path, in their order"));
    let about = "A calculation at many contacts: the parameters hold for every contact that does not state its own";
    let schema = SharedParameters::describe(ObjectSchema::new(about, components));
    ContactParameters::describe(schema, C::STATES).with::<C::Members>().required_property(CONTACTS, contacts).build()
}

/// The schema of an answer for many contacts.
pub(super) fn describe_answer<C: Calculation>(components: &mut Components) -> RefOr<Schema> {
    let about = "The answer for many contacts: an array for each figure, in the order sent; null where a contact has no answer";
    let mut schema = ObjectBuilder::new().schema_type(Type::Object).description(Some(about));
    schema = schema.property("model", MODEL.kind.schema("the model that answered", components)).required("model");
    schema = schema.property("summary", components.refer_type::<Summary>()).required("summary");
    for figure in C::figures() {
        schema = schema.property(figure.name, figure.column_schema(components));
        schema = if figure.is_required_column() { schema.required(figure.name) } else { schema };
    }
    let failures = ArrayBuilder::new().items(components.refer_type::<Failure>()).description(Some("the contacts that have no answer"));
    schema = schema.property("failures", failures).required("failures");
    schema.property("warnings", warnings_schema(components)).required("warnings").into()
}
