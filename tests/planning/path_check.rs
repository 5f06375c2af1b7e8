//! `POST /v1/path-check` and its upload: what a path leaves on a surface.

use crate::app::{TestApp, figure};
use crate::planning::plan::parts::steps;
use crate::planning::plan::surfaces::Facet;
use crate::planning::solids::mesh;
use crate::planning::with;
use crate::writers::{ascii_stl, binary_stl};
use approx::assert_relative_eq;
use serde_json::{Value, json};
use std::fmt::Write;

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

/// What is left of the area to check is what is seen from above.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_part_of_a_plate_under_a_roof_is_not_checked() {
    let app = TestApp::start().await;
    let points = json!([[0, 0, 0], [20, 0, 0], [20, 12, 0], [0, 12, 0], [8, 0, 9], [20, 0, 9], [20, 12, 9], [8, 12, 9]]);
    let triangles = json!([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
    // On the plate up to the roof's edge.
    let tips: Vec<[f64; 3]> = zigzag(0.2).into_iter().map(|[x, y, z]| [x.min(8.0 - 3.0), y, z]).collect();
    let roofed = json!({"surface": {"mesh": {"points": points, "triangles": triangles}}, "select": {"pieces": [0]}});
    let answer = app.answer(PATH_CHECK, &with(with(roofed, ball()), json!({"path": {"tip_mm": tips}}))).await;
    // The ball leaves its own shape from x = 5 on.
    let over = (8.0 - 5.0 - (9.0 - 2.99_f64.powi(2)).sqrt()) / 8.0;
    assert!((figure(&answer, "/over_tolerance_share") - over).abs() < 0.02, "{answer:#}");
    let reason = &answer["confidence"]["reasons"][0];
    assert_eq!(reason["code"], "hidden-area");
    assert!((figure(reason, "/value") - 0.6).abs() < 0.02, "{reason}");
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
    let (moves, rates) = (vec!["cut"; tips.len()], vec![3000; tips.len()]);
    let passes = json!({"tip_mm": tips, "move": moves, "feed_rate_mm_min": rates, "run_starts": [0], "operation": [0], "normal": []});
    let upload = async |path: String| {
        let stl = binary_stl("plate", &[[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]);
        let parts = [("surface", stl), ("path", path.into_bytes()), ("parameters", ball().to_string().into_bytes())];
        app.post_parts("/v1/path-check/upload", parts).await
    };
    let [alone, in_answer] =
        [upload(passes.to_string()).await.ok(), upload(json!({"passes": passes, "warnings": []}).to_string()).await.ok()];
    assert_eq!(upload("{\"tip_mm\": [".to_owned()).await.faults(), (422, vec![("/path", "faulty-program")]));
    for answer in [&inline, &file, &alone, &in_answer] {
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
    // The median over everything is a higher percentile of what the cutter can reach, which is left lower than the rest.
    let [p50, p90] = ["/scallop_height_mm/p50", "/scallop_height_mm/p90"].map(|percentile| figure(candidate, percentile));
    let expected = p50 + (0.5 / (1.0 - figure(candidate, "/uncut_share")) - 0.5) / 0.4 * (p90 - p50);
    let median = figure(&check, "/residual_mm/p50");
    assert!((median / expected - 1.0).abs() < 0.03, "{median}: {candidate:#}");
    assert!(figure(&check, "/gouge/depth_mm") < 0.004 && figure(&check, "/gouge/rapid_depth_mm") < 1e-9);
}

/// A pocket with vertical walls, 5 mm deep, in a plate.
fn pocket() -> Value {
    mesh(&steps(&[0.0, 4.0, 44.0, 48.0], &[0.0, 4.0, 34.0, 38.0], &[&[5.0; 3], &[5.0, 0.0, 5.0], &[5.0; 3]]))
}

/// The small cutter comes down in a corner that the large one does not fit.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_operation_of_a_plan_has_its_cutter_from_the_clearance_height_on() {
    let app = TestApp::start().await;
    let cutters = [10, 4].map(|diameter| json!({"type": "flat_end", "diameter_mm": diameter}));
    let machine = json!({"scallop_tolerance_mm": 0.01, "machine": {"preset": "five_axis_vmc", "tool_change_s": 1}});
    let several = json!({"cutters": cutters, "operations": {"max": 2}, "max_uncut_share": 0.005, "include": ["passes"]});
    let plan = app.recommend(&with(with(pocket(), machine.clone()), several)).await.ok();
    assert_eq!(plan["passes"]["operation"].as_array().unwrap().last(), Some(&json!(1)), "{:#}", plan["plan"]);
    let check = json!({"path": {"passes": plan["passes"]}, "cutters": {"0": cutters[0], "1": cutters[1]}});
    let answer = app.answer(PATH_CHECK, &with(with(pocket(), machine), check)).await;
    assert!(figure(&answer, "/gouge/depth_mm") < 0.001 && figure(&answer, "/gouge/rapid_depth_mm") < 1e-9, "{:#}", answer["gouge"]);
}

/// A floor of 25 x 20 mm, and beside it a block 8 mm high.
fn block_beside_a_floor() -> Vec<Facet> {
    steps(&[0.0, 25.0, 40.0], &[0.0, 20.0], &[&[0.0], &[8.0]])
}

/// A flat cutter of 6 mm goes 0.5 mm into the block's wall, and up again.
fn into_the_wall() -> Value {
    let cutter =
        json!({"cutter": {"type": "flat_end", "diameter_mm": 6}, "scallop_tolerance_mm": 0.01, "machine": {"preset": "five_axis_vmc"}});
    let tips = json!([[10, -8, 20], [10, -8, 0], [10, 10, 0], [22.5, 10, 0], [22.5, 10, 20]]);
    with(cutter, json!({"path": {"tip_mm": tips, "rapid": [0, 4]}}))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn cuts_into_what_is_not_selected_are_found() {
    let app = TestApp::start().await;
    let facets = block_beside_a_floor();
    // The floor alone or everything, with and without the block's top.
    let floor = json!({"select": {"slope_deg": [0, 1], "box_mm": {"min": [-1, -1, -1], "max": [24.9, 21, 1]}}});
    let below_the_top: Vec<Facet> = facets.iter().copied().filter(|facet| facet.iter().any(|corner| corner[2] < 4.0)).collect();
    assert!(below_the_top.len() < facets.len());
    for (part, select) in [(&facets, floor.clone()), (&facets, json!({})), (&below_the_top, floor), (&below_the_top, json!({}))] {
        let answer = app.answer(PATH_CHECK, &with(with(mesh(part), into_the_wall()), select.clone())).await;
        assert_relative_eq!(figure(&answer, "/gouge/depth_mm"), 0.5, epsilon = 1e-4);
        assert_relative_eq!(figure(&answer, "/gouge/rapid_depth_mm"), 0.5, epsilon = 1e-4);
        let codes: Vec<&Value> = answer["places"].as_array().unwrap().iter().map(|place| &place["code"]).collect();
        assert!(codes.contains(&&json!("gouge")) && codes.contains(&&json!("collision")), "{select}: {codes:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn cuts_into_a_surface_to_avoid_are_found_and_what_it_covers_is_not_judged() {
    let app = TestApp::start().await;
    let (block, floor): (Vec<Facet>, Vec<Facet>) =
        block_beside_a_floor().into_iter().partition(|facet| facet.iter().any(|corner| corner[2] > 4.0));
    let request = with(mesh(&floor), into_the_wall());
    let alone = app.answer(PATH_CHECK, &request).await;
    assert!(figure(&alone, "/gouge/depth_mm") < 1e-9 && figure(&alone, "/gouge/rapid_depth_mm") < 1e-9);
    // The block, and a clamp over a fifth of the floor.
    let clamp = steps(&[0.0, 5.0], &[0.0, 20.0], &[&[3.0]]);
    let avoided = [block, clamp].concat();
    let avoid = json!({"avoid": mesh(&avoided)["surface"]});
    let avoiding = app.answer(PATH_CHECK, &with(request, avoid.clone())).await;
    let finished = |answer: &Value, area: f64| area * (1.0 - figure(answer, "/over_tolerance_share"));
    assert!((finished(&avoiding, 400.0) - finished(&alone, 500.0)).abs() < 4.0, "{avoiding:#}");
    // The same as parts of a form, with a facet of it twice.
    let twice = [avoided.clone(), vec![avoided[0]]].concat();
    let upload = async |more: Value| {
        let program = "G21 G90\nG0 X10 Y-8 Z20\nG1 Z0 F1000\nY10\nX22.5\nG0 Z20";
        let mut parameters = with(into_the_wall(), more);
        parameters.as_object_mut().unwrap().remove("path");
        let parts = [("surface", ascii_stl(&floor)), ("avoid", ascii_stl(&twice)), ("path", program.to_owned())];
        let parts = parts.into_iter().chain([("parameters", parameters.to_string())]);
        app.post_parts("/v1/path-check/upload", parts.map(|(name, text)| (name, text.into_bytes()))).await
    };
    let uploaded = upload(json!({"unit": "mm"})).await.ok();
    for answer in [&avoiding, &uploaded] {
        assert_relative_eq!(figure(answer, "/gouge/depth_mm"), 0.5, epsilon = 1e-4);
    }
    let warned = &uploaded["warnings"][0];
    assert_eq!(warned["code"], "duplicate-facets");
    assert!(warned["detail"].as_str().unwrap().starts_with("avoid: "), "{warned}");
    assert_eq!(upload(avoid).await.faults(), (422, vec![("/avoid", "conflicting-fields")]));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn facets_that_are_seen_from_behind_count_as_turned() {
    let app = TestApp::start().await;
    let mut surface = plate();
    surface["surface"]["mesh"]["triangles"][1].as_array_mut().unwrap().reverse();
    let path = json!({"path": {"tip_mm": zigzag(0.5)}, "facing": "any"});
    let [turned, plain] = [&surface, &plate()].map(|surface| with(with(surface.clone(), ball()), path.clone()));
    let [turned, plain] = [app.answer(PATH_CHECK, &turned).await, app.answer(PATH_CHECK, &plain).await];
    assert!(figure(&turned, "/uncut_share") <= 0.0, "{turned:#}");
    assert_relative_eq!(figure(&turned, "/residual_mm/p99"), figure(&plain, "/residual_mm/p99"), max_relative = 0.01);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faults_of_paths_have_their_places() {
    let app = TestApp::start().await;
    let cases = [
        (json!({}), "/path", "missing-field"),
        (json!({"program": "G21 G90\nG0 X0 Y0 Z0\nG1 X1 F100", "tip_mm": [[0, 0, 0], [1, 0, 0]]}), "/path", "conflicting-fields"),
        (json!({"program": "G0 X0 Y0 Z5\nG41 D1 X1"}), "/path/program", "faulty-program"),
        (json!({"tip_mm": [[0, 0, 0], [1, 0, 0]], "rapid": [2]}), "/path/rapid/0", "out-of-range"),
        (json!({"tip_mm": [[0, 0, 0], [1, 0, 0]], "rapid": [7, 0, 9]}), "/path/rapid/2", "out-of-range"),
        (json!({"tip_mm": [[0, 0, 0], [1, 0, 0]], "feed_rate_mm_min": [1, 2, 3]}), "/path/feed_rate_mm_min", "wrong-count"),
        (json!({"tip_mm": [[0, 0, 0], [1, 0]]}), "/path/tip_mm/1", "wrong-type"),
        (json!({"program": "T1 M6\nG0 X0 Y0 Z5\nG1 Z0 F100\nT2 M6\nG0 X0 Y0 Z5\nG1 Z0\nX3"}), "/path", "faulty-program"),
    ];
    for (path, pointer, code) in cases {
        let answer = app.post(PATH_CHECK, &with(with(plate(), ball()), json!({"path": path.clone()}))).await;
        let (status, faults) = answer.faults();
        assert_eq!(status, 422, "{path}");
        assert!(faults.contains(&(pointer, code)), "{path}: {faults:?}");
    }
    // Both surfaces are faulty.
    let (mut faulty, mut on_a_line) = (plate(), plate());
    faulty["surface"]["mesh"]["triangles"] = json!([[0, 1, 7]]);
    on_a_line["surface"]["mesh"]["points"] = json!([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]);
    let more = json!({"path": {"tip_mm": [[0, 0, 0], [1, 0, 0]]}, "avoid": on_a_line["surface"]});
    let answer = app.post(PATH_CHECK, &with(with(faulty, ball()), more)).await;
    let expected = vec![("/surface/mesh/triangles/0/2", "out-of-range"), ("/avoid", "only-degenerate-facets")];
    assert_eq!(answer.faults(), (422, expected));
    let answer = app.post_parts("/v1/path-check/upload", [("other", b"x".to_vec())]).await;
    let (status, faults) = answer.faults();
    assert_eq!((status, faults.len()), (422, 4), "{faults:?}");
}

fn driven_ball() -> Value {
    let cutter = json!({"type": "ball_end", "diameter_mm": 6, "teeth": 2, "spindle_speed_rpm": 6000});
    json!({"cutter": cutter, "scallop_height_mm": 0.01, "machine": {"feed_rate_mm_min": 10_000, "acceleration_m_s2": 5, "jerk_m_s3": 100, "path_tolerance_mm": 0.01}})
}

/// The feed per tooth that a tolerance of 10 um leaves a ball of 6 mm on a plane between passes 0.4 mm apart.
fn feed_of_ball() -> f64 {
    2.0 * (9.0 - 2.99_f64.powi(2) - 0.04).sqrt()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_largest_feeds_are_those_of_the_closed_form_and_written_into_the_program() {
    let app = TestApp::start().await;
    let program = program_of(&zigzag(0.4));
    let job = |program: &str| {
        with(with(plate(), driven_ball()), json!({"path": {"program": program}, "include": ["feeds", "program", "places"]}))
    };
    let answer = app.answer(PATH_CHECK, &job(&program)).await;
    let lines = answer["feeds"]["line"].as_array().unwrap();
    let feeds = answer["feeds"]["feed_per_tooth_mm"].as_array().unwrap();
    let rates = answer["feeds"]["feed_rate_mm_min"].as_array().unwrap();
    assert_eq!((feeds.len(), lines.len()), (rates.len(), rates.len()));
    // Passes over the plate, at y = 0.4 to 11.6.
    let middle: Vec<(f64, f64)> = (24..80).step_by(2).filter_map(|at| Some((feeds[at].as_f64()?, rates[at].as_f64()?))).collect();
    assert!(middle.len() > 20);
    for (feed, rate) in middle {
        assert!(feed <= 1.005 * feed_of_ball() && feed > 0.95 * feed_of_ball(), "{feed} {}", feed_of_ball());
        assert_relative_eq!(rate, feed * 12_000.0, max_relative = 1e-9);
    }
    // The same text but for its feed words.
    let text = answer["program"]["text"].as_str().unwrap();
    assert_eq!(answer["program"]["dialect"], "iso");
    let without = |text: &str| {
        let words = |line: &str| line.split(' ').filter(|word| !word.starts_with('F')).collect::<Vec<_>>().join(" ");
        text.lines().map(words).collect::<Vec<_>>()
    };
    assert_eq!(without(text), without(&program));
    let again = app.answer(PATH_CHECK, &job(text)).await;
    assert!(figure(&again, "/scallop_height_with_marks_mm/p99") <= 0.0101);
    assert_relative_eq!(figure(&again, "/machining_time_s"), figure(&answer, "/feeds/machining_time_s"), max_relative = 0.01);
    assert!(again["places"].as_array().unwrap().iter().all(|place| place["code"] != "feed-too-high"), "{:#}", again["places"]);
    let commented = with(job(&program), json!({"old_feeds_in_comments": true}));
    assert!(app.answer(PATH_CHECK, &commented).await["program"]["text"].as_str().unwrap().contains("(F3000)"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_program_in_klartext_has_the_answer_of_the_same_g_code() {
    let app = TestApp::start().await;
    let klartext_of = |program: &str| {
        let blocks = program.replace("%\nG21 G90\nT1 M6", "BEGIN PGM A MM\n;\nTOOL CALL 1 Z").replace("M30\n%", "M30\nEND PGM A MM");
        let block = |line: &str| match line.split_at_checked(3) {
            Some(("G0 ", axes)) => format!("L {axes} FMAX\n"),
            Some(("G1 ", axes)) => format!("L {axes}\n"),
            _ => format!("{line}\n"),
        };
        blocks.lines().map(block).collect::<String>()
    };
    let program = program_of(&zigzag(0.4));
    let ask = async |text: &str| {
        let job = json!({"path": {"program": text}, "include": ["feeds", "program", "places"]});
        let mut answer = app.answer(PATH_CHECK, &with(with(plate(), driven_ball()), job)).await;
        let program = answer.as_object_mut().unwrap().remove("program").unwrap();
        (answer, program)
    };
    let (of_iso, iso) = ask(&program).await;
    let (of_klartext, klartext) = ask(&klartext_of(&program)).await;
    assert_eq!(of_klartext, of_iso);
    assert_eq!(klartext, json!({"dialect": "klartext", "text": klartext_of(iso["text"].as_str().unwrap())}));
}

/// As a user would: from a plan to its program, one line raised and one feed trebled by hand, and the check names both.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn lines_edited_by_hand_are_named() {
    let app = TestApp::start().await;
    let mut job =
        with(with(plate(), driven_ball()), json!({"include": ["program", "passes"], "directions_deg": [0], "max_uncut_share": 1}));
    let cutter = job.as_object_mut().unwrap().remove("cutter").unwrap();
    let plan = app.recommend(&with(job, json!({"cutters": [cutter]}))).await.ok();
    let check = |text: &str| with(with(plate(), driven_ball()), json!({"path": {"program": text}}));
    let text = plan["program"]["text"].as_str().unwrap().to_owned();
    let sound = app.answer(PATH_CHECK, &check(&text)).await;
    assert_relative_eq!(figure(&sound, "/machining_time_s"), figure(&plan, "/candidates/0/machining_time_s"), max_relative = 0.02);
    let lines: Vec<&str> = text.lines().collect();
    // Long moves along X.
    let mut at = 0.0;
    let mut passes: Vec<usize> = Vec::new();
    for (line, words) in lines.iter().enumerate() {
        let x = words.split(' ').find_map(|word| word.strip_prefix('X')?.parse::<f64>().ok());
        if x.is_some_and(|x: f64| (x - at).abs() > 15.0) && !words.contains('G') {
            passes.push(line);
        }
        at = x.unwrap_or(at);
    }
    assert!(passes.len() > 10, "{text}");
    let (raised, hurried) = (passes[passes.len() / 3], passes[2 * passes.len() / 3]);
    let without = |letter: char, line: &str| line.split(' ').filter(|word| !word.starts_with(letter)).collect::<Vec<_>>().join(" ");
    let edited: Vec<String> = (0..lines.len())
        .map(|at| match at {
            at if at == raised => format!("Z0.2\n{}\nZ0", without('Z', lines[at])),
            at if at == hurried => format!("{} F9999", without('F', lines[at])),
            at if at == hurried + 1 => format!("{} F1000", without('F', lines[at])),
            _ => lines[at].to_owned(),
        })
        .collect();
    let answer = app.answer(PATH_CHECK, &check(&edited.join("\n"))).await;
    let named_in = |answer: &Value, code: &str| -> Vec<u64> {
        let places = answer["places"].as_array().unwrap().iter();
        places.filter(|place| place["code"] == code).filter_map(|place| place["line"].as_u64()).collect()
    };
    let named = |code: &str| named_in(&answer, code);
    // Lines count from 1, and two were added at the first.
    assert!(named("over-tolerance").contains(&(raised as u64 + 2)), "{} {:?}", raised + 2, answer["places"]);
    assert!(named("feed-too-high").contains(&(hurried as u64 + 3)), "{} {:?}", hurried + 3, answer["places"]);
    assert!(named("feed-over-limit").is_empty());
    // A machine of 5000 mm/min, for which the plan itself is too fast as well.
    let slower = with(check(&edited.join("\n")), json!({"machine": {"preset": "five_axis_vmc"}}));
    let over = named_in(&app.answer(PATH_CHECK, &slower).await, "feed-over-limit");
    assert!(over.len() == 2 && over.contains(&(hurried as u64 + 3)), "{over:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn several_tools_are_checked_together() {
    let app = TestApp::start().await;
    let half = |tool: u32, from: f64, to: f64| {
        let mut text = format!("T{tool} M6 S6000 M3\nG0 X{from} Y-4 Z5\nG1 Z0 F2000\n");
        for pass in 0..=40 {
            let y = -4.0 + 0.5 * f64::from(pass);
            let [near, far] = if pass % 2 == 0 { [from, to] } else { [to, from] };
            writeln!(text, "G1 X{near} Y{y}\nX{far}").unwrap();
        }
        text + "G0 Z5\n"
    };
    let program = format!("G21 G90\n{}{}M30\n", half(1, -6.0, 10.0), half(4, 10.0, 26.0));
    let cutters =
        json!({"1": {"type": "ball_end", "diameter_mm": 6, "teeth": 2}, "4": {"type": "ball_end", "diameter_mm": 12, "teeth": 4}});
    let mut job = with(with(plate(), ball()), json!({"path": {"program": program}, "include": ["feeds", "map"]}));
    job.as_object_mut().unwrap().remove("cutter");
    let answer = app.answer(PATH_CHECK, &with(job.clone(), json!({"cutters": cutters}))).await;
    let ridge = |radius: f64| radius - (radius * radius - 0.0625_f64).sqrt();
    assert_relative_eq!(figure(&answer, "/residual_mm/max"), ridge(3.0), max_relative = 2e-3);
    assert!(figure(&answer, "/uncut_share") <= 0.0 && figure(&answer, "/gouge/depth_mm") < 1e-6);
    let map = &answer["map"];
    let [columns, rows] = ["columns", "rows"].map(|name| usize::try_from(map[name].as_u64().unwrap()).unwrap());
    let heights: Vec<f64> = map["scallop_height_mm"].as_array().unwrap().iter().map(|height| height.as_f64().unwrap()).collect();
    assert_eq!(heights.len(), columns * rows);
    let most = |columns_of: std::ops::Range<usize>| {
        (0..rows).flat_map(|row| columns_of.clone().map(move |column| row * columns + column)).map(|at| heights[at]).fold(0.0, f64::max)
    };
    assert!(most(0..columns / 4) <= ridge(3.0) * 1.001 && most(0..columns / 4) > 0.9 * ridge(3.0));
    assert!(most(3 * columns / 4..columns) <= ridge(6.0) * 1.001);
    let of_four = with(job, json!({"cutters": {"4": cutters["4"]}}));
    let answer = app.post(PATH_CHECK, &of_four).await;
    let (status, faults) = answer.faults();
    assert_eq!((status, faults[0]), (422, ("/path", "faulty-program")));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn moves_that_cut_nothing_are_counted() {
    let app = TestApp::start().await;
    let tips = zigzag(0.5);
    let once = app.answer(PATH_CHECK, &with(with(plate(), ball()), json!({"path": {"tip_mm": tips}}))).await;
    let twice: Vec<[f64; 3]> = tips.iter().chain(tips.iter().rev()).copied().collect();
    let answer = app.answer(PATH_CHECK, &with(with(plate(), ball()), json!({"path": {"tip_mm": twice}}))).await;
    let more = figure(&answer, "/idle_length_mm") - figure(&once, "/idle_length_mm");
    let length = figure(&once, "/cutting_length_mm");
    assert!((more / length - 1.0).abs() < 0.05, "{more} of {length}");
    let reasons = answer["confidence"]["reasons"].as_array().unwrap().iter();
    assert_eq!(reasons.map(|reason| reason["code"].as_str().unwrap()).collect::<Vec<_>>(), ["assumed-path-feed", "corners-not-timed"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_control_that_looks_ahead_is_timed_with_its_corners() {
    let app = TestApp::start().await;
    let time = async |machine: Value| {
        let machine = with(json!({"preset": "five_axis_vmc"}), machine);
        let job = with(with(plate(), ball()), json!({"path": {"tip_mm": zigzag(0.5)}, "machine": machine}));
        figure(&app.answer(PATH_CHECK, &job).await, "/machining_time_s")
    };
    let (fine, coarse) = (time(json!({"path_tolerance_mm": 0.002})).await, time(json!({"path_tolerance_mm": 0.1})).await);
    assert!(fine > 1.01 * coarse, "{fine} {coarse}");
    let stopping = time(json!({})).await;
    assert!(stopping > coarse, "{stopping} {coarse}");
    assert_relative_eq!(time(json!({"time_factor": 1.25})).await, 1.25 * stopping, max_relative = 1e-12);
}
