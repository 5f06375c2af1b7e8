//! `POST /v1/cutting-parameters`: the fastest step-over and feed, the limits that bind, and faults.

use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, angles, ball_end, shortest, toroidal, with, without};
use crate::app::{Answer, TestApp, faults, figure};
use approx::assert_relative_eq;
use serde_json::{Value, json};

#[tokio::test]
async fn a_ball_end_cutter_on_a_plane_has_the_closed_form() {
    let app = TestApp::start().await;
    let (radius, tolerance) = (5.0_f64, 0.01);
    let expected = (2.0 * (2.0 * radius * tolerance - tolerance * tolerance)).sqrt();
    let body = json!({"cutter": ball_end(2.0 * radius), "contact": angles(30.0, 20.0), "scallop_tolerance_mm": tolerance});
    let answer = app.answer(CUTTING_PARAMETERS, &body).await;
    // The closed form is that of the parabola near the contact; the circle differs by the share tolerance / radius.
    assert_relative_eq!(figure(&answer, "step_over_mm"), expected, max_relative = 2.0 * tolerance / radius);
    assert_relative_eq!(figure(&answer, "feed_per_tooth_mm"), expected, max_relative = 2.0 * tolerance / radius);
    assert_eq!(answer["limited_by"], json!(["scallop_tolerance"]));
    for name in ["feed_rate_mm_min", "area_rate_mm2_min"] {
        assert_eq!(answer.get(name), None);
    }
}

fn limited(limits: &Value) -> Value {
    let mut body = with(with(shortest(CUTTING_PARAMETERS), "/spindle_speed_rpm", 10_000), "/model", "envelope");
    for (name, value) in limits.as_object().unwrap() {
        body[name] = value.clone();
    }
    body
}

#[tokio::test]
async fn all_limits_that_bind_are_named() {
    let app = TestApp::start().await;
    // At 10 000 rpm and 4 teeth a feed rate of 4000 mm/min is 0.1 mm a tooth.
    for (limits, expected) in [
        (json!({}), json!(["scallop_tolerance"])),
        (json!({"max_feed_per_tooth_mm": 0.1}), json!(["scallop_tolerance", "max_feed_per_tooth"])),
        (json!({"max_feed_rate_mm_min": 4000}), json!(["scallop_tolerance", "max_feed_rate"])),
        (
            json!({"max_feed_rate_mm_min": 4000, "max_feed_per_tooth_mm": 0.1}),
            json!(["scallop_tolerance", "max_feed_per_tooth", "max_feed_rate"]),
        ),
        (json!({"max_feed_rate_mm_min": 4000, "max_feed_per_tooth_mm": 0.05}), json!(["scallop_tolerance", "max_feed_per_tooth"])),
        (json!({"max_step_over_mm": 0.2}), json!(["scallop_tolerance", "max_step_over"])),
        (json!({"min_step_over_mm": 0.7}), json!(["scallop_tolerance", "min_step_over"])),
        (json!({"max_step_over_mm": 0.2, "max_feed_per_tooth_mm": 0.05}), json!(["max_feed_per_tooth", "max_step_over"])),
    ] {
        let answer = app.answer(CUTTING_PARAMETERS, &limited(&limits)).await;
        assert_eq!(answer["limited_by"], expected, "{limits}");
        let (step_over, feed) = (figure(&answer, "step_over_mm"), figure(&answer, "feed_per_tooth_mm"));
        assert_relative_eq!(figure(&answer, "feed_rate_mm_min"), feed * 40_000.0, max_relative = 1e-12);
        assert_relative_eq!(figure(&answer, "area_rate_mm2_min"), step_over * feed * 40_000.0, max_relative = 1e-12);
        assert!(figure(&answer, "scallop_height_mm") <= 0.013);
        // The calculations of the feed alone and of the step-over alone agree.
        let at_that = with(without(shortest(MAX_FEED), "/step_over_mm"), "/step_over_mm", step_over);
        let by_feed = app.answer(MAX_FEED, &with(at_that, "/model", "envelope")).await;
        assert!(feed <= figure(&by_feed, "feed_per_tooth_mm") * (1.0 + 1e-9));
        let heights = with(with(shortest(SCALLOP_HEIGHT), "/step_over_mm", step_over), "/feed_per_tooth_mm", feed);
        let heights = app.answer(SCALLOP_HEIGHT, &with(heights, "/model", "envelope")).await;
        assert_relative_eq!(figure(&answer, "scallop_height_mm"), figure(&heights, "scallop_height_mm"), max_relative = 1e-12);
    }
}

#[tokio::test]
async fn no_pair_of_step_over_and_feed_is_faster() {
    let app = TestApp::start().await;
    let answer = app.answer(CUTTING_PARAMETERS, &limited(&json!({}))).await;
    let fastest = figure(&answer, "step_over_mm") * figure(&answer, "feed_per_tooth_mm");
    for share in [0.25, 0.5, 0.9, 1.1, 1.5] {
        let feed = share * figure(&answer, "feed_per_tooth_mm");
        let body = with(with(shortest(STEP_OVER), "/feed_per_tooth_mm", feed), "/model", "envelope");
        let Answer { status, body: other } = app.post(STEP_OVER, &body).await;
        if status == 200 {
            assert!(figure(&other, "step_over_mm") * feed <= fastest * (1.0 + 1e-6), "{share}");
        }
    }
}

#[tokio::test]
async fn all_faults_of_the_limits_are_listed_with_their_members() {
    let app = TestApp::start().await;
    let crossed = limited(&json!({"min_step_over_mm": 0.6, "max_step_over_mm": 0.5}));
    assert_eq!(faults(&app.refusal(CUTTING_PARAMETERS, &crossed).await), [("/min_step_over_mm", "out-of-range")]);
    let wide = limited(&json!({"min_step_over_mm": 2}));
    let problem = app.refusal(CUTTING_PARAMETERS, &wide).await;
    assert_eq!(faults(&problem), [("/min_step_over_mm", "tolerance-exceeded")]);
    assert!(figure(&problem, "max_step_over_mm") < 2.0);
    let without_speed = with(shortest(CUTTING_PARAMETERS), "/max_feed_rate_mm_min", 4000);
    let without_both = with(without_speed, "/cutter", without(toroidal(), "/teeth"));
    let mut found = app.refusal(CUTTING_PARAMETERS, &with(without_both, "/scallop_tolerance_mm", -1)).await;
    found["errors"].as_array_mut().unwrap().sort_by_key(|error| error["pointer"].to_string());
    let expected = [("/cutter/teeth", "missing-field"), ("/scallop_tolerance_mm", "out-of-range"), ("/spindle_speed_rpm", "missing-field")];
    assert_eq!(faults(&found), expected);
}
