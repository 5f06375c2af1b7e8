//! Every member of a recommendation's request has an effect in each method, or a warning or a fault that names it.

use crate::app::TestApp;
use crate::planning::wavy::{self, triangles};
use crate::planning::with;
use crate::writers::exact;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A wavy slope with troughs too narrow for the cutters, over a facet that faces down, a cutter with a drive and one without, and one direction, so that plans take
/// little time.
fn request(method: &str) -> Value {
    let mut points: Vec<_> = wavy::nodes([1.5, 1.25], [0.8, 0.9]).into_iter().map(exact).collect();
    let mut triangles = triangles();
    triangles.push([points.len(), points.len() + 2, points.len() + 1]);
    points.extend([[0.0, 0.0, -5.0], [20.0, 0.0, -5.0], [0.0, 10.0, -5.0]]);
    json!({
        "surface": {"mesh": {"points": points, "triangles": triangles}},
        "cutters": [
            {"type": "toroidal", "diameter_mm": 6, "corner_radius_mm": 1, "teeth": 4, "spindle_speed_rpm": 10_000},
            {"type": "ball_end", "diameter_mm": 6},
        ],
        "scallop_tolerance_mm": 0.01,
        "machine": {"preset": "five_axis_vmc"},
        "directions_deg": [0],
        "max_uncut_share": 1,
        "method": method,
    })
}

/// A value for each member under a pointer, with which the answer must differ from that to [`request`], or name the member.
fn stated() -> Vec<(&'static str, Value)> {
    let plate = json!({"mesh": {"points": [[0, 0, 0], [30, 0, 0], [30, 30, 60]], "triangles": [[0, 1, 2]]}});
    vec![
        ("/cutters", json!([{"type": "ball_end", "diameter_mm": 4}])),
        ("/scallop_tolerance_mm", json!(0.02)),
        // The older name beside the other is a fault.
        ("/scallop_height_mm", json!(0.02)),
        ("/roughness", json!({"ra_um": 1})),
        ("/machine", json!({"preset": "hobby_router"})),
        ("/pattern", json!("one_way")),
        ("/library_filter", json!({"types": ["ball_end"]})),
        ("/max_slope_deg", json!(20)),
        ("/method", json!("other")),
        ("/model", json!("other")),
        ("/directions_deg", json!([45])),
        ("/unit", json!("inch")),
        ("/facing", json!("any")),
        ("/max_uncut_share", json!(0)),
        ("/select", json!({"slope_deg": [0, 25]})),
        ("/avoid", plate.clone()),
        ("/include", json!(["map"])),
        ("/operations", json!({"max": 2})),
        ("/rest_of", json!({"cutter": {"type": "ball_end", "diameter_mm": 8}})),
        ("/program", json!({"unit": "inch"})),
        ("/surface", plate),
        ("/machine/preset", json!("hobby_router")),
        ("/machine/feed_rate_mm_min", json!(1000)),
        ("/machine/acceleration_m_s2", json!(0.5)),
        ("/machine/jerk_m_s3", json!(5)),
        ("/machine/rapid_rate_mm_min", json!(40_000)),
        ("/machine/max_spindle_speed_rpm", json!(3000)),
        ("/machine/clearance_height_mm", json!(50)),
        ("/machine/path_tolerance_mm", json!(0.01)),
        ("/machine/time_factor", json!(1.5)),
        ("/machine/tool_change_s", json!(5)),
        ("/cutters/0/name", json!("T6")),
        ("/cutters/0/teeth", json!(2)),
        ("/cutters/0/spindle_speed_rpm", json!(3000)),
        ("/cutters/0/max_feed_per_tooth_mm", json!(0.02)),
        ("/cutters/0/flute_length_mm", json!(0.5)),
        ("/cutters/1/teeth", json!(2)),
        ("/cutters/1/spindle_speed_rpm", json!(3000)),
        ("/cutters/1/max_feed_per_tooth_mm", json!(0.02)),
        ("/cutters/1/flute_length_mm", json!(0.5)),
    ]
}

/// The answer without what states the request again.
async fn answer(app: &TestApp, request: &Value) -> Value {
    let mut answer = app.recommend(request).await.body;
    answer.as_object_mut().unwrap().remove("request_id");
    answer
}

fn set(request: &mut Value, pointer: &str, value: &Value) {
    let (parent, name) = pointer.rsplit_once('/').unwrap();
    request.pointer_mut(parent).unwrap()[name] = value.clone();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_member_has_an_effect_or_is_named() {
    let app = TestApp::start().await;
    for method in ["surface", "rectangle"] {
        let base = with(request(method), json!({"scallop_tolerance_mm": 0.04}));
        let usual = answer(&app, &base).await;
        assert_eq!(usual["method"], method, "{usual}");
        for (pointer, value) in stated() {
            let value = match pointer {
                "/method" => json!(if method == "surface" { "rectangle" } else { "surface" }),
                "/model" => json!(if method == "surface" { "analytic" } else { "envelope" }),
                _ => value,
            };
            let mut request = base.clone();
            set(&mut request, pointer, &value);
            let answer = answer(&app, &request).await;
            let name = pointer.rsplit('/').next().unwrap();
            let texts = ["warnings", "errors"].map(|list| answer[list].to_string());
            let differs = ["candidates", "recommended", "surface", "not_ranked", "confidence", "map", "plan"]
                .iter()
                .any(|part| answer[*part] != usual[*part]);
            let is_named = texts.iter().any(|text| text.contains(name) || (name == "flute_length_mm" && text.contains("flutes-too-short")));
            assert!(differs || is_named, "method {method}, {pointer}: {answer}");
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_member_of_the_document_is_missing_above() {
    let document: Value = serde_json::from_str(&TestApp::start().await.get("/openapi.json").await.text().await.unwrap()).unwrap();
    let properties = |schema: &str| -> BTreeSet<String> {
        document["components"]["schemas"][schema]["properties"].as_object().unwrap().keys().cloned().collect()
    };
    let stated = stated();
    let under = |prefix: &str| -> BTreeSet<String> {
        let names = stated.iter().filter_map(|(pointer, _)| pointer.strip_prefix(prefix));
        names.filter(|name| !name.contains('/')).map(str::to_owned).collect()
    };
    assert_eq!(under("/"), properties("RecommendationRequest"));
    assert_eq!(under("/machine/"), properties("Machine"));
    let geometry = ["type", "diameter_mm"].map(str::to_owned).into();
    assert_eq!(under("/cutters/0/"), &properties("BallEndCandidate") - &geometry);
}

/// The feed of method `rectangle` is within the limits of cutter and machine, with teeth and spindle speed.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_rectangle_keeps_the_limits_on_the_feed() {
    let app = TestApp::start().await;
    let driven = |limit: Value| {
        let cutter = json!({"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4, "spindle_speed_rpm": 10_000});
        json!([with(cutter, limit)])
    };
    let recommended = |cutters: Value| with(request("rectangle"), json!({"cutters": cutters}));
    let free = app.recommend(&recommended(driven(json!({})))).await.ok();
    let limited = app.recommend(&recommended(driven(json!({"max_feed_per_tooth_mm": 0.05})))).await.ok();
    // 5000 mm/min over 4 teeth and 10 000 rpm is 0.125 mm; the cutter's limit of 0.05 mm is 2000 mm/min.
    for (answer, feed, rate) in [(&free, 0.125, 5000.0), (&limited, 0.05, 2000.0)] {
        let candidate = &answer["candidates"][0];
        assert!((candidate["feed_per_tooth_mm"].as_f64().unwrap() / feed - 1.0).abs() < 1e-9, "{candidate}");
        assert!((candidate["feed_rate_mm_min"].as_f64().unwrap() / rate - 1.0).abs() < 1e-9, "{candidate}");
        assert_eq!(candidate["feed"], "stated");
    }
    let time = |answer: &Value| answer["candidates"][0]["machining_time_s"].as_f64().unwrap();
    assert!(time(&limited) > 1.2 * time(&free), "{} s, {} s", time(&limited), time(&free));
    // Tooth marks take a part of the scallop height, so passes are closer than without a drive.
    let step = |answer: &Value| answer["candidates"][0]["step_over_xy_mm"]["median"].as_f64().unwrap();
    let undriven = app.recommend(&recommended(json!([{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}]))).await.ok();
    assert!(step(&free) < step(&limited) && step(&limited) < step(&undriven));
}

/// A selection has the rectangle of its facets: half of a plane, half of its area and of its time.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_rectangle_is_that_of_the_selected_facets() {
    let app = TestApp::start().await;
    let slope = f64::to_radians(30.0).tan();
    let points: Vec<[f64; 3]> = (0..5)
        .flat_map(|row| (0..9).map(move |column| [f64::from(column) * 10.0, f64::from(row) * 10.0, slope * f64::from(row) * 10.0]))
        .collect();
    let plane = json!({"grid": {"rows": 5, "columns": 9, "points": points}});
    let half = json!({"grid": {"rows": 5, "columns": 5, "points": points.iter().filter(|point| point[0] <= 40.0).collect::<Vec<_>>()}});
    let of = |surface: &Value| {
        let request = with(request("rectangle"), json!({"surface": surface}));
        with(request, json!({"cutters": [{"type": "ball_end", "diameter_mm": 6}]}))
    };
    let selected = with(of(&plane), json!({"select": {"box_mm": {"min": [-1, -1, -1], "max": [40, 41, 100]}}}));
    let (selected, alone) = (app.recommend(&selected).await.ok(), app.recommend(&of(&half)).await.ok());
    for pointer in
        ["/surface/form_factor", "/surface/characteristic_size_mm2", "/candidates/0/machining_time_s", "/surface/bounds_mm/max/0"]
    {
        let [one, other] = [&selected, &alone].map(|answer| answer.pointer(pointer).unwrap().as_f64().unwrap());
        assert!((one / other - 1.0).abs() < 1e-9, "{pointer}: {one}, {other}");
    }
}

/// One way on a plane, by hand: n (t(pass) + t(up) + t(back) + t(down)).
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_way_passes_return_at_the_rapid_rate() {
    let app = TestApp::start().await;
    let points: Vec<[f64; 3]> = [[0.0, 0.0], [60.0, 0.0], [0.0, 30.0], [60.0, 30.0]].map(|[x, y]| [x, y, 0.0]).into();
    let machine = json!({"preset": "five_axis_vmc", "rapid_rate_mm_min": 20_000, "clearance_height_mm": 8});
    let members = json!({
        "surface": {"grid": {"rows": 2, "columns": 2, "points": points}},
        "cutters": [{"type": "ball_end", "diameter_mm": 6}], "machine": machine, "pattern": "one_way",
    });
    let answer = app.recommend(&with(request("rectangle"), members)).await.ok();
    let (jerk, acceleration) = (40_000.0_f64, 6_000.0_f64);
    // All moves of this test: those that reach V with and without reaching A, and those that only the jerk limits.
    let time = |length: f64, rate: f64| {
        let v = rate / 60.0;
        let (t_a, t_v, t_l) = (acceleration / jerk, (v / jerk).sqrt(), (length / (2.0 * jerk)).cbrt());
        if t_l <= t_a.min(t_v) {
            4.0 * t_l
        } else if t_v <= t_a {
            length / v + 2.0 * t_v
        } else {
            panic!("no move of this test reaches the acceleration: {t_a} {t_v} {t_l}")
        }
    };
    // The moments of a rectangle of 60 x 30 give its own sides.
    let step = 2.0 * (2.0_f64 * 3.0 * 0.01 - 0.01 * 0.01).sqrt();
    let passes = 30.0 / step;
    let back = 60.0_f64.hypot(step);
    let expected = passes * (time(60.0, 5000.0) + 2.0 * time(8.0, 20_000.0) + time(back, 20_000.0));
    let found = answer["candidates"][0]["machining_time_s"].as_f64().unwrap();
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} s, {expected} s");
    let length = answer["candidates"][0]["path_length_mm"].as_f64().unwrap();
    assert!((length / (passes * (60.0 + 16.0 + back)) - 1.0).abs() < 1e-9, "{length} mm");
}

/// On a level plate both methods keep the published bound of the step-over on a floor, 2 (R - r) + 2 sqrt(2 r sh - sh^2).
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_level_plate_has_the_step_over_of_a_floor() {
    let app = TestApp::start().await;
    let points = [[0, 0, 0], [50, 0, 0], [0, 40, 0], [50, 40, 0]];
    let on_floor = 6.0 + 2.0 * 0.0399_f64.sqrt();
    for (method, model) in [("rectangle", "analytic"), ("rectangle", "envelope"), ("surface", "analytic"), ("surface", "envelope")] {
        let members = json!({
            "surface": {"grid": {"rows": 2, "columns": 2, "points": points}}, "model": model,
            "cutters": [{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}],
        });
        let answer = app.recommend(&with(request(method), members)).await.ok();
        let largest = answer["candidates"][0]["step_over_xy_mm"]["max"].as_f64().unwrap();
        assert!(largest <= on_floor * (1.0 + 1e-9), "{method}, {model}: {largest} mm");
        if method == "rectangle" {
            assert!(largest > on_floor * (1.0 - 1e-9), "{model}: {largest} mm");
        }
    }
}
