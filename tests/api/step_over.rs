//! `POST /v1/step-over`: published step-overs, and tolerances that allow none.

use crate::api::requests::{SCALLOP_HEIGHT, STEP_OVER, angles, ball_end, longest, shortest, toroidal, with, without};
use crate::app::{TestApp, faults, figure};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use serde_json::json;

#[tokio::test]
async fn a_tolerance_of_10_um_gives_the_published_step_overs() {
    let app = TestApp::start().await;
    for (alpha, step_over) in [(0.0, 0.73), (30.0, 0.687), (90.0, 0.4)] {
        let body = json!({"cutter": toroidal(), "contact": angles(40.0, alpha), "scallop_tolerance_mm": 0.01});
        // Printed to 0.001 mm at best: 0.3995 is printed 0.4.
        assert_abs_diff_eq!(figure(&app.answer(STEP_OVER, &body).await, "step_over_mm"), step_over, epsilon = 0.001);
    }
}

#[tokio::test]
async fn a_ball_end_has_its_published_step_over() {
    let body = json!({"cutter": ball_end(6.0), "contact": angles(0.0, 0.0), "scallop_tolerance_mm": 0.005});
    // Published to five decimals.
    assert_abs_diff_eq!(figure(&TestApp::start().await.answer(STEP_OVER, &body).await, "step_over_mm"), 0.346_27, epsilon = 5e-6);
}

#[tokio::test]
async fn the_largest_step_over_leaves_the_tolerance() {
    let app = TestApp::start().await;
    for model in ["analytic", "envelope"] {
        let body = with(longest(STEP_OVER), "/model", model);
        let answer = app.answer(STEP_OVER, &body).await;
        assert_relative_eq!(figure(&answer, "scallop_height_mm"), 0.013, max_relative = 1e-9);
        let given = with(without(body, "/scallop_tolerance_mm"), "/step_over_xy_mm", answer["step_over_xy_mm"].clone());
        assert_relative_eq!(figure(&app.answer(SCALLOP_HEIGHT, &given).await, "scallop_height_mm"), 0.013, max_relative = 1e-9);
    }
}

#[tokio::test]
async fn a_feed_that_uses_up_the_tolerance_is_refused_with_its_height() {
    let app = TestApp::start().await;
    for model in ["analytic", "envelope"] {
        let body = with(with(shortest(STEP_OVER), "/feed_per_tooth_mm", 0.6), "/model", model);
        let body = with(body, "/scallop_tolerance_mm", 0.005);
        let problem = app.refusal(STEP_OVER, &body).await;
        assert_eq!(faults(&problem), [("/feed_per_tooth_mm", "tolerance-exceeded-by-feed")]);
        assert_eq!(problem["type"], "tolerance-exceeded-by-feed");
        assert!(figure(&problem, "feed_height_mm") >= 0.005);
    }
}

#[tokio::test]
async fn a_tolerance_above_every_scallop_sets_no_limit() {
    let app = TestApp::start().await;
    let problem = app.refusal(STEP_OVER, &with(shortest(STEP_OVER), "/scallop_tolerance_mm", 50)).await;
    assert_eq!(faults(&problem), [("/scallop_tolerance_mm", "tolerance-sets-no-limit")]);
    // Twice the effective radius is 11.807 mm, but seen from above no step-over is wider than the cutter: 10 mm over
    // sqrt(1 - sin^2(40) sin^2(30)).
    assert_abs_diff_eq!(figure(&problem, "largest_step_over_mm"), 10.5603, epsilon = 1e-4);
}
