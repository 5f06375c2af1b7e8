//! One contact, one answer.

use super::contact::{CONTACT, StatedContact};
use super::figures::{Check, Common, Figures};
use super::refusal;
use super::terms::{Setup, Terms};
use super::warning::{Strain, Warning};
use super::{Calculation, contact, cutter};
use crate::http::body::JsonBody;
use crate::http::codes::WarningCode;
use crate::http::problem::Problem;
use crate::http::reading::{Faulted, Faults, ObjectSchema, Place};
use crate::milling::{Envelope, JudgedPass, Model, NoAnswer, Pass, StepOver};
use axum::Json;
use utoipa::openapi::{RefOr, Schema};

/// Answers a request with one contact.
pub(super) fn answer<C: Calculation>(body: &JsonBody) -> Result<Json<<C::Figures as Figures>::Answer>, Problem> {
    body.read(|object, faults| {
        let setup = Setup::read(object, faults);
        let contact = object.required(&CONTACT, faults);
        let terms = Terms::read(object, C::STATES, faults);
        let calculation = C::read(object, setup.as_ref().map_err(|faulted| *faulted), faults);
        let request = Request { setup, contact, terms, calculation };
        request.answer(&object.place(), faults)
    })
    .map(Json)
}

/// The schemas of a request with one contact, by name.
pub(super) fn schemas<C: Calculation>() -> Vec<(String, RefOr<Schema>)> {
    let schema = Setup::describe(ObjectSchema::new("a calculation at one contact")).required(&CONTACT);
    let schema = C::describe(Terms::describe(schema, C::STATES));
    let mut schemas = vec![(C::SCHEMAS[0].to_owned(), schema.build())];
    schemas.extend(cutter::schemas());
    schemas.extend(contact::schemas());
    schemas
}

/// A request in which any part may have been faulty. As much as can be judged is judged, for the faults that show only then.
struct Request<C> {
    setup: Result<Setup, Faulted>,
    contact: Result<StatedContact, Faulted>,
    terms: Terms,
    calculation: Result<C, Faulted>,
}

impl<C: Calculation> Request<C> {
    fn answer(self, place: &Place<'_>, faults: &mut Faults) -> Result<<C::Figures as Figures>::Answer, Faulted> {
        let step_over = self.terms.step_over(C::STATES, place, faults);
        let pass = self.judge(place, faults);
        let (setup, contact, pass) = (self.setup?, self.contact?, pass?);
        let figures = work_out(&self.calculation?, &setup, &pass, step_over?, &self.terms)?;
        let figures = figures.map_err(|cause| faults.push(refusal::fault(cause, place, contact, step_over.ok().flatten())))?;
        let common = figures.common();
        let mut warnings: Vec<Warning> = Strain::of(&pass, common.step_over, common.feed_per_tooth).map(Warning::from).collect();
        let check = check(&pass, common, &mut warnings);
        Ok(figures.into_answer(setup.model, check, warnings))
    }

    /// The pass under its model, as soon as cutter, contact and surface are known, whatever else is faulty.
    fn judge(&self, place: &Place<'_>, faults: &mut Faults) -> Result<JudgedPass, Faulted> {
        let (setup, contact, surface) = (self.setup?, self.contact?, self.terms.surface()?);
        let pass = Pass { cutter: setup.tool.cutter, contact: contact.contact, surface, runout: setup.runout };
        JudgedPass::new(setup.model, pass).map_err(|cause| faults.push(refusal::fault(cause, place, contact, None)))
    }
}

/// Works out one contact: the outer error is a fault that is recorded already, the inner one a cause that is not.
pub(super) fn work_out<C: Calculation>(
    calculation: &C,
    setup: &Setup,
    pass: &JudgedPass,
    step_over: Option<StepOver>,
    terms: &Terms,
) -> Result<Result<C::Figures, NoAnswer>, Faulted> {
    let feed_per_tooth = terms.feed_per_tooth()?;
    let along = step_over.map(|step_over| step_over.along_surface(pass.pass().contact)).transpose();
    Ok(along.and_then(|along| calculation.work_out(setup, pass, along, feed_per_tooth)))
}

/// A deviation beyond which the analytic model is outside its range: 5 % under what the cutter leaves.
const OUTSIDE_RANGE: f64 = -0.05;

/// The analytic height beside the envelope's, and the warning that it is far under it.
fn check(pass: &JudgedPass, common: &Common, warnings: &mut Vec<Warning>) -> Option<Check> {
    const CODE: WarningCode = WarningCode::OutsideAnalyticRange;
    if pass.model() != Model::Analytic {
        return None;
    }
    let envelope = Envelope::new(*pass.pass()).and_then(|envelope| envelope.scallop_height(common.step_over, common.feed_per_tooth));
    let envelope = match envelope {
        Ok(height) => height.total().mm(),
        Err(cause) => {
            warnings.push(Warning::new(CODE, format!("the cutter's exact shape leaves no scallop to compare with: {cause}")));
            return None;
        }
    };
    let deviation = (envelope > 0.0).then(|| (common.height.total().mm() - envelope) / envelope);
    if let Some(deviation) = deviation.filter(|deviation| *deviation < OUTSIDE_RANGE) {
        let detail = format!(
            "the analytic height is {:.1} % under the {envelope:.6} mm that the cutter's exact shape leaves; model \"envelope\" keeps the tolerance",
            -deviation * 100.0
        );
        warnings.push(Warning::new(CODE, detail));
    }
    Some(Check { envelope_scallop_height_mm: envelope, deviation })
}
