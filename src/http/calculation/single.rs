//! Requests with one contact, as JSON or as a query, and their answers.

use super::{Calculation, Inputs};
use crate::cancellation::CancelFlag;
use crate::http::codes::WarningCode;
use crate::http::json_body::{JsonBody, WrittenJson};
use crate::http::problem::Problem;
use crate::http::query::Query;
use crate::http::reading::{Components, Faulted, Faults, Kind, Members, Object, ObjectSchema};
use crate::http::wire::{
    Check, ContactParameters, Figures, Heights, InOrder, MODEL, OneContact, SharedMembers, SharedParameters, StatedContact, Warning,
    no_answer,
};
use crate::http::work::Work;
use crate::milling::{Envelope, EvaluatedPass, Model, NoAnswer, Pass};
use serde::Serialize;
use serde_json::Value;
use std::num::NonZeroU32;
use std::sync::Arc;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The answer for one contact.
#[derive(Serialize)]
struct Answer {
    model: &'static str,
    #[serde(flatten)]
    figures: InOrder<Option<Value>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<Check>,
    warnings: Vec<Warning>,
}

/// The schema of an answer for one contact.
pub(super) fn describe_answer<C: Calculation>(components: &mut Components) -> RefOr<Schema> {
    let mut schema = ObjectBuilder::new().schema_type(Type::Object).description(Some("The answer for one contact"));
    schema = schema.property("model", MODEL.kind.schema("the model that answered", components)).required("model");
    for figure in C::figures() {
        schema = schema.property(figure.name, figure.schema(components));
        schema = if figure.is_required() { schema.required(figure.name) } else { schema };
    }
    schema = schema.property("check", components.refer_type::<Check>());
    schema.property("warnings", warnings_schema(components)).required("warnings").into()
}

/// The schema of an answer's warnings.
pub(super) fn warnings_schema(components: &mut Components) -> ArrayBuilder {
    ArrayBuilder::new()
        .items(components.refer_type::<Warning>())
        .description(Some("facts that need attention although the request is answered"))
}

/// The schema of a request with one contact.
pub(super) fn describe_request<C: Calculation>(components: &mut Components) -> RefOr<Schema> {
    let schema = ObjectSchema::new("A calculation at one contact", components).with::<SharedMembers>().with::<OneContact>();
    schema.with_members(C::STATED.members()).with::<C::Members>().build()
}

/// Answers a request with one contact.
pub(super) async fn answer<C: Calculation + 'static>(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    let takes_long = C::TAKES_LONG || may_state_curvature(body.json(), b'\\');
    let answer = move |cancel: &CancelFlag| WrittenJson::of(&body.read(|object, faults| read::<C>(object, faults, cancel))?);
    if takes_long { work.run_piece(answer).await } else { answer(&CancelFlag::default()) }
}

/// Answers the same request as a query.
pub(super) async fn answer_query<C: Calculation + 'static>(
    work: Work,
    query: Arc<Query>,
    text: Option<String>,
) -> Result<WrittenJson, Problem> {
    let text = text.unwrap_or_default();
    let takes_long = C::TAKES_LONG || may_state_curvature(text.as_bytes(), b'%');
    let answer = move |cancel: &CancelFlag| WrittenJson::of(&query.read(&text, |object, faults| read::<C>(object, faults, cancel))?);
    if takes_long { work.run_piece(answer).await } else { answer(&CancelFlag::default()) }
}

/// Whether a request may state a curvature. A search with a curvature can take tens of milliseconds, too long for a
/// thread that serves connections. A request with escapes counts, because it may write the name with escapes.
fn may_state_curvature(request: &[u8], escape: u8) -> bool {
    memchr::memmem::find(request, b"surface_").is_some() || memchr::memchr(escape, request).is_some()
}

/// Reads a request and computes its answer. Its parts without faults are evaluated to find further faults.
fn read<C: Calculation>(object: &mut Object<'_, '_>, faults: &mut Faults, cancel: &CancelFlag) -> Result<Answer, Faulted> {
    let path = object.path();
    let shared = SharedParameters::read(object, faults);
    let contact = OneContact::read(object, faults).contact;
    let parameters = ContactParameters::read(object, C::STATED, faults);
    let members = C::Members::read(object, faults);
    let calculation = C::new(members, shared.as_ref().map_err(|faulted| *faulted), faults);
    let step_over = parameters.step_over(&path, faults);
    let (shared, contact) = (shared?, contact?);
    let fault = |cause, step_over_member| no_answer(cause, &path, contact, &parameters, step_over_member);
    let pass = EvaluatedPass::new(shared.model, pass(&shared, &contact, &parameters)?);
    let pass = pass.map_err(|cause| faults.push(fault(cause, parameters.step_over_member())))?;
    let calculation = calculation?;
    let feed_per_tooth = parameters.feed_per_tooth()?;
    let inputs = Inputs { shared: &shared, pass: &pass, step_over: step_over?, feed_per_tooth, heights: Heights::Parts, cancel };
    let figures = calculation.compute(&inputs).map_err(|cause| faults.push(fault(cause, calculation.step_over_member(&parameters))))?;
    let mut warnings: Vec<Warning> = figures.warnings(&pass).map(Warning::from).collect();
    let check = check(&pass, &figures, &mut warnings);
    let values = C::figures().map(|figure| (figure, figure.value(&figures)));
    let stated = values.filter(|(figure, value)| value.is_some() || figure.is_required());
    let figures = InOrder(stated.map(|(figure, value)| (figure.name, value)).collect());
    Ok(Answer { model: MODEL.kind.word(&shared.model), figures, check, warnings })
}

/// The pass that a request describes at a contact.
#[inline]
pub(super) fn pass(shared: &SharedParameters, contact: &StatedContact, parameters: &ContactParameters) -> Result<Pass, Faulted> {
    Ok(Pass {
        cutter: shared.tool.cutter,
        contact: contact.contact,
        surface: parameters.curvature()?,
        runout: shared.runout,
        teeth: shared.tool.teeth.and_then(NonZeroU32::new),
    })
}

/// The deviation below which the analytic model is outside its range: 5 % below the height by the cutter's exact shape.
const OUTSIDE_RANGE: f64 = -0.05;

/// Compares the height by the pass's model with the envelope's, and tells whether that is a bound; heights are not compared with one
/// that is none.
pub(super) fn compare(pass: &EvaluatedPass, figures: &Figures) -> Result<(Check, bool), NoAnswer> {
    let height = figures.height.unwrap_or_else(|| unreachable!("a comparison needs the height")).mm();
    let (envelope, is_bound) = match pass.model() {
        Model::Analytic => {
            let envelope = Envelope::new(*pass.pass())?.scallop_height(figures.step_over, figures.feed_per_tooth)?;
            (envelope.total().mm(), pass.is_bound(envelope.largest_turn()))
        }
        Model::Envelope => (height, true),
    };
    let deviation = (is_bound && envelope > 0.0).then(|| (height - envelope) / envelope);
    Ok((Check { envelope_scallop_height_mm: envelope, deviation }, is_bound))
}

/// Whether the analytic model is outside its range.
pub(super) fn is_outside_range(compared: &Result<(Check, bool), NoAnswer>) -> bool {
    compared.as_ref().map_or(true, |(check, _)| check.deviation.is_some_and(|deviation| deviation < OUTSIDE_RANGE))
}

/// Compares the analytic height with the envelope's, and adds a warning if it is far lower, or if the envelope's is no bound.
fn check(pass: &EvaluatedPass, figures: &Figures, warnings: &mut Vec<Warning>) -> Option<Check> {
    if pass.model() != Model::Analytic {
        return None;
    }
    let compared = compare(pass, figures);
    if is_outside_range(&compared) {
        let detail = match compared {
            Err(cause) => format!("the cutter's exact shape leaves no scallop to compare with: {cause}"),
            Ok((Check { envelope_scallop_height_mm, deviation }, _)) => format!(
                "the analytic height is {:.1} % under the {envelope_scallop_height_mm:.6} mm that the cutter's exact shape leaves; model \"envelope\" keeps the tolerance",
                -deviation.unwrap_or_default() * 100.0
            ),
        };
        warnings.push(Warning::new(WarningCode::OutsideAnalyticRange, detail));
    }
    let (check, is_bound) = compared.ok()?;
    if !is_bound {
        let detail = "the curved surface can be level or upright within a step-over, where the height by the cutter's exact shape is no bound: the analytic height is not compared with it";
        warnings.push(Warning::new(WarningCode::HeightNotABound, detail));
    }
    Some(check)
}
