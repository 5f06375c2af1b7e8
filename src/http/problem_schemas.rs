//! Problems in the OpenAPI document: the answers of each kind of operation that fails, and a schema for each problem that has
//! figures.

use super::codes::{Code, CodeFamily, FileFaultCode, NoAnswerCode, ProblemFigure, ServiceProblem};
use super::problem::{HOLLOW, NEEDED_SHARE, ProblemBody};
use super::wire::NotRanked;
use axum::http::StatusCode;
use std::collections::BTreeMap;
use utoipa::openapi::schema::{AdditionalProperties, ArrayBuilder, Discriminator, ObjectBuilder, OneOfBuilder, Type};
use utoipa::openapi::{self, Ref, RefOr, ResponseBuilder, Schema};
use utoipa::{IntoResponses, PartialSchema, ToSchema};

/// The problems that any operation with a JSON body can answer with, for the API document.
pub(crate) struct Problems;

impl IntoResponses for Problems {
    fn responses() -> BTreeMap<String, RefOr<utoipa::openapi::Response>> {
        responses("The body is not JSON", "The body's media type or encoding is not supported")
    }
}

/// The problems that an operation without a body can answer with, for the API document.
pub(crate) struct QueryProblems;

impl IntoResponses for QueryProblems {
    fn responses() -> BTreeMap<String, RefOr<utoipa::openapi::Response>> {
        let of_bodies = ["400", "408", "413", "415"];
        responses("", "").into_iter().filter(|(status, _)| !of_bodies.contains(&status.as_str())).collect()
    }
}

/// The problems that an operation with an uploaded file can answer with, for the API document.
pub(crate) struct UploadProblems;

impl IntoResponses for UploadProblems {
    fn responses() -> BTreeMap<String, RefOr<utoipa::openapi::Response>> {
        responses(
            "The form, its parameters or the file is malformed; for the file, `errors` has the line or byte",
            "The body is not a form, or the file's format is not supported",
        )
    }
}

fn responses(malformed: &str, unsupported: &str) -> BTreeMap<String, RefOr<utoipa::openapi::Response>> {
    [
        ("400", malformed, PROBLEM),
        ("408", "The request was not complete in time", PROBLEM),
        ("413", "The body, counted decompressed, exceeds the server's limit", PROBLEM),
        ("415", unsupported, PROBLEM),
        ("422", "The request is well-formed and cannot be answered; `errors` lists every fault with its location", UNPROCESSABLE),
        ("500", "The server failed; its log has the cause under the request id", PROBLEM),
        ("503", "The server is busy; try again after the time in Retry-After", PROBLEM),
    ]
    .into_iter()
    .map(|(status, description, schema)| (status.to_owned(), problem_response(description, schema)))
    .collect()
}

fn problem_response(description: &str, schema: &str) -> RefOr<utoipa::openapi::Response> {
    let content = openapi::Content::new(Some(RefOr::Ref(Ref::from_schema_name(schema))));
    ResponseBuilder::new().description(description).content("application/problem+json", content).build().into()
}

const NOT_RANKED: &str = "not_ranked";
const PROBLEM: &str = "Problem";
const UNPROCESSABLE: &str = "UnprocessableProblem";

/// The schemas of problems with status 422, by name: one for each type that has figures, one for all other types, and
/// their union.
pub(crate) fn schemas() -> Vec<(String, RefOr<Schema>)> {
    let mut schemas: Vec<(String, RefOr<Schema>)> = Vec::new();
    let mut any = OneOfBuilder::new().description(Some("The reason why a well-formed request has no answer, discriminated by `type`."));
    let mut mapping = Vec::new();
    let mut add = |name: String, types: &[&'static str], schema: ObjectBuilder| {
        any = std::mem::take(&mut any).item(Ref::from_schema_name(&name));
        mapping.extend(types.iter().map(|of_type| (*of_type, format!("#/components/schemas/{name}"))));
        schemas.push((name, schema.into()));
    };
    let of_files =
        FileFaultCode::ALL.iter().filter(|fault| fault.entry().status == Some(StatusCode::UNPROCESSABLE_ENTITY)).map(|fault| fault.name());
    let mut plain: Vec<_> = std::iter::once(ServiceProblem::InvalidRequest.name()).chain(of_files).collect();
    for code in NoAnswerCode::ALL {
        match code.figures() {
            (&[], &[]) => plain.push(code.name()),
            figures => add(format!("{}Problem", pascal_case(code.name())), &[code.name()], schema_of_types(&[code.name()], figures)),
        }
    }
    let no_cutter_fits = [ServiceProblem::NoCutterFits.name()];
    let of_cutters = ArrayBuilder::new().items(Ref::from_schema_name(NotRanked::name())).min_items(Some(1));
    let of_cutters = of_cutters.description(Some("The cutters, each with the reason why it is not ranked."));
    let schema = schema_of_types(&no_cutter_fits, (&[], &[NEEDED_SHARE, HOLLOW])).property(NOT_RANKED, of_cutters).required(NOT_RANKED);
    add("NoCutterFitsProblem".to_owned(), &no_cutter_fits, schema);
    add("ProblemWithoutFigures".to_owned(), &plain, schema_of_types(&plain, (&[], &[])));
    let any = any.discriminator(Some(Discriminator::with_mapping("type", mapping)));
    schemas.push((UNPROCESSABLE.to_owned(), any.into()));
    schemas.push((NotRanked::name().into_owned(), NotRanked::schema()));
    NotRanked::schemas(&mut schemas);
    schemas
}

/// The schema of a problem of one of `types`, with the figures that are always present and those that may be absent.
fn schema_of_types(types: &[&'static str], (always, sometimes): (&[ProblemFigure], &[ProblemFigure])) -> ObjectBuilder {
    let RefOr::T(Schema::Object(problem)) = ProblemBody::schema() else { unreachable!("a struct is described as an object") };
    let kind = ObjectBuilder::new().schema_type(Type::String).enum_values(Some(types.iter().copied()));
    let kind = kind.description(Some("The problem, as a code for programs."));
    let answer = ObjectBuilder::new().schema_type(Type::Object).additional_properties(Some(AdditionalProperties::FreeForm(true)));
    let answer = answer.description(Some(
        "Of a batch whose contacts all failed: the answer in its usual form, with null in every column and the reasons in failures.",
    ));
    let mut schema = ObjectBuilder::from(problem).property("type", kind).property("answer", answer);
    for figure in always.iter().chain(sometimes) {
        let number = ObjectBuilder::new().schema_type(Type::Number).minimum(Some(0.0)).description(Some(figure.about));
        schema = schema.property(figure.name, number);
    }
    always.iter().fold(schema, |schema, figure| schema.required(figure.name))
}

/// The name in Pascal case of a name in kebab case.
pub(crate) fn pascal_case(name: &str) -> String {
    name.split('-').map(|word| word[..1].to_ascii_uppercase() + &word[1..]).collect()
}
