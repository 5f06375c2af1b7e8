//! Faults of well-formed requests: each kind with its pointer and code, and all faults of a request in one answer.

use crate::api::requests::{
    CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, angles, ball_end, longest, members, shortest, toroidal, with, with_literal,
    without,
};
use crate::app::{TestApp, faults, figure};
use serde_json::{Value, json};

const SINGLES: [&str; 4] = [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS];

/// Asserts that `body` is refused with exactly this fault, and returns the problem.
async fn assert_fault(app: &TestApp, path: &str, body: &Value, pointer: &str, code: &str) -> Value {
    let problem = app.refusal(path, body).await;
    assert_eq!(faults(&problem), [(pointer, code)], "{body}");
    problem
}

fn is_number(body: &Value, pointer: &str) -> bool {
    body.pointer(pointer).is_some_and(Value::is_number)
}

#[tokio::test]
async fn every_member_refuses_values_of_another_type() {
    let app = TestApp::start().await;
    for path in SINGLES {
        let body = longest(path);
        for pointer in members(&body) {
            let right = body.pointer(&pointer).unwrap();
            for wrong in [json!(null), json!(true), json!("0.5"), json!(1.5), json!([]), json!({})] {
                let of_its_type = match right {
                    Value::Number(_) => wrong.is_number(),
                    Value::String(_) => wrong.is_string(),
                    _ => wrong.is_object(),
                };
                if !of_its_type {
                    assert_fault(&app, path, &with(body.clone(), &pointer, wrong), &pointer, "wrong-type").await;
                }
            }
        }
    }
}

#[tokio::test]
async fn numbers_beyond_double_precision_and_words_for_them_are_refused_in_every_number() {
    let app = TestApp::start().await;
    for path in SINGLES {
        let body = longest(path);
        for pointer in members(&body).into_iter().filter(|pointer| is_number(&body, pointer)) {
            for (literal, code) in [
                ("1e999", "out-of-range"),
                ("-1e999", "out-of-range"),
                ("\"NaN\"", "wrong-type"),
                ("\"Infinity\"", "wrong-type"),
                ("\"-inf\"", "wrong-type"),
            ] {
                let problem = app.refusal_of_text(path, with_literal(body.clone(), &pointer, literal)).await;
                assert_eq!(faults(&problem), [(pointer.as_str(), code)], "{literal}");
            }
        }
    }
}

#[tokio::test]
async fn numbers_outside_their_bounds_are_refused() {
    let app = TestApp::start().await;
    for (pointer, wrong) in [
        ("/cutter/diameter_mm", json!(0)),
        ("/cutter/diameter_mm", json!(-10)),
        ("/cutter/diameter_mm", json!(1.1e6)),
        ("/cutter/corner_radius_mm", json!(0)),
        ("/cutter/corner_radius_mm", json!(-1)),
        ("/cutter/teeth", json!(0)),
        ("/cutter/teeth", json!(101)),
        ("/contact/slope_deg", json!(-0.1)),
        ("/contact/slope_deg", json!(90.1)),
        ("/step_over_mm", json!(0)),
        ("/step_over_mm", json!(-0.5)),
        ("/scallop_tolerance_mm", json!(0)),
        ("/scallop_tolerance_mm", json!(-0.01)),
        ("/surface_radius_mm", json!(0)),
        ("/surface_radius_mm", json!(1e13)),
        ("/runout/radial_mm", json!(-0.001)),
        ("/runout/radial_mm", json!(11)),
        ("/runout/axial_mm", json!(-11)),
        ("/spindle_speed_rpm", json!(0)),
        ("/max_feed_per_tooth_mm", json!(0)),
        ("/max_feed_rate_mm_min", json!(-1)),
    ] {
        assert_fault(&app, MAX_FEED, &with(longest(MAX_FEED), pointer, wrong), pointer, "out-of-range").await;
    }
    let negative = with(shortest(SCALLOP_HEIGHT), "/feed_per_tooth_mm", -0.1);
    assert_fault(&app, SCALLOP_HEIGHT, &negative, "/feed_per_tooth_mm", "out-of-range").await;
    let half_a_tooth = with(longest(MAX_FEED), "/cutter/teeth", 2.5);
    assert_fault(&app, MAX_FEED, &half_a_tooth, "/cutter/teeth", "wrong-type").await;
}

#[tokio::test]
async fn unknown_words_are_refused() {
    let app = TestApp::start().await;
    for (pointer, word) in [("/model", "exact"), ("/model", "Analytic"), ("/cutter/type", "drill"), ("/cutter/type", "")] {
        let problem = assert_fault(&app, MAX_FEED, &with(longest(MAX_FEED), pointer, word), pointer, "unknown-value").await;
        assert!(problem["detail"].as_str().unwrap().contains(if pointer == "/model" { "envelope" } else { "bull_nose" }), "{problem}");
    }
}

#[tokio::test]
async fn unknown_members_are_refused_at_every_depth() {
    let app = TestApp::start().await;
    for path in SINGLES {
        for place in ["", "/cutter", "/contact", "/runout"] {
            let pointer = format!("{place}/diameter");
            assert_fault(&app, path, &with(longest(path), &pointer, 1), &pointer, "unknown-field").await;
        }
    }
    let ball_with_corner = with(shortest(SCALLOP_HEIGHT), "/cutter", with(ball_end(10.0), "/corner_radius_mm", 2));
    assert_fault(&app, SCALLOP_HEIGHT, &ball_with_corner, "/cutter/corner_radius_mm", "unknown-field").await;
    let step_over = with(shortest(STEP_OVER), "/step_over_mm", 0.5);
    assert_fault(&app, STEP_OVER, &step_over, "/step_over_mm", "unknown-field").await;
    let mut escaped = shortest(SCALLOP_HEIGHT);
    escaped.as_object_mut().unwrap().insert("a/b~c".to_owned(), json!(1));
    assert_fault(&app, SCALLOP_HEIGHT, &escaped, "/a~1b~0c", "unknown-field").await;
}

#[tokio::test]
async fn members_given_twice_are_refused_at_every_depth() {
    let app = TestApp::start().await;
    for (pointer, literal) in [
        ("/step_over_mm", "0.5,\"step_over_mm\":0.5"),
        ("/contact/slope_deg", "40,\"slope_deg\":50"),
        ("/cutter/teeth", "4,\"te\\u0065th\":4"),
    ] {
        let text = with_literal(shortest(SCALLOP_HEIGHT), pointer, literal);
        assert_eq!(faults(&app.refusal_of_text(SCALLOP_HEIGHT, text).await), [(pointer, "repeated-field")]);
    }
}

#[tokio::test]
async fn every_missing_required_member_is_a_fault() {
    let app = TestApp::start().await;
    for path in SINGLES {
        for pointer in members(&shortest(path)).into_iter().filter(|pointer| pointer != "/cutter/teeth") {
            assert_fault(&app, path, &without(shortest(path), &pointer), &pointer, "missing-field").await;
        }
    }
}

#[tokio::test]
async fn a_step_over_is_given_in_exactly_one_way() {
    let app = TestApp::start().await;
    for path in [SCALLOP_HEIGHT, MAX_FEED] {
        let both = with(shortest(path), "/step_over_xy_mm", 0.65);
        assert_fault(&app, path, &both, "/step_over_xy_mm", "conflicting-fields").await;
        let one_faulty = app.refusal(path, &with(both, "/step_over_mm", -1)).await;
        assert_eq!(faults(&one_faulty), [("/step_over_mm", "out-of-range"), ("/step_over_xy_mm", "conflicting-fields")]);
        let neither = assert_fault(&app, path, &without(shortest(path), "/step_over_mm"), "/step_over_mm", "missing-field").await;
        assert!(neither["detail"].as_str().unwrap().contains("step_over_xy_mm"), "{neither}");
    }
}

#[tokio::test]
async fn a_contact_is_given_in_exactly_one_form() {
    let app = TestApp::start().await;
    let vectors = json!({"normal": [0, 0, 1], "feed": [1, 0, 0]});
    for (contact, pointer, code) in [
        (json!({}), "/contact", "missing-field"),
        (json!({"slope_deg": 40, "feed_angle_deg": 30, "normal": [0, 0, 1], "feed": [1, 0, 0]}), "/contact", "conflicting-fields"),
        (json!({"slope_deg": 40, "feed": [1, 0, 0]}), "/contact", "conflicting-fields"),
        (json!({"slope_deg": 40}), "/contact/feed_angle_deg", "missing-field"),
        (json!({"feed_angle_deg": 30}), "/contact/slope_deg", "missing-field"),
        (without(vectors.clone(), "/feed"), "/contact/feed", "missing-field"),
        (without(vectors.clone(), "/normal"), "/contact/normal", "missing-field"),
        (with(vectors.clone(), "/normal", json!([0, 0, 0])), "/contact/normal", "no-direction"),
        (with(vectors.clone(), "/normal", json!([0, 1, -1])), "/contact/normal", "no-direction"),
        (with(vectors.clone(), "/feed", json!([0, 0, 0])), "/contact/feed", "no-direction"),
        (with(vectors.clone(), "/feed", json!([0, 0, 3])), "/contact/feed", "no-direction"),
        (with(vectors.clone(), "/feed", json!([1, 0])), "/contact/feed", "wrong-type"),
        (with(vectors.clone(), "/feed", json!([1, 0, 0, 0])), "/contact/feed", "wrong-type"),
        (with(vectors.clone(), "/feed", json!({"x": 1})), "/contact/feed", "wrong-type"),
        (with(vectors.clone(), "/feed", json!([1, "0", 0])), "/contact/feed/1", "wrong-type"),
        (with(vectors, "/normal", json!([0, 0, null])), "/contact/normal/2", "wrong-type"),
    ] {
        assert_fault(&app, SCALLOP_HEIGHT, &with(shortest(SCALLOP_HEIGHT), "/contact", contact), pointer, code).await;
    }
}

#[tokio::test]
async fn a_corner_radius_that_is_not_under_half_the_diameter_is_refused() {
    let app = TestApp::start().await;
    for radius in [5.0, 7.0] {
        let body = with(shortest(SCALLOP_HEIGHT), "/cutter/corner_radius_mm", radius);
        let problem = assert_fault(&app, SCALLOP_HEIGHT, &body, "/cutter/corner_radius_mm", "corner-radius-too-large").await;
        assert!(problem["detail"].as_str().unwrap().contains("half its diameter, 5 mm"), "{problem}");
    }
}

#[tokio::test]
async fn a_flat_floor_is_refused_at_the_member_that_states_the_slope() {
    let app = TestApp::start().await;
    let vectors = json!({"normal": [0, 0, 2], "feed": [1, 0, 0]});
    let flat_end = json!({"type": "flat_end", "diameter_mm": 10});
    for path in SINGLES {
        for (contact, pointer) in [(angles(0.0, 0.0), "/contact/slope_deg"), (vectors.clone(), "/contact/normal")] {
            for cutter in [toroidal(), flat_end.clone()] {
                let body = with(with(shortest(path), "/contact", contact.clone()), "/cutter", cutter);
                let problem = assert_fault(&app, path, &body, pointer, "flat-floor").await;
                assert_eq!(problem["type"], "flat-floor");
            }
        }
    }
    let ball = with(with(shortest(SCALLOP_HEIGHT), "/contact", angles(0.0, 0.0)), "/cutter", ball_end(10.0));
    app.answer(SCALLOP_HEIGHT, &ball).await;
}

#[tokio::test]
async fn passes_and_marks_that_do_not_overlap_are_refused() {
    let app = TestApp::start().await;
    let body = with(shortest(SCALLOP_HEIGHT), "/feed_per_tooth_mm", 0.3);
    for model in ["analytic", "envelope"] {
        let body = with(body.clone(), "/model", model);
        // Wider than the cutter and than twice its effective radius of 5.9 mm.
        let wide = with(body.clone(), "/step_over_mm", 14);
        let problem = assert_fault(&app, SCALLOP_HEIGHT, &wide, "/step_over_mm", "passes-do-not-overlap").await;
        let just_under = 0.999 * figure(&problem, "largest_step_over_mm");
        app.answer(SCALLOP_HEIGHT, &without(with(wide, "/step_over_mm", just_under), "/feed_per_tooth_mm")).await;
        let from_above = with(without(body.clone(), "/step_over_mm"), "/step_over_xy_mm", 14);
        assert_fault(&app, SCALLOP_HEIGHT, &from_above, "/step_over_xy_mm", "passes-do-not-overlap").await;
        // The largest distance on a slope of 40 deg is 10 / cos 40 deg = 13.1; this one is larger.
        let long = with(body, "/feed_per_tooth_mm", 13.5);
        assert_fault(&app, SCALLOP_HEIGHT, &long, "/feed_per_tooth_mm", "marks-do-not-overlap").await;
    }
}

#[tokio::test]
async fn passes_along_a_wall_cannot_be_spaced_from_above() {
    let app = TestApp::start().await;
    let body = with(without(shortest(SCALLOP_HEIGHT), "/step_over_mm"), "/step_over_xy_mm", 0.5);
    let body = with(body, "/contact", angles(90.0, 90.0));
    assert_fault(&app, SCALLOP_HEIGHT, &body, "/step_over_xy_mm", "passes-coincide-from-above").await;
}

#[tokio::test]
async fn a_hollow_narrower_than_the_cutter_is_refused() {
    let app = TestApp::start().await;
    for path in SINGLES {
        for model in ["analytic", "envelope"] {
            let body = with(with(shortest(path), "/surface_radius_mm", -5.9), "/model", model);
            let problem = assert_fault(&app, path, &body, "/surface_radius_mm", "gouging").await;
            assert_eq!(problem["type"], "gouging");
            // At the effective radius, 5.9036 mm, the relative curvature is 0, and the corner still cuts beside the contact.
            let radius = figure(&problem, "smallest_radius_mm");
            assert!(radius > 5.9036 && radius < 6.4, "{radius}");
            app.answer(path, &with(with(shortest(path), "/surface_radius_mm", -radius), "/model", model)).await;
        }
    }
    // A flat bottom bridges any hollow.
    let floor = with(with(shortest(SCALLOP_HEIGHT), "/contact", angles(0.0, 0.0)), "/surface_radius_mm", -1e6);
    assert_fault(&app, SCALLOP_HEIGHT, &with(floor, "/model", "envelope"), "/surface_radius_mm", "gouging").await;
}

#[tokio::test]
async fn faults_of_all_kinds_are_listed_in_one_answer() {
    let app = TestApp::start().await;
    let body = json!({
        "cutter": {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 6, "teeth": "four", "coating": "TiAlN"},
        "contact": {"slope_deg": 91, "feed_angle_deg": "NaN"},
        "step_over_mm": 0.7, "step_over_xy_mm": 0.65,
        "runout": {"radial_mm": -1, "tilt_deg": 2},
        "model": "exact",
        "surface_radius_mm": 0,
        "spindle_speed_rpm": null,
        "max_feed_rate_mm_min": [],
        "colour": "red",
    });
    let problem = app.refusal(MAX_FEED, &body).await;
    assert_eq!(problem["type"], "invalid-request");
    let mut found = faults(&problem);
    found.sort_unstable();
    assert_eq!(
        found,
        [
            ("/colour", "unknown-field"),
            ("/contact/feed_angle_deg", "wrong-type"),
            ("/contact/slope_deg", "out-of-range"),
            ("/cutter/coating", "unknown-field"),
            ("/cutter/corner_radius_mm", "corner-radius-too-large"),
            ("/cutter/teeth", "wrong-type"),
            ("/max_feed_rate_mm_min", "wrong-type"),
            ("/model", "unknown-value"),
            ("/runout/radial_mm", "out-of-range"),
            ("/runout/tilt_deg", "unknown-field"),
            ("/scallop_tolerance_mm", "missing-field"),
            ("/spindle_speed_rpm", "wrong-type"),
            ("/step_over_xy_mm", "conflicting-fields"),
            ("/surface_radius_mm", "out-of-range"),
        ]
    );
}

#[tokio::test]
async fn a_reason_without_an_answer_is_listed_beside_other_faults() {
    let app = TestApp::start().await;
    let body = with(with(shortest(SCALLOP_HEIGHT), "/contact", angles(0.0, 0.0)), "/feed_per_tooth_mm", -1);
    let mut problem = app.refusal(SCALLOP_HEIGHT, &with(body, "/note", "x")).await;
    problem["errors"].as_array_mut().unwrap().sort_by_key(|error| error["pointer"].to_string());
    let expected = [("/contact/slope_deg", "flat-floor"), ("/feed_per_tooth_mm", "out-of-range"), ("/note", "unknown-field")];
    assert_eq!(faults(&problem), expected);
    assert_eq!(problem["type"], "invalid-request");
}

#[tokio::test]
async fn numbers_of_the_wrong_type_are_all_listed() {
    let app = TestApp::start().await;
    for path in SINGLES {
        let body = longest(path);
        let numbers: Vec<_> = members(&body).into_iter().filter(|pointer| is_number(&body, pointer)).collect();
        let wrong = numbers.iter().fold(body.clone(), |body, pointer| with(body, pointer, "x"));
        let problem = app.refusal(path, &wrong).await;
        let mut found: Vec<_> = faults(&problem);
        let mut expected: Vec<_> = numbers.iter().map(|pointer| (pointer.as_str(), "wrong-type")).collect();
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected);
    }
}

#[tokio::test]
async fn an_unknown_member_is_answered_with_the_known_ones_of_every_form() {
    let app = TestApp::start().await;
    let known = |problem: &Value, pointer: &str| {
        let errors = problem["errors"].as_array().unwrap();
        let fault = errors.iter().find(|error| error["pointer"] == pointer).unwrap_or_else(|| panic!("no {pointer} in {problem}"));
        fault["detail"].as_str().unwrap().strip_prefix("unknown field; known here: ").unwrap().to_owned()
    };
    let contact = app.refusal(SCALLOP_HEIGHT, &json!({"cutter": ball_end(10.0), "contact": {"steepness": 1}, "step_over_mm": 0.5})).await;
    assert_eq!(known(&contact, "/contact/steepness"), "slope_deg, feed_angle_deg, normal, feed, tool_axis");
    let surface = app.refusal("/v1/cutter-recommendation", &json!({"surface": {"stl": 1}})).await;
    assert_eq!(known(&surface, "/surface/stl"), "points, grid, mesh, bezier, samples");
}
