//! `POST /v1/path-check` and its upload: what a path leaves on a surface.

use crate::app::{TestApp, figure};
use crate::planning::with;
use crate::writers::binary_stl;
use approx::assert_relative_eq;
use serde_json::{Value, json};

const PATH_CHECK: &str = "/v1/path-check";

/// A plate of 20 x 12 mm at z = 0.
fn plate() -> Value {
    let points = json!([[0, 0, 0], [20, 0, 0], [20, 12, 0], [0, 12, 0]]);
    json!({"surface": {"mesh": {"points": points, "triangles": [[0, 1, 2], [0, 2, 3]]}}})
}

fn ball() -> Value {
    json!({"cutter": {"type": "ball_end", "diameter_mm": 6}, "scallop_height_mm": 0.01, "machine": {"preset": "five_axis_vmc"}})
}

/// The tips of a zigzag over the plate and 4 mm beyond it, `spacing` apart.
fn zigzag(spacing: f64) -> Vec<[f64; 3]> {
    let mut tips = Vec::new();
    let mut y = -4.0;
    while y < 16.0 {
        let ends = if tips.len() % 4 == 0 { [-4.0, 24.0] } else { [24.0, -4.0] };
        tips.extend(ends.map(|x| [x, y, 0.0]));
        y += spacing;
    }
    tips
}

fn program_of(tips: &[[f64; 3]]) -> String {
    let cuts: Vec<String> = tips.iter().skip(1).map(|[x, y, z]| format!("G1 X{x:.6} Y{y:.6} Z{z:.6}")).collect();
    let [x, y, z] = tips[0];
    format!("%\nG21 G90\nT1 M6\nG0 X{x} Y{y} Z20\nG1 Z{z} F3000\n{}\nG0 Z20\nM30\n%\n", cuts.join("\n"))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ridges_on_a_plate_have_the_height_of_the_closed_form() {
    let app = TestApp::start().await;
    let spacing: f64 = 0.5;
    let tips = zigzag(spacing);
    let answer = app.answer(PATH_CHECK, &with(with(plate(), ball()), json!({"path": {"tip_mm": tips}}))).await;
    let radius: f64 = 3.0;
    let ridge = radius - (radius * radius - spacing * spacing / 4.0).sqrt();
    assert_relative_eq!(figure(&answer, "/residual_mm/max"), ridge, max_relative = 1e-3);
    // The share of places beyond the offset at which the arc is at 10.2 um.
    let over = 1.0 - 2.0 * (radius * radius - (radius - 0.0102_f64).powi(2)).sqrt() / spacing;
    assert!((figure(&answer, "/over_tolerance_share") - over).abs() < 4.0 * figure(&answer, "/standard_error/over_tolerance_share"));
    assert_relative_eq!(figure(&answer, "/reachable_over_tolerance_share"), figure(&answer, "/over_tolerance_share"));
    assert!(figure(&answer, "/gouge/depth_mm") < 1e-9 && figure(&answer, "/uncut_share") <= 0.0);
    let length: f64 = tips.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum();
    assert_relative_eq!(figure(&answer, "/cutting_length_mm"), length, max_relative = 1e-12);
    // At the machine's feed rate, from rest to rest.
    assert!(figure(&answer, "/machining_time_s") > length / 5000.0 * 60.0);
    assert_eq!(answer["moves"], tips.len() - 1);
    assert_eq!(answer["places"][0]["code"], "over-tolerance");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_program_in_a_file_has_the_figures_of_its_points() {
    let app = TestApp::start().await;
    let tips = zigzag(0.7);
    let points = app.answer(PATH_CHECK, &with(with(plate(), ball()), json!({"path": {"tip_mm": tips, "feed_rate_mm_min": 3000}}))).await;
    let inline = app.answer(PATH_CHECK, &with(with(plate(), ball()), json!({"path": {"program": program_of(&tips)}}))).await;
    let corners: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [20.0, 12.0, 0.0], [0.0, 12.0, 0.0]];
    let stl = binary_stl("plate", &[[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]);
    let parts = [("surface", stl), ("path", program_of(&tips).into_bytes()), ("parameters", ball().to_string().into_bytes())];
    let file = app.post_parts("/v1/path-check/upload", parts).await.ok();
    for answer in [&inline, &file] {
        for pointer in ["/residual_mm/p50", "/residual_mm/p99", "/over_tolerance_share", "/uncut_share"] {
            assert_relative_eq!(figure(answer, pointer), figure(&points, pointer), max_relative = 1e-6, epsilon = 1e-9);
        }
    }
    // Down and up again.
    assert_relative_eq!(figure(&file, "/cutting_length_mm"), figure(&points, "/cutting_length_mm") + 20.0, max_relative = 1e-9);
    assert_relative_eq!(figure(&file, "/rapid_length_mm"), 20.0, max_relative = 1e-9);
    assert!(file["places"][0]["line"].is_number(), "{}", file["places"][0]);
    assert_eq!(points["places"][0].get("line"), None);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn cuts_into_the_part_are_found_with_their_lines() {
    let app = TestApp::start().await;
    let program = "G21 G90\nG0 X-5 Y6 Z5\nG1 Z0 F2000\nX8\nX12 Z-0.05\nX25\nG0 Z5\nX10 Y2\nZ-0.3\nZ5";
    let answer = app.answer(PATH_CHECK, &with(with(plate(), ball()), json!({"path": {"program": program}}))).await;
    assert_relative_eq!(figure(&answer, "/gouge/depth_mm"), 0.05, max_relative = 1e-4);
    assert_relative_eq!(figure(&answer, "/gouge/rapid_depth_mm"), 0.3, max_relative = 1e-3);
    let worst = |code: &str| answer["places"].as_array().unwrap().iter().find(|place| place["code"] == code).unwrap().clone();
    assert_eq!(worst("collision")["line"], 9);
    assert!([5, 6].contains(&worst("gouge")["line"].as_u64().unwrap()));
    assert_eq!(worst("uncut").get("value_mm"), None);
    // The same path, stated by the ball's centre.
    let raised = program.replace("Z-0.3", "Z2.7").replace("Z-0.05", "Z2.95").replace("Z0 ", "Z3 ").replace("Z5", "Z8");
    let centre = app.answer(PATH_CHECK, &with(with(plate(), ball()), json!({"path": {"program": raised}, "tip": "centre"}))).await;
    assert_relative_eq!(figure(&centre, "/gouge/depth_mm"), 0.05, max_relative = 1e-4);
}

/// The figures of a plan are those that the check of its passes finds, at other places.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_passes_of_a_plan_leave_what_the_plan_states() {
    let app = TestApp::start().await;
    let points: Vec<[f64; 3]> = (0..31_u8)
        .flat_map(|row| (0..41_u8).map(move |column| [f64::from(column), f64::from(row)]))
        .map(|[x, y]| [x, y, 0.02 * (x - 20.0).powi(2) - 0.01 * (y - 15.0).powi(2)])
        .collect();
    let surface = json!({"surface": {"grid": {"rows": 31, "columns": 41, "points": points}}});
    let cutter = json!({"type": "toroidal", "diameter_mm": 8, "corner_radius_mm": 2});
    let job = json!({"cutters": [cutter], "scallop_height_mm": 0.01, "machine": {"preset": "five_axis_vmc"}, "include": ["passes"], "max_uncut_share": 1, "directions_deg": [20]});
    let plan = app.recommend(&with(surface.clone(), job)).await.ok();
    let passes = &plan["passes"];
    let rapid: Vec<usize> = passes["move"]
        .as_array()
        .unwrap()
        .iter()
        .enumerate()
        .skip(1)
        .filter(|(_, kind)| **kind == "rapid")
        .map(|(index, _)| index)
        .collect();
    let path = json!({"path": {"tip_mm": passes["tip_mm"], "rapid": rapid, "feed_rate_mm_min": passes["feed_rate_mm_min"]}});
    let machine = json!({"cutter": cutter, "scallop_height_mm": 0.01, "machine": {"preset": "five_axis_vmc"}});
    let check = app.answer(PATH_CHECK, &with(with(surface, machine), path)).await;
    let candidate = &plan["candidates"][0];
    let difference = figure(&check, "/reachable_over_tolerance_share") - figure(candidate, "/over_tolerance_share");
    assert!(difference.abs() < 0.005, "{difference}: {check:#}");
    // What the cutter cannot reach.
    let beyond = figure(&check, "/over_tolerance_share") - figure(&check, "/reachable_over_tolerance_share");
    assert!((beyond - figure(candidate, "/uncut_share")).abs() < 0.01, "{beyond}: {candidate:#}");
    let median = figure(&check, "/residual_mm/p50");
    assert!((median / figure(candidate, "/scallop_height_mm/p50") - 1.0).abs() < 0.05, "{median}: {candidate:#}");
    assert!(figure(&check, "/gouge/depth_mm") < 0.004 && figure(&check, "/gouge/rapid_depth_mm") < 1e-9);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faults_of_paths_have_their_places() {
    let app = TestApp::start().await;
    let cases = [
        (json!({}), "/path", "missing-field"),
        (json!({"program": "G21 G90\nG0 X0 Y0 Z0\nG1 X1 F100", "tip_mm": [[0, 0, 0], [1, 0, 0]]}), "/path", "conflicting-fields"),
        (json!({"program": "G0 X0 Y0 Z5\nG41 D1 X1"}), "/path/program", "faulty-program"),
        (json!({"tip_mm": [[0, 0, 0], [1, 0, 0]], "rapid": [2]}), "/path/rapid", "out-of-range"),
        (json!({"tip_mm": [[0, 0, 0], [1, 0, 0]], "feed_rate_mm_min": [1, 2, 3]}), "/path/feed_rate_mm_min", "wrong-count"),
        (json!({"tip_mm": [[0, 0, 0], [1, 0]]}), "/path/tip_mm/1", "wrong-type"),
        (json!({"program": "T1 M6\nG0 X0 Y0 Z5\nG1 Z0 F100\nT2 M6\nG0 X0 Y0 Z5\nG1 Z0\nX3"}), "/path/program", "faulty-program"),
    ];
    for (path, pointer, code) in cases {
        let answer = app.post(PATH_CHECK, &with(with(plate(), ball()), json!({"path": path.clone()}))).await;
        let (status, faults) = answer.faults();
        assert_eq!(status, 422, "{path}");
        assert!(faults.contains(&(pointer, code)), "{path}: {faults:?}");
    }
    let answer = app.post_parts("/v1/path-check/upload", [("other", b"x".to_vec())]).await;
    let (status, faults) = answer.faults();
    assert_eq!((status, faults.len()), (422, 4), "{faults:?}");
}
