//! Batch requests: many contacts in, one column for each figure out. Contacts are parsed and computed on all cores. A
//! contact without an answer does not affect the others.

use super::column::{Column, ColumnSelection, Table};
use super::single::{self, warnings_schema};
use super::{Calculation, Inputs};
use crate::budget::Job;
use crate::cancellation::CancelFlag;
use crate::http::codes::{RequestFault, WarningCode};
use crate::http::json_body::{JsonBody, WrittenJson};
use crate::http::problem::Problem;
use crate::http::reading::{Components, Fault, Faulted, Faults, JsonPath, Kind, Members, Object, ObjectSchema};
use crate::http::wire::{
    BatchContact, CHECK_FIGURES, ContactParameters, Contacts, Failure, Figure, Figures, Get, InOrder, MODEL, SharedMembers,
    SharedParameters, Summary, Warning, no_answer,
};
use crate::http::work::Work;
use crate::milling::{EvaluatedPass, NoAnswer};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::f64::consts::FRAC_PI_2;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The number of contacts that one thread computes at a time. They take some tenths of a millisecond, so the cost of
/// distributing them is negligible.
const CHUNK: usize = 1024;

const CONTACTS: &str = "contacts";

/// The largest number of failures that an answer lists. Further failures are only counted.
const MOST_FAILURES: usize = 1000;

/// The largest number of faults in the problem returned when no contact has an answer.
const MOST_FAULTS: usize = 100;

/// The largest number of faults listed for one contact.
const MOST_FAULTS_OF_A_CONTACT: usize = 8;

/// Answers a request with many contacts, on worker threads and within the memory budget.
pub(super) async fn answer<C: Calculation + 'static>(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    // There is a comma between contacts, as objects or in a column.
    let contacts = Contacts::MOST.min(memchr::memchr_iter(b',', body.json()).count() + 1);
    work.answer(Job::Batch { contacts }, move |cancel| compute::<C>(&body, cancel)).await
}

fn compute<C: Calculation>(body: &JsonBody, cancel: &CancelFlag) -> Result<WrittenJson, Problem> {
    let mut without_answers = None;
    let answer = body.read(|object, faults| {
        let path = object.path();
        let (defaults, batch) = Batch::<C>::read(object, faults);
        let path = path.member(CONTACTS);
        let Some(contacts) = object.take(CONTACTS, faults) else {
            faults.object_knows(&path, Contacts::names(C::STATED));
            return Err(faults.add(&path, RequestFault::MissingField, "the field is missing: the contacts to compute"));
        };
        let contacts = Contacts::open(contacts, C::STATED, path, faults)?;
        if !faults.is_empty() {
            // Nothing is computed, but the contacts are still checked, so that the answer lists their faults too.
            for index in (0..contacts.count()).take_while(|_| !cancel.is_cancelled()) {
                let path = contacts.path(index, &path);
                let contact = contacts.read(index, &defaults, path, faults);
                let _recorded = contact.and_then(|contact| contact.parameters.step_over(&path, faults));
            }
            return Err(Faulted);
        }
        let batch = batch?;
        let part = batch.compute(&contacts, path, cancel);
        if cancel.is_cancelled() {
            // The answer of a cancelled batch is discarded.
            return Err(Faulted);
        }
        if part.count == 0 || part.failed < part.count {
            return Ok(part.table(&batch).written());
        }
        part.list_failures(faults);
        without_answers = Some(part.table(&batch).joined());
        Err(Faulted)
    });
    match without_answers {
        // No contact has an answer. The problem has the batch's answer, so that clients read its `failures` as usual.
        Some(table) => answer.map_err(|problem| problem.with_answer(table)),
        None => answer,
    }
}

/// The parts of a request beside its contacts.
struct Batch<C> {
    shared: SharedParameters,
    defaults: ContactParameters,
    calculation: C,
    selection: ColumnSelection,
}

/// The results of a chunk of consecutive contacts. Indices are those in the chunk.
struct Part {
    columns: Vec<Column>,
    /// The number of contacts.
    count: usize,
    failed: usize,
    /// The first failures, with their faults.
    failures: Vec<(usize, Vec<Fault>)>,
    outside_range: usize,
    warnings: Vec<Warning>,
    /// The number of contacts by angles, and their largest slope in deg.
    by_angles: usize,
    largest_slope: f64,
}

/// The number of slopes from which on it is no accident that all are small.
const MANY_SLOPES: usize = 20;

/// The slope in deg up to which a surface counts as a floor.
const SMALL_SLOPE: f64 = 0.2;

impl<C: Calculation> Batch<C> {
    /// Reads the parts of a request beside its contacts. The parameters of contacts are returned even if other parts have
    /// faults.
    fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> (ContactParameters, Result<Self, Faulted>) {
        let shared = SharedParameters::read(object, faults);
        let defaults = ContactParameters::read(object, C::STATED, faults);
        let members = C::Members::read(object, faults);
        let calculation = C::new(members, shared.as_ref().map_err(|faulted| *faulted), faults);
        let selection = ColumnSelection::read::<C>(object, faults);
        let batch = || Ok(Self { shared: shared?, defaults, calculation: calculation?, selection: selection? });
        (defaults, batch())
    }

    /// Reads and computes contacts on all cores; the rest of a cancelled batch is left out.
    fn compute(&self, contacts: &Contacts<'_>, path: JsonPath<'_>, cancel: &CancelFlag) -> Part {
        let compute = |chunk: usize| {
            let first = chunk * CHUNK;
            let end = contacts.count().min(first + CHUNK);
            let mut part = self.part(end - first);
            let mut faults = Faults::at_most(MOST_FAULTS_OF_A_CONTACT);
            for index in (first..end).take_while(|_| !cancel.is_cancelled()) {
                let path = contacts.path(index, &path);
                let contact = contacts.read(index, &self.defaults, path, &mut faults);
                self.take_in(&mut part, &contact, path, &mut faults, cancel);
            }
            part
        };
        let chunks = (0..contacts.count().div_ceil(CHUNK)).into_par_iter();
        chunks.map(compute).reduce(|| self.part(0), Part::followed_by)
    }

    /// Adds the next contact to a part: its figures, or its faults if it has no answer. `faults` are empty
    /// afterwards, for the next contact.
    #[inline]
    fn take_in(
        &self,
        part: &mut Part,
        contact: &Result<BatchContact, Faulted>,
        path: JsonPath<'_>,
        faults: &mut Faults,
        cancel: &CancelFlag,
    ) {
        let is_computed = contact.as_ref().is_ok_and(|contact| self.compute_contact(part, contact, path, faults, cancel).is_ok());
        if !is_computed {
            part.fail(faults.take());
        }
        if let Some(slope) = contact.as_ref().ok().and_then(|contact| contact.contact.stated_slope_deg()) {
            part.by_angles += 1;
            part.largest_slope = part.largest_slope.max(slope);
        }
        part.count += 1;
    }

    /// Computes a contact and adds its figures to a part.
    #[inline]
    fn compute_contact(
        &self,
        part: &mut Part,
        contact: &BatchContact,
        path: JsonPath<'_>,
        faults: &mut Faults,
        cancel: &CancelFlag,
    ) -> Result<(), Faulted> {
        let BatchContact { contact, parameters } = contact;
        let step_over = parameters.step_over(&path, faults)?;
        let member = self.calculation.step_over_member(parameters);
        // The fault points to the contact as a whole: any of its parameters, defaults included, may be the cause.
        let mut fail =
            |cause: NoAnswer| faults.push(Fault { pointer: path.to_string(), ..no_answer(cause, &path, *contact, parameters, member) });
        // The results are borrowed: they are large, and each `?` would copy them.
        let evaluated = EvaluatedPass::new(self.shared.model, single::pass(&self.shared, contact, parameters)?);
        let pass = evaluated.as_ref().map_err(|cause| fail(*cause))?;
        let (feed_per_tooth, heights) = (parameters.feed_per_tooth()?, self.selection.heights);
        let inputs = Inputs { shared: &self.shared, pass, step_over, feed_per_tooth, heights, cancel };
        let mut computed = self.calculation.compute(&inputs);
        let figures = computed.as_mut().map_err(|cause| fail(*cause))?;
        if self.selection.is_compared {
            let compared = single::compare(pass, figures);
            part.outside_range += usize::from(single::is_outside_range(&compared));
            figures.check = compared.ok().map(|(check, _)| check);
        }
        part.add(figures, pass, &self.selection);
        Ok(())
    }

    /// A part without contacts, and room for about `count`.
    fn part(&self, count: usize) -> Part {
        let columns = self.selection.figures.iter().map(|_| Column::with_capacity(count)).collect();
        Part {
            columns,
            count: 0,
            failed: 0,
            failures: Vec::new(),
            outside_range: 0,
            warnings: Vec::new(),
            by_angles: 0,
            largest_slope: 0.0,
        }
    }
}

impl Part {
    fn add(&mut self, figures: &Figures, pass: &EvaluatedPass, selection: &ColumnSelection) {
        let index = self.count;
        for (column, figure) in self.columns.iter_mut().zip(&selection.figures) {
            match figure.get {
                Get::Number(get) => column.push_number(index, get(figures).map(|number| selection.rounded(number))),
                Get::Word(get, _) => column.push(get(figures).as_ref()),
                Get::Words(..) => column.push(figure.value(figures).as_ref()),
            }
        }
        for warning in figures.warnings(pass) {
            match self.warnings.iter_mut().find(|known| known.code == warning.into()) {
                Some(known) => known.contacts = known.contacts.map(|contacts| contacts + 1),
                None => self.warnings.push(Warning { contacts: Some(1), first_index: Some(index), ..Warning::from(warning) }),
            }
        }
    }

    fn fail(&mut self, faults: Faults) {
        self.columns.iter_mut().for_each(Column::push_failed);
        self.failed += 1;
        if self.failures.len() < MOST_FAILURES {
            self.failures.push((self.count, faults.into_listed()));
        }
    }

    /// This part and the one after it. Failures beyond those that are listed are dropped to save memory.
    fn followed_by(mut self, mut next: Self) -> Self {
        for (column, mut next) in self.columns.iter_mut().zip(next.columns) {
            next.shift(self.count);
            column.append(next);
        }
        let listed = MOST_FAILURES - self.failures.len();
        self.failures.extend(next.failures.into_iter().take(listed).map(|(index, faults)| (self.count + index, faults)));
        for warning in &mut next.warnings {
            warning.first_index = warning.first_index.map(|index| self.count + index);
        }
        for warning in next.warnings {
            match self.warnings.iter_mut().find(|known| known.code == warning.code) {
                Some(known) => known.contacts = known.contacts.zip(warning.contacts).map(|(a, b)| a + b),
                None => self.warnings.push(warning),
            }
        }
        self.count += next.count;
        self.failed += next.failed;
        self.outside_range += next.outside_range;
        self.by_angles += next.by_angles;
        self.largest_slope = self.largest_slope.max(next.largest_slope);
        self
    }

    /// Records the first faults of a batch whose contacts all failed.
    fn list_failures(&self, faults: &mut Faults) {
        let mut left_out = self.count;
        let mut listed = 0;
        for (_, of_contact) in &self.failures {
            listed += of_contact.len();
            if listed > MOST_FAULTS {
                break;
            }
            left_out -= 1;
            for fault in of_contact {
                faults.push(fault.clone());
            }
        }
        faults.add_left_out(left_out);
    }

    /// The warnings about figures that contacts with an answer do not have.
    fn absent_figures(&self, selection: &ColumnSelection) -> Vec<Warning> {
        let columns = selection.figures.iter().zip(&self.columns);
        let absent = columns.filter(|(figure, column)| column.absent > 0 && selection.shows(figure, column));
        let warning = |(figure, column): (&&Figure, &Column)| Warning {
            contacts: Some(column.absent),
            first_index: column.first_absent,
            ..Warning::new(WarningCode::FigureAbsent, figure.absence())
        };
        absent.map(warning).collect()
    }

    /// The warning that slopes may be in radians: none of many exceeds pi/2.
    fn radians(&self) -> Option<Warning> {
        // The slope was converted to radians and back.
        let largest = FRAC_PI_2 * (1.0 + 4.0 * f64::EPSILON);
        let is_suspicious = self.by_angles >= MANY_SLOPES && self.largest_slope > SMALL_SLOPE && self.largest_slope <= largest;
        let detail = format!(
            "none of the {} slopes exceeds {:.4} deg; slope_deg and feed_angle_deg are in degrees, and these look like radians",
            self.by_angles, self.largest_slope
        );
        is_suspicious.then(|| Warning::new(WarningCode::AnglesLikeRadians, detail))
    }

    fn table<C>(mut self, batch: &Batch<C>) -> Table {
        let further: Vec<Warning> = self.absent_figures(&batch.selection).into_iter().chain(self.radians()).collect();
        self.warnings.extend(further);
        let Batch { shared, selection, .. } = batch;
        let named = || selection.figures.iter().zip(&self.columns);
        let extremes = InOrder(named().filter_map(|(figure, column)| Some((figure.name, column.extremes()?))).collect());
        let outside_analytic_range = selection.is_compared.then_some(self.outside_range);
        let mut table = Table::default();
        table.value("model", &MODEL.kind.word(&shared.model));
        table.value("summary", &Summary { count: self.count, failures: self.failed, outside_analytic_range, extremes });
        for (figure, column) in selection.figures.iter().zip(self.columns) {
            if selection.shows(figure, &column) {
                table.column(figure.name, column);
            }
        }
        let failures: Vec<_> = self.failures.iter().filter_map(|(index, faults)| Failure::new(*index, faults)).collect();
        table.value("failures", &failures);
        table.value("warnings", &self.warnings);
        table
    }
}

/// The schema of a request with many contacts.
pub(super) fn describe_request<C: Calculation>(components: &mut Components) -> RefOr<Schema> {
    let contacts = Contacts::schema(C::STATED, components);
    let about = "A calculation at many contacts; the parameters apply to every contact that does not state its own";
    let schema = ObjectSchema::new(about, components).with::<SharedMembers>();
    let schema = schema.with_members(C::STATED.members()).with::<C::Members>();
    ColumnSelection::describe::<C>(schema).required_property(CONTACTS, contacts).build()
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
