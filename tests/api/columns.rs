//! Batches for numerical callers: contacts as columns, a choice of the answer's columns, rounding, and numbers that are
//! not finite.

use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, batch_of, shortest, with, with_literal, without};
use crate::app::{Answer, TestApp, faults, figure};
use serde_json::{Value, json};

const SINGLES: [&str; 4] = [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS];

fn batch(single: &str) -> String {
    format!("{single}/batch")
}

fn with_contacts(path: &str, contacts: Value) -> Value {
    with(batch_of(shortest(path)), "/contacts", contacts)
}

/// An answer without the pointers of its faults, which differ between rows and columns.
fn without_pointers(mut answer: Value) -> Value {
    for failure in answer["failures"].as_array_mut().unwrap() {
        failure["pointer"].take();
        failure["detail"].take();
    }
    answer
}

#[tokio::test]
async fn columns_are_answered_as_the_same_contacts_in_rows() {
    let app = TestApp::start().await;
    for path in SINGLES {
        let mut columns = json!({
            "slope_deg": [40, 20.5, 91, 50],
            "feed_angle_deg": [30, -20, 10, null],
            "surface_curvature": {"along_per_mm": [0.001, null, 0, 0], "twist_per_mm": [0.002, null, null, null]},
            "surface_radius_mm": [null, -200, null, null],
        });
        if path == SCALLOP_HEIGHT || path == STEP_OVER {
            columns["feed_per_tooth_mm"] = json!([0.1, null, 0, 0.1]);
        }
        if path == SCALLOP_HEIGHT || path == MAX_FEED {
            columns["step_over_xy_mm"] = json!([0.3, null, null, 0.3]);
        }
        let rows: Vec<Value> = (0..4)
            .map(|index| {
                let mut row = json!({});
                for (name, column) in columns.as_object().unwrap() {
                    if name == "surface_curvature" {
                        let parts = column.as_object().unwrap().iter().map(|(name, column)| (name.clone(), column[index].clone()));
                        let parts: serde_json::Map<_, _> = parts.filter(|(_, value)| !value.is_null()).collect();
                        if !parts.is_empty() {
                            row[name] = parts.into();
                        }
                    } else if !column[index].is_null() {
                        row[name] = column[index].clone();
                    }
                }
                row
            })
            .collect();
        let of_rows = app.answer(&batch(path), &with_contacts(path, rows.into())).await;
        let of_columns = app.answer(&batch(path), &with_contacts(path, columns)).await;
        let pointers: Vec<_> =
            of_columns["failures"].as_array().unwrap().iter().map(|failure| failure["pointer"].as_str().unwrap()).collect();
        assert_eq!(pointers, ["/contacts/slope_deg/2", "/contacts/feed_angle_deg/3"], "{path}");
        assert_eq!(without_pointers(of_columns), without_pointers(of_rows), "{path}");
    }
}

#[tokio::test]
async fn vectors_and_principal_curvatures_are_columns_of_arrays() {
    let app = TestApp::start().await;
    let columns = json!({
        "normal": [[-0.64, 0, 0.77], [-0.64, 0], [0, 0, 1]],
        "feed": [[1, 0, 0.84], [1, 0, 0.84], [0, 0, 1]],
        "tool_axis": [[0.1, 0, 0.99], null, null],
        "surface_curvature": {"principal_per_mm": [[0.012, -0.005], null, null], "angle_deg": [30, null, null]},
    });
    let answer = app.answer(&batch(SCALLOP_HEIGHT), &with_contacts(SCALLOP_HEIGHT, columns)).await;
    let failures: Vec<_> = answer["failures"]
        .as_array()
        .unwrap()
        .iter()
        .map(|failure| (failure["pointer"].as_str().unwrap(), failure["code"].as_str().unwrap()))
        .collect();
    assert_eq!(failures, [("/contacts/normal/1", "wrong-type"), ("/contacts/feed/2", "no-direction")]);
    let contact = json!({"normal": [-0.64, 0, 0.77], "feed": [1, 0, 0.84], "tool_axis": [0.1, 0, 0.99]});
    let single = with(shortest(SCALLOP_HEIGHT), "/surface_curvature", json!({"principal_per_mm": [0.012, -0.005], "angle_deg": 30}));
    let single = app.answer(SCALLOP_HEIGHT, &with(single, "/contact", contact)).await;
    assert_eq!(answer["scallop_height_mm"][0], single["scallop_height_mm"]);
}

#[tokio::test]
async fn a_curvature_of_a_contact_replaces_either_form_of_the_default() {
    let app = TestApp::start().await;
    let columns =
        json!({"slope_deg": [40, 40, 40], "feed_angle_deg": [30, 30, 30], "surface_curvature": {"across_per_mm": [null, 0.02, 0]}});
    for default in ["surface_radius_mm", "surface_curvature"] {
        let value = if default == "surface_radius_mm" { json!(-50) } else { json!({"across_per_mm": -0.02}) };
        let body = with(with_contacts(SCALLOP_HEIGHT, columns.clone()), &format!("/{default}"), value);
        let answer = app.answer(&batch(SCALLOP_HEIGHT), &body).await;
        for (index, across) in [(0, -0.02), (1, 0.02), (2, 0.0)] {
            let single = with(shortest(SCALLOP_HEIGHT), "/surface_curvature", json!({"across_per_mm": across}));
            let single = app.answer(SCALLOP_HEIGHT, &single).await;
            assert_eq!(answer["scallop_height_mm"][index], single["scallop_height_mm"], "{default} {index}");
        }
    }
}

#[tokio::test]
async fn faults_of_the_columns_themselves_refuse_the_batch() {
    let app = TestApp::start().await;
    for (columns, pointer, code) in [
        (json!({}), "/contacts", "missing-field"),
        (json!({"slope_deg": [40, 40], "feed_angle_deg": [30]}), "/contacts/feed_angle_deg", "wrong-count"),
        (json!({"slope_deg": 40, "feed_angle_deg": [30]}), "/contacts/slope_deg", "wrong-type"),
        (json!({"slope_deg": [40], "feed_angle_deg": [30], "slope": [40]}), "/contacts/slope", "unknown-field"),
        (json!({"slope_deg": [40], "feed_angle_deg": [30], "surface_curvature": [0]}), "/contacts/surface_curvature", "wrong-type"),
        (
            json!({"slope_deg": [40], "feed_angle_deg": [30], "surface_curvature": {"twist_per_mm": [0, 0]}}),
            "/contacts/surface_curvature/twist_per_mm",
            "wrong-count",
        ),
    ] {
        let problem = app.refusal(&batch(SCALLOP_HEIGHT), &with_contacts(SCALLOP_HEIGHT, columns)).await;
        assert_eq!(faults(&problem), [(pointer, code)]);
    }
}

#[tokio::test]
async fn the_answer_has_the_columns_that_are_named() {
    let app = TestApp::start().await;
    for (path, named) in [
        (SCALLOP_HEIGHT, json!(["deviation", "scallop_height_mm"])),
        (MAX_FEED, json!(["feed_per_tooth_mm"])),
        (MAX_FEED, json!(["limited_by", "feed_rate_mm_min"])),
        (CUTTING_PARAMETERS, json!(["limited_by", "step_over_mm"])),
    ] {
        let whole = app.answer(&batch(path), &batch_of(shortest(path))).await;
        let answer = app.answer(&batch(path), &with(batch_of(shortest(path)), "/columns", named.clone())).await;
        let mut names: Vec<_> = answer.as_object().unwrap().keys().map(String::as_str).collect();
        names.retain(|name| !["model", "summary", "failures", "warnings"].contains(name));
        let named: Vec<_> = named.as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
        assert_eq!(names, named);
        for name in named.into_iter().filter(|name| whole.get(*name).is_some()) {
            assert_eq!(answer[name], whole[name]);
            assert_eq!(answer["summary"]["extremes"].get(name), whole["summary"]["extremes"].get(name));
        }
    }
}

#[tokio::test]
async fn deviations_are_those_of_single_answers_and_the_summary_counts_those_outside_the_range() {
    let app = TestApp::start().await;
    let contacts = json!({"slope_deg": [40, 70, 5], "feed_angle_deg": [30, 90, 10]});
    let body = with(with_contacts(SCALLOP_HEIGHT, contacts.clone()), "/feed_per_tooth_mm", 0.3);
    let body = with(body, "/columns", json!(["envelope_scallop_height_mm", "deviation"]));
    let answer = app.answer(&batch(SCALLOP_HEIGHT), &body).await;
    let mut outside = 0;
    for index in 0..3 {
        let contact = json!({"slope_deg": contacts["slope_deg"][index], "feed_angle_deg": contacts["feed_angle_deg"][index]});
        let single = with(with(shortest(SCALLOP_HEIGHT), "/feed_per_tooth_mm", 0.3), "/contact", contact);
        let single = app.answer(SCALLOP_HEIGHT, &single).await;
        for name in ["envelope_scallop_height_mm", "deviation"] {
            assert_eq!(answer[name][index], single["check"][name], "{index}");
        }
        outside += usize::from(crate::app::warnings(&single).contains(&"outside-analytic-range"));
    }
    assert_eq!(answer["summary"]["outside_analytic_range"], json!(outside));
    assert!(outside > 0);
    let exact = app.answer(&batch(SCALLOP_HEIGHT), &with(body, "/model", "envelope")).await;
    assert_eq!((&exact["deviation"], &exact["summary"]["outside_analytic_range"]), (&json!([0.0, 0.0, 0.0]), &json!(0)));
}

#[tokio::test]
async fn columns_that_are_unknown_or_named_twice_are_refused() {
    let app = TestApp::start().await;
    for (columns, pointer, code) in [
        (json!(["scallop_height"]), "/columns/0", "unknown-value"),
        (json!(["scallop_height_mm", "scallop_height_mm"]), "/columns/1", "repeated-field"),
        (json!([]), "/columns", "wrong-count"),
        (json!("scallop_height_mm"), "/columns", "wrong-type"),
        (json!([1]), "/columns/0", "wrong-type"),
        (json!(["feed_rate_mm_min"]), "/columns/0", "unknown-value"),
    ] {
        let problem = app.refusal(&batch(SCALLOP_HEIGHT), &with(batch_of(shortest(SCALLOP_HEIGHT)), "/columns", columns)).await;
        assert_eq!(faults(&problem), [(pointer, code)]);
        if code == "unknown-value" {
            assert!(problem["detail"].as_str().unwrap().contains("envelope_scallop_height_mm"), "{problem}");
        }
    }
}

#[tokio::test]
async fn numbers_are_rounded_to_significant_digits() {
    let app = TestApp::start().await;
    let whole = app.answer(&batch(SCALLOP_HEIGHT), &batch_of(shortest(SCALLOP_HEIGHT))).await;
    for digits in [3_usize, 6, 17] {
        let body = with(batch_of(shortest(SCALLOP_HEIGHT)), "/significant_digits", digits);
        let rounded = app.answer(&batch(SCALLOP_HEIGHT), &body).await;
        for name in ["scallop_height_mm", "effective_radius_mm", "step_over_xy_mm"] {
            for index in 0..2 {
                let expected: f64 = format!("{:.*e}", digits - 1, whole[name][index].as_f64().unwrap()).parse().unwrap();
                assert_eq!(rounded[name][index], json!(expected));
            }
        }
        let minimum = &rounded["summary"]["extremes"]["scallop_height_mm"]["minimum"];
        assert_eq!(minimum["value"], rounded["scallop_height_mm"][usize::try_from(minimum["index"].as_u64().unwrap()).unwrap()]);
    }
    for (digits, code) in [(json!(2), "out-of-range"), (json!(18), "out-of-range"), (json!(3.5), "wrong-type")] {
        let problem = app.refusal(&batch(STEP_OVER), &with(batch_of(shortest(STEP_OVER)), "/significant_digits", digits)).await;
        assert_eq!(faults(&problem), [("/significant_digits", code)]);
    }
}

#[tokio::test]
async fn a_number_that_is_not_finite_fails_only_its_contact() {
    let app = TestApp::start().await;
    for token in ["NaN", "Infinity", "-Infinity"] {
        let text = with_literal(
            with_contacts(SCALLOP_HEIGHT, json!({"slope_deg": 0, "feed_angle_deg": [30, 30]})),
            "/contacts/slope_deg",
            &format!("[40, {token}]"),
        );
        let Answer { status, body: of_columns } = app.post_text(&batch(SCALLOP_HEIGHT), text).await;
        assert_eq!(status, 200, "{of_columns}");
        let rows = json!([{"slope_deg": 40, "feed_angle_deg": 30}, {"slope_deg": "x", "feed_angle_deg": 30}]);
        let text = with_contacts(SCALLOP_HEIGHT, rows).to_string().replace("\"x\"", token);
        let Answer { status, body: of_rows } = app.post_text(&batch(SCALLOP_HEIGHT), text).await;
        assert_eq!(status, 200, "{of_rows}");
        for (answer, pointer) in [(&of_columns, "/contacts/slope_deg/1"), (&of_rows, "/contacts/1/slope_deg")] {
            let failure = &answer["failures"][0];
            assert_eq!((&failure["index"], &failure["pointer"], &failure["code"]), (&json!(1), &json!(pointer), &json!("not-finite")));
            assert!(failure["detail"].as_str().unwrap().contains(token));
            assert!(figure(&json!({"h": answer["scallop_height_mm"][0]}), "h") > 0.0 && answer["scallop_height_mm"][1].is_null());
        }
        for path in SINGLES {
            let problem = app.refusal_of_text(path, with_literal(shortest(path), "/cutter/diameter_mm", token)).await;
            assert_eq!(faults(&problem), [("/cutter/diameter_mm", "not-finite")]);
        }
    }
}

#[tokio::test]
async fn a_batch_without_any_answer_is_refused_with_its_first_hundred_faults() {
    let app = TestApp::start().await;
    let columns = json!({"slope_deg": vec![91; 300], "feed_angle_deg": vec![30; 300]});
    let rows: Vec<Value> = (0..300).map(|_| json!({"slope_deg": 91, "feed_angle_deg": 30})).collect();
    for (contacts, first, last) in
        [(columns, "/contacts/slope_deg/0", "/contacts/slope_deg/99"), (rows.into(), "/contacts/0/slope_deg", "/contacts/99/slope_deg")]
    {
        let problem = app.refusal(&batch(STEP_OVER), &with_contacts(STEP_OVER, contacts)).await;
        let found = faults(&problem);
        assert_eq!((found.len(), found[0], found[99]), (100, (first, "out-of-range"), (last, "out-of-range")));
        assert_eq!(problem["detail"], "300 faults, the first of them in errors");
    }
    // A single fault determines the problem's type and figures.
    let one = json!([{"slope_deg": 40, "feed_angle_deg": 30, "surface_curvature": {"across_per_mm": -0.5}}]);
    let problem = app.refusal(&batch(SCALLOP_HEIGHT), &with_contacts(SCALLOP_HEIGHT, one)).await;
    assert_eq!(problem["type"], "gouging");
    assert!(figure(&problem, "smallest_radius_mm") > 2.0);
}

#[tokio::test]
async fn failures_beyond_a_thousand_are_counted() {
    let app = TestApp::start().await;
    let slopes: Vec<f64> = (0..3000).map(|index| if index % 2 == 0 { 91.0 } else { 40.0 }).collect();
    let body = with_contacts(SCALLOP_HEIGHT, json!({"slope_deg": slopes, "feed_angle_deg": vec![30; 3000]}));
    let answer = app.answer(&batch(SCALLOP_HEIGHT), &body).await;
    let failures = answer["failures"].as_array().unwrap();
    assert_eq!((failures.len(), &failures[999]["index"], &answer["summary"]["failures"]), (1000, &json!(1998), &json!(1500)));
}

#[tokio::test]
async fn contacts_without_the_step_over_that_they_need_fail_alone() {
    let app = TestApp::start().await;
    let columns = json!({"slope_deg": [40, 40], "feed_angle_deg": [30, 30], "step_over_mm": [0.5, null]});
    let body = without(with_contacts(SCALLOP_HEIGHT, columns), "/step_over_mm");
    let answer = app.answer(&batch(SCALLOP_HEIGHT), &body).await;
    let failure = &answer["failures"][0];
    assert_eq!((&failure["pointer"], &failure["code"]), (&json!("/contacts/step_over_mm/1"), &json!("missing-field")));
}
