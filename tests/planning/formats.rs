//! One surface in every form in which it can be sent gives one answer.

use crate::app::{TestApp, figure, warnings};
use crate::planning::wavy::{self, COLUMNS, ROWS, triangles};
use crate::planning::{job, with};
use crate::writers::{ascii_stl, binary_stl, exact, facets_of, obj, ply, words};
use approx::assert_relative_eq;
use serde_json::{Value, json};

fn nodes() -> Vec<[f32; 3]> {
    wavy::nodes([3.0, 2.5], [2.0, 0.1])
}

fn lines(separator: &str) -> String {
    nodes().into_iter().map(|node| words(&exact(node), separator) + "\n").collect()
}

/// The corners of each triangle, in double precision.
fn exact_facets(nodes: &[[f32; 3]], triangles: &[[usize; 3]]) -> Vec<[[f64; 3]; 3]> {
    facets_of(nodes, triangles).into_iter().map(|facet| facet.map(exact)).collect()
}

/// Every number of an answer, with its pointer.
fn figures(body: &Value) -> Vec<(String, f64)> {
    fn collect(value: &Value, place: &str, into: &mut Vec<(String, f64)>) {
        match value {
            Value::Object(members) => members.iter().for_each(|(name, value)| collect(value, &format!("{place}/{name}"), into)),
            Value::Array(items) => items.iter().enumerate().for_each(|(index, value)| collect(value, &format!("{place}/{index}"), into)),
            Value::Number(number) => into.push((place.to_owned(), number.as_f64().unwrap())),
            _ => {}
        }
    }
    let mut all = Vec::new();
    collect(body, "", &mut all);
    all
}

#[track_caller]
fn assert_same(one: &Value, other: &Value, tolerance: f64) {
    assert_eq!(one["recommended"]["cutter"], other["recommended"]["cutter"]);
    assert_eq!(one["confidence"]["level"], other["confidence"]["level"]);
    let (one, other) = (figures(one), figures(other));
    assert_eq!(one.len(), other.len());
    assert!(one.len() > 30);
    for ((place, one), (_, other)) in one.into_iter().zip(other) {
        assert_relative_eq!(one, other, max_relative = tolerance, epsilon = 1e-12);
        assert!(one.is_finite(), "{place}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn points_in_every_form_give_the_same_answer() {
    let app = TestApp::start().await;
    let points: Vec<_> = nodes().into_iter().map(exact).collect();
    let expected = app.recommend(&with(job(), json!({"surface": {"points": points}}))).await.ok();
    assert_eq!((&expected["surface"]["source"], figure(&expected, "/surface/points")), (&json!("points"), 221.0));
    let header = "X,Y,Z\r\n".to_owned() + &lines(",").replace('\n', "\r\n");
    let commas = lines(";").replace('.', ",");
    let marked = "\u{feff}# a scan\n".to_owned() + &lines("\t");
    for (file, source) in
        [(lines(","), "text"), (header, "text"), (commas, "text"), (marked, "text"), (lines(" "), "text"), (obj(&nodes(), &[]), "obj")]
    {
        let answer = app.upload(file, &job()).await.ok();
        assert_eq!(answer["surface"]["source"], source);
        // The same numbers in the same order: only the order of sums could differ.
        assert_same(&answer, &expected, 1e-12);
    }
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        assert_same(&app.upload(ply(encoding, &nodes(), &[]), &job()).await.ok(), &expected, 1e-12);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn facets_in_every_form_give_the_same_answer() {
    let app = TestApp::start().await;
    let (nodes, triangles) = (nodes(), triangles());
    let points: Vec<_> = nodes.iter().copied().map(exact).collect();
    let grid = json!({"surface": {"grid": {"rows": ROWS, "columns": COLUMNS, "points": points}}});
    let expected = app.recommend(&with(job(), grid)).await.ok();
    assert_eq!((&expected["surface"]["source"], figure(&expected, "/surface/facets")), (&json!("grid"), 384.0));
    for (file, source) in [
        (ascii_stl(&exact_facets(&nodes, &triangles)).into_bytes(), "stl_ascii"),
        (binary_stl("a surface", &facets_of(&nodes, &triangles)), "stl_binary"),
        (binary_stl("solid in name only", &facets_of(&nodes, &triangles)), "stl_binary"),
        (obj(&nodes, &triangles).into_bytes(), "obj"),
        (ply("ascii", &nodes, &triangles), "ply_ascii"),
        (ply("binary_little_endian", &nodes, &triangles), "ply_little_endian"),
        (ply("binary_big_endian", &nodes, &triangles), "ply_big_endian"),
    ] {
        let answer = app.upload(file, &job()).await.ok();
        assert_eq!(answer["surface"]["source"], source);
        assert!(warnings(&answer).is_empty(), "{}", answer["warnings"]);
        // All hold the same single-precision corners exactly.
        assert_same(&answer, &expected, 1e-12);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_patch_and_the_grid_of_its_points_give_the_same_answer() {
    let app = TestApp::start().await;
    let request: Value = serde_json::from_str(include_str!("../../examples/surface_2.json")).unwrap();
    let patch = app.recommend(&with(request.clone(), json!({"method": "rectangle"}))).await.ok();
    let grid = |nodes: u16| {
        let net = &request["surface"]["bezier"]["control_points"];
        let points: Vec<_> = (0..=nodes)
            .flat_map(|u| (0..=nodes).map(move |v| (u, v)))
            .map(|(u, v)| at(net, f64::from(u) / f64::from(nodes), f64::from(v) / f64::from(nodes)))
            .collect();
        with(job(), json!({"surface": {"grid": {"rows": nodes + 1, "columns": nodes + 1, "points": points}}}))
    };
    let grid = app.recommend(&grid(80)).await.ok();
    assert_eq!(grid["recommended"]["cutter"], patch["recommended"]["cutter"]);
    // A patch gives its samples equal weights, a grid weights its facets by area; the areas in this patch differ by a
    // tenth.
    for pointer in [
        "/critical_slope_deg",
        "/surface/slope_deg",
        "/surface/form_factor",
        "/surface/characteristic_size_mm2",
        "/recommended/machining_time_s",
    ] {
        assert_relative_eq!(figure(&grid, pointer), figure(&patch, pointer), max_relative = 0.02);
    }
    // The area is the same integral: the facets' falls short by the square of their size, some 1e-4.
    assert_relative_eq!(figure(&grid, "/surface/area_mm2"), figure(&patch, "/surface/area_mm2"), max_relative = 2e-4);
}

/// A point of a patch of 4 x 4 control points, by the definition of the Bernstein polynomials.
fn at(net: &Value, u: f64, v: f64) -> [f64; 3] {
    let bernstein = |t: f64| [(1.0 - t).powi(3), 3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t), t.powi(3)];
    let mut point = [0.0; 3];
    for (i, b_u) in bernstein(u).into_iter().enumerate() {
        for (j, b_v) in bernstein(v).into_iter().enumerate() {
            (0..3).for_each(|axis| point[axis] += b_u * b_v * net[i][j][axis].as_f64().unwrap());
        }
    }
    point
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn single_precision_changes_figures_by_a_part_in_a_million() {
    let app = TestApp::start().await;
    // Coordinates that single precision cannot hold: binary STL rounds them to 6e-8 of their magnitude, which is 40 mm.
    let fine: Vec<[f64; 3]> = nodes().into_iter().map(|node| exact(node).map(|c| c * 0.7 + 0.1)).collect();
    let grid = app.recommend(&with(job(), json!({"surface": {"grid": {"rows": ROWS, "columns": COLUMNS, "points": fine}}}))).await.ok();
    #[expect(clippy::cast_possible_truncation, reason = "what is measured here")]
    let rounded: Vec<_> = fine.iter().map(|point| point.map(|c| c as f32)).collect();
    let stl = app.upload(binary_stl("", &facets_of(&rounded, &triangles())), &job()).await.ok();
    for pointer in [
        "/critical_slope_deg",
        "/surface/slope_deg",
        "/surface/form_factor",
        "/surface/characteristic_size_mm2",
        "/recommended/machining_time_s",
        "/surface/area_mm2",
    ] {
        assert_relative_eq!(figure(&stl, pointer), figure(&grid, pointer), max_relative = 1e-6);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn facing_selects_the_side_and_a_warning_states_it() {
    let app = TestApp::start().await;
    let (nodes, triangles) = (nodes(), triangles());
    let up = app.upload(obj(&nodes, &triangles), &job()).await.ok();
    let turned: Vec<_> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let over = app.upload(obj(&nodes, &turned), &job()).await.ok();
    assert_eq!(warnings(&over), ["turned-over"]);
    assert_relative_eq!(figure(&over, "/critical_slope_deg"), figure(&up, "/critical_slope_deg"), max_relative = 1e-12);
    // A surface and its underside, which is left out by default.
    let both = [triangles.clone(), turned].concat();
    let closed = app.upload(obj(&nodes, &both), &job()).await.ok();
    assert_eq!((warnings(&closed), figure(&closed, "/surface/facets")), (vec!["facets-left-out"], 384.0));
    let all = app.upload(obj(&nodes, &both), &with(job(), json!({"facing": "any"}))).await.ok();
    assert_eq!((warnings(&all).len(), figure(&all, "/surface/facets")), (0, 768.0));
    let wall = app.upload("v 0 0 0\nv 30 0 0\nv 30 0 20\nv 0 0 20\nf 1 2 3 4\n", &job()).await.ok();
    assert_eq!((warnings(&wall), figure(&wall, "/surface/slope_deg")), (vec!["walls-only"], 90.0));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn elements_left_out_are_counted_in_a_warning() {
    let app = TestApp::start().await;
    let (nodes, triangles) = (nodes(), triangles());
    let further = lines(",").replace('\n', ",7\n");
    assert_eq!(warnings(&app.upload(further, &job()).await.ok()), ["further-columns"]);
    let trailing = [binary_stl("", &facets_of(&nodes, &triangles)), b"and more".to_vec()].concat();
    let answer = app.upload(trailing, &job()).await.ok();
    assert_eq!(warnings(&answer), ["trailing-bytes"]);
    assert!(answer["warnings"][0]["detail"].as_str().unwrap().starts_with("8 bytes"), "{answer}");
    let degenerate = obj(&nodes, &[triangles.clone(), vec![[0, 0, 1], [5, 6, 6]]].concat());
    let answer = app.upload(degenerate, &job()).await.ok();
    assert_eq!(warnings(&answer), ["degenerate-facets"]);
    let cut = ascii_stl(&exact_facets(&nodes, &triangles)).replace("endsolid surface\n", "");
    assert_eq!(warnings(&app.upload(cut, &job()).await.ok()), ["missing-end"]);
}
