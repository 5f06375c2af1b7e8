//! Faults and warnings that say what was probably meant.

use crate::app::{TestApp, faults, warnings};
use serde_json::{Value, json};

/// The detail of the fault at a pointer.
fn detail(problem: &Value, pointer: &str) -> String {
    let errors = problem["errors"].as_array().unwrap();
    let fault = errors.iter().find(|fault| fault["pointer"] == pointer).unwrap_or_else(|| panic!("no fault at {pointer}: {problem}"));
    fault["detail"].as_str().unwrap().to_owned()
}

fn max_feed() -> Value {
    json!({
        "cutter": {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4},
        "contact": {"slope_deg": 40, "feed_angle_deg": 30},
        "step_over_mm": 0.5,
        "scallop_tolerance_mm": 0.01,
    })
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn misplaced_members_are_told_where_they_belong() {
    let app = TestApp::start().await;
    let mut request = max_feed();
    request["cutter"]["spindle_speed_rpm"] = json!(10_000);
    request["radial_mm"] = json!(0.01);
    request["runout"] = json!({"axial_mm": 0.01});
    request["slope_deg"] = json!(40);
    let problem = app.refusal("/v1/max-feed", &request).await;
    for (pointer, expected) in [
        ("/cutter/spindle_speed_rpm", "spindle_speed_rpm belongs at the top of the request, not here"),
        ("/radial_mm", "radial_mm belongs in runout, not here"),
        ("/slope_deg", "slope_deg belongs in contact, not here"),
    ] {
        assert_eq!(detail(&problem, pointer), expected);
    }
    // Objects that are not there: the members of a query, sent as JSON.
    let flat =
        json!({"type": "ball_end", "diameter_mm": 6, "slope_deg": 20, "feed_angle_deg": 0, "step_over_mm": 0.5, "along_per_mm": 0.01});
    let problem = app.refusal("/v1/scallop-height", &flat).await;
    for (pointer, expected) in [
        ("/type", "type belongs in cutter, not here"),
        ("/diameter_mm", "diameter_mm belongs in cutter, not here"),
        ("/slope_deg", "slope_deg belongs in contact, not here"),
        ("/along_per_mm", "along_per_mm belongs in surface_curvature, not here"),
    ] {
        assert_eq!(detail(&problem, pointer), expected);
    }
    let columns = json!({"cutter": {"type": "ball_end", "diameter_mm": 6}, "slope_deg": [20], "feed_angle_deg": [0], "step_over_mm": 0.5});
    let problem = app.refusal("/v1/scallop-height/batch", &columns).await;
    assert_eq!(detail(&problem, "/slope_deg"), "slope_deg belongs in contacts, not here");
    let without_units = json!({"diameter": 6, "slope": 20, "stepOver": 0.5, "radius": 0.01});
    let problem = app.refusal("/v1/scallop-height", &without_units).await;
    for (pointer, expected) in [
        ("/diameter", "unknown field; did you mean diameter_mm in cutter?"),
        ("/slope", "unknown field; did you mean slope_deg in contact?"),
        ("/stepOver", "unknown field; did you mean step_over_mm?"),
        // Not one of another object that only resembles it: `radial_mm` of the runout.
        ("/radius", "unknown field; did you mean surface_radius_mm?"),
    ] {
        assert_eq!(detail(&problem, pointer), expected);
    }
    // In a recommendation the same member belongs to the cutter.
    let problem = app
        .refusal(
            "/v1/cutter-recommendation",
            &json!({
                "surface": {"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}, "scallop_height_mm": 0.01, "machine": "vmc",
                "cutters": [{"type": "ball_end", "diameter_mm": 6}], "spindle_speed_rpm": 10_000, "feed_rate_mm_min": 3000,
            }),
        )
        .await;
    assert_eq!(detail(&problem, "/spindle_speed_rpm"), "spindle_speed_rpm belongs in cutters/0, not here");
    // Members beside the name of a preset, and those of a mesh beside its points.
    assert_eq!(detail(&problem, "/feed_rate_mm_min"), "feed_rate_mm_min belongs in machine, not here");
    let surface = json!({"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 2]]});
    let job = json!({"surface": surface, "scallop_height_mm": 0.01, "machine": "vmc", "cutters": [{"type": "ball_end", "diameter_mm": 6}]});
    let problem = app.refusal("/v1/cutter-recommendation", &job).await;
    assert_eq!(detail(&problem, "/surface/triangles"), "triangles belongs in surface/mesh, not here");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn misspelt_members_are_told_the_nearest_name() {
    let app = TestApp::start().await;
    for (name, meant) in [
        ("spindel_speed_rpm", "spindle_speed_rpm"),
        ("scallop_tolerence_mm", "scallop_tolerance_mm"),
        ("stepover_mm", "step_over_mm"),
        ("step_over", "step_over_mm"),
        ("step-over", "step_over_mm"),
        ("scallopTolerance", "scallop_tolerance_mm"),
        ("scallop_tolerance_in", "scallop_tolerance_mm"),
        ("spindle_speed", "spindle_speed_rpm"),
        ("spindle_rpm", "spindle_speed_rpm"),
        ("tolerance", "scallop_tolerance_mm"),
    ] {
        let mut request = max_feed();
        request[name] = json!(1);
        let problem = app.refusal("/v1/max-feed", &request).await;
        assert_eq!(detail(&problem, &format!("/{name}")), format!("unknown field; did you mean {meant}?"));
    }
    let cutter = json!({"type": "tapered_ball", "ball_diameter_mm": 2, "taper_half_angle_deg": 5, "feedPerTooth": 0.1, "angle_deg": 5});
    let request = json!({"surface": {"points": []}, "scallop_height_mm": 0.01, "machine": "vmc", "cutters": [cutter]});
    let problem = app.refusal("/v1/cutter-recommendation", &request).await;
    for (name, meant) in
        [("ball_diameter_mm", "diameter_mm"), ("taper_half_angle_deg", "taper_deg"), ("feedPerTooth", "max_feed_per_tooth_mm")]
    {
        assert_eq!(detail(&problem, &format!("/cutters/0/{name}")), format!("unknown field; did you mean {meant}?"));
    }
    assert!(detail(&problem, "/cutters/0/angle_deg").starts_with("unknown field; known here: type, "));
    let mut request = max_feed();
    request["coolant"] = json!(1);
    assert!(detail(&app.refusal("/v1/max-feed", &request).await, "/coolant").starts_with("unknown field; known here: cutter, "));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn numbers_with_commas_and_units_are_told_how_to_be_written() {
    let app = TestApp::start().await;
    let mut request = max_feed();
    request["step_over_mm"] = json!("0.5in");
    request["scallop_tolerance_mm"] = json!("0,5");
    request["contact"]["slope_deg"] = json!("40deg");
    let problem = app.refusal("/v1/max-feed", &request).await;
    for pointer in ["/step_over_mm", "/scallop_tolerance_mm"] {
        assert!(detail(&problem, pointer).ends_with("; write the length in mm as a plain number with a decimal point, such as 0.5"));
    }
    assert!(detail(&problem, "/contact/slope_deg").contains("angle in degrees"));
    request = json!({
        "surface": {"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}, "scallop_height_mm": 0.01, "machine": "vmc",
        "cutters": [{"type": "ball_end", "diameter_mm": 6}], "max_uncut_share": "50%",
    });
    assert!(detail(&app.refusal("/v1/cutter-recommendation", &request).await, "/max_uncut_share").ends_with("such as 0.5 for 50 %"));
    let query = "/v1/scallop-height?cutter=ball_end&diameter_mm=10&slope_deg=40&feed_angle_deg=30&step_over_mm=0,5";
    let problem: Value = serde_json::from_str(&app.get(query).await.text().await.unwrap()).unwrap();
    assert!(detail(&problem, "/step_over_mm").contains("with a decimal point"));
    // A word is not a number with a unit.
    request = max_feed();
    request["step_over_mm"] = json!("wide");
    assert_eq!(detail(&app.refusal("/v1/max-feed", &request).await, "/step_over_mm"), "expected a number, found the string \"wide\"");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn queries_are_told_the_names_of_queries() {
    let app = TestApp::start().await;
    let ask = async |query: &str| -> Value {
        let answer = app.get(&format!("/v1/scallop-height?{query}")).await;
        assert_eq!(answer.status(), 422);
        serde_json::from_str(&answer.text().await.unwrap()).unwrap()
    };
    let problem = ask("cutter=ball_end&diameter_mm=10&corner_radius_mm=5&slope_deg=40&feed_angle_deg=30&step_over_mm=0.5").await;
    assert_eq!(
        detail(&problem, "/corner_radius_mm"),
        "the parameter does not go with the others; those that do: cutter, diameter_mm, teeth"
    );
    let problem = ask("cutter=ball_end&diameter_mm=10&slope_deg=40&feed_angle_deg=30&stepover_mm=0.5").await;
    assert_eq!(detail(&problem, "/stepover_mm"), "unknown parameter; did you mean step_over_mm?");
    let many: Vec<String> = (0..2000).map(|number| format!("p{number}=1")).collect();
    let problem = ask(&format!("cutter=ball_end&{}", many.join("&"))).await;
    assert!(problem.to_string().len() < 16_000, "{} bytes", problem.to_string().len());
    assert_eq!(faults(&problem).last(), Some(&("", "further-faults")));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_machine_may_be_the_name_of_a_preset() {
    let app = TestApp::start().await;
    let request = |machine: Value| {
        json!({
            "width_mm": 56, "height_mm": 28, "scallop_height_mm": 0.01, "machine": machine,
            "toroidal": {"diameter_mm": 10, "corner_radius_mm": 2}, "ball_end": {"diameter_mm": 10},
        })
    };
    let [by_name, by_object] = [json!("vmc"), json!({"preset": "vmc"})].map(request);
    assert_eq!(app.post("/v1/critical-slope", &by_name).await.ok(), app.post("/v1/critical-slope", &by_object).await.ok());
    assert_eq!(faults(&app.refusal("/v1/critical-slope", &request(json!("vnc"))).await), [("/machine", "unknown-value")]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nulls_of_contacts_with_an_answer_have_a_warning() {
    let app = TestApp::start().await;
    let contacts = json!([{"slope_deg": 40, "feed_angle_deg": 30}, {"slope_deg": 0, "feed_angle_deg": 0}]);
    let mut request = max_feed();
    request.as_object_mut().unwrap().remove("contact");
    request["contacts"] = contacts;
    request["columns"] = json!(["feed_rate_mm_min", "effective_radius_mm"]);
    request["model"] = json!("envelope");
    let answer = app.answer("/v1/max-feed/batch", &request).await;
    assert_eq!(answer["feed_rate_mm_min"], json!([null, null]));
    assert_eq!(warnings(&answer), ["figure-absent", "figure-absent"]);
    let [rate, radius] = [0, 1].map(|place| answer["warnings"][place].clone());
    assert_eq!((&rate["contacts"], &rate["first_index"]), (&json!(2), &json!(0)));
    assert_eq!(rate["detail"], "feed_rate_mm_min has values only if the cutter's teeth and the spindle speed are given");
    assert_eq!((&radius["contacts"], &radius["first_index"]), (&json!(1), &json!(1)));
    // Without a selection, the column of the feed rate is left out.
    request.as_object_mut().unwrap().remove("columns");
    let answer = app.answer("/v1/max-feed/batch", &request).await;
    assert!(answer.get("feed_rate_mm_min").is_none());
    // The marks at a floor and the two radii there.
    assert!(answer["warnings"].as_array().unwrap().iter().all(|warning| warning["contacts"] == 1), "{}", answer["warnings"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn slopes_that_look_like_radians_have_a_warning() {
    let app = TestApp::start().await;
    let batch = |slopes: Vec<f64>| {
        let angles = vec![0.5; slopes.len()];
        json!({
            "cutter": {"type": "ball_end", "diameter_mm": 6}, "scallop_tolerance_mm": 0.01,
            "contacts": {"slope_deg": slopes, "feed_angle_deg": angles},
        })
    };
    let slopes = |largest: f64| (0..50).map(|number| largest * f64::from(number) / 49.0).collect::<Vec<_>>();
    for (slopes, expected) in [
        (slopes(std::f64::consts::FRAC_PI_2), vec!["angles-like-radians"]),
        (slopes(1.6), vec![]),
        (slopes(80.0), vec![]),
        (vec![0.0; 50], vec![]),
        (vec![1.0; 5], vec![]),
    ] {
        assert_eq!(warnings(&app.answer("/v1/step-over/batch", &batch(slopes.clone())).await), expected, "{slopes:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_whose_contacts_all_fail_has_its_answer_in_the_problem() {
    let app = TestApp::start().await;
    let batch = |step_overs: &[f64]| {
        json!({
            "cutter": {"type": "ball_end", "diameter_mm": 6}, "columns": ["scallop_height_mm"],
            "contacts": step_overs.iter().map(|s| json!({"slope_deg": 40, "feed_angle_deg": 0, "step_over_mm": s})).collect::<Vec<_>>(),
        })
    };
    let in_part = app.answer("/v1/scallop-height/batch", &batch(&[20.0, 0.5])).await;
    let answer = app.post("/v1/scallop-height/batch", &batch(&[20.0, 30.0])).await;
    assert_eq!((answer.status, &answer.body["type"]), (422, &json!("invalid-request")));
    let inner = &answer.body["answer"];
    assert_eq!(inner.as_object().unwrap().keys().collect::<Vec<_>>(), in_part.as_object().unwrap().keys().collect::<Vec<_>>());
    assert_eq!(inner["scallop_height_mm"], json!([null, null]));
    assert_eq!((&inner["summary"]["count"], &inner["summary"]["failures"]), (&json!(2), &json!(2)));
    assert_eq!(inner["failures"][0], in_part["failures"][0]);
    assert_eq!(inner["failures"].as_array().unwrap().len(), 2);
}
