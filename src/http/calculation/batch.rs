//! Batch requests: many contacts in, one column for each figure out. Contacts are parsed and computed on all cores. A
//! contact without an answer does not affect the others.

use super::Calculation;
use super::column::{Column, Table};
use super::selection::Selection;
use super::single::{self, warnings_schema};
use crate::cancellation::CancelFlag;
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::codes::RequestFault;
use crate::http::problem::Problem;
use crate::http::reading::{Components, Fault, Faulted, Faults, JsonPath, Kind, Members, ObjectSchema, for_runs_of_items, items};
use crate::http::wire::{
    BatchContact, CHECK_FIGURES, ColumnExtremes, ContactColumns, ContactParameters, Failure, Figures, MODEL, SharedParameters, Summary,
    Warning, batch_contact_schemas, contact_columns_schema, model_name, no_answer, warning_code,
};
use crate::http::worker_pool::Work;
use crate::milling::{EvaluatedPass, NoAnswer};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The number of contacts that one thread computes at a time. They take some tenths of a millisecond, so the cost of
/// distributing them is negligible.
const CHUNK: usize = 1024;

/// The largest number of contacts in a request. Without this limit, a body of the largest size could hold some ten
/// million. With it, an answer stays below about 100 MB.
const MOST_CONTACTS: usize = 250_000;

const CONTACTS: &str = "contacts";

/// The largest number of failures that an answer lists. Further failures are only counted.
const MOST_FAILURES: usize = 1000;

/// The largest number of faults in the problem returned when no contact has an answer.
const MOST_FAULTS: usize = 100;

/// The largest number of faults listed for one contact.
const MOST_FAULTS_OF_A_CONTACT: usize = 8;

/// The fewest bytes that a contact takes in a body: `{},` as an object, `0,` in each of two columns.
const SHORTEST_CONTACT: usize = 4;

/// The memory of a contact in the columns and in the answer's text, in bytes. Measured: 250 000 contacts with the most
/// columns take 92 MiB beside their body, 386 bytes each, of which 176 are the answer. Contacts sent as columns are
/// stored as up to 15 numbers of 16 bytes.
const MEMORY_OF_A_CONTACT: usize = 660;

/// The memory of the listed failures and of the rest of an answer.
const MEMORY_OF_AN_ANSWER: usize = 1 << 20;

/// Answers a request with many contacts, on worker threads and within the memory budget.
pub(super) async fn answer<C: Calculation + 'static>(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    let contacts = MOST_CONTACTS.min(body.json().len() / SHORTEST_CONTACT);
    let memory = work.reserve((contacts * MEMORY_OF_A_CONTACT + MEMORY_OF_AN_ANSWER) as u64)?;
    work.run(move |cancel| compute::<C>(&body, cancel)?.holding(memory)).await?
}

fn compute<C: Calculation>(body: &JsonBody, cancel: &CancelFlag) -> Result<WrittenJson, Problem> {
    body.read_until(cancel, |object, faults| {
        let path = object.path();
        let shared = SharedParameters::read(object, faults);
        let defaults = ContactParameters::read(object, C::STATED, faults);
        let members = C::Members::read(object, faults);
        let calculation = C::new(members, shared.as_ref().map_err(|faulted| *faulted), &path, faults);
        let selection = Selection::read::<C>(object, faults);
        let path = path.member(CONTACTS);
        let Some(contacts) = object.take(CONTACTS, faults) else {
            return Err(faults.add(&path, RequestFault::MissingField, "the field is missing: the contacts to compute"));
        };
        let are_columns = contacts.get().starts_with('{');
        if !faults.is_empty() {
            // Nothing is computed, but the contacts are still checked, so that the answer lists their faults too.
            check_contacts::<C>(contacts, &defaults, path, cancel, faults)?;
            return Err(Faulted);
        }
        let batch = Batch { shared: shared?, defaults, calculation: calculation?, selection: selection? };
        let (whole, count) = if are_columns {
            batch.compute_columns(contacts, path, cancel, faults)?
        } else {
            batch.compute_rows(contacts, path, cancel, faults)?
        };
        if cancel.is_cancelled() {
            // The answer of a cancelled batch is discarded.
            return Err(Faulted);
        }
        if count > 0 && whole.failed == count {
            let mut left_out = count;
            let mut listed = 0;
            for (_, of_contact) in whole.failures {
                listed += of_contact.len();
                if listed > MOST_FAULTS {
                    break;
                }
                left_out -= 1;
                for fault in of_contact {
                    faults.push(fault);
                }
            }
            faults.add_left_out(left_out);
            return Err(Faulted);
        }
        Ok(whole.written(&batch, count))
    })
}

/// Records the faults of contacts that are not computed.
fn check_contacts<C: Calculation>(
    contacts: &RawValue,
    defaults: &ContactParameters,
    path: JsonPath<'_>,
    cancel: &CancelFlag,
    faults: &mut Faults,
) -> Result<(), Faulted> {
    if contacts.get().starts_with('{') {
        // Columns are read even if another part of the request has faults.
        let mut of_columns = Faults::default();
        let columns = ContactColumns::read(contacts, C::STATED, MOST_CONTACTS, path, &mut of_columns);
        faults.take_in(of_columns, |pointer| Some(pointer.to_owned()));
        let columns = columns?;
        for index in (0..columns.count).take_while(|_| !cancel.is_cancelled()) {
            let _recorded = columns.contact(index, C::STATED, defaults, columns.path(index, &path), faults);
        }
    } else {
        let contacts = items(contacts, MOST_CONTACTS, path, faults)?;
        for (index, contact) in contacts.into_iter().enumerate().take_while(|_| !cancel.is_cancelled()) {
            let _recorded = BatchContact::read(contact, C::STATED, defaults, path.item(index), faults);
        }
    }
    Ok(())
}

struct Batch<C> {
    shared: SharedParameters,
    defaults: ContactParameters,
    calculation: C,
    selection: Selection,
}

/// The results of a chunk of consecutive contacts.
struct Part {
    columns: Vec<Column>,
    failed: usize,
    /// The first failures, with their faults.
    failures: Vec<(usize, Vec<Fault>)>,
    outside_range: usize,
    warnings: Vec<Warning>,
}

impl<C: Calculation> Batch<C> {
    /// Reads an array of contacts. This thread splits the array into chunks; other threads compute them at the same
    /// time.
    fn compute_rows(
        &self,
        contacts: &RawValue,
        path: JsonPath<'_>,
        cancel: &CancelFlag,
        faults: &mut Faults,
    ) -> Result<(Part, usize), Faulted> {
        let parts = Parts::default();
        let count = rayon::scope(|scope| {
            for_runs_of_items(contacts, MOST_CONTACTS, CHUNK, path, faults, |first, contacts| {
                let parts = &parts;
                scope.spawn(move |_| {
                    let part = self.compute_chunk(first, contacts.len(), cancel, |index, faults| {
                        let path = path.item(index);
                        let contact = BatchContact::read(contacts[index - first], C::STATED, &self.defaults, path, faults);
                        contact.and_then(|contact| self.compute_contact(contact, path, faults))
                    });
                    parts.insert(first, part);
                });
            })
        })?;
        Ok((self.joined(parts), count))
    }

    /// Reads columns of contacts, and then computes their rows on all cores.
    fn compute_columns(
        &self,
        contacts: &RawValue,
        path: JsonPath<'_>,
        cancel: &CancelFlag,
        faults: &mut Faults,
    ) -> Result<(Part, usize), Faulted> {
        let columns = ContactColumns::read(contacts, C::STATED, MOST_CONTACTS, path, faults)?;
        let parts = Parts::default();
        (0..columns.count.div_ceil(CHUNK)).into_par_iter().for_each(|chunk| {
            let first = chunk * CHUNK;
            let part = self.compute_chunk(first, CHUNK.min(columns.count - first), cancel, |index, faults| {
                let path = columns.path(index, &path);
                let contact = columns.contact(index, C::STATED, &self.defaults, path, faults);
                contact.and_then(|contact| self.compute_contact(contact, path, faults))
            });
            parts.insert(first, part);
        });
        Ok((self.joined(parts), columns.count))
    }

    /// Computes a chunk of contacts. After a cancellation, the rest of the chunk is skipped.
    fn compute_chunk(
        &self,
        first: usize,
        count: usize,
        cancel: &CancelFlag,
        compute: impl Fn(usize, &mut Faults) -> Result<(Figures, EvaluatedPass), Faulted>,
    ) -> Part {
        let mut part = self.part(|| Column::with_capacity(count));
        for index in first..first + count {
            if cancel.is_cancelled() {
                break;
            }
            let mut faults = Faults::at_most(MOST_FAULTS_OF_A_CONTACT);
            match compute(index, &mut faults) {
                Ok((mut figures, pass)) => {
                    if self.selection.is_compared() {
                        let check = single::compare(&pass, &figures);
                        part.outside_range += usize::from(single::is_outside_range(&check));
                        figures.check = check.ok();
                    }
                    part.add(index, &figures, &pass, &self.selection);
                }
                Err(Faulted) => part.fail(index, faults),
            }
        }
        part
    }

    fn compute_contact(&self, contact: BatchContact, path: JsonPath<'_>, faults: &mut Faults) -> Result<(Figures, EvaluatedPass), Faulted> {
        let BatchContact { contact, parameters } = contact;
        let step_over = parameters.step_over(C::STATED, &path, faults)?;
        let member = self.calculation.step_over_member(&parameters);
        // The fault points to the contact as a whole: any of its parameters, defaults included, may be the cause.
        let mut fail =
            |cause: NoAnswer| faults.push(Fault { pointer: path.to_string(), ..no_answer(cause, &path, contact, &parameters, member) });
        let pass = single::evaluate(&self.shared, contact, &parameters)?.map_err(&mut fail)?;
        let figures = single::compute(&self.calculation, &self.shared, &pass, step_over, &parameters)?.map_err(fail)?;
        Ok((figures, pass))
    }

    /// A part without contacts.
    fn part(&self, column: impl Fn() -> Column) -> Part {
        let columns = self.selection.figures.iter().map(|_| column()).collect();
        Part { columns, failed: 0, failures: Vec::new(), outside_range: 0, warnings: Vec::new() }
    }

    fn joined(&self, parts: Parts) -> Part {
        let mut whole = self.part(Column::default);
        for part in parts.0.into_inner().unwrap_or_else(PoisonError::into_inner).into_values() {
            whole.append(part);
        }
        whole
    }
}

/// The completed parts, by the index of their first contact.
#[derive(Default)]
struct Parts(Mutex<BTreeMap<usize, Part>>);

impl Parts {
    /// Adds a part. If earlier parts already have as many failures as are listed, the failures of this part are dropped
    /// to save memory.
    fn insert(&self, first: usize, mut part: Part) {
        let mut parts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let earlier: usize = parts.range(..first).map(|(_, part)| part.failures.len()).sum();
        if earlier >= MOST_FAILURES {
            part.failures = Vec::new();
        }
        parts.insert(first, part);
    }
}

impl Part {
    fn add(&mut self, index: usize, figures: &Figures, pass: &EvaluatedPass, selection: &Selection) {
        for (column, figure) in self.columns.iter_mut().zip(&selection.figures) {
            column.push(index, (figure.get)(figures).map(|value| value.rounded(selection.significant_digits)));
        }
        for warning in pass.warnings(figures.step_over, figures.feed_per_tooth) {
            match self.warnings.iter_mut().find(|known| known.code == warning_code(warning)) {
                Some(known) => known.contacts = known.contacts.map(|contacts| contacts + 1),
                None => self.warnings.push(Warning { contacts: Some(1), first_index: Some(index), ..Warning::from(warning) }),
            }
        }
    }

    fn fail(&mut self, index: usize, faults: Faults) {
        self.columns.iter_mut().for_each(|column| column.push(index, None));
        self.failed += 1;
        if self.failures.len() < MOST_FAILURES {
            self.failures.push((index, faults.into_listed()));
        }
    }

    fn append(&mut self, next: Self) {
        self.columns.iter_mut().zip(next.columns).for_each(|(column, next)| column.append(next));
        self.failed += next.failed;
        let listed = MOST_FAILURES - self.failures.len();
        self.failures.extend(next.failures.into_iter().take(listed));
        self.outside_range += next.outside_range;
        for warning in next.warnings {
            match self.warnings.iter_mut().find(|known| known.code == warning.code) {
                Some(known) => known.contacts = known.contacts.zip(warning.contacts).map(|(a, b)| a + b),
                None => self.warnings.push(warning),
            }
        }
    }

    fn written<C>(self, batch: &Batch<C>, count: usize) -> WrittenJson {
        let Batch { shared, selection, .. } = batch;
        let named = || selection.figures.iter().zip(&self.columns);
        let extremes = ColumnExtremes(named().filter_map(|(figure, column)| Some((figure.name, column.extremes()?))).collect());
        let outside_analytic_range = selection.is_compared().then_some(self.outside_range);
        let mut table = Table::default();
        table.value("model", &model_name(shared.model));
        table.value("summary", &Summary { count, failures: self.failed, outside_analytic_range, extremes });
        for (figure, column) in selection.figures.iter().zip(self.columns) {
            if selection.is_stated || figure.is_required_column() {
                table.column(figure.name, column);
            } else {
                table.optional_column(figure.name, column);
            }
        }
        let failures: Vec<_> = self.failures.iter().filter_map(|(index, faults)| Failure::new(*index, faults)).collect();
        table.value("failures", &failures);
        table.value("warnings", &self.warnings);
        table.written()
    }
}

/// The schema of a request with many contacts.
pub(super) fn describe_request<C: Calculation>(components: &mut Components) -> RefOr<Schema> {
    let contact = batch_contact_schemas(C::STATED, components);
    let rows = ArrayBuilder::new().items(contact).max_items(Some(MOST_CONTACTS)).description(Some("an object for each contact"));
    let columns = contact_columns_schema(C::STATED, MOST_CONTACTS, components);
    let contacts = OneOfBuilder::new().item(rows).item(columns);
    let contacts = contacts.description(Some("the contacts of the tool path, in their order: an array of objects or an object of columns"));
    let about = "A calculation at many contacts; the parameters apply to every contact that does not state its own";
    let schema = SharedParameters::describe(ObjectSchema::new(about, components));
    let schema = ContactParameters::describe(schema, C::STATED).with::<C::Members>();
    Selection::describe::<C>(schema).required_property(CONTACTS, contacts).build()
}

/// The schema of an answer for many contacts.
pub(super) fn describe_answer<C: Calculation>(components: &mut Components) -> RefOr<Schema> {
    let about = "The answer for many contacts: an array for each figure, in the order sent; null for a contact without an answer";
    let mut schema = ObjectBuilder::new().schema_type(Type::Object).description(Some(about));
    schema = schema.property("model", MODEL.kind.schema("the model that answered", components)).required("model");
    schema = schema.property("summary", components.refer_type::<Summary>()).required("summary");
    for figure in C::figures().chain(CHECK_FIGURES) {
        // Where the request names columns, the others are absent.
        schema = schema.property(figure.name, figure.column_schema(components));
    }
    let failures = ArrayBuilder::new().items(components.refer_type::<Failure>()).max_items(Some(MOST_FAILURES));
    let failures = failures.description(Some("the first thousand contacts that have no answer; summary.failures counts all of them"));
    schema = schema.property("failures", failures).required("failures");
    schema.property("warnings", warnings_schema(components)).required("warnings").into()
}
