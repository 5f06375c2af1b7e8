//! The surface's curvature in its forms, and tilted tools.

use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, shortest, with};
use crate::app::{TestApp, faults, figure};
use approx::assert_relative_eq;
use serde_json::json;

const SINGLES: [&str; 4] = [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS];

#[tokio::test]
async fn all_forms_of_a_curvature_give_the_same_answer() {
    let app = TestApp::start().await;
    for path in SINGLES {
        for model in ["analytic", "envelope"] {
            let body = with(with(shortest(path), "/model", model), "/scallop_tolerance_mm", 0.013);
            let body = if path == SCALLOP_HEIGHT { crate::api::requests::without(body, "/scallop_tolerance_mm") } else { body };
            let radius = app.answer(path, &with(body.clone(), "/surface_radius_mm", 50)).await;
            for curvature in [
                json!({"across_per_mm": 0.02}),
                json!({"along_per_mm": 0, "across_per_mm": 0.02, "twist_per_mm": 0}),
                json!({"principal_per_mm": [0, 0.02], "angle_deg": 0}),
                json!({"principal_per_mm": [0.02, 0], "angle_deg": 90}),
            ] {
                let answer = app.answer(path, &with(body.clone(), "/surface_curvature", curvature.clone())).await;
                for name in ["scallop_height_mm", "step_over_mm"] {
                    // 1/50 is not exactly 0.02, and the sine of a right angle is exact.
                    assert_relative_eq!(figure(&answer, name), figure(&radius, name), max_relative = 1e-9);
                }
            }
            // An empty object is a plane.
            let plane = app.answer(path, &body).await;
            assert_eq!(app.answer(path, &with(body.clone(), "/surface_curvature", json!({}))).await, plane);
        }
    }
}

#[tokio::test]
async fn the_sign_of_the_feed_angle_matters_only_with_twist() {
    let app = TestApp::start().await;
    let height = async |feed: f64, twist: f64| {
        let body = with(with(shortest(SCALLOP_HEIGHT), "/contact/feed_angle_deg", feed), "/model", "envelope");
        let body =
            with(with(body, "/feed_per_tooth_mm", 0.3), "/surface_curvature", json!({"across_per_mm": 0.002, "twist_per_mm": twist}));
        figure(&app.answer(SCALLOP_HEIGHT, &body).await, "scallop_height_mm")
    };
    assert_relative_eq!(height(30.0, 0.0).await, height(-30.0, 0.0).await, max_relative = 1e-9);
    assert!((height(30.0, 0.02).await / height(-30.0, 0.02).await - 1.0).abs() > 1e-3);
    // Mirrored, both signs change.
    assert_relative_eq!(height(30.0, 0.02).await, height(-30.0, -0.02).await, max_relative = 1e-9);
}

#[tokio::test]
async fn faults_of_curvatures_point_to_their_members() {
    let app = TestApp::start().await;
    for path in SINGLES {
        for (curvature, pointer, code) in [
            (json!(0.1), "/surface_curvature", "wrong-type"),
            (json!({"along_per_mm": "flat"}), "/surface_curvature/along_per_mm", "wrong-type"),
            (json!({"across_per_mm": 1.1e6}), "/surface_curvature/across_per_mm", "out-of-range"),
            (json!({"radius_mm": 5}), "/surface_curvature/radius_mm", "unknown-field"),
            (json!({"principal_per_mm": [0.1, 0.2]}), "/surface_curvature/angle_deg", "missing-field"),
            (json!({"angle_deg": 3}), "/surface_curvature/principal_per_mm", "missing-field"),
            (json!({"principal_per_mm": [0.1], "angle_deg": 3}), "/surface_curvature/principal_per_mm", "wrong-type"),
            (json!({"principal_per_mm": [0.1, -2e6], "angle_deg": 3}), "/surface_curvature/principal_per_mm/1", "out-of-range"),
            (json!({"principal_per_mm": [0.1, 0.2], "angle_deg": 3, "twist_per_mm": 0}), "/surface_curvature", "conflicting-fields"),
        ] {
            let problem = app.refusal(path, &with(shortest(path), "/surface_curvature", curvature)).await;
            assert_eq!(faults(&problem), [(pointer, code)]);
        }
        let both = with(with(shortest(path), "/surface_radius_mm", 50), "/surface_curvature", json!({"across_per_mm": 0.02}));
        assert_eq!(faults(&app.refusal(path, &both).await), [("/surface_curvature", "conflicting-fields")]);
    }
}

#[tokio::test]
async fn gouging_points_to_the_member_that_states_the_curvature() {
    let app = TestApp::start().await;
    for path in SINGLES {
        for (member, value) in [("/surface_radius_mm", json!(-2)), ("/surface_curvature", json!({"across_per_mm": -0.5}))] {
            let problem = app.refusal(path, &with(shortest(path), member, value)).await;
            assert_eq!(faults(&problem), [(member, "gouging")]);
            let radius = figure(&problem, "smallest_radius_mm");
            assert!(radius > 2.0);
        }
    }
}

#[tokio::test]
async fn a_tilted_tool_is_an_upright_one_in_the_frame_of_its_axis() {
    let app = TestApp::start().await;
    // A floor, the tool tilted by 40 deg against the feed or across it.
    let (sin, cos) = 40.0_f64.to_radians().sin_cos();
    for path in SINGLES {
        // With a level feed, the step-over leaves 30 um.
        let body = if path == SCALLOP_HEIGHT { shortest(path) } else { with(shortest(path), "/scallop_tolerance_mm", 0.05) };
        for (axis, feed_angle) in [([-sin, 0.0, cos], 0.0), ([0.0, -sin, cos], 90.0)] {
            let upright = app.answer(path, &with(body.clone(), "/contact/feed_angle_deg", feed_angle)).await;
            let contact = json!({"normal": [0, 0, 2], "feed": [3, 0, 0], "tool_axis": axis});
            let tilted = app.answer(path, &with(body.clone(), "/contact", contact)).await;
            for name in ["scallop_height_mm", "step_over_mm", "effective_radius_mm"] {
                assert_relative_eq!(figure(&tilted, name), figure(&upright, name), max_relative = 1e-12);
            }
        }
        // A surface that overhangs against Z is seen along the axis.
        let overhang = json!({"normal": [1, 0, -0.2], "feed": [0, 1, 0], "tool_axis": [1, 0, 0.5]});
        app.answer(path, &with(body.clone(), "/contact", overhang)).await;
        for (axis, pointer, code) in [
            (json!([0, 0, 0]), "/contact/tool_axis", "no-direction"),
            (json!([0, 0, -1]), "/contact/normal", "no-direction"),
            (json!([0, 1]), "/contact/tool_axis", "wrong-type"),
        ] {
            let contact = json!({"normal": [0, 0.1, 1], "feed": [1, 0, 0], "tool_axis": axis});
            assert_eq!(faults(&app.refusal(path, &with(body.clone(), "/contact", contact)).await), [(pointer, code)]);
        }
    }
    let angles = with(shortest(SCALLOP_HEIGHT), "/contact/tool_axis", json!([0, 0, 1]));
    assert_eq!(faults(&app.refusal(SCALLOP_HEIGHT, &angles).await), [("/contact", "conflicting-fields")]);
}
