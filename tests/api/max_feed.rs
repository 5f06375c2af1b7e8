//! `POST /v1/max-feed`: published feed rates, the limits of a feed, and tolerances that allow none.

use crate::api::requests::{MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, angles, shortest, toroidal, with, without};
use crate::api::scallop_height::published;
use crate::app::{TestApp, faults, figure};
use approx::assert_relative_eq;
use serde_json::json;

#[tokio::test]
async fn the_published_feed_rates_follow_from_the_heights_that_they_leave() {
    let (app, published) = (TestApp::start().await, published());
    let feeds = published["feeds"].as_array().unwrap();
    for row in published["heights_um"].as_array().unwrap() {
        let contact = json!({"slope_deg": published["slope_deg"], "feed_angle_deg": row["alpha_deg"]});
        let body = json!({"cutter": toroidal(), "contact": contact, "step_over_mm": row["step_over_mm"]});
        let left = app.answer(SCALLOP_HEIGHT, &with(body.clone(), "/feed_per_tooth_mm", row["feed_per_tooth_mm"].clone())).await;
        let body = with(with(body, "/scallop_tolerance_mm", left["scallop_height_mm"].clone()), "/spindle_speed_rpm", 10_000);
        let answer = app.answer(MAX_FEED, &body).await;
        let feed = feeds.iter().find(|feed| feed["feed_per_tooth_mm"] == row["feed_per_tooth_mm"]).unwrap();
        // The tolerance of 10 um has a rounding error of 2e-18 mm, and the feed height is at least 0.047 um, so the
        // relative error is 4e-14.
        assert_relative_eq!(figure(&answer, "feed_per_tooth_mm"), figure(feed, "feed_per_tooth_mm"), max_relative = 1e-12);
        assert_relative_eq!(figure(&answer, "feed_rate_mm_min"), figure(feed, "feed_rate_mm_min"), max_relative = 1e-12);
        assert_eq!(answer["limited_by"], "scallop_tolerance");
    }
}

#[tokio::test]
async fn the_feed_is_limited_by_tolerance_cutter_or_machine_whichever_is_lowest() {
    let app = TestApp::start().await;
    let body = with(shortest(MAX_FEED), "/spindle_speed_rpm", 10_000);
    let free = figure(&app.answer(MAX_FEED, &body).await, "feed_per_tooth_mm");
    // At 10 000 rpm and 4 teeth a feed rate of 4000 mm/min is 0.1 mm a tooth.
    for (per_tooth, rate, by, expected) in [
        (0.9, 36_000, "scallop_tolerance", free),
        (0.2, 36_000, "max_feed_per_tooth", 0.2),
        (0.9, 4_000, "max_feed_rate", 0.1),
        (0.2, 4_000, "max_feed_rate", 0.1),
        (0.05, 4_000, "max_feed_per_tooth", 0.05),
    ] {
        let limited = with(with(body.clone(), "/max_feed_per_tooth_mm", per_tooth), "/max_feed_rate_mm_min", rate);
        let answer = app.answer(MAX_FEED, &limited).await;
        assert_eq!(answer["limited_by"], by);
        assert_relative_eq!(figure(&answer, "feed_per_tooth_mm"), expected, max_relative = 1e-15);
        assert_relative_eq!(figure(&answer, "feed_rate_mm_min"), 40_000.0 * expected, max_relative = 1e-14);
        let at_that_feed = with(without(shortest(MAX_FEED), "/scallop_tolerance_mm"), "/feed_per_tooth_mm", expected);
        let heights = app.answer(SCALLOP_HEIGHT, &at_that_feed).await;
        assert_relative_eq!(figure(&answer, "scallop_height_mm"), figure(&heights, "scallop_height_mm"), max_relative = 1e-13);
    }
}

#[tokio::test]
async fn without_teeth_or_speed_there_is_a_feed_per_tooth_and_no_feed_rate() {
    let app = TestApp::start().await;
    let with_speed = with(shortest(MAX_FEED), "/spindle_speed_rpm", 10_000);
    for body in [shortest(MAX_FEED), without(with_speed, "/cutter/teeth")] {
        let answer = app.answer(MAX_FEED, &body).await;
        assert!(figure(&answer, "feed_per_tooth_mm") > 0.0);
        assert_eq!(answer.get("feed_rate_mm_min"), None);
    }
}

#[tokio::test]
async fn a_step_over_that_uses_up_the_tolerance_is_refused_with_the_largest_one() {
    let app = TestApp::start().await;
    for (model, step_over) in [("analytic", "step_over_mm"), ("envelope", "step_over_mm"), ("analytic", "step_over_xy_mm")] {
        let body = json!({"cutter": toroidal(), "contact": angles(40.0, 30.0), "model": model, "scallop_tolerance_mm": 0.009});
        let body = with(body, &format!("/{step_over}"), 0.687);
        let problem = app.refusal(MAX_FEED, &body).await;
        assert_eq!(problem["type"], "tolerance-exceeded");
        assert_eq!(faults(&problem), [(format!("/{step_over}").as_str(), "tolerance-exceeded")]);
        let height = app.answer(SCALLOP_HEIGHT, &without(body.clone(), "/scallop_tolerance_mm")).await;
        assert_eq!(problem["step_over_height_mm"], height["step_over_height_mm"]);
        let widest = app.answer(STEP_OVER, &without(body.clone(), &format!("/{step_over}"))).await;
        assert_relative_eq!(figure(&problem, "max_step_over_mm"), figure(&widest, "step_over_mm"), max_relative = 1e-12);
        // A slightly smaller step-over leaves room for a feed.
        let narrower = with(without(body, &format!("/{step_over}")), "/step_over_mm", 0.99 * figure(&problem, "max_step_over_mm"));
        assert!(figure(&app.answer(MAX_FEED, &narrower).await, "feed_per_tooth_mm") > 0.0);
    }
}

#[tokio::test]
async fn runout_that_uses_up_the_tolerance_is_refused() {
    let app = TestApp::start().await;
    // Some 5 um are left for the marks, which are then about 0.4 mm apart; 1 mm of runout sets them further apart.
    let body = with(with(shortest(MAX_FEED), "/runout", json!({"radial_mm": 1.0})), "/step_over_mm", 0.5);
    let problem = app.refusal(MAX_FEED, &body).await;
    assert_eq!(faults(&problem), [("/runout", "tolerance-exceeded-by-runout")]);
    assert_eq!(problem["type"], "tolerance-exceeded-by-runout");
    // With the cutter's exact shape, the deepest teeth alone can make the surface, whatever the runout of the others.
    let exact = app.answer(MAX_FEED, &with(body, "/model", "envelope")).await;
    assert_eq!(exact["limited_by"], "scallop_tolerance");
}

#[tokio::test]
async fn a_tolerance_above_every_mark_sets_no_limit_unless_another_limit_is_stated() {
    let app = TestApp::start().await;
    let body = with(shortest(MAX_FEED), "/scallop_tolerance_mm", 50);
    assert_eq!(faults(&app.refusal(MAX_FEED, &body).await), [("/scallop_tolerance_mm", "tolerance-sets-no-limit")]);
    let answer = app.answer(MAX_FEED, &with(body, "/max_feed_per_tooth_mm", 0.2)).await;
    assert_eq!((figure(&answer, "feed_per_tooth_mm"), &answer["limited_by"]), (0.2, &json!("max_feed_per_tooth")));
}

#[tokio::test]
async fn a_largest_feed_rate_needs_teeth_and_speed() {
    let app = TestApp::start().await;
    let body = with(without(shortest(MAX_FEED), "/cutter/teeth"), "/max_feed_rate_mm_min", 10_000);
    let problem = app.refusal(MAX_FEED, &body).await;
    assert_eq!(faults(&problem), [("/spindle_speed_rpm", "missing-field"), ("/cutter/teeth", "missing-field")]);
}
