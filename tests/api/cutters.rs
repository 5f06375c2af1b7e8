//! Cutters of all shapes: heights computed from their solids, every calculation by JSON, query and batch, and refusals.

use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, angles, batch_of, shortest, toroidal, with};
use crate::app::{TestApp, faults, figure};
use approx::assert_relative_eq;
use serde_json::{Value, json};

const SINGLES: [&str; 4] = [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS];

/// One of each shape that is not a torus. Each cuts a slope of 40 deg with an arc.
pub(crate) fn shapes() -> [(&'static str, Value); 5] {
    [
        ("TaperedBallCutter", json!({"type": "tapered_ball", "diameter_mm": 2, "taper_deg": 5, "shank_diameter_mm": 6})),
        ("LensCutter", json!({"type": "lens", "diameter_mm": 16, "lens_radius_mm": 40, "corner_radius_mm": 1})),
        ("OvalCutter", json!({"type": "oval", "diameter_mm": 10, "tip_radius_mm": 2, "side_radius_mm": 80})),
        (
            "ConicalBarrelCutter",
            json!({"type": "conical_barrel", "diameter_mm": 10, "tip_radius_mm": 2, "side_radius_mm": 250, "taper_deg": 20}),
        ),
        ("ProfileCutter", json!({"type": "profile", "arcs": [arc(2.0, 3.0, 2.0, 0.0, 90.0)]})),
    ]
}

fn arc(radius: f64, offset: f64, height: f64, from: f64, to: f64) -> Value {
    json!({"radius_mm": radius, "centre_offset_mm": offset, "centre_height_mm": height, "from_deg": from, "to_deg": to})
}

/// The file states 0.1 %.
#[tokio::test]
async fn heights_on_planes_are_those_of_the_solids() {
    let app = TestApp::start().await;
    let document: Value = serde_json::from_str(include_str!("../data/profile_cutters.json")).unwrap();
    let on_plane = |case: &&Value| figure(case, "along_per_mm") == 0.0 && figure(case, "across_per_mm") == 0.0;
    let cases: Vec<&Value> = document["cases"].as_array().unwrap().iter().filter(on_plane).collect();
    for case in &cases {
        let request = json!({
            "model": "envelope",
            "cutter": case["cutter"],
            "contact": angles(figure(case, "slope_deg"), figure(case, "feed_angle_deg")),
            "step_over_mm": case["step_over_mm"],
            "feed_per_tooth_mm": case["feed_per_tooth_mm"],
        });
        let answer = app.answer(SCALLOP_HEIGHT, &request).await;
        for (member, of_case) in [("step_over_height_mm", "step_over_height_mm"), ("scallop_height_mm", "scallop_height_mm")] {
            assert_relative_eq!(figure(&answer, member), figure(case, of_case), max_relative = 1e-3);
        }
        assert_relative_eq!(figure(&answer, "effective_radius_mm"), figure(case, "effective_radius_mm"), max_relative = 1e-3);
    }
    assert!(cases.len() >= 10);
}

#[tokio::test]
async fn every_calculation_takes_every_shape_by_json_by_query_and_in_batches() {
    let app = TestApp::start().await;
    for (name, cutter) in shapes() {
        for path in SINGLES {
            for model in ["analytic", "envelope"] {
                let cutter = with(cutter.clone(), "/teeth", 4);
                let request = with(with(shortest(path), "/cutter", cutter.clone()), "/model", model);
                // A lens cuts 40 deg with its corner of 1 mm, for which 0.687 mm is wide.
                let request = if path == MAX_FEED { with(request, "/step_over_mm", 0.2) } else { request };
                let single = app.answer(path, &request).await;
                let batch = app.answer(&format!("{path}/batch"), &batch_of(request.clone())).await;
                for figure in ["scallop_height_mm", "step_over_mm", "effective_radius_mm"] {
                    assert_eq!(single[figure], batch[figure][0], "{name} {path} {model} {figure}");
                }
                let mut query = form_urlencoded::Serializer::new(String::new());
                for (member, value) in request.as_object().unwrap() {
                    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                    match value.as_object() {
                        Some(members) => members.iter().for_each(|(inner, value)| {
                            let name = if inner == "type" { "cutter" } else { inner };
                            query.append_pair(name, &text(value));
                        }),
                        None => _ = query.append_pair(member, &text(value)),
                    }
                }
                let by_query = app.get(&format!("{path}?{}", query.finish())).await;
                assert_eq!(by_query.status(), 200, "{name} {path}");
                assert_eq!(by_query.json::<Value>().await.unwrap(), single, "{name} {path} {model}");
            }
        }
    }
}

#[tokio::test]
async fn a_profile_that_spells_a_torus_answers_as_the_torus() {
    let app = TestApp::start().await;
    let spelled = json!({"type": "profile", "arcs": [arc(2.0, 3.0, 2.0, 0.0, 90.0)], "teeth": 4});
    for path in SINGLES {
        for curvature in [0.0, 0.01] {
            let request = with(with(shortest(path), "/model", "envelope"), "/surface_curvature", json!({"across_per_mm": curvature}));
            let answer = app.answer(path, &request).await;
            assert_eq!(app.answer(path, &with(request, "/cutter", spelled.clone())).await, answer, "{path}");
        }
    }
}

#[tokio::test]
async fn a_slope_of_a_cone_or_beyond_it_is_refused_by_name() {
    let app = TestApp::start().await;
    let [(_, tapered), ..] = shapes();
    let at = |slope: f64| with(with(shortest(SCALLOP_HEIGHT), "/cutter", tapered.clone()), "/contact", angles(slope, 30.0));
    let on_cone = app.refusal(SCALLOP_HEIGHT, &at(85.0)).await;
    assert_eq!(faults(&on_cone), [("/contact/slope_deg", "straight-flank")]);
    // The envelope has a height there: the cone's straight line is a pass's.
    app.answer(SCALLOP_HEIGHT, &with(at(85.0), "/model", "envelope")).await;
    for model in ["analytic", "envelope"] {
        let beyond = app.refusal(SCALLOP_HEIGHT, &with(at(86.0), "/model", model)).await;
        assert_eq!(faults(&beyond), [("/contact/slope_deg", "slope-too-steep")]);
        assert_relative_eq!(figure(&beyond, "steepest_slope_deg"), 85.0, max_relative = 1e-12);
    }
}

#[tokio::test]
async fn dimensions_that_do_not_fit_are_faults_of_their_members() {
    let app = TestApp::start().await;
    let [tapered, lens, oval, conical, _] = shapes().map(|(_, cutter)| cutter);
    let profile = |arcs: Value| json!({"type": "profile", "arcs": arcs});
    let ball = arc(2.0, 0.0, 2.0, 0.0, 60.0);
    for (cutter, pointer, code) in [
        (with(tapered.clone(), "/taper_deg", 90), "/cutter/taper_deg", "out-of-range"),
        (with(tapered, "/shank_diameter_mm", 1), "/cutter/shank_diameter_mm", "dimensions-do-not-fit"),
        (with(lens.clone(), "/lens_radius_mm", 7), "/cutter/lens_radius_mm", "dimensions-do-not-fit"),
        (with(lens, "/corner_radius_mm", 8), "/cutter/corner_radius_mm", "corner-radius-too-large"),
        (with(oval.clone(), "/tip_radius_mm", 6), "/cutter/tip_radius_mm", "dimensions-do-not-fit"),
        (with(oval, "/side_radius_mm", 4), "/cutter/side_radius_mm", "dimensions-do-not-fit"),
        (with(conical, "/side_radius_mm", 4), "/cutter/side_radius_mm", "dimensions-do-not-fit"),
        (profile(json!([ball, arc(80.0, -75.0, 60.0, 60.0, 90.0)])), "/cutter/arcs/1", "not-a-profile"),
        (profile(json!([arc(2.0, 0.0, 3.0, 0.0, 90.0)])), "/cutter/arcs", "not-a-profile"),
        (profile(json!([arc(0.0, 0.0, 0.0, 0.0, 90.0)])), "/cutter/arcs", "not-a-profile"),
        (profile(json!([])), "/cutter/arcs", "wrong-count"),
        (profile(json!([arc(2.0, 0.0, 2.0, 0.0, 91.0)])), "/cutter/arcs/0/to_deg", "out-of-range"),
        (with(toroidal(), "/taper_deg", 5), "/cutter/taper_deg", "unknown-field"),
    ] {
        let problem = app.refusal(SCALLOP_HEIGHT, &with(shortest(SCALLOP_HEIGHT), "/cutter", cutter.clone())).await;
        assert_eq!(faults(&problem), [(pointer, code)], "{cutter}");
    }
}
