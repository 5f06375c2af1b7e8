//! Refused recommendations in JSON: every fault with its pointer.

use crate::app::{Answer, TestApp};
use crate::planning::{job, with};
use serde_json::{Value, json};

async fn refused(app: &TestApp, surface: Value) -> Answer {
    app.recommend(&with(job(), json!({"surface": surface}))).await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn surfaces_that_cannot_be_read_are_refused_with_all_their_faults() {
    let app = TestApp::start().await;
    let square = json!([[0, 0, 0], [9, 0, 1], [0, 9, 0], [9, 9, 1]]);
    for (surface, expected) in [
        (json!(7), vec![("/surface", "wrong-type")]),
        (json!({}), vec![("/surface", "missing-field")]),
        (json!({"points": square, "samples": 80}), vec![("/surface/samples", "unknown-field")]),
        (
            json!({"points": [[0, 0], 1], "bezier": {}}),
            vec![
                ("/surface/points/0", "wrong-type"),
                ("/surface/points/1", "wrong-type"),
                ("/surface/bezier/control_points", "missing-field"),
                ("/surface", "conflicting-fields"),
            ],
        ),
        (json!({"points": {}}), vec![("/surface/points", "wrong-type")]),
        (
            json!({"points": [[0, 0, 0], [1, null, "2"], [1, 2, 3, 4], [1e13, 0, 0]]}),
            vec![
                ("/surface/points/1/1", "wrong-type"),
                ("/surface/points/1/2", "wrong-type"),
                ("/surface/points/2", "wrong-type"),
                ("/surface/points/3/0", "out-of-range"),
            ],
        ),
        (
            json!({"grid": {"rows": 1, "columns": 2.5}}),
            vec![
                ("/surface/grid/rows", "out-of-range"),
                ("/surface/grid/columns", "wrong-type"),
                ("/surface/grid/points", "missing-field"),
            ],
        ),
        (json!({"grid": {"rows": 2, "columns": 3, "points": square}}), vec![("/surface/grid/points", "wrong-count")]),
        (json!({"grid": {"rows": 2, "columns": 2}}), vec![("/surface/grid/points", "missing-field")]),
        (
            json!({"grid": {"rows": "2", "columns": 2, "points": [[0]]}}),
            vec![("/surface/grid/rows", "wrong-type"), ("/surface/grid/points/0", "wrong-type")],
        ),
        (
            json!({"bezier": {"control_points": [[[0, 0, 0], [1, 0, 0]], [[0, 1, 0]]]}, "samples": 1}),
            vec![("/surface/bezier/control_points/1", "wrong-count"), ("/surface/samples", "out-of-range")],
        ),
        (
            json!({"bezier": {"control_points": [[[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1]]]}}),
            vec![("/surface/bezier/control_points/1/1", "wrong-type"), ("/surface/samples", "missing-field")],
        ),
        (json!({"bezier": {"control_points": [[[0, 0, 0]]]}, "samples": 9}), vec![("/surface/bezier/control_points", "wrong-count")]),
        (
            json!({"bezier": {"control_points": vec![square.clone(); 21]}, "samples": 9}),
            vec![("/surface/bezier/control_points", "wrong-count")],
        ),
    ] {
        let answer = refused(&app, surface.clone()).await;
        assert_eq!(answer.faults(), (422, expected), "{surface}: {}", answer.body);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn points_that_span_no_surface_are_refused() {
    let app = TestApp::start().await;
    let line: Vec<_> = (0..9).map(|index| [index, 2 * index, -index]).collect();
    for (points, code) in [
        (json!([]), "too-few-points"),
        (json!([[1, 2, 3], [4, 5, 7]]), "too-few-points"),
        (json!(vec![[1.5, 2.5, 3.5]; 7]), "all-points-equal"),
        (json!(line), "collinear"),
    ] {
        let answer = refused(&app, json!({"points": points})).await;
        assert_eq!(answer.faults(), (422, vec![("/surface", code)]));
    }
    let flat = json!([[0, 0, 0], [1, 1, 1], [2, 2, 2], [3, 3, 3]]);
    let answer = refused(&app, json!({"grid": {"rows": 2, "columns": 2, "points": flat}})).await;
    assert_eq!(answer.faults(), (422, vec![("/surface", "only-degenerate-facets")]));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn surfaces_beyond_the_bounds_of_lengths_are_refused() {
    let app = TestApp::start().await;
    let huge = json!({"points": [[0, 0, 0], [1e9, 0, 1e8], [0, 1e9, 0], [1e9, 1e9, 1e8]]});
    assert_eq!(refused(&app, huge).await.faults(), (422, vec![("/surface", "size-out-of-range")]));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faults_of_surface_and_parameters_are_listed_together() {
    let app = TestApp::start().await;
    let request = json!({
        "surface": {"points": [[0, 0, "z"]]},
        "cutters": [
            {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 5},
            {"type": "ball_end", "diameter_mm": -1, "spindle_speed_rpm": 0, "name": ""},
        ],
        "directions_deg": [0, "x"],
        "select": {"slope_deg": [60, 10], "box_mm": {"min": [0, 0]}, "pieces": []},
        "include": ["pictures"],
        "scallop_height_mm": 0.01,
        "machine": {"preset": "vmc"},
        "unit": "furlong",
        "facing": "down",
        "model": "exact",
        "colour": "red",
    });
    let answer = app.recommend(&request).await;
    let (status, faults) = answer.faults();
    for expected in [
        ("/cutters/0/corner_radius_mm", "corner-radius-too-large"),
        ("/cutters/1/diameter_mm", "out-of-range"),
        ("/cutters/1/name", "out-of-range"),
        ("/cutters/1/spindle_speed_rpm", "out-of-range"),
        ("/directions_deg/1", "wrong-type"),
        ("/select/box_mm/min", "wrong-type"),
        ("/select/box_mm/max", "missing-field"),
        ("/select/pieces", "wrong-count"),
        ("/include/0", "unknown-value"),
        ("/model", "unknown-value"),
        ("/unit", "unknown-value"),
        ("/facing", "unknown-value"),
        ("/surface/points/0/2", "wrong-type"),
        ("/colour", "unknown-field"),
    ] {
        assert!(faults.contains(&expected), "{expected:?} is not in {faults:?}");
    }
    assert_eq!(status, 422);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_very_many_faulty_points_a_part_is_listed() {
    let app = TestApp::start().await;
    let answer = refused(&app, json!({"points": vec![json!([1, 2]); 5000]})).await;
    let (status, faults) = answer.faults();
    assert_eq!((status, faults.len(), faults[1000]), (422, 1001, ("", "further-faults")));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn bodies_that_are_not_json_are_refused() {
    let app = TestApp::start().await;
    let path = "/v1/cutter-recommendation";
    assert_eq!(app.post_text(path, "{\"surface\": {\"points\": [[1, 2, NaN]]}}").await.status, 422);
    assert_eq!(app.post_text(path, "").await.status, 400);
    assert_eq!(app.post_text(path, "[".repeat(100_000)).await.status, 400);
    assert_eq!(app.post_as(path, "text/csv", "1,2,3").await.status, 415);
    let huge_number = format!("{{\"surface\": {{\"points\": [[0, 0, 1e999], [{}, 0, 0]]}}}}", "9".repeat(1000));
    let answer = app.post_text(path, huge_number).await;
    let (status, faults) = answer.faults();
    assert_eq!(status, 422);
    assert!(faults.contains(&("/surface/points/0/2", "out-of-range")) && faults.contains(&("/surface/points/1/0", "out-of-range")));
}

/// The tolerance has one name in calculations and plans; the older one of plans means the same.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_tolerance_of_a_plan_has_an_older_name() {
    let app = TestApp::start().await;
    let slope = json!({"grid": {"rows": 2, "columns": 2, "points": [[0, 0, 0], [20, 0, 0], [0, 20, 9], [20, 20, 9]]}});
    let ball = json!({"type": "ball_end", "diameter_mm": 6});
    let plan = json!({"surface": slope, "cutters": [ball], "machine": "vmc", "directions_deg": [0]});
    let check = json!({"surface": slope, "cutter": ball, "machine": "vmc", "path": {"tip_mm": [[0, 0, 0.29], [20, 20, 9.29]]}});
    let rectangle = json!({"width_mm": 56, "height_mm": 28, "slope_deg": 30, "machine": "vmc",
        "toroidal": {"diameter_mm": 10, "corner_radius_mm": 2}, "ball_end": {"diameter_mm": 10}});
    for (path, request) in [("/v1/cutter-recommendation", plan), ("/v1/path-check", check), ("/v1/critical-slope", rectangle)] {
        let of = async |members: Value| app.post(path, &with(request.clone(), members)).await;
        let named = of(json!({"scallop_tolerance_mm": 0.02})).await.ok();
        assert_eq!(of(json!({"scallop_height_mm": 0.02})).await.ok(), named, "{path}");
        assert_ne!(of(json!({"scallop_tolerance_mm": 1.5})).await.ok(), named, "{path}");
        let both = of(json!({"scallop_tolerance_mm": 0.02, "scallop_height_mm": 0.02})).await;
        assert_eq!(both.faults(), (422, vec![("/scallop_height_mm", "conflicting-fields")]), "{path}");
        let neither = of(json!({})).await;
        assert_eq!(neither.faults(), (422, vec![("/scallop_tolerance_mm", "missing-field")]), "{path}");
        let with_roughness = of(json!({"scallop_height_mm": 0.02, "roughness": {"ra_um": 1}})).await;
        assert_eq!(with_roughness.faults(), (422, vec![("/roughness", "conflicting-fields")]), "{path}");
    }
}
