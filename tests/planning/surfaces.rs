//! `POST /v1/cutter-recommendation` by method `surface` on realistic parts: pockets, several pieces, turned and refined
//! surfaces, large files, several libraries, and the passes against the part as a solid.

use crate::app::{TestApp, figure, warnings};
use crate::planning::wavy::{self, COLUMNS, ROWS, triangles};
use crate::planning::{job, with};
use crate::writers::{binary_stl, exact, facets_of, obj, ply, three_mf, zip};
use approx::assert_relative_eq;
use serde_json::{Value, json};

/// The published cutters, simulated in these directions.
fn in_directions(directions: &[f64]) -> Value {
    with(job(), json!({"method": "surface", "directions_deg": directions}))
}

fn ball(diameter: f64) -> Value {
    json!({"name": format!("B{diameter}"), "type": "ball_end", "diameter_mm": diameter})
}

/// A grid of `rows` x `columns` nodes over parameters from 0 to 1.
fn grid(rows: u32, columns: u32, at: impl Fn(f64, f64) -> [f64; 3]) -> Value {
    let node = |row: u32, column: u32| at(f64::from(column) / f64::from(columns - 1), f64::from(row) / f64::from(rows - 1));
    let points: Vec<_> =
        (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))).map(|(row, column)| node(row, column)).collect();
    json!({"surface": {"grid": {"rows": rows, "columns": columns, "points": points}}})
}

/// A surface of 40 x 25 mm with waves along Y.
fn waves([u, v]: [f64; 2]) -> [f64; 3] {
    let (x, y) = (40.0 * u, 25.0 * v);
    [x, y, 0.3 * y + 0.8 * (0.2 * y).sin() + 0.1 * x]
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_way_lifts_after_every_pass_and_takes_longer() {
    let app = TestApp::start().await;
    let surface = with(in_directions(&[0.0]), grid(26, 41, |u, v| waves([u, v])));
    let zigzag = app.recommend(&surface).await.ok();
    let one_way = app.recommend(&with(surface, json!({"pattern": "one_way"}))).await.ok();
    for place in 0..2 {
        let links = one_way.pointer(&format!("/candidates/{place}/links")).unwrap();
        assert_eq!(links["lifts"], links["count"]);
        assert!(figure(links, "/count") > 10.0);
    }
    assert!(figure(&one_way, "/recommended/machining_time_s") > 1.2 * figure(&zigzag, "/recommended/machining_time_s"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn turning_the_part_about_z_turns_the_direction() {
    let app = TestApp::start().await;
    // So low that one line of about a hundred matters little: a turned part may need one more.
    let request = with(
        job(),
        json!({"method": "surface", "scallop_height_mm": 0.002,
            "cutters": [{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}]}),
    );
    let turned = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let at = move |u, v| {
            let [x, y, z] = waves([u, v]);
            [cos * x - sin * y, sin * x + cos * y, z]
        };
        with(request.clone(), grid(31, 51, at))
    };
    let (straight, oblique) = (app.recommend(&turned(0.0)).await.ok(), app.recommend(&turned(25.0)).await.ok());
    let direction = |answer: &Value| figure(answer, "/recommended/direction_deg");
    let turned = (direction(&oblique) - direction(&straight)).rem_euclid(180.0);
    // Directions are found to half a degree, because times hardly vary near the best.
    assert!((turned - 25.0).abs() < 4.0, "{straight:#} {oblique:#}");
    assert_relative_eq!(
        figure(&oblique, "/recommended/machining_time_s"),
        figure(&straight, "/recommended/machining_time_s"),
        max_relative = 0.02
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn refining_a_patch_converges() {
    const HEIGHT: f64 = 0.05;
    let app = TestApp::start().await;
    let patch: Value = serde_json::from_str(include_str!("../../examples/surface_2.json")).unwrap();
    let mut times = Vec::new();
    for samples in [20, 40, 80] {
        let surface = with(patch["surface"].clone(), json!({"samples": samples}));
        let request = with(in_directions(&[0.0, 90.0]), json!({"surface": surface, "scallop_height_mm": HEIGHT}));
        let answer = app.recommend(&request).await.ok();
        times.push([0, 1].map(|place| figure(&answer, &format!("/candidates/{place}/machining_time_s"))));
    }
    // The path is milled on the facets. Those of 3 mm are up to 3^2/(8 x 50) = 0.022 mm from the patch with its radii of 50 mm
    // and more, half of them a quarter; spacings, and with them times, go with the square root of the height. One line more or
    // less is 1 in 40.
    for (place, sagitta) in [(0, 0.022), (1, 0.0055)] {
        for (coarse, fine) in times[place].iter().zip(&times[place + 1]) {
            assert_relative_eq!(*coarse, *fine, max_relative = 0.5 * sagitta / HEIGHT + 1.0 / 40.0);
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn two_pieces_side_by_side_take_the_sum_of_their_runs_and_one_lift() {
    let app = TestApp::start().await;
    let nodes = wavy::nodes([1.5, 1.25], [0.25, 0.2]);
    let mut points: Vec<_> = nodes.into_iter().map(exact).collect();
    let mut triangles = triangles();
    let mesh = |points: &[[f64; 3]], triangles: &[[usize; 3]]| json!({"surface": {"mesh": {"points": points, "triangles": triangles}}});
    let one = app.recommend(&with(in_directions(&[0.0]), mesh(&points, &triangles))).await.ok();
    let count = points.len();
    points.extend(points.clone().into_iter().map(|[x, y, z]| [x + 80.0, y, z]));
    triangles.extend(triangles.clone().into_iter().map(|corners| corners.map(|corner| corner + count)));
    let both = app.recommend(&with(in_directions(&[0.0]), mesh(&points, &triangles))).await.ok();
    assert_eq!((&one["surface"]["pieces"], &both["surface"]["pieces"]), (&json!(1), &json!(2)));
    assert_eq!(both["candidates"][0]["links"]["lifts"], 1);
    let lift = figure(&both, "/recommended/machining_time_s") - 2.0 * figure(&one, "/recommended/machining_time_s");
    // Some 60 mm across and twice 15 mm of height.
    assert!(lift > 0.3 && lift < 5.0, "{lift}");
    let codes: Vec<_> = both["confidence"]["reasons"].as_array().unwrap().iter().map(|reason| &reason["code"]).collect();
    assert!(codes.contains(&&json!("several-pieces")), "{codes:?}");
}

/// A pocket of 30 x 30 mm with corners of 6 mm, 6 mm deep, in a plate of 40 x 40 mm; fillets of 3 mm between floor and
/// walls.
fn pocket(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = (40.0 * u - 20.0, 40.0 * v - 20.0);
    let (dx, dy) = (x.abs() - 9.0, y.abs() - 9.0);
    // The distance from the wall, positive inside.
    let inside = 6.0 - dx.max(0.0).hypot(dy.max(0.0)) - dx.max(dy).min(0.0);
    let z = if inside <= 0.0 {
        6.0
    } else if inside < 3.0 {
        3.0 - (9.0 - (3.0 - inside).powi(2)).sqrt()
    } else {
        0.0
    };
    [x, y, z]
}

/// A plate of `length` x `length`/2 with ten slots 5 mm deep.
fn slotted(length: f64, slot: f64) -> Value {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let pitch = length / 10.0;
    for number in 0..10 {
        let [start, wall, end] = [0.0, pitch - slot, pitch].map(|x| pitch * f64::from(number) + x);
        for (from, to) in [([start, 0.0], [wall, 0.0]), ([wall, 0.0], [wall, -5.0]), ([wall, -5.0], [end, -5.0]), ([end, -5.0], [end, 0.0])]
        {
            let first = points.len();
            points.extend([(from, 0.0), (to, 0.0), (to, 0.5 * length), (from, 0.5 * length)].map(|([x, z], y)| [x, y, z]));
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    json!({"surface": {"mesh": {"points": points, "triangles": triangles}}})
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn slots_narrower_than_the_cutter_are_uncut_on_large_plates_too() {
    let app = TestApp::start().await;
    for length in [100.0, 500.0, 1000.0] {
        // The larger cutter does not fit into the slots of 4 mm, the last of which has a wall at the border of the plate.
        for (diameter, height, slots) in [(6, 5.0, 10.0 * 4.0 / length), (3, 0.0, 0.0)] {
            let alone = json!({"cutters": [{"type": "flat_end", "diameter_mm": diameter}], "max_uncut_share": 1, "include": ["map"]});
            let answer = app.recommend(&with(with(in_directions(&[90.0]), slotted(length, 4.0)), alone)).await.ok();
            assert_eq!(answer["surface"]["visible_area_share"], 1.0);
            let map: Vec<Option<f64>> = serde_json::from_value(answer["map"]["uncut_mm"].clone()).unwrap();
            let largest = map.iter().flatten().copied().fold(0.0, f64::max);
            assert!((largest - height).abs() < 1e-6, "{length}, {diameter}: {largest}");
            // The share of 20,000 random places has a standard error of 1/sqrt(20,000 x 0.04) = 3.5 % at most.
            let candidate = &answer["candidates"][0];
            let share = figure(candidate, "/uncut_share");
            assert!((share - slots).abs() <= 0.1 * slots, "{length}, {diameter}: {share} of {slots}");
            assert!((figure(candidate, "/uncut_height_mm") - height).abs() < 1e-6, "{length}, {diameter}: {candidate:#}");
        }
    }
}

/// One request says where every cutter does not fit into slots, ranked or not.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_request_has_the_maps_of_all_cutters_ranked_or_not() {
    let app = TestApp::start().await;
    let flat = |diameter: f64| json!({"type": "flat_end", "diameter_mm": diameter});
    let request = with(with(in_directions(&[90.0]), slotted(100.0, 4.0)), json!({"cutters": [flat(6.0), flat(3.0), flat(2.5)]}));
    let of = async |include: Value| app.recommend(&with(request.clone(), json!({"include": include}))).await.ok();
    let all = of(json!(["maps"])).await;
    assert_eq!((&all["recommended"]["cutter"], &all["not_ranked"][0]["cutter"]), (&json!(1), &json!(0)));
    // The map is that of the fastest, whether the others are asked for or not.
    let alone = of(json!(["map"])).await;
    assert_eq!((&alone["map"], alone.get("maps")), (&all["map"], None));
    let maps = all["maps"].as_array().unwrap();
    assert_eq!(maps.iter().map(|map| map["cutter"].as_u64().unwrap()).collect::<Vec<_>>(), [2, 0]);
    let heights = |map: &Value, name: &str| -> Vec<Option<f64>> { serde_json::from_value(map[name].clone()).unwrap() };
    // The largest stands on the slots' edges, 5 mm over their floors; on the plate between them it fits, and the smallest everywhere.
    // But for their ends, which are open: from beside them it reaches 0.76 mm into each, 2.1 mm^2.
    let open_ends = 20.0 * (9.0 * (2.0_f64 / 3.0).asin() - 2.0 * 5.0_f64.sqrt()) / (100.0 * 50.0);
    for (map, over_slots, reached) in [(&maps[0], 0.0, 0.0), (&maps[1], 5.0, open_ends)] {
        let (heights_of_part, uncut) = (heights(&all["map"], "z_mm"), heights(map, "uncut_mm"));
        let machined: Vec<(f64, f64)> = heights_of_part.iter().zip(&uncut).filter_map(|(z, uncut)| Some(((*z)?, (*uncut)?))).collect();
        // Cells on walls are not machined.
        assert!(machined.len() * 10 > heights_of_part.iter().flatten().count() * 9, "{}", machined.len());
        assert!(machined.iter().any(|(z, _)| *z < -1.0));
        let is_right = |(z, uncut): &&(f64, f64)| (uncut - if *z < -1.0 { over_slots } else { 0.0 }).abs() < 1e-6;
        let wrong = machined.len() - machined.iter().filter(is_right).count();
        #[expect(clippy::cast_precision_loss, reason = "thousands")]
        let share = wrong as f64 / machined.len() as f64;
        assert!((share - reached).abs() < 1e-3, "{share} {reached}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_a_library_of_50_only_cutters_that_fit_the_pocket_are_ranked() {
    let app = TestApp::start().await;
    let surface = grid(161, 161, pocket);
    // The top of the fillet is left out: between nodes 0.25 mm apart the wall is inclined, and a ball that just fits
    // would not reach the fillet.
    let select = json!({"select": {"slope_deg": [0, 50]}, "max_uncut_share": 0.02});
    let request = with(with(in_directions(&[0.0]), surface), select);
    let two = app.recommend(&with(request.clone(), json!({"cutters": [ball(10.0), ball(4.0)]}))).await.ok();
    assert_eq!(two["recommended"]["name"], "B4");
    assert_eq!((&two["not_ranked"][0]["name"], &two["not_ranked"][0]["code"]), (&json!("B10"), &json!("cannot-reach")));
    // 25 cutters up to 4 mm, 25 from 8 mm on.
    let diameters = (0..25).map(|index| 1.6 + 0.1 * f64::from(index)).chain((0..25).map(|index| 8.0 + 0.5 * f64::from(index)));
    let cutters: Vec<_> = diameters.map(ball).collect();
    let answer = app.recommend(&with(request, json!({"cutters": cutters}))).await.ok();
    let (ranked, not_ranked) = (answer["candidates"].as_array().unwrap(), answer["not_ranked"].as_array().unwrap());
    assert_eq!((ranked.len(), not_ranked.len()), (25, 25));
    assert!(not_ranked.iter().all(|cutter| cutter["code"] == "cannot-reach" && cutter["cutter"].as_u64().unwrap() >= 25), "{not_ranked:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn several_libraries_and_a_zip_of_them_join() {
    let app = TestApp::start().await;
    let freecad = |name: &str| {
        format!(r#"{{"version": 2, "name": "{name}", "shape": "ballend.fcstd", "parameter": {{"Diameter": "6,00 mm", "Flutes": "2"}}}}"#)
    };
    let [first, second] = ["F1", "F2"].map(freecad);
    let libraries = zip(&[("Bit/first.fctb", first.as_bytes()), ("Bit/second.fctb", second.as_bytes())]);
    let table = b"name,type,diameter_mm,corner_radius_mm\nT8,toroidal,8,2\n".to_vec();
    let mut parameters = in_directions(&[0.0]);
    parameters["cutters"] = json!([ball(5.0)]);
    let surface = obj(&wavy::nodes([1.5, 1.25], [0.25, 0.2]), &triangles()).into_bytes();
    let parts = [("library", libraries), ("surface", surface), ("library", table), ("parameters", parameters.to_string().into_bytes())];
    let answer = app.upload_parts(parts).await.ok();
    let mut names: Vec<_> = answer["candidates"].as_array().unwrap().iter().map(|candidate| candidate["name"].as_str().unwrap()).collect();
    names.sort_unstable();
    assert_eq!(names, ["B5", "F1", "F2", "T8"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_file_of_more_facets_than_are_held_is_merged() {
    let app = TestApp::start().await;
    // 2 x 501^2 = 502,002 facets of 0.05 mm.
    let count = 502_u16;
    let row = |row: u16| (0..count).map(move |column| [f32::from(column) * 0.05, f32::from(row) * 0.05, f32::from(row) * 0.02]);
    let nodes: Vec<[f32; 3]> = (0..count).flat_map(row).collect();
    let number = |row: usize, column: usize| row * usize::from(count) + column;
    let quads = (1..usize::from(count)).flat_map(|row| (1..usize::from(count)).map(move |column| (row, column)));
    let triangles: Vec<[usize; 3]> = quads
        .flat_map(|(row, column)| {
            let [a, b, c, d] = [number(row - 1, column - 1), number(row - 1, column), number(row, column), number(row, column - 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let request = with(in_directions(&[0.0]), json!({"cutters": [ball(10.0)]}));
    let merged = app.upload(binary_stl("fine", &facets_of(&nodes, &triangles)), &request).await.ok();
    assert_eq!(warnings(&merged), ["facets-merged"]);
    let corners = json!({"surface": {"grid": {"rows": 2, "columns": 2,
        "points": [[0, 0, 0], [25.05, 0, 0], [0, 25.05, 10.02], [25.05, 25.05, 10.02]]}}});
    let plane = app.recommend(&with(request, corners)).await.ok();
    // The lattice loses up to a cell, 1/16 mm, at each border.
    assert_relative_eq!(
        figure(&merged, "/recommended/machining_time_s"),
        figure(&plane, "/recommended/machining_time_s"),
        max_relative = 0.03
    );
}

/// The height of a cutter's bottom above its tip at the distance d from the axis, for the radii R and r; `None` beyond
/// R.
fn bottom(d: f64, [outer, corner]: [f64; 2]) -> Option<f64> {
    let over = (d - (outer - corner)).max(0.0);
    (over <= corner).then(|| corner - (corner * corner - over * over).max(0.0).sqrt())
}

/// Asserts that no tip cuts deeper into the facets than the tolerance, and that each touches them at its stated contact, but
/// for the chords between tips.
fn assert_tips_rest_on(answer: &Value, facets: &[[[f64; 3]; 3]], radii: [f64; 2], tolerance: f64) {
    let column = |name: &str| answer["passes"][name].as_array().unwrap().clone();
    let point = |value: &Value| [0, 1, 2].map(|axis| value[axis].as_f64().unwrap());
    // Points of every facet: its corners, and 21 inside.
    let places: Vec<[f64; 3]> = facets
        .iter()
        .flat_map(|[a, b, c]| {
            let weights = (0..=5_u8).flat_map(|i| (0..=5 - i).map(move |j| (f64::from(i) / 5.0, f64::from(j) / 5.0)));
            weights.map(move |(u, v)| [0, 1, 2].map(|axis| a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis])))
        })
        .collect();
    let (tips, contacts) = (column("tip_mm"), column("contact_mm"));
    assert!(tips.len() > 50);
    let (mut deepest, mut farthest) = (0.0_f64, 0.0_f64);
    for (tip, contact) in tips.iter().zip(&contacts).step_by(3) {
        let tip = point(tip);
        for place in &places {
            let d = (place[0] - tip[0]).hypot(place[1] - tip[1]);
            if let Some(height) = bottom(d, radii) {
                deepest = deepest.max(place[2] - tip[2] - height);
            }
        }
        if !contact.is_null() {
            let contact = point(contact);
            let d = (contact[0] - tip[0]).hypot(contact[1] - tip[1]);
            farthest = farthest.max((bottom(d.min(radii[0]), radii).unwrap() + tip[2] - contact[2]).abs());
        }
    }
    println!("deepest {deepest:.5} mm, farthest from its contact {farthest:.2e} mm");
    assert!(deepest <= tolerance && farthest < 1e-6, "{deepest} {farthest}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_tips_of_passes_touch_the_part_without_cutting_into_it_in_every_format() {
    let app = TestApp::start().await;
    let (nodes, triangles) = (wavy::nodes([0.6, 0.5], [0.25, 0.2]), triangles());
    let facets: Vec<_> = facets_of(&nodes, &triangles).into_iter().map(|facet| facet.map(exact)).collect();
    let cutter = json!({"type": "toroidal", "diameter_mm": 6, "corner_radius_mm": 1});
    let request = with(in_directions(&[0.0]), json!({"cutters": [cutter], "include": ["passes"]}));
    for file in [
        binary_stl("a surface", &facets_of(&nodes, &triangles)),
        obj(&nodes, &triangles).into_bytes(),
        ply("binary_little_endian", &nodes, &triangles),
        three_mf("millimeter", &nodes, &triangles),
    ] {
        let answer = app.upload(file, &request).await.ok();
        assert_eq!(figure(&answer, "/surface/facets").to_bits(), 384.0_f64.to_bits());
        assert_tips_rest_on(&answer, &facets, [3.0, 1.0], 0.01);
    }
    assert_eq!(facets.len(), 2 * (ROWS - 1) * (COLUMNS - 1));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_tips_of_passes_on_the_example_file_do_not_gouge() {
    let app = TestApp::start().await;
    let file = include_bytes!("../../examples/surface_2.stl");
    let number = |bytes: &[u8]| f64::from(f32::from_le_bytes(bytes.try_into().unwrap()));
    let corner = |bytes: &[u8]| [0, 4, 8].map(|at| number(&bytes[at..at + 4]));
    let facets: Vec<_> = file[84..].chunks_exact(50).map(|facet| [12, 24, 36].map(|at| corner(&facet[at..at + 12]))).collect();
    let request = with(in_directions(&[30.0]), json!({"cutters": [ball(10.0)], "include": ["passes"]}));
    let answer = app.upload(file.to_vec(), &request).await.ok();
    assert_tips_rest_on(&answer, &facets, [5.0, 5.0], 0.01);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn all_faults_of_a_selection_are_listed_with_either_method() {
    let app = TestApp::start().await;
    let surface = grid(5, 5, |u, v| waves([u, v]));
    let select = json!({"select": {"slope_deg": [60, 20], "box_mm": {"min": [1, 1, 1], "max": [0, 0, 0]}, "pieces": []}});
    let refused = app.recommend(&with(with(in_directions(&[0.0]), surface.clone()), select)).await;
    let (status, faults) = refused.faults();
    let pointers: Vec<_> = faults.into_iter().map(|(pointer, _)| pointer).collect();
    assert_eq!((status, pointers.len()), (422, 3), "{}", refused.body);
    assert!(["/select/slope_deg", "/select/box_mm", "/select/pieces"].iter().all(|pointer| pointers.contains(pointer)), "{pointers:?}");
    for method in ["surface", "rectangle"] {
        let unknown = with(with(job(), surface.clone()), json!({"method": method, "select": {"pieces": [7]}}));
        assert_eq!(app.recommend(&unknown).await.faults(), (422, vec![("/select/pieces", "out-of-range")]), "{method}");
    }
}
