//! The operations of a calculation: for one contact by `POST` and `GET`, and for many by `POST`; each with its handler
//! and its documentation.

use super::{Calculation, batch, single};
use crate::http::app_state::AppState;
use crate::http::problem_schemas::{Problems, QueryProblems, pascal_case};
use crate::http::query::Query;
use crate::http::reading::Components;
use crate::http::routes::{RouteClass, Routes};
use crate::http::work::Work;
use axum::extract::RawQuery;
use axum::routing::post;
use std::sync::Arc;
use utoipa::IntoResponses;
use utoipa::openapi::path::{OperationBuilder, Paths};
use utoipa::openapi::request_body::RequestBodyBuilder;
use utoipa::openapi::{Content, HttpMethod, Ref, RefOr, Required, ResponseBuilder, ResponsesBuilder, Schema};
use utoipa_axum::router::UtoipaMethodRouter;

/// The texts of a calculation's documentation.
pub(crate) struct Texts {
    /// The name in paths, such as `max-feed`. Operation ids and names of schemas are derived from it.
    pub(crate) name: &'static str,
    /// The operation for one contact in a few words.
    pub(crate) summary: &'static str,
    /// What it computes.
    pub(crate) about: &'static str,
    /// The content of its answer.
    pub(crate) answer: &'static str,
    /// The operation for many contacts in a few words.
    pub(crate) batch_summary: &'static str,
}

const ABOUT_QUERY: &str = "The same as the POST, with the members as query parameters: the names of nested members are joined by an underscore,\n\
    members of `cutter` and `contact` keep their names, the cutter's type is `cutter`, and a vector is three numbers\n\
    separated by commas.";

const ABOUT_BATCH: &str = "The same calculation at many contacts. A contact without an answer is null in every column and listed in `failures`;\n\
    it does not affect the others.";

type Schemas = Vec<(String, RefOr<Schema>)>;
type Describe = fn(&mut Components) -> RefOr<Schema>;

/// The routes of a calculation, with the file of examples.
pub(super) fn operations_of<C: Calculation + 'static>(examples: &'static str) -> Routes {
    let routes = Routes::new().documented(RouteClass::Single, single::<C>()).documented(RouteClass::Batch, batch::<C>());
    routes.with_examples(examples)
}

/// The operations for one contact.
fn single<C: Calculation + 'static>() -> UtoipaMethodRouter<AppState> {
    let Texts { name, summary, about, answer, .. } = C::TEXTS;
    let (mut schemas, mut paths) = (Schemas::new(), Paths::new());
    let path = format!("/v1/{name}");
    let request = content(&mut schemas, &format!("{name}-request"), single::describe_request::<C>);
    let body = content(&mut schemas, &format!("{name}-answer"), single::describe_answer::<C>);
    let query = Arc::new(Query::of(single::describe_request::<C>));
    let by_query =
        operation::<QueryProblems>(&format!("{name}-query"), &format!("{summary}, by a query"), ABOUT_QUERY, answer, body.clone());
    paths.add_path_operation(&path, vec![HttpMethod::Get], by_query.parameters(Some(query.describe())));
    let by_body = operation::<Problems>(name, summary, about, answer, body);
    paths.add_path_operation(&path, vec![HttpMethod::Post], with_body(by_body, request));
    let answer_query = async move |work: Work, RawQuery(text): RawQuery| single::answer_query::<C>(work, query, text).await;
    (schemas, paths, post(single::answer::<C>).get(answer_query))
}

/// The operation for many contacts.
fn batch<C: Calculation + 'static>() -> UtoipaMethodRouter<AppState> {
    let Texts { name, batch_summary, .. } = C::TEXTS;
    let (mut schemas, mut paths) = (Schemas::new(), Paths::new());
    let request = content(&mut schemas, &format!("{name}-batch-request"), batch::describe_request::<C>);
    let body = content(&mut schemas, &format!("{name}-batch-answer"), batch::describe_answer::<C>);
    let operation = operation::<Problems>(&format!("{name}-batch"), batch_summary, ABOUT_BATCH, "A column for each figure", body);
    paths.add_path_operation(format!("/v1/{name}/batch"), vec![HttpMethod::Post], with_body(operation, request));
    (schemas, paths, post(batch::answer::<C>))
}

/// Adds the schema `name` and those to which it refers, and returns a body of this schema.
fn content(schemas: &mut Schemas, name: &str, describe: Describe) -> Content {
    let (name, mut components) = (pascal_case(name), Components::default());
    schemas.push((name.clone(), describe(&mut components)));
    schemas.extend(components.into_named());
    Content::new(Some(Ref::from_schema_name(name)))
}

fn operation<P: IntoResponses>(name: &str, summary: &str, about: &str, answer: &str, body: Content) -> OperationBuilder {
    let answer = ResponseBuilder::new().description(answer).content("application/json", body);
    let responses = ResponsesBuilder::new().response("200", answer).responses_from_into_responses::<P>();
    let operation = OperationBuilder::new().tag("calculations").operation_id(Some(name.replace('-', "_")));
    operation.summary(Some(summary)).description(Some(about)).responses(responses)
}

fn with_body(operation: OperationBuilder, body: Content) -> OperationBuilder {
    let body = RequestBodyBuilder::new().content("application/json", body).required(Some(Required::True));
    operation.request_body(Some(body.build()))
}
