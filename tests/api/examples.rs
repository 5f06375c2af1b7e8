//! The examples of the OpenAPI document hold: each request has its answer, each refused request its problem, and all fit
//! the schemas. An operation without an example fails here.
//!
//! After an intended change, `docs/renew-examples` updates answers and problems.

use std::collections::BTreeSet;
use std::fs;

use crate::api::openapi::{Operation, assert_valid, document, operations, validator};
use crate::app::{Answer, TestApp};
use serde_json::{Map, Value};

/// The largest relative difference of numbers from those of a machine with another mathematical library. Twenty
/// functions of a calculation may each differ by some roundings of 1e-16, and a deviation of a tenth has ten times
/// their relative error; a plan sums thousands of times.
fn rounding(operation: Operation<'_>) -> f64 {
    if operation.described["tags"][0] == "planning" { 1e-9 } else { 1e-12 }
}

/// Asserts that `found` is `expected` but for the rounding of numbers.
#[track_caller]
fn assert_same(found: &Value, expected: &Value, rounding: f64, place: &str) {
    match (found, expected) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a - b).abs() <= rounding * b.abs(), "{place}: {a} is not {b}");
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter().zip(b).enumerate().for_each(|(index, (a, b))| assert_same(a, b, rounding, &format!("{place}/{index}")));
        }
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>(), "{place}");
            a.iter().for_each(|(name, a)| assert_same(a, &b[name], rounding, &format!("{place}/{name}")));
        }
        _ => assert_eq!(found, expected, "{place}"),
    }
}

/// The examples of all operations by their ids, from `openapi/examples/`.
fn files() -> Map<String, Value> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/openapi/examples");
    let files = fs::read_dir(folder).unwrap().map(|entry| fs::read_to_string(entry.unwrap().path()).unwrap());
    files.flat_map(|file| serde_json::from_str::<Map<String, Value>>(&file).unwrap()).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_example_request_gives_its_example_answer() {
    let (app, document) = (TestApp::start().await, document());
    for operation in operations(&document) {
        let (id, request, expected) = (operation.id(), operation.example(), &operation.answer()["example"]);
        assert!(!request.is_null() && !expected.is_null(), "{id} has no example");
        if operation.media_type().is_some() {
            assert_valid(&validator(&document, &operation.body()["schema"]), &request);
        }
        let answer = Answer::of(operation.request(&app, &request).send().await.unwrap()).await;
        assert_eq!(answer.status, 200, "{id}: {}", answer.body);
        assert_same(&answer.body, expected, rounding(operation), id);
        let answers = validator(&document, &operation.answer()["schema"]);
        assert_valid(&answers, expected);
        assert_valid(&answers, &answer.body);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_refused_example_gives_its_problem() {
    let (app, document, files) = (TestApp::start().await, document(), files());
    for operation in operations(&document).filter(|operation| operation.statuses().contains(&422)) {
        let (id, shown) = (operation.id(), &operation.problem(422)["examples"]);
        let refused = files[id]["refused"].as_object().unwrap_or_else(|| panic!("{id} has no refused examples"));
        let problems = validator(&document, &operation.problem(422)["schema"]);
        for (name, example) in refused {
            let mut answer = Answer::of(operation.request(&app, &example["request"]).send().await.unwrap()).await;
            assert_eq!(answer.status, 422, "{id} {name}");
            answer.body.as_object_mut().unwrap().shift_remove("request_id").unwrap();
            assert_same(&answer.body, &shown[name]["value"], rounding(operation), &format!("{id} {name}"));
            assert_valid(&problems, &shown[name]["value"]);
        }
    }
}

#[test]
fn every_example_is_in_the_document() {
    let (document, files) = (document(), files());
    let known: BTreeSet<&str> = operations(&document).map(Operation::id).collect();
    let given: BTreeSet<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(given, known);
}
