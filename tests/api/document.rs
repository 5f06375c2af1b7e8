//! The OpenAPI document compared with the service: the committed file is the generated one, requests and answers fit its
//! schemas, and its members are those that the service accepts.

use std::collections::BTreeSet;

use crate::api::cutters::shapes;
use crate::api::openapi::{Operation, assert_valid, document, json_operations, operation, validator};
use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, batch_of, longest, shortest, with, without};
use crate::app::{Answer, TestApp, faults};
use scallopd::http::{OPENAPI_3_0_JSON, openapi_json};
use serde_json::{Value, json};

const SINGLES: [&str; 4] = [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS];

#[test]
fn the_committed_document_is_the_generated_one() {
    let committed = include_str!("../../openapi/openapi.json");
    assert!(committed == openapi_json(), "openapi/openapi.json is stale: cargo run -- openapi > openapi/openapi.json");
}

/// The script's own check, `openapi/to_3_0 --check`, compares every byte; this one needs no Python.
#[test]
fn the_committed_document_of_version_3_0_has_the_members_of_the_other() {
    let (document, converted): (_, Value) = (document(), serde_json::from_str(OPENAPI_3_0_JSON).unwrap());
    assert_eq!(converted["openapi"], "3.0.3");
    let names = |object: &Value| object.as_object().map(|members| members.keys().cloned().collect::<BTreeSet<_>>());
    let mut paths = names(&document["paths"]).unwrap();
    paths.remove("/v1/cutter-recommendation/upload");
    paths.remove("/v1/path-check/upload");
    assert_eq!(names(&converted["paths"]).unwrap(), paths, "openapi-3.0.json is stale: openapi/to_3_0");
    let schemas = &converted["components"]["schemas"];
    let (all, kept) = (names(&document["components"]["schemas"]).unwrap(), names(schemas).unwrap());
    let of_forms = ["UploadRequest", "PathCheckUpload", "PathCheckParameters"];
    let is_left_out = |name: &&String| name.contains("Problem") || of_forms.contains(&name.as_str());
    assert!(kept.is_subset(&all) && all.difference(&kept).all(|name| is_left_out(&name)));
    for name in kept.iter().filter(|name| *name != "Problem") {
        let before = names(&document["components"]["schemas"][name]["properties"]);
        assert_eq!(names(&schemas[name]["properties"]), before, "openapi-3.0.json is stale in {name}: openapi/to_3_0");
    }
}

#[tokio::test]
async fn the_server_serves_the_same_document_in_both_versions() {
    let app = TestApp::start().await;
    for (path, document) in [("/openapi.json", openapi_json()), ("/openapi-3.0.json", OPENAPI_3_0_JSON.to_owned())] {
        let answer = app.get(path).await;
        assert_eq!(answer.headers()["content-type"], "application/json");
        assert_eq!(answer.text().await.unwrap(), document);
    }
}

#[tokio::test]
async fn problems_of_requests_without_members_and_of_bodies_that_are_not_json_fit_their_schemas() {
    let (app, document) = (TestApp::start().await, document());
    for operation in json_operations(&document) {
        for body in ["{}", "{"] {
            let Answer { status, body: problem } = app.post_text(operation.path, body).await;
            assert_valid(&validator(&document, &operation.problem(status)["schema"]), &problem);
        }
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
            let operation = operation(&document, "post", &path);
            let requests = validator(&document, &operation.body()["schema"]);
            let answers = validator(&document, &operation.answer()["schema"]);
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
        let schema = validator(&document, &operation(&document, "post", single).body()["schema"]);
        let problems = validator(&document, &operation(&document, "post", single).problem(422)["schema"]);
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

/// The schema of an operation's requests.
fn schema<'a>(document: &'a Value, operation: Operation<'a>) -> &'a Value {
    component(document, &operation.body()["schema"])
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
        let top = schema(&document, operation(&document, "post", single));
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
        ]
        .into_iter()
        .chain(shapes())
        {
            assert_eq!(known_at(single, with(shortest(single), "/cutter", cutter), "/cutter").await, properties(&components[name]));
        }

        let path = format!("{single}/batch");
        let top = schema(&document, operation(&document, "post", &path));
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
    for operation in json_operations(&document) {
        let (path, schema) = (operation.path, schema(&document, operation));
        let required: BTreeSet<_> =
            schema["required"].as_array().unwrap().iter().map(|name| format!("/{}", name.as_str().unwrap())).collect();
        let problem = app.refusal(path, &json!({})).await;
        assert!(faults(&problem).iter().all(|(_, code)| *code == "missing-field"), "{problem}");
        let missed: BTreeSet<_> = faults(&problem).into_iter().map(|(pointer, _)| pointer.to_owned()).collect();
        assert!(required.is_subset(&missed), "{path}: {problem}");
        // One of two members, or of two pairs of members, may be required, which `required` cannot express.
        for pointer in missed.difference(&required) {
            let error = problem["errors"].as_array().unwrap().iter().find(|error| error["pointer"] == **pointer).unwrap();
            let detail = error["detail"].as_str().unwrap();
            let alternatives = properties(schema).into_iter().filter(|name| detail.contains(name.as_str()));
            assert!(detail.contains(" or ") && alternatives.count() >= 2, "{path} {pointer}: {detail}");
        }
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
        let union = component(&document, &operation(&document, "post", path).problem(422)["schema"]);
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
