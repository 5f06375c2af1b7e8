//! Many contacts, a column for each figure. Items are read and worked out on all cores; one that has no answer fails alone.

use super::contact::{self, StatedContact};
use super::figures::{Columns, Extreme, Failure, Figures, Summary};
use super::terms::{Setup, Stated, Terms};
use super::warning::{Strain, Warning};
use super::{Calculation, cutter, plain, refusal, single};
use crate::cancellation::CancelFlag;
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::codes::RequestFault;
use crate::http::problem::Problem;
use crate::http::reading::member::{for_runs_of_items, items};
use crate::http::reading::{Fault, Faulted, Faults, Kind, Member, Object, ObjectSchema, Place};
use crate::http::worker_pool::Work;
use crate::milling::{JudgedPass, Model, Pass};
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use utoipa::openapi::schema::{ArrayBuilder, OneOfBuilder};
use utoipa::openapi::{Ref, RefOr, Schema};

/// Contacts worked out in one go by one thread: some tenths of a millisecond, long against the cost of sharing out.
const CHUNK: usize = 1024;

/// Contacts in one request. A body of the largest size could name some ten million faulty ones, and the answer names each; with this
/// many an answer stays under some 100 MB.
const MOST_CONTACTS: usize = 250_000;

const CONTACTS: &str = "contacts";

/// Contacts that are listed with their failures; further ones are null in the columns and counted.
const MOST_FAILURES: usize = 1000;

/// Faults that are listed of one contact.
const MOST_FAULTS_OF_A_CONTACT: usize = 8;

/// The fewest bytes in which a body states a contact that is worked out: `{},` and a part of the columns.
const SHORTEST_CONTACT: usize = 4;

/// The memory that a contact takes in the columns and in the answer's text, in bytes. Measured: 250 000 contacts with every column
/// take 70 MB.
const MEMORY_OF_A_CONTACT: usize = 320;

/// The memory of the failures listed and of the rest of an answer.
const MEMORY_OF_AN_ANSWER: usize = 1 << 20;

/// Answers a request with many contacts, on worker threads and within the memory budget.
pub(super) async fn answer<C: Calculation + 'static>(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    let contacts = MOST_CONTACTS.min(body.len() / SHORTEST_CONTACT);
    let memory = work.reserve((contacts * MEMORY_OF_A_CONTACT + MEMORY_OF_AN_ANSWER) as u64)?;
    work.run(move |cancel| work_out::<C>(&body, cancel)?.holding(memory)).await?
}

fn work_out<C: Calculation>(body: &JsonBody, cancel: &CancelFlag) -> Result<WrittenJson, Problem> {
    body.read(|object, faults| {
        let setup = Setup::read(object, faults);
        let defaults = Terms::read(object, C::STATES, faults);
        let calculation = C::read(object, setup.as_ref().map_err(|faulted| *faulted), faults);
        let place = object.place();
        let place = place.member(CONTACTS);
        let Some(contacts) = object.take(CONTACTS, faults) else {
            return Err(faults.add(&place, RequestFault::MissingField, "the field is missing: the contacts to work out"));
        };
        if !faults.is_empty() {
            // Nothing is worked out, but what is wrong with the array as a whole is told, too.
            items(contacts, MOST_CONTACTS, place, faults)?;
            return Err(Faulted);
        }
        let batch = Batch { setup: setup?, defaults, calculation: calculation? };
        batch.work_out(contacts, place, cancel, faults)
    })
}

struct Batch<C> {
    setup: Setup,
    defaults: Terms,
    calculation: C,
}

/// What a run of contacts yields.
struct Part<F: Figures> {
    columns: F::Columns,
    /// The first failures.
    failures: Vec<Failure>,
    failed: usize,
    minimum: Option<Extreme>,
    maximum: Option<Extreme>,
    warnings: Vec<Warning>,
}

impl<C: Calculation> Batch<C> {
    /// Contacts are worked out on other cores while this one still tells them apart.
    fn work_out(&self, contacts: &RawValue, place: Place<'_>, cancel: &CancelFlag, faults: &mut Faults) -> Result<WrittenJson, Faulted> {
        let parts = Mutex::new(BTreeMap::new());
        let count = rayon::scope(|scope| {
            for_runs_of_items(contacts, MOST_CONTACTS, CHUNK, place, faults, |first, contacts| {
                let parts = &parts;
                scope.spawn(move |_| {
                    let part = self.work_out_chunk(first, &contacts, &place, cancel);
                    parts.lock().unwrap_or_else(PoisonError::into_inner).insert(first, part);
                });
            })
        })?;
        let mut whole = Part::<C::Figures>::of(Default::default());
        for part in parts.into_inner().unwrap_or_else(PoisonError::into_inner).into_values() {
            whole.append(part);
        }
        Ok(whole.written(self.setup.model, count))
    }

    /// A cancelled batch has an answer that nobody gets: the rest of its contacts is left out.
    fn work_out_chunk(&self, first: usize, contacts: &[&RawValue], place: &Place<'_>, cancel: &CancelFlag) -> Part<C::Figures> {
        let mut part = Part::of(Columns::open(contacts.len()));
        for (index, raw) in (first..).zip(contacts) {
            if cancel.is_cancelled() {
                break;
            }
            let mut faults = Faults::at_most(MOST_FAULTS_OF_A_CONTACT);
            let worked_out = self.work_out_contact(index, raw, place.item(index), &mut faults, &mut part);
            if worked_out.is_err() {
                part.fail(index, &faults.into_listed());
            }
        }
        part
    }

    fn work_out_contact(
        &self,
        index: usize,
        raw: &RawValue,
        place: Place<'_>,
        faults: &mut Faults,
        part: &mut Part<C::Figures>,
    ) -> Result<(), Faulted> {
        let (contact, terms) = match plain::read(raw, C::STATES) {
            Some((contact, terms)) => (contact, terms.or(self.defaults)),
            None => self.read(raw, place, faults)?,
        };
        let step_over = terms.step_over(C::STATES, &place, faults)?;
        let pass = self.judge(contact, &terms, &place, faults)?;
        let figures = single::work_out(&self.calculation, &self.setup, &pass, step_over, &terms)?;
        let figures = figures.map_err(|cause| faults.push(at(&place, refusal::fault(cause, &place, contact, step_over))))?;
        part.add(index, &figures, &pass);
        Ok(())
    }

    /// A contact and the terms that hold for it, with all their faults.
    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<(StatedContact, Terms), Faulted> {
        let mut object = Object::open(raw, place, faults)?;
        let contact = contact::read(&mut object, faults);
        let terms = Terms::read(&mut object, C::STATES, faults).or(self.defaults);
        object.close(faults)?;
        terms.step_over(C::STATES, &place, faults)?;
        // Faulty terms keep that to themselves until they are asked for.
        if faults.is_empty() { Ok((contact?, terms)) } else { Err(Faulted) }
    }

    fn judge(&self, contact: StatedContact, terms: &Terms, place: &Place<'_>, faults: &mut Faults) -> Result<JudgedPass, Faulted> {
        let pass = Pass { cutter: self.setup.tool.cutter, contact: contact.contact, surface: terms.surface()?, runout: self.setup.runout };
        JudgedPass::new(self.setup.model, pass).map_err(|cause| faults.push(at(place, refusal::fault(cause, place, contact, None))))
    }
}

/// A contact without an answer is to blame as a whole: which of its terms come from the defaults is not told apart.
fn at(place: &Place<'_>, fault: Fault) -> Fault {
    Fault { pointer: place.to_string(), ..fault }
}

impl<F: Figures> Part<F> {
    fn of(columns: F::Columns) -> Self {
        Self { columns, failures: Vec::new(), failed: 0, minimum: None, maximum: None, warnings: Vec::new() }
    }

    fn add(&mut self, index: usize, figures: &F, pass: &JudgedPass) {
        self.columns.push(Some(figures));
        let common = figures.common();
        for strain in Strain::of(pass, common.step_over, common.feed_per_tooth) {
            match self.warnings.iter_mut().find(|warning| warning.code == strain.code()) {
                Some(warning) => warning.contacts = warning.contacts.map(|contacts| contacts + 1),
                None => self.warnings.push(Warning { contacts: Some(1), first_index: Some(index), ..Warning::from(strain) }),
            }
        }
        let found = Some(Extreme { index, value_mm: figures.found_mm() });
        self.minimum = lower(self.minimum, found);
        self.maximum = higher(self.maximum, found);
    }

    fn fail(&mut self, index: usize, faults: &[Fault]) {
        self.columns.push(None);
        self.failed += 1;
        if self.failures.len() < MOST_FAILURES {
            self.failures.extend(Failure::new(index, faults));
        }
    }

    fn append(&mut self, mut next: Self) {
        self.columns.append(next.columns);
        let room = MOST_FAILURES.saturating_sub(self.failures.len());
        self.failures.extend(next.failures.drain(..room.min(next.failures.len())));
        self.failed += next.failed;
        self.minimum = lower(self.minimum, next.minimum);
        self.maximum = higher(self.maximum, next.maximum);
        for warning in next.warnings {
            match self.warnings.iter_mut().find(|known| known.code == warning.code) {
                Some(known) => known.contacts = known.contacts.zip(warning.contacts).map(|(a, b)| a + b),
                None => self.warnings.push(warning),
            }
        }
    }

    fn written(self, model: Model, count: usize) -> WrittenJson {
        let summary = Summary { count, failures: self.failed, minimum: self.minimum, maximum: self.maximum };
        self.columns.written(model, summary, self.failures, self.warnings)
    }
}

/// The extreme with the smaller value, the first of equals.
fn lower(first: Option<Extreme>, second: Option<Extreme>) -> Option<Extreme> {
    match (first, second) {
        (Some(a), Some(b)) => Some(if b.value_mm < a.value_mm { b } else { a }),
        (one, other) => one.or(other),
    }
}

/// The extreme with the larger value, the first of equals.
fn higher(first: Option<Extreme>, second: Option<Extreme>) -> Option<Extreme> {
    match (first, second) {
        (Some(a), Some(b)) => Some(if b.value_mm > a.value_mm { b } else { a }),
        (one, other) => one.or(other),
    }
}

/// The schemas of a request with many contacts, by name.
pub(super) fn schemas<C: Calculation>() -> Vec<(String, RefOr<Schema>)> {
    let schema =
        Setup::describe(ObjectSchema::new("a calculation at many contacts: the terms hold for every contact that does not state its own"));
    let contacts = Member { name: CONTACTS, about: "the contacts of the tool path, in their order", kind: ContactsKind(C::STATES) };
    let schema = C::describe(Terms::describe(schema, C::STATES)).required(&contacts);
    let mut schemas = vec![(C::SCHEMAS[1].to_owned(), schema.build())];
    let names = item_names(C::STATES);
    schemas.extend(contact::forms(names, "a contact with terms of its own", |schema| Terms::describe(schema, C::STATES)));
    schemas.extend(cutter::schemas());
    schemas
}

/// The schemas of a batch's items depend on which terms they may state.
fn item_names(stated: Stated) -> [&'static str; 2] {
    match (stated.step_over, stated.feed_per_tooth) {
        (true, true) => ["AngleContactWithTerms", "VectorContactWithTerms"],
        (true, false) => ["AngleContactWithStepOver", "VectorContactWithStepOver"],
        _ => ["AngleContactWithFeed", "VectorContactWithFeed"],
    }
}

/// Only described: the items are read one by one, so that one that is faulty fails alone.
struct ContactsKind(Stated);

impl Kind for ContactsKind {
    type Value = ();

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<(), Faulted> {
        items(raw, MOST_CONTACTS, place, faults).map(|_| ())
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        let [angles, vectors] = item_names(self.0);
        let item = OneOfBuilder::new().item(Ref::from_schema_name(angles)).item(Ref::from_schema_name(vectors));
        ArrayBuilder::new().items(item).max_items(Some(MOST_CONTACTS)).description(Some(about)).into()
    }
}
