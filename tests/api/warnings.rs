//! Warnings: an answer has one if and only if an assumption of the model is near its limit.

use crate::api::requests::{MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, angles, ball_end, batch_of, shortest, toroidal, with};
use crate::app::{TestApp, warnings};
use serde_json::{Value, json};

/// Along the steepest slope of 40 deg, where `R_eff` is 6.667 mm and `TR_eff` 2 mm.
fn ordinary() -> Value {
    json!({"cutter": toroidal(), "contact": angles(40.0, 0.0), "step_over_mm": 0.7, "feed_per_tooth_mm": 0.1})
}

async fn warned(app: &TestApp, body: &Value) -> Vec<String> {
    let answer = app.answer(SCALLOP_HEIGHT, body).await;
    for warning in answer["warnings"].as_array().unwrap() {
        assert!(warning["detail"].as_str().unwrap().len() > 20 && warning.as_object().unwrap().len() == 2, "{warning}");
    }
    warnings(&answer).into_iter().map(str::to_owned).collect()
}

#[tokio::test]
async fn ordinary_requests_have_no_warnings() {
    let app = TestApp::start().await;
    for body in [ordinary(), with(ordinary(), "/cutter", ball_end(10.0))] {
        for model in ["analytic", "envelope"] {
            assert_eq!(warned(&app, &with(body.clone(), "/model", model)).await, [""; 0], "{body}");
        }
    }
    let curved = with(ordinary(), "/surface_radius_mm", 200);
    assert_eq!(warned(&app, &curved).await, [""; 0]);
    let runout = with(with(ordinary(), "/runout", json!({"radial_mm": 0.01})), "/model", "envelope");
    assert_eq!(warned(&app, &runout).await, [""; 0]);
    let tolerance = json!({"cutter": toroidal(), "contact": angles(40.0, 0.0), "scallop_tolerance_mm": 0.01});
    assert_eq!(warnings(&app.answer(STEP_OVER, &tolerance).await), [""; 0]);
    assert_eq!(warnings(&app.answer(MAX_FEED, &with(tolerance, "/step_over_mm", 0.6)).await), [""; 0]);
}

#[tokio::test]
async fn runout_over_a_fifth_of_the_feed_per_tooth_gives_a_warning() {
    let app = TestApp::start().await;
    // The magnitude of (0.012, 0.016) is 0.02, a fifth of 0.1.
    for (radial, axial, expected) in [(0.012, 0.0159, false), (0.012, 0.0161, true), (0.0, -0.021, true)] {
        let body = with(ordinary(), "/runout", json!({"radial_mm": radial, "axial_mm": axial}));
        assert_eq!(warned(&app, &body).await.contains(&"runout-not-small".to_owned()), expected, "{body}");
        // Model envelope holds for runout of any size.
        assert_eq!(warned(&app, &with(body, "/model", "envelope")).await, [""; 0]);
    }
}

#[tokio::test]
async fn a_step_over_or_feed_over_a_fifth_of_the_effective_diameter_gives_a_warning() {
    let app = TestApp::start().await;
    // A fifth of 2 R_eff = 13.334 mm is 2.667 mm, of 2 TR_eff = 4 mm 0.8 mm.
    for (member, under, over, code) in
        [("/step_over_mm", 2.66, 2.67, "step-over-wide"), ("/feed_per_tooth_mm", 0.799, 0.801, "feed-per-tooth-long")]
    {
        assert!(!warned(&app, &with(ordinary(), member, under)).await.contains(&code.to_owned()));
        let over = with(ordinary(), member, over);
        assert!(warned(&app, &over).await.contains(&code.to_owned()));
        assert!(!warned(&app, &with(over, "/model", "envelope")).await.contains(&code.to_owned()), "no circle is in the envelope");
    }
}

#[tokio::test]
async fn an_effective_radius_over_the_cutters_diameter_gives_a_warning() {
    let app = TestApp::start().await;
    // R_eff = 3 / sin S + 2 exceeds 10 mm where sin S < 3/8, S < 22.02 deg.
    for (slope, expected) in [(22.1, false), (21.9, true)] {
        let found = warned(&app, &with(ordinary(), "/contact/slope_deg", slope)).await;
        assert_eq!(found.contains(&"effective-radius-beyond-cutter".to_owned()), expected, "{slope}");
    }
}

#[tokio::test]
async fn a_flat_end_gives_a_warning_in_both_models() {
    let app = TestApp::start().await;
    for model in ["analytic", "envelope"] {
        let body = with(with(ordinary(), "/cutter", json!({"type": "flat_end", "diameter_mm": 10})), "/model", model);
        let body = with(body, "/contact/feed_angle_deg", 30);
        assert!(warned(&app, &body).await.contains(&"sharp-marks".to_owned()));
    }
}

#[tokio::test]
async fn the_analytic_model_gives_a_warning_where_the_cutter_leaves_5_percent_more() {
    let app = TestApp::start().await;
    // By the table of both models: at 1 deg the analytic height is 10 % under the envelope's, at 5 deg 2.4 %.
    let floor = json!({"cutter": toroidal(), "contact": angles(1.0, 0.0), "step_over_mm": 3.7});
    assert!(warned(&app, &floor).await.contains(&"outside-analytic-range".to_owned()));
    let slope = json!({"cutter": toroidal(), "contact": angles(5.0, 0.0), "step_over_mm": 2.0});
    assert!(!warned(&app, &slope).await.contains(&"outside-analytic-range".to_owned()));
    assert_eq!(warned(&app, &with(shortest(SCALLOP_HEIGHT), "/feed_per_tooth_mm", 0.3)).await, ["outside-analytic-range"]);
}

#[tokio::test]
async fn a_pass_without_an_envelope_height_has_a_warning_and_no_check() {
    let app = TestApp::start().await;
    // With a level feed at 5 deg, TR_eff is 36 mm: marks 12 mm apart overlap as circles, but not those of the cutter of
    // 10 mm.
    let body = json!({"cutter": toroidal(), "contact": angles(5.0, 90.0), "step_over_mm": 0.7, "feed_per_tooth_mm": 12});
    let answer = app.answer(SCALLOP_HEIGHT, &body).await;
    assert!(warnings(&answer).contains(&"outside-analytic-range"));
    assert_eq!(answer.get("check"), None);
}

#[tokio::test]
async fn curvature_under_10_degrees_and_a_hollow_that_the_cutter_nearly_fills_give_warnings() {
    let app = TestApp::start().await;
    let body = with(with(ordinary(), "/surface_radius_mm", 200), "/model", "envelope");
    for (slope, expected) in [(9.9, vec!["curvature-approximate"]), (10.1, Vec::new())] {
        assert_eq!(warned(&app, &with(body.clone(), "/contact/slope_deg", slope)).await, expected);
    }
    // R_eff is 6.667 mm: lambda = 1 - 6.667/16.6 = 0.598, and 0.602 at 16.75 mm.
    for model in ["analytic", "envelope"] {
        for (radius, expected) in [(-16.6, vec!["near-gouging"]), (-16.75, Vec::new())] {
            let body = with(with(ordinary(), "/surface_radius_mm", radius), "/model", model);
            assert_eq!(warned(&app, &body).await, expected, "{model} {radius}");
        }
    }
}

/// On a cylinder of 100 mm the normal turns to level ground within 0.5 mm at 0.3 deg. A brute-force section leaves 0.1215 mm there,
/// and 0.0112 mm at 1 deg.
#[tokio::test]
async fn near_level_ground_within_a_step_over_a_height_is_said_to_be_no_bound() {
    let app = TestApp::start().await;
    let torus = json!({"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 1});
    let body = json!({"cutter": torus, "contact": angles(0.3, 90.0), "surface_radius_mm": 100, "step_over_mm": 1, "model": "envelope"});
    for (slope, expected, bounds) in [(0.3, "height-not-a-bound", false), (1.0, "curvature-approximate", true)] {
        let body = with(body.clone(), "/contact/slope_deg", slope);
        assert_eq!(warned(&app, &body).await, [expected]);
        let section = if slope < 0.5 { 0.1215 } else { 0.0112 };
        assert_eq!(app.answer(SCALLOP_HEIGHT, &body).await["scallop_height_mm"].as_f64().unwrap() >= section, bounds);
    }
    // The analytic height, the corner's alone, is not said to be far too high.
    let analytic = app.answer(SCALLOP_HEIGHT, &with(body, "/model", "analytic")).await;
    assert!(warnings(&analytic).contains(&"height-not-a-bound"));
    assert_eq!(analytic["check"].get("deviation"), None);
}

/// Where two arcs of a profile meet, the cutter does not touch with its other side.
#[tokio::test]
async fn beside_the_border_of_two_arcs_a_height_is_a_bound() {
    let app = TestApp::start().await;
    let oval = json!({"type": "oval", "diameter_mm": 10, "tip_radius_mm": 2, "side_radius_mm": 80});
    let contacts: Vec<_> = (0..160).map(|step| angles(40.0 + f64::from(step) / 4.0, 90.0)).collect();
    let body = json!({"cutter": oval, "contacts": contacts, "surface_radius_mm": 100, "step_over_mm": 0.5, "model": "envelope"});
    let answer = app.answer("/v1/scallop-height/batch", &body).await;
    assert_eq!(warnings(&answer), ["curvature-approximate"]);
}

#[tokio::test]
async fn a_batch_lists_each_warning_once_with_its_count() {
    let app = TestApp::start().await;
    let body = with(batch_of(ordinary()), "/cutter", json!({"type": "flat_end", "diameter_mm": 10}));
    // A fifth of 2 R_eff = 10.66 mm is 2.13 mm.
    let wide = json!({"slope_deg": 60, "feed_angle_deg": 30, "step_over_mm": 4});
    let contacts = json!([angles(60.0, 30.0), wide, angles(0.0, 30.0), wide]);
    let answer = app.answer("/v1/scallop-height/batch", &with(body, "/contacts", contacts)).await;
    let counted: Vec<_> = answer["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|warning| (warning["code"].as_str().unwrap(), warning["contacts"].as_u64().unwrap(), warning["first_index"].as_u64().unwrap()))
        .collect();
    assert!(counted.contains(&("sharp-marks", 3, 0)), "{counted:?}");
    assert!(counted.contains(&("step-over-wide", 2, 1)), "{counted:?}");
}
