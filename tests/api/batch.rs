//! Batches: columns in the order sent, failures of single contacts, defaults and their overrides.

use crate::api::requests::{MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, angles, batch_of, longest, shortest, with, without};
use crate::app::{TestApp, faults};
use serde_json::{Map, Value, json};

const SINGLES: [&str; 3] = [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER];

fn batch(single: &str) -> String {
    format!("{single}/batch")
}

fn columns(answer: &Value) -> impl Iterator<Item = (&String, &Vec<Value>)> {
    let beside = |name: &str| name == "failures" || name == "warnings";
    answer.as_object().unwrap().iter().filter_map(move |(name, column)| Some((name, column.as_array()?)).filter(|_| !beside(name)))
}

/// The figures of one contact from the columns, without nulls.
fn row(answer: &Value, index: usize) -> Map<String, Value> {
    columns(answer).map(|(name, column)| (name.clone(), column[index].clone())).filter(|(_, value)| !value.is_null()).collect()
}

/// The figures of a single answer, without the members that have another form in a batch.
fn figures(answer: &Value) -> Map<String, Value> {
    let beside = ["model", "check", "warnings"];
    let figures = answer.as_object().unwrap().clone().into_iter();
    figures.filter(|(name, value)| !beside.contains(&name.as_str()) && !value.is_null()).collect()
}

/// One contact of a batch as a single request.
fn single(body: &Value, index: usize) -> Value {
    let contact = &body["contacts"][index];
    let mut request = without(body.clone(), "/contacts");
    let mut inner = Map::new();
    for (name, value) in contact.as_object().unwrap() {
        if ["slope_deg", "feed_angle_deg", "normal", "feed"].contains(&name.as_str()) {
            inner.insert(name.clone(), value.clone());
        } else {
            if name.starts_with("step_over") {
                request.as_object_mut().unwrap().retain(|name, _| !name.starts_with("step_over"));
            }
            request[name] = value.clone();
        }
    }
    with(request, "/contact", inner)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_100_000_contacts_three_faulty_ones_fail_and_the_others_are_answered_in_their_order() {
    const COUNT: usize = 100_000;
    const BAD: [usize; 3] = [17, 50_000, COUNT - 1];
    let app = TestApp::start().await;
    for (path, model) in [(SCALLOP_HEIGHT, "analytic"), (MAX_FEED, "analytic"), (STEP_OVER, "envelope")] {
        // Slopes from 30 to 60 deg, all contacts different, so that a wrong order is detected.
        let contact = |index: usize| angles(30.0 + 3e-4 * f64::from(u32::try_from(index).unwrap()), 20.0);
        let mut contacts: Vec<Value> = (0..COUNT).map(contact).collect();
        contacts[BAD[0]] = json!({"slope_deg": 91, "feed_angle_deg": 20});
        contacts[BAD[1]] = json!({"slope_deg": 45});
        contacts[BAD[2]] = json!({"slope_deg": 45, "feed_angle_deg": 20, "surface_radius_mm": -1});
        let body = with(with(batch_of(shortest(path)), "/contacts", contacts), "/model", model);
        let body = if path == STEP_OVER { body } else { with(body, "/step_over_mm", 0.6) };
        let answer = app.answer(&batch(path), &body).await;

        let failures = answer["failures"].as_array().unwrap();
        let failed: Vec<_> =
            failures.iter().map(|failure| (failure["index"].as_u64().unwrap(), failure["code"].as_str().unwrap())).collect();
        assert_eq!(failed, [(17, "out-of-range"), (50_000, "missing-field"), (99_999, "gouging")]);
        assert_eq!(failures[0]["pointer"], "/contacts/17/slope_deg");
        assert_eq!(failures[1]["pointer"], "/contacts/50000/feed_angle_deg");
        assert_eq!((&answer["summary"]["count"], &answer["summary"]["failures"]), (&json!(COUNT), &json!(3)));
        assert!(columns(&answer).count() >= 8);
        for (name, column) in columns(&answer) {
            let nulls: Vec<_> = column.iter().enumerate().filter(|(_, value)| value.is_null()).map(|(index, _)| index).collect();
            assert_eq!((column.len(), nulls.as_slice()), (COUNT, BAD.as_slice()), "{name}");
        }
        // Contacts at the borders of the runs that are computed together, and beside the faulty contacts.
        for index in [0, 16, 18, 1_023, 1_024, 49_999, 50_001, COUNT - 2] {
            assert_eq!(row(&answer, index), figures(&app.answer(path, &single(&body, index)).await), "{path} {index}");
        }
    }
}

#[tokio::test]
async fn a_contact_overrides_the_defaults_for_itself_only() {
    let app = TestApp::start().await;
    for path in SINGLES {
        let mut contacts = vec![
            angles(40.0, 30.0),
            json!({"slope_deg": 40, "feed_angle_deg": 30, "surface_radius_mm": -50}),
            json!({"normal": [-0.64, 0, 0.77], "feed": [1, 0, 0.84]}),
        ];
        if path != STEP_OVER {
            contacts.push(json!({"slope_deg": 40, "feed_angle_deg": 30, "step_over_mm": 0.5}));
            contacts.push(json!({"slope_deg": 40, "feed_angle_deg": 30, "step_over_xy_mm": 0.5}));
        }
        if path != MAX_FEED {
            contacts.push(json!({"slope_deg": 40, "feed_angle_deg": 30, "feed_per_tooth_mm": 0.2}));
            contacts.push(json!({"slope_deg": 40, "feed_angle_deg": 30, "feed_per_tooth_mm": 0}));
        }
        contacts.push(angles(40.0, 30.0));
        for model in ["analytic", "envelope"] {
            let body = with(with(batch_of(longest(path)), "/contacts", contacts.clone()), "/model", model);
            // At -50 mm, runout and feed use up only a part of the tolerance, so that every contact has an answer.
            let answer = app.answer(&batch(path), &body).await;
            assert_eq!(answer["failures"], json!([]), "{path}");
            for index in 0..contacts.len() {
                assert_eq!(row(&answer, index), figures(&app.answer(path, &single(&body, index)).await), "{path} {index}");
            }
            assert_eq!(row(&answer, 0), row(&answer, contacts.len() - 1));
            assert_ne!(row(&answer, 0), row(&answer, 1));
        }
    }
}

#[tokio::test]
async fn parameters_may_be_stated_by_the_contacts_only() {
    let app = TestApp::start().await;
    let contacts = json!([{"slope_deg": 40, "feed_angle_deg": 30, "step_over_mm": 0.5}, angles(40.0, 30.0)]);
    let body = with(without(batch_of(shortest(SCALLOP_HEIGHT)), "/step_over_mm"), "/contacts", contacts);
    let answer = app.answer(&batch(SCALLOP_HEIGHT), &body).await;
    assert_eq!(answer["step_over_mm"], json!([0.5, null]));
    assert_eq!((&answer["failures"][0]["index"], &answer["failures"][0]["code"]), (&json!(1), &json!("missing-field")));
}

#[tokio::test]
async fn the_summary_names_the_extremes_of_every_column() {
    let app = TestApp::start().await;
    for (path, column) in [(SCALLOP_HEIGHT, "scallop_height_mm"), (MAX_FEED, "feed_per_tooth_mm"), (STEP_OVER, "step_over_mm")] {
        let contacts = json!([angles(0.0, 0.0), angles(40.0, 50.0), angles(50.0, 0.0), angles(41.0, 20.0), angles(50.0, 0.0)]);
        let body = with(batch_of(shortest(path)), "/contacts", contacts);
        let body = if path == MAX_FEED { with(body, "/scallop_tolerance_mm", 0.03) } else { body };
        let answer = app.answer(&batch(path), &body).await;
        let found = answer[column].as_array().unwrap();
        let by_value = |order: f64| {
            let values = found.iter().enumerate().filter_map(|(index, value)| Some((index, value.as_f64()?)));
            values.reduce(|best, next| if order * next.1 < order * best.1 { next } else { best }).unwrap()
        };
        for (extreme, order) in [("minimum", 1.0), ("maximum", -1.0)] {
            let (index, value) = by_value(order);
            assert_eq!(answer["summary"]["extremes"][column][extreme], json!({"index": index, "value": value}), "{path}");
        }
        assert_eq!((&answer["summary"]["count"], &answer["summary"]["failures"]), (&json!(5), &json!(1)));
    }
}

#[tokio::test]
async fn an_empty_list_of_contacts_is_answered_with_empty_columns() {
    let app = TestApp::start().await;
    for path in SINGLES {
        let answer = app.answer(&batch(path), &with(batch_of(shortest(path)), "/contacts", json!([]))).await;
        assert_eq!(answer["summary"], json!({"count": 0, "failures": 0, "extremes": {}}));
        assert!(columns(&answer).count() >= 8 && columns(&answer).all(|(_, column)| column.is_empty()));
        assert_eq!((&answer["failures"], &answer["warnings"]), (&json!([]), &json!([])));
    }
}

#[tokio::test]
async fn a_faulty_contact_fails_alone_with_all_its_faults() {
    let app = TestApp::start().await;
    let contacts = json!([null, 7, [], {}, {"slope_deg": "x", "feed_angle_deg": null, "tilt": 1, "step_over_mm": -1}, angles(40.0, 30.0)]);
    let answer = app.answer(&batch(SCALLOP_HEIGHT), &with(batch_of(shortest(SCALLOP_HEIGHT)), "/contacts", contacts)).await;
    let failures = answer["failures"].as_array().unwrap();
    let codes: Vec<_> = failures.iter().map(|failure| failure["code"].as_str().unwrap()).collect();
    assert_eq!(codes[..4], ["wrong-type", "wrong-type", "wrong-type", "missing-field"]);
    assert_eq!(failures[0]["pointer"], "/contacts/0");
    assert_eq!(failures[4]["pointer"], "/contacts/4/slope_deg");
    for further in ["/contacts/4/feed_angle_deg: ", "/contacts/4/step_over_mm: ", "/contacts/4/tilt: "] {
        assert!(failures[4]["detail"].as_str().unwrap().contains(further), "{}", failures[4]);
    }
    assert!(answer["scallop_height_mm"][5].is_number());
}

#[tokio::test]
async fn each_reason_without_an_answer_fails_its_contact_with_its_code() {
    let app = TestApp::start().await;
    for (path, contact, code) in [
        (SCALLOP_HEIGHT, angles(0.0, 0.0), "flat-floor"),
        (SCALLOP_HEIGHT, json!({"slope_deg": 40, "feed_angle_deg": 30, "step_over_mm": 14}), "passes-do-not-overlap"),
        (SCALLOP_HEIGHT, json!({"slope_deg": 40, "feed_angle_deg": 30, "feed_per_tooth_mm": 14}), "marks-do-not-overlap"),
        (SCALLOP_HEIGHT, json!({"slope_deg": 90, "feed_angle_deg": 90, "step_over_xy_mm": 1}), "passes-coincide-from-above"),
        (SCALLOP_HEIGHT, json!({"slope_deg": 40, "feed_angle_deg": 30, "step_over_mm": 1, "step_over_xy_mm": 1}), "conflicting-fields"),
        (SCALLOP_HEIGHT, json!({"slope_deg": 40, "feed_angle_deg": 30, "surface_radius_mm": -2}), "gouging"),
        (MAX_FEED, json!({"slope_deg": 40, "feed_angle_deg": 30, "step_over_mm": 1}), "tolerance-exceeded"),
        (STEP_OVER, json!({"slope_deg": 40, "feed_angle_deg": 30, "feed_per_tooth_mm": 1}), "tolerance-exceeded-by-feed"),
    ] {
        let body = with(batch_of(shortest(path)), "/contacts", json!([angles(40.0, 30.0), contact]));
        let answer = app.answer(&batch(path), &body).await;
        let failure = &answer["failures"][0];
        assert_eq!((&failure["index"], &failure["code"]), (&json!(1), &json!(code)), "{answer}");
        assert!(columns(&answer).all(|(_, column)| column[0].is_number() || column[0].is_string()) && row(&answer, 1).is_empty());
    }
}

#[tokio::test]
async fn infinite_radii_are_null_in_valid_answers() {
    let app = TestApp::start().await;
    let body = with(batch_of(shortest(SCALLOP_HEIGHT)), "/contacts", json!([angles(0.0, 0.0)]));
    let answer = app.answer(&batch(SCALLOP_HEIGHT), &with(body, "/model", "envelope")).await;
    assert_eq!(answer["failures"], json!([]));
    let nulls: Vec<_> = columns(&answer).filter(|(_, column)| column[0].is_null()).map(|(name, _)| name.as_str()).collect();
    // The step-over of 0.687 mm is less than the width of the flat, so the height is 0 and has no share.
    assert_eq!(nulls, ["feed_share", "effective_radius_mm", "transverse_effective_radius_mm"]);
}

#[tokio::test]
async fn faults_of_the_batch_itself_refuse_it_as_a_whole() {
    let app = TestApp::start().await;
    for path in SINGLES {
        let body = batch_of(longest(path));
        for (wrong, pointer, code) in [
            (without(body.clone(), "/contacts"), "/contacts", "missing-field"),
            (with(body.clone(), "/contacts", json!({})), "/contacts", "missing-field"),
            (with(body.clone(), "/contacts", json!(7)), "/contacts", "wrong-type"),
            (with(body.clone(), "/contacts", json!(null)), "/contacts", "wrong-type"),
            (with(body.clone(), "/contact", angles(1.0, 1.0)), "/contact", "unknown-field"),
            (with(body.clone(), "/cutter/diameter_mm", -1), "/cutter/diameter_mm", "out-of-range"),
            (with(body.clone(), "/surface_radius_mm", "flat"), "/surface_radius_mm", "wrong-type"),
        ] {
            assert_eq!(faults(&app.refusal(&batch(path), &wrong).await), [(pointer, code)]);
        }
    }
}

#[tokio::test]
async fn faults_of_the_batch_itself_are_listed_with_those_of_its_contacts() {
    let app = TestApp::start().await;
    let rows = json!([angles(40.0, 30.0), angles(99.0, 30.0)]);
    let columns = json!({"slope_deg": [40, 99], "feed_angle_deg": [30, 30]});
    for path in SINGLES {
        for (contacts, pointer) in [(rows.clone(), "/contacts/1/slope_deg"), (columns.clone(), "/contacts/slope_deg/1")] {
            let body = with(with(batch_of(longest(path)), "/contacts", contacts), "/cutter/diameter_mm", -1);
            let problem = app.refusal(&batch(path), &body).await;
            assert_eq!(faults(&problem), [("/cutter/diameter_mm", "out-of-range"), (pointer, "out-of-range")]);
        }
    }
}
