//! The OpenAPI document compared with the service: the committed file is the generated one, its examples hold, requests
//! and answers fit its schemas, and its members are those that the service accepts.

use std::collections::BTreeSet;

use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, batch_of, longest, shortest, with, without};
use crate::app::{Answer, TestApp, faults};
use jsonschema::Validator;
use scallopd::http::{openapi_3_0_json, openapi_json};
use serde_json::{Value, json};

const SINGLES: [&str; 4] = [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS];

pub(super) fn document() -> Value {
    serde_json::from_str(&openapi_json()).unwrap()
}

/// A validator of `schema`, which refers to the document's components.
pub(super) fn validator(document: &Value, schema: &Value) -> Validator {
    let mut schema = schema.clone();
    schema["components"] = document["components"].clone();
    jsonschema::draft202012::new(&schema).unwrap()
}

pub(super) fn assert_valid(validator: &Validator, instance: &Value) {
    let errors: Vec<_> = validator.iter_errors(instance).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert!(errors.is_empty(), "{errors:#?} in {instance}");
}

/// The operations that take a JSON body, with their paths.
fn operations(document: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let posts = document["paths"].as_object().unwrap().iter().filter_map(|(path, item)| Some((path.as_str(), item.get("post")?)));
    posts.filter(|(_, operation)| request_of(operation).is_object())
}

fn request_of(operation: &Value) -> &Value {
    &operation["requestBody"]["content"]["application/json"]
}

fn answer_of(operation: &Value) -> &Value {
    &operation["responses"]["200"]["content"]["application/json"]
}

pub(super) fn problem_of<'a>(operation: &'a Value, status: &str) -> &'a Value {
    &operation["responses"][status]["content"]["application/problem+json"]["schema"]
}

/// Asserts that `found` is `expected`, with numbers to a relative 1e-12: twenty functions of the system's mathematical
/// library may each differ by some roundings of 1e-16, and a deviation of a tenth has ten times their relative error.
pub(super) fn assert_same(found: &Value, expected: &Value, place: &str) {
    match (found, expected) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a - b).abs() <= 1e-12 * b.abs(), "{place}: {a} is not {b}");
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                assert_same(a, b, &format!("{place}/{index}"));
            }
        }
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.keys().collect::<BTreeSet<_>>(), b.keys().collect::<BTreeSet<_>>(), "{place}");
            for (name, a) in a {
                assert_same(a, &b[name], &format!("{place}/{name}"));
            }
        }
        _ => assert_eq!(found, expected, "{place}"),
    }
}

#[test]
fn the_committed_document_is_the_generated_one() {
    let committed = include_str!("../../openapi/openapi.json");
    assert!(committed == openapi_json(), "openapi/openapi.json is stale: cargo run -- openapi > openapi/openapi.json");
}

#[tokio::test]
async fn the_server_serves_the_same_document_in_both_versions() {
    let app = TestApp::start().await;
    for (path, document) in [("/openapi.json", openapi_json()), ("/openapi-3.0.json", openapi_3_0_json())] {
        let answer = app.get(path).await;
        assert_eq!(answer.headers()["content-type"], "application/json");
        assert_eq!(answer.text().await.unwrap(), document);
    }
}

#[tokio::test]
async fn every_example_request_gives_its_example_answer() {
    let (app, document) = (TestApp::start().await, document());
    assert!(operations(&document).count() >= 6);
    for (path, operation) in operations(&document) {
        let (request, expected) = (&request_of(operation)["example"], &answer_of(operation)["example"]);
        assert!(request.is_object() && expected.is_object(), "{path} has no example");
        assert_same(&app.answer(path, request).await, expected, path);
    }
}

#[tokio::test]
async fn examples_answers_and_problems_fit_the_schemas() {
    let (app, document) = (TestApp::start().await, document());
    for (path, operation) in operations(&document) {
        let (request, answer) = (request_of(operation), answer_of(operation));
        let (requests, answers) = (validator(&document, &request["schema"]), validator(&document, &answer["schema"]));
        assert_valid(&requests, &request["example"]);
        assert_valid(&answers, &answer["example"]);
        assert_valid(&answers, &app.answer(path, &request["example"]).await);
        let Answer { status, body: problem } = app.post(path, &json!({})).await;
        assert_valid(&validator(&document, problem_of(operation, &status.to_string())), &problem);
        let Answer { status, body: problem } = app.post_text(path, "{").await;
        assert_valid(&validator(&document, problem_of(operation, &status.to_string())), &problem);
    }
}

/// Valid requests of all shapes.
fn answered(path: &str) -> Vec<Value> {
    let vectors = json!({"normal": [-0.64, 0, 0.77], "feed": [1, 0, 0.84]});
    let mut bodies =
        vec![shortest(path), longest(path), with(longest(path), "/model", "envelope"), with(shortest(path), "/contact", vectors)];
    for cutter in [json!({"type": "ball_end", "diameter_mm": 6}), json!({"type": "flat_end", "diameter_mm": 6, "teeth": 2})] {
        bodies.push(with(shortest(path), "/cutter", cutter));
    }
    bodies.push(with(shortest(path), "/cutter/type", "bull_nose"));
    if path == SCALLOP_HEIGHT {
        let floor = with(with(shortest(path), "/contact/slope_deg", 0), "/model", "envelope");
        bodies.push(floor);
        bodies.push(with(without(shortest(path), "/step_over_mm"), "/step_over_xy_mm", 0.5));
    }
    // The sharp marks of the flat end need more tolerance than those of the others.
    bodies.into_iter().map(|body| if path == SCALLOP_HEIGHT { body } else { with(body, "/scallop_tolerance_mm", 0.04) }).collect()
}

#[tokio::test]
async fn requests_of_all_shapes_and_their_answers_fit_the_schemas() {
    let (app, document) = (TestApp::start().await, document());
    for single in SINGLES {
        for (path, batch) in [(single.to_owned(), false), (format!("{single}/batch"), true)] {
            let operation = &document["paths"][&path]["post"];
            let requests = validator(&document, &request_of(operation)["schema"]);
            let answers = validator(&document, &answer_of(operation)["schema"]);
            for body in answered(single) {
                let body = if batch { batch_of(body) } else { body };
                assert_valid(&requests, &body);
                assert_valid(&answers, &app.answer(&path, &body).await);
            }
        }
    }
}

#[tokio::test]
async fn the_service_refuses_requests_that_the_schemas_refuse() {
    let (app, document) = (TestApp::start().await, document());
    for single in SINGLES {
        let schema = validator(&document, &request_of(&document["paths"][single]["post"])["schema"]);
        let problems = validator(&document, problem_of(&document["paths"][single]["post"], "422"));
        let body = longest(single);
        for wrong in [
            with(body.clone(), "/note", "x"),
            with(body.clone(), "/cutter/note", "x"),
            with(body.clone(), "/cutter/teeth", 0),
            with(body.clone(), "/cutter/type", "drill"),
            with(body.clone(), "/cutter/type", "ball_end"),
            with(body.clone(), "/contact/slope_deg", 91),
            with(body.clone(), "/contact/feed", json!([1, 0, 0])),
            with(body.clone(), "/contact", json!({"normal": [0, 0, 1], "feed": [1, 0]})),
            with(body.clone(), "/runout/radial_mm", -1),
            with(body.clone(), "/model", "exact"),
            without(body.clone(), "/cutter"),
        ] {
            assert!(!schema.is_valid(&wrong), "{wrong}");
            assert_valid(&problems, &app.refusal(single, &wrong).await);
        }
    }
}

/// The known names in the detail of the fault of an unknown member.
fn known(detail: &str) -> BTreeSet<String> {
    let (_, names) = detail.split_once("known here: ").unwrap_or_else(|| panic!("no names in {detail:?}"));
    names.split(", ").map(str::to_owned).collect()
}

/// The names that a schema of the document has.
fn properties(schema: &Value) -> BTreeSet<String> {
    schema["properties"].as_object().unwrap().keys().cloned().collect()
}

fn schema<'a>(document: &'a Value, operation: &'a Value) -> &'a Value {
    component(document, &request_of(operation)["schema"])
}

/// The component that a reference names.
fn component<'a>(document: &'a Value, reference: &Value) -> &'a Value {
    let pointer = reference["$ref"].as_str().unwrap().strip_prefix('#').unwrap();
    document.pointer(pointer).unwrap()
}

#[tokio::test]
async fn the_members_of_each_schema_are_those_that_the_service_accepts() {
    let (app, document) = (TestApp::start().await, document());
    let known_at = async |path: &str, body: Value, place: &str| {
        let problem = app.refusal(path, &with(body, &format!("{place}/zz"), 1)).await;
        assert_eq!(faults(&problem), [(format!("{place}/zz").as_str(), "unknown-field")]);
        known(problem["errors"][0]["detail"].as_str().unwrap())
    };
    for single in SINGLES {
        let top = schema(&document, &document["paths"][single]["post"]);
        assert_eq!(known_at(single, longest(single), "").await, properties(top), "{single}");
        assert_eq!(
            known_at(single, longest(single), "/runout").await,
            properties(component(&document, &top["properties"]["runout"])),
            "{single}"
        );
        let vectors = with(shortest(single), "/contact", json!({"normal": [0, 0.5, 1], "feed": [1, 0, 0]}));
        let components = &document["components"]["schemas"];
        assert_eq!(known_at(single, shortest(single), "/contact").await, properties(&components["AngleContact"]));
        assert_eq!(known_at(single, vectors, "/contact").await, properties(&components["VectorContact"]));
        for (name, cutter) in [
            ("ToroidalCutter", json!({"type": "toroidal", "diameter_mm": 6, "corner_radius_mm": 1})),
            ("BallEndCutter", json!({"type": "ball_end", "diameter_mm": 6})),
            ("FlatEndCutter", json!({"type": "flat_end", "diameter_mm": 6})),
        ] {
            assert_eq!(known_at(single, with(shortest(single), "/cutter", cutter), "/cutter").await, properties(&components[name]));
        }

        let path = format!("{single}/batch");
        let top = schema(&document, &document["paths"][&path]["post"]);
        assert_eq!(known_at(&path, batch_of(longest(single)), "").await, properties(top), "{path}");
        let contacts = json!([{"slope_deg": 40, "feed_angle_deg": 30, "zz": 1}, {"normal": [0, 0.5, 1], "feed": [1, 0, 0], "zz": 1}]);
        // No contact has an answer, so the batch has none.
        let problem = app.refusal(&path, &with(batch_of(shortest(single)), "/contacts", contacts)).await;
        let forms = top["properties"]["contacts"]["oneOf"].as_array().unwrap();
        for (index, item) in forms[0]["items"]["oneOf"].as_array().unwrap().iter().enumerate() {
            let detail = problem["errors"][index]["detail"].as_str().unwrap();
            assert_eq!(known(detail), properties(component(&document, item)), "{path} {index}");
        }
        let columns = known_at(&path, with(batch_of(shortest(single)), "/contacts", json!({})), "/contacts").await;
        assert_eq!(columns, properties(component(&document, &forms[1])), "{path}");
    }
}

#[tokio::test]
async fn the_members_that_each_schema_requires_are_those_that_the_service_requires() {
    let (app, document) = (TestApp::start().await, document());
    for (path, operation) in operations(&document) {
        let required = schema(&document, operation)["required"].as_array().unwrap().iter();
        let required: BTreeSet<_> = required.map(|name| format!("/{}", name.as_str().unwrap())).collect();
        let problem = app.refusal(path, &json!({})).await;
        assert!(faults(&problem).iter().all(|(_, code)| *code == "missing-field"), "{problem}");
        let mut missed: BTreeSet<_> = faults(&problem).into_iter().map(|(pointer, _)| pointer.to_owned()).collect();
        // One of two members, or of two pairs of members, is required, which `required` cannot express.
        let either = missed.remove("/step_over_mm") || missed.remove("");
        assert_eq!(either, [SCALLOP_HEIGHT, MAX_FEED, "/v1/critical-slope"].contains(&path), "{path}");
        assert_eq!(missed, required, "{path}");
    }
}

/// A refused request for each type of problem that has figures, and for two that have none.
fn refused() -> Vec<(&'static str, &'static str, Value)> {
    let wide = with(shortest(SCALLOP_HEIGHT), "/step_over_mm", 14);
    vec![
        (MAX_FEED, "tolerance-exceeded", with(shortest(MAX_FEED), "/step_over_mm", 1)),
        (SCALLOP_HEIGHT, "passes-do-not-overlap", wide.clone()),
        (SCALLOP_HEIGHT, "gouging", with(shortest(SCALLOP_HEIGHT), "/surface_radius_mm", -2)),
        (STEP_OVER, "tolerance-exceeded-by-feed", with(shortest(STEP_OVER), "/feed_per_tooth_mm", 1)),
        (STEP_OVER, "tolerance-sets-no-limit", with(shortest(STEP_OVER), "/scallop_tolerance_mm", 100)),
        (MAX_FEED, "tolerance-sets-no-limit", with(shortest(MAX_FEED), "/scallop_tolerance_mm", 100)),
        (SCALLOP_HEIGHT, "flat-floor", with(shortest(SCALLOP_HEIGHT), "/contact/slope_deg", 0)),
        // A problem has its type's figures; one with several faults has none.
        (SCALLOP_HEIGHT, "invalid-request", with(wide, "/note", "x")),
    ]
}

#[tokio::test]
async fn a_problem_has_the_members_that_the_schema_of_its_type_names_and_no_others() {
    let (app, document) = (TestApp::start().await, document());
    for (path, kind, body) in refused() {
        let problem = app.refusal(path, &body).await;
        assert_eq!(problem["type"], kind, "{problem}");
        let union = component(&document, problem_of(&document["paths"][path]["post"], "422"));
        let schema = component(&document, &json!({"$ref": union["discriminator"]["mapping"][kind]}));
        assert_valid(&validator(&document, schema), &problem);
        let members: BTreeSet<String> = problem.as_object().unwrap().keys().cloned().collect();
        assert!(members.is_subset(&properties(schema)), "{problem}");
    }
}

#[test]
fn each_type_of_problem_has_one_schema() {
    let document = document();
    let schemas = &document["components"]["schemas"];
    let mut seen = BTreeSet::new();
    for item in schemas["UnprocessableProblem"]["oneOf"].as_array().unwrap() {
        for kind in component(&document, item)["properties"]["type"]["enum"].as_array().unwrap() {
            assert!(seen.insert(kind.as_str().unwrap().to_owned()), "{kind} has two schemas");
            assert!(schemas["ProblemType"]["enum"].as_array().unwrap().contains(kind), "{kind} is not a problem type");
        }
    }
    let mapping = schemas["UnprocessableProblem"]["discriminator"]["mapping"].as_object().unwrap();
    assert_eq!(seen, mapping.keys().cloned().collect());
}
