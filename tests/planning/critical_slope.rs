//! `POST /v1/critical-slope` and `GET /v1/machines`.

use crate::app::{Answer, TestApp, figure, warnings};
use crate::planning::{pair, with};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use serde_json::{Value, json};

const PATH: &str = "/v1/critical-slope";

fn published() -> Value {
    serde_json::from_str(include_str!("../data/herraz_2020.json")).unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_published_plane_has_its_times_and_lengths() {
    let app = TestApp::start().await;
    let answer = app.post(PATH, &with(pair(), json!({"width_mm": 56, "height_mm": 28, "slope_deg": 60}))).await.ok();
    assert_abs_diff_eq!(figure(&answer, "/critical_slope_deg"), 33.8558, epsilon = 0.00005);
    assert_eq!(answer["recommended"]["cutter"], "ball_end");
    assert_eq!(answer["recommended"].get("direction_deg"), None);
    assert_eq!((&answer["candidates"][0]["cutter"], &answer["candidates"][1]["cutter"]), (&json!("toroidal"), &json!("ball_end")));
    // Printed with two decimals, and whole millimetres.
    for (index, time, length) in [(0, 43.06, 2429.0), (1, 37.34, 2508.0)] {
        assert_abs_diff_eq!(figure(&answer, &format!("/candidates/{index}/machining_time_s")), time, epsilon = 0.005);
        assert_abs_diff_eq!(figure(&answer, &format!("/candidates/{index}/path_length_mm")), length, epsilon = 0.5);
    }
    assert!(warnings(&answer).is_empty());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_published_surfaces_have_their_critical_slopes() {
    let app = TestApp::start().await;
    let published = published();
    for (index, exact) in [(0, 38.90), (1, 62.61)] {
        let surface = &published["surfaces"][index];
        let form = json!({"form_factor": surface["form_factor"], "characteristic_size_mm2": surface["characteristic_size_mm2"]});
        let answer = app.post(PATH, &with(pair(), form)).await.ok();
        assert_abs_diff_eq!(figure(&answer, "/critical_slope_deg"), exact, epsilon = 0.005);
        assert_eq!(
            answer.as_object().unwrap().keys().collect::<Vec<_>>(),
            ["form_factor", "characteristic_size_mm2", "critical_slope_deg", "warnings"]
        );
    }
}

/// Section 4.1 of the paper: passes of 28 and 56 mm reach the feed rate and not the acceleration, steps of 0.66 and 0.63 mm
/// neither; t_A = 0.15 s and t_V = 0.046 s.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_plane_of_table_1_has_its_radii_and_kinematic_cases() {
    let app = TestApp::start().await;
    let answer = app.post(PATH, &with(pair(), json!({"width_mm": 56, "height_mm": 28, "slope_deg": 60}))).await.ok();
    assert_eq!((figure(&answer, "/form_factor"), figure(&answer, "/characteristic_size_mm2")), (2.0, 1568.0));
    // (R - r)/sin(60 deg) + r
    for (index, radius, pass) in [(0, 3.0 / 60.0_f64.to_radians().sin() + 2.0, 28.0), (1, 5.0, 56.0)] {
        let candidate = &answer["candidates"][index];
        assert_relative_eq!(candidate["effective_radius_mm"].as_f64().unwrap(), radius, max_relative = 1e-14);
        assert_eq!(candidate["pass_length_mm"], pass);
        assert_eq!((&candidate["pass_case"], &candidate["step_case"]), (&json!("feed_rate"), &json!("jerk_only")));
    }
    let floor = app.post(PATH, &with(pair(), json!({"width_mm": 56, "height_mm": 28, "slope_deg": 0}))).await.ok();
    assert!(floor["candidates"][0].get("effective_radius_mm").is_none());
}

/// The factor that a shop measured multiplies all times, which leaves the critical slope as it is.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_time_factor_multiplies_the_times_and_other_members_of_the_machine_are_named() {
    let app = TestApp::start().await;
    let rectangle = json!({"width_mm": 56, "height_mm": 28, "slope_deg": 60});
    let on = async |members: Value| {
        let machine = with(json!({"preset": "five_axis_vmc"}), members);
        app.post(PATH, &with(pair(), with(rectangle.clone(), json!({"machine": machine})))).await.ok()
    };
    let (usual, slow) = (on(json!({})).await, on(json!({"time_factor": 1.25})).await);
    for pointer in ["/candidates/0/machining_time_s", "/candidates/1/machining_time_s", "/recommended/machining_time_s"] {
        assert_relative_eq!(figure(&slow, pointer), 1.25 * figure(&usual, pointer), max_relative = 1e-14);
    }
    assert_eq!(slow["critical_slope_deg"], usual["critical_slope_deg"]);
    assert!(warnings(&slow).is_empty());
    for (name, value) in [
        ("rapid_rate_mm_min", 20_000.0),
        ("max_spindle_speed_rpm", 18_000.0),
        ("clearance_height_mm", 8.0),
        ("path_tolerance_mm", 0.01),
        ("tool_change_s", 5.0),
    ] {
        let answer = on(json!({name: value})).await;
        assert_eq!(answer["candidates"], usual["candidates"]);
        assert_eq!(warnings(&answer), ["member-unused"], "{name}");
        assert!(answer["warnings"][0]["detail"].as_str().unwrap().starts_with(&format!("machine.{name} has no effect")), "{answer}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn sides_and_form_give_the_same_answer() {
    let app = TestApp::start().await;
    let sides = app.post(PATH, &with(pair(), json!({"width_mm": 80, "height_mm": 20, "slope_deg": 10}))).await.ok();
    let form = app.post(PATH, &with(pair(), json!({"form_factor": 4, "characteristic_size_mm2": 1600, "slope_deg": 10}))).await.ok();
    assert_relative_eq!(figure(&sides, "/critical_slope_deg"), figure(&form, "/critical_slope_deg"), max_relative = 1e-12);
    assert_relative_eq!(figure(&sides, "/critical_form_factor"), figure(&form, "/critical_form_factor"), max_relative = 1e-12);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cutter_that_is_always_faster_is_named() {
    let app = TestApp::start().await;
    // A ball of 1 mm takes far more passes than the torus even on a wall. On a strip as narrow as the ball's step-over
    // of 0.63 mm, the torus would take at least 2000 mm of steps.
    for (members, critical, faster) in [
        (json!({"width_mm": 30, "height_mm": 30, "ball_end": {"diameter_mm": 1}, "scallop_height_mm": 0.001}), 90.0, "toroidal"),
        (json!({"width_mm": 2000, "height_mm": 0.2}), 0.0, "ball_end"),
    ] {
        let answer = app.post(PATH, &with(pair(), with(members, json!({"slope_deg": 30})))).await.ok();
        assert_abs_diff_eq!(figure(&answer, "/critical_slope_deg"), critical);
        assert_eq!((&answer["always_faster"], &answer["recommended"]["cutter"]), (&json!(faster), &json!(faster)));
    }
    let square = with(pair(), json!({"width_mm": 30, "height_mm": 30, "slope_deg": 30}));
    assert_eq!(app.post(PATH, &square).await.ok().get("always_faster"), None);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn near_a_floor_the_published_bound_holds_and_its_height_is_stated() {
    let app = TestApp::start().await;
    // Flat of 2 (R - r) = 6 mm, and the chord of r = 2 mm at 10 um: the 6.4 mm of section 4.1.1.
    let on_floor = 6.0 + 2.0 * 0.0399_f64.sqrt();
    // At 0.2 deg the flat leaves 20 um with that step-over: its lower edge is 22 um under the upper one.
    for (slope, model, expected) in
        [(0.0, "envelope", vec![]), (0.0, "analytic", vec![]), (0.2, "analytic", vec!["outside-analytic-range"]), (2.0, "analytic", vec![])]
    {
        let members = json!({"width_mm": 56, "height_mm": 28, "slope_deg": slope, "model": model});
        let answer = app.post(PATH, &with(pair(), members)).await.ok();
        assert_eq!(answer["recommended"]["cutter"], "toroidal");
        assert_eq!(warnings(&answer), expected, "{slope} deg, {model}");
        if slope < 0.3 {
            assert_relative_eq!(figure(&answer, "/recommended/step_over_mm"), on_floor, max_relative = 1e-9);
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn all_faults_of_a_rectangle_are_listed_with_their_pointers() {
    let app = TestApp::start().await;
    for (members, expected) in [
        (json!({}), vec![("", "missing-field")]),
        (json!({"width_mm": 56}), vec![("/height_mm", "missing-field")]),
        (json!({"width_mm": 28, "height_mm": 56}), vec![("/height_mm", "height-exceeds-width")]),
        (json!({"width_mm": 0, "height_mm": "1"}), vec![("/width_mm", "out-of-range"), ("/height_mm", "wrong-type")]),
        (json!({"width_mm": 2, "height_mm": 1, "form_factor": 0.5}), vec![("/form_factor", "out-of-range"), ("", "conflicting-fields")]),
        (json!({"form_factor": 1e6, "characteristic_size_mm2": 1e12}), vec![("/characteristic_size_mm2", "out-of-range")]),
        (json!({"width_mm": 2, "height_mm": 1, "slope_deg": 90.1}), vec![("/slope_deg", "out-of-range")]),
        (json!({"width_mm": 2, "height_mm": 1, "slope": 1}), vec![("/slope", "unknown-field")]),
        (json!({"width_mm": 2, "height_mm": 1, "scallop_height_mm": 2.5}), vec![("/scallop_height_mm", "scallop-too-high")]),
    ] {
        let answer = app.post(PATH, &with(pair(), members)).await;
        assert_eq!(answer.faults(), (422, expected), "{}", answer.body);
    }
    let answer = app.post(PATH, &json!({"width_mm": 56, "height_mm": 28})).await;
    let missing = ["/toroidal", "/ball_end", "/machine", "/scallop_tolerance_mm"].map(|pointer| (pointer, "missing-field"));
    assert_eq!(answer.faults(), (422, missing.to_vec()));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn machines_are_presets_values_or_both() {
    let app = TestApp::start().await;
    let critical = async |machine: Value| {
        let answer = app.post(PATH, &with(pair(), json!({"width_mm": 56, "height_mm": 28, "machine": machine}))).await;
        if answer.status == 200 { Ok(figure(&answer.body, "/critical_slope_deg")) } else { Err(answer) }
    };
    let preset = critical(json!({"preset": "five_axis_vmc"})).await.unwrap();
    let values = critical(json!({"feed_rate_mm_min": 5000, "acceleration_m_s2": 6, "jerk_m_s3": 40})).await.unwrap();
    assert!((preset - values).abs() == 0.0);
    let overridden = critical(json!({"preset": "vmc", "feed_rate_mm_min": 5000, "acceleration_m_s2": 6, "jerk_m_s3": 40})).await.unwrap();
    assert!((preset - overridden).abs() == 0.0);
    // A faster machine gains more on long passes: s_c falls with V.
    assert!(critical(json!({"preset": "five_axis_vmc", "feed_rate_mm_min": 9000})).await.unwrap() < preset);

    let refused = critical(json!({"preset": "lathe"})).await.unwrap_err();
    assert_eq!(refused.faults(), (422, vec![("/machine/preset", "unknown-value")]));
    assert!(refused.detail().contains("hobby_router, vmc, five_axis_vmc"), "{}", refused.detail());
    let refused = critical(json!({"feed_rate_mm_min": 0, "jerk_m_s3": 1e99, "accel": 1})).await.unwrap_err();
    let expected = [
        ("/machine/feed_rate_mm_min", "out-of-range"),
        ("/machine/jerk_m_s3", "out-of-range"),
        ("/machine/acceleration_m_s2", "missing-field"),
        ("/machine/accel", "unknown-field"),
    ];
    assert_eq!(refused.faults(), (422, expected.to_vec()));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_listed_machines_are_those_that_can_be_named() {
    let app = TestApp::start().await;
    let listed = Answer::of(app.get("/v1/machines").await).await.ok();
    let machines = listed["machines"].as_array().unwrap();
    assert!(machines.len() >= 4);
    for machine in machines {
        let by_name = json!({"width_mm": 56, "height_mm": 28, "machine": {"preset": machine["name"]}});
        let limits = ["feed_rate_mm_min", "acceleration_m_s2", "jerk_m_s3"].map(|limit| (limit.to_owned(), machine[limit].clone()));
        let by_values = json!({"width_mm": 56, "height_mm": 28, "machine": Value::Object(limits.into_iter().collect())});
        assert_eq!(app.post(PATH, &with(pair(), by_name)).await.ok(), app.post(PATH, &with(pair(), by_values)).await.ok());
        assert!(!machine["source"].as_str().unwrap().is_empty() && !machine["description"].as_str().unwrap().is_empty());
    }
}
