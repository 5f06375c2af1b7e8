//! `POST /v1/cutter-recommendation` by its default method: passes simulated on the surface itself.

use crate::app::{TestApp, figure, warnings};
use crate::planning::wavy::{self, COLUMNS, ROWS, triangles};
use crate::planning::{job, with};
use crate::writers::{binary_stl, exact, facets_of, obj, ply, three_mf};
use approx::assert_relative_eq;
use serde_json::{Value, json};

fn nodes() -> Vec<[f32; 3]> {
    wavy::nodes([1.5, 1.25], [0.25, 0.2])
}

/// The published cutters, simulated in two directions.
fn simulated() -> Value {
    with(job(), json!({"method": "surface", "directions_deg": [0, 90]}))
}

fn grid() -> Value {
    let points: Vec<_> = nodes().into_iter().map(exact).collect();
    json!({"surface": {"grid": {"rows": ROWS, "columns": COLUMNS, "points": points}}})
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_surface_in_every_form_gives_the_same_recommendation() {
    let app = TestApp::start().await;
    let (nodes, triangles) = (nodes(), triangles());
    let points: Vec<_> = nodes.iter().copied().map(exact).collect();
    let expected = app.recommend(&with(simulated(), grid())).await.ok();
    assert_eq!((&expected["method"], &expected["model"]), (&json!("surface"), &json!("envelope")));
    let mut answers = vec![
        app.recommend(&with(simulated(), json!({"surface": {"points": points}}))).await.ok(),
        app.recommend(&with(simulated(), json!({"surface": {"mesh": {"points": points, "triangles": triangles}}}))).await.ok(),
    ];
    for file in [
        binary_stl("a surface", &facets_of(&nodes, &triangles)),
        obj(&nodes, &triangles).into_bytes(),
        ply("binary_little_endian", &nodes, &triangles),
        three_mf("millimeter", &nodes, &triangles),
    ] {
        answers.push(app.upload(file, &simulated()).await.ok());
    }
    for answer in answers {
        assert_eq!(answer["recommended"]["cutter"], expected["recommended"]["cutter"], "{}", answer["surface"]);
        assert_eq!(figure(&answer, "/surface/pieces").to_bits(), 1.0_f64.to_bits());
        for pointer in ["/candidates/0/machining_time_s", "/candidates/1/machining_time_s"] {
            assert_relative_eq!(figure(&answer, pointer), figure(&expected, pointer), max_relative = 0.01);
        }
    }
}

/// A groove of 4 mm radius, 30 deg at its ends, in a plate 64 mm wide.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn grooves_that_the_cutter_does_not_fit_into_count_as_uncut() {
    let row = |y: f64| {
        (0..=320).map(move |step: u32| {
            let x = 0.2 * f64::from(step);
            let from_centre = (x - 32.0).abs();
            let depth = if from_centre < 2.0 { 4.0 - (16.0 - from_centre * from_centre).sqrt() } else { 4.0 - 12_f64.sqrt() };
            json!([x, y, depth])
        })
    };
    let points: Vec<_> = (0..41).flat_map(|number| row(f64::from(number))).collect();
    let app = TestApp::start().await;
    let surface =
        json!({"surface": {"grid": {"rows": 41, "columns": 321, "points": points}}, "directions_deg": [90], "max_uncut_share": 0.1});
    let cutter = |diameter: f64| json!({"cutters": [{"type": "ball_end", "diameter_mm": diameter}]});
    // [what a larger cutter leaves, what the passes leave of what this one reaches, the deepest cut]
    let left = async |diameter: f64| {
        let answer = app.recommend(&with(with(simulated(), surface.clone()), cutter(diameter))).await.ok();
        ["uncut_share", "over_tolerance_share", "gouge_mm"].map(|name| figure(&answer, &format!("/candidates/0/{name}")))
    };
    // The groove is 4 mm of the 64 mm, 0.065 of the area. A ball of 5 mm rests on its edges and stands
    // (4 - sqrt(12)) - (5 - sqrt(21)) = 0.118 mm over its middle.
    let [uncut, over, gouge] = left(10.0).await;
    assert!((0.04..0.07).contains(&uncut) && over < 0.005 && gouge < 0.005, "{uncut} {over} {gouge}");
    let [uncut, over, gouge] = left(4.0).await;
    assert!(uncut + over < 0.005 && gouge < 0.005, "{uncut} {over} {gouge}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn map_and_passes_are_included_on_request() {
    let app = TestApp::start().await;
    let plain = app.recommend(&with(simulated(), grid())).await.ok();
    assert_eq!((plain.get("map"), plain.get("passes")), (None, None));
    let answer = app.recommend(&with(with(simulated(), grid()), json!({"include": ["map", "passes"]}))).await.ok();
    let map = &answer["map"];
    let cells = map["columns"].as_u64().unwrap() * map["rows"].as_u64().unwrap();
    for column in ["z_mm", "slope_deg", "scallop_height_mm", "uncut_mm"] {
        assert_eq!(map[column].as_array().unwrap().len() as u64, cells, "{column}");
        assert!(map[column].as_array().unwrap().iter().any(Value::is_number), "{column}");
    }
    let passes = &answer["passes"];
    let count = passes["tip_mm"].as_array().unwrap().len();
    for column in ["contact_mm", "normal", "step_over_mm", "feed_rate_mm_min", "scallop_height_mm"] {
        assert_eq!(passes[column].as_array().unwrap().len(), count, "{column}");
    }
    assert_eq!(passes["surface_curvature"]["twist_per_mm"].as_array().unwrap().len(), count);
    // Down from the clearance height to the first run.
    assert_eq!((&passes["move"][0], &passes["move"][1], &passes["move"][2]), (&json!("rapid"), &json!("rapid"), &json!("link")));
    assert_eq!(passes["run_starts"][0], 0);
}

/// The program of a plan leaves what its passes leave.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_plan_is_written_as_a_program_that_the_service_reads() {
    let app = TestApp::start().await;
    let cutter = json!({"name": "B8", "type": "ball_end", "diameter_mm": 8, "teeth": 2, "spindle_speed_rpm": 9000});
    let asked = json!({"cutters": [cutter], "include": ["passes", "program"], "max_uncut_share": 1, "program": {"unit": "inch", "number_lines": true, "decimals": 6, "header": ["(part 7)"], "footer": ["G28"], "tool": 12, "coolant": true, "tool_length_offset": true, "origin_mm": [-8, 2.5, 40]}});
    let answer = app.recommend(&with(with(simulated(), grid()), asked)).await.ok();
    let text = answer["program"]["text"].as_str().unwrap();
    let begin: Vec<&str> = text.lines().take(6).collect();
    assert_eq!(begin, ["%", "N10 (part 7)", "N20 G17 G20 G90 G94", "N30 (B8)", "N40 T12 M6", "N50 S9000 M3"]);
    assert!(text.contains(" M8\n") && text.contains(" G28\n") && text.contains(" G43 H12 Z"), "{text}");
    let job = json!({"cutter": {"type": "ball_end", "diameter_mm": 8}, "scallop_height_mm": 0.01, "machine": {"preset": "five_axis_vmc"}});
    let of_program =
        with(with(job.clone(), grid()), json!({"path": {"program": text.replace(" G28\n", " M9\n")}, "origin_mm": [-8, 2.5, 40]}));
    let passes = &answer["passes"];
    let rapid: Vec<usize> = (1..passes["move"].as_array().unwrap().len()).filter(|index| passes["move"][*index] == "rapid").collect();
    let of_tips = with(
        with(job.clone(), grid()),
        json!({"path": {"tip_mm": passes["tip_mm"], "rapid": rapid, "feed_rate_mm_min": passes["feed_rate_mm_min"]}}),
    );
    let of_passes = with(with(job.clone(), grid()), json!({"path": {"passes": passes}}));
    let [program, tips, of_passes] = [
        app.answer("/v1/path-check", &of_program).await,
        app.answer("/v1/path-check", &of_tips).await,
        app.answer("/v1/path-check", &of_passes).await,
    ];
    for member in ["residual_mm", "cutting_length_mm", "machining_time_s", "gouge", "uncut_share"] {
        assert_eq!(of_passes[member], tips[member], "{member}");
    }
    let both = json!({"path": {"passes": passes, "program": "G0 X0 Y0 Z9"}});
    let both = app.post("/v1/path-check", &with(with(job.clone(), grid()), both)).await;
    assert_eq!(both.faults(), (422, vec![("/path", "conflicting-fields")]));
    let mut faulty = passes.clone();
    faulty["move"][3] = json!("jump");
    faulty["operation"].as_array_mut().unwrap().push(json!(0));
    faulty.as_object_mut().unwrap().remove("tip_mm");
    let faulty = app.post("/v1/path-check", &with(with(job.clone(), grid()), json!({"path": {"passes": faulty}}))).await;
    let expected =
        vec![("/path/passes/tip_mm", "missing-field"), ("/path/passes/move/3", "unknown-value"), ("/path/passes/operation", "wrong-count")];
    assert_eq!(faulty.faults(), (422, expected));
    // Coordinates are rounded to 25.4e-6/2 mm.
    for pointer in ["/residual_mm/p50", "/residual_mm/p99"] {
        assert!((figure(&program, pointer) - figure(&tips, pointer)).abs() < 3e-5, "{pointer}");
    }
    assert_relative_eq!(figure(&program, "/cutting_length_mm"), figure(&tips, "/cutting_length_mm"), max_relative = 1e-4);
    assert_relative_eq!(figure(&program, "/rapid_length_mm"), figure(&tips, "/rapid_length_mm"), max_relative = 1e-4);
    // Without its zero point it is not where the part is.
    let misplaced = app.answer("/v1/path-check", &with(of_program, json!({"origin_mm": [0, 0, 0]}))).await;
    assert_eq!(misplaced["confidence"]["reasons"][0]["code"], "path-misplaced", "{}", misplaced["confidence"]);
    assert_eq!(misplaced["confidence"]["level"], "low");
    assert!(!program["confidence"].to_string().contains("path-misplaced"));
    let faulty = json!({"program": {"decimals": 9, "coolant": 1, "header": ["a\nb"], "origin_mm": [0, "a", 1]}});
    let faults = app.recommend(&with(with(simulated(), grid()), faulty)).await;
    let mut expected = vec![
        ("/program/decimals", "out-of-range"),
        ("/program/coolant", "wrong-type"),
        ("/program/header/0", "out-of-range"),
        ("/program/origin_mm/1", "wrong-type"),
    ];
    expected.sort_unstable();
    let (status, mut found) = faults.faults();
    found.sort_unstable();
    assert_eq!((status, found), (422, expected));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_selection_is_machined_alone() {
    let app = TestApp::start().await;
    let whole = app.recommend(&with(simulated(), grid())).await.ok();
    let half = json!({"select": {"box_mm": {"min": [-1, -1, -100], "max": [12, 100, 100]}}});
    let half = app.recommend(&with(with(simulated(), grid()), half)).await.ok();
    assert!(figure(&half, "/recommended/machining_time_s") < 0.7 * figure(&whole, "/recommended/machining_time_s"));
    let none = app.recommend(&with(with(simulated(), grid()), json!({"select": {"slope_deg": [80, 85]}}))).await;
    assert_eq!(none.faults(), (422, vec![("/surface", "nothing-to-machine")]));
    let unknown = app.recommend(&with(with(simulated(), grid()), json!({"select": {"pieces": [3]}}))).await;
    assert_eq!(unknown.faults(), (422, vec![("/select/pieces", "out-of-range")]));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn facets_are_selected_by_their_numbers_in_the_order_of_the_file() {
    let app = TestApp::start().await;
    let points = json!([[0, 0, 0], [20, 0, 0], [20, 20, 0], [0, 20, 0], [40, 0, 5], [40, 20, 5]]);
    // The second triangle has no area, the fourth is the first once more: both count.
    let triangles = json!([[0, 1, 2], [0, 1, 1], [0, 2, 3], [0, 1, 2], [1, 4, 5], [1, 5, 2]]);
    let mesh = json!({"surface": {"mesh": {"points": points, "triangles": triangles}}, "directions_deg": [0]});
    let area = async |select: Value| {
        let answer = app
            .recommend(&with(
                with(job(), json!({"method": "surface", "include": ["passes"], "max_uncut_share": 1})),
                with(mesh.clone(), select),
            ))
            .await;
        let answer = answer.ok();
        let contacts = answer["passes"]["contact_mm"].as_array().unwrap().clone();
        contacts
            .iter()
            .filter(|contact| !contact.is_null())
            .map(|contact| contact[0].as_f64().unwrap())
            .fold([99.0_f64, -99.0], |[least, most], x| [least.min(x), most.max(x)])
    };
    let [least, most] = area(json!({"select": {"facets": [[4, 4], [5, 5]]}})).await;
    assert!(least > 19.0 && most > 39.0, "{least} to {most}");
    let [least, most] = area(json!({"select": {"facets": [[0, 2]]}})).await;
    assert!(least < 1.0 && most < 20.1, "{least} to {most}");
    for (ranges, pointer) in [(json!([[4, 6]]), "/select/facets"), (json!([[3, 2]]), "/select/facets"), (json!([[3]]), "/select/facets/0")]
    {
        let select = json!({"select": {"facets": ranges}});
        let refused = app.recommend(&with(with(simulated(), mesh.clone()), select)).await;
        let (status, faults) = refused.faults();
        assert_eq!((status, faults.len(), faults[0].0), (422, 1, pointer), "{faults:?}");
    }
    let of_points = json!({"surface": {"points": [[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]]}, "select": {"facets": [[0, 0]]}});
    assert_eq!(app.recommend(&with(simulated(), of_points)).await.faults(), (422, vec![("/select/facets", "out-of-range")]));
}

/// A plate, and a wall on one of its sides, which is sent apart.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_surface_to_avoid_is_neither_machined_nor_cut() {
    let app = TestApp::start().await;
    let box_of = |low: [f64; 3], high: [f64; 3]| {
        let points: Vec<_> =
            (0..8_usize).map(|corner| [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] })).collect();
        let triangles =
            json!([[4, 5, 7], [4, 7, 6], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3]]);
        json!({"mesh": {"points": points, "triangles": triangles}})
    };
    let cutters = json!({"cutters": [{"type": "ball_end", "diameter_mm": 6}], "max_uncut_share": 1, "include": ["passes"]});
    let request = with(with(simulated(), json!({"surface": box_of([0.0; 3], [20.0, 20.0, 2.0])})), cutters);
    let wall = box_of([20.0, 0.0, 0.0], [25.0, 20.0, 12.0]);
    let free = app.recommend(&request).await.ok();
    let avoiding = app.recommend(&with(request.clone(), json!({"avoid": wall}))).await.ok();
    let farthest = |answer: &Value| {
        let passes = &answer["passes"];
        let low = passes["tip_mm"].as_array().unwrap().iter().filter(|tip| tip[2].as_f64().unwrap() < 11.9);
        low.map(|tip| tip[0].as_f64().unwrap()).fold(0.0, f64::max)
    };
    assert!(farthest(&free) > 19.5, "{}", farthest(&free));
    // The ball's centre stays its radius away from the wall.
    assert!(farthest(&avoiding) <= 17.0 + 1e-3, "{}", farthest(&avoiding));
    assert!(figure(&avoiding, "/candidates/0/gouge_mm") < 1e-3);
    assert!(figure(&avoiding, "/candidates/0/uncut_share") > 0.05);
    assert_eq!(avoiding["surface"]["area_mm2"], free["surface"]["area_mm2"]);
    // As a part of a form.
    let corners = |mesh: &Value| -> Vec<[[f32; 3]; 3]> {
        #[expect(clippy::cast_possible_truncation, reason = "exact")]
        let point = |index: &Value| {
            let point = &mesh["mesh"]["points"][usize::try_from(index.as_u64().unwrap()).unwrap()];
            [0, 1, 2].map(|axis| point[axis].as_f64().unwrap() as f32)
        };
        mesh["mesh"]["triangles"].as_array().unwrap().iter().map(|t| [0, 1, 2].map(|corner| point(&t[corner]))).collect()
    };
    let (plate, wall_file) = (binary_stl("plate", &corners(&request["surface"])), binary_stl("wall", &corners(&wall)));
    let mut parameters = request.clone();
    parameters.as_object_mut().unwrap().remove("surface");
    parameters["unit"] = json!("mm");
    let parts = |parameters: &Value| {
        [("surface", plate.clone()), ("avoid", wall_file.clone()), ("parameters", parameters.to_string().into_bytes())]
    };
    let uploaded = app.upload_parts(parts(&parameters)).await.ok();
    assert_relative_eq!(farthest(&uploaded), farthest(&avoiding), max_relative = 1e-6);
    parameters["avoid"] = wall;
    assert_eq!(app.upload_parts(parts(&parameters)).await.faults(), (422, vec![("/avoid", "conflicting-fields")]));
    let by_rectangle = json!({"method": "rectangle", "avoid": parameters["avoid"]});
    let mut by_rectangle = with(with(simulated(), grid()), by_rectangle);
    by_rectangle.as_object_mut().unwrap().remove("directions_deg");
    assert_eq!(warnings(&app.recommend(&by_rectangle).await.ok()), ["member-unused"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn if_no_cutter_fits_each_has_its_reason() {
    let app = TestApp::start().await;
    // A groove of 4 mm, 5 mm deep, which a ball of 20 mm does not fit into.
    let at = |x: f64| if (x - 10.0).abs() < 2.5 { 0.0 } else { 5.0 };
    let points: Vec<[f64; 3]> =
        (0..11).flat_map(|row| (0..41).map(move |c| [0.5 * f64::from(c), f64::from(row), at(0.5 * f64::from(c))])).collect();
    let surface = json!({"surface": {"grid": {"rows": 11, "columns": 41, "points": points}}, "cutters": [{"name": "B20", "type": "ball_end", "diameter_mm": 20}]});
    let request = with(simulated(), surface);
    let answer = app.recommend(&request).await;
    assert_eq!((answer.status, &answer.body["type"]), (422, &json!("no-cutter-fits")), "{}", answer.body);
    let not_ranked = &answer.body["not_ranked"][0];
    assert_eq!((&not_ranked["name"], &not_ranked["code"]), (&json!("B20"), &json!("cannot-reach")));
    assert!(figure(not_ranked, "/uncut_share") > 0.1);
    assert!(figure(&answer.body, "/needed_max_uncut_share") < 1.0);
    // Of what a smaller ball leaves it reaches nothing: no limit on what may be left helps.
    let rest = json!({"rest_of": {"cutter": {"type": "ball_end", "diameter_mm": 10}}, "max_uncut_share": 1});
    let answer = app.recommend(&with(request, rest)).await;
    let not_ranked = &answer.body["not_ranked"][0];
    assert_eq!((&not_ranked["code"], &not_ranked["uncut_share"]), (&json!("cannot-reach"), &json!(1.0)), "{}", answer.body);
    assert_eq!(answer.body.get("needed_max_uncut_share"), None);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn cutters_of_libraries_join_and_other_tools_are_counted() {
    let app = TestApp::start().await;
    let library = b"name,type,diameter_mm,corner_radius_mm,teeth\nB6,ball_end,6,,2\nT8,toroidal,8,2,4\nD8,drill,8,,2\n".to_vec();
    let file = obj(&nodes(), &triangles()).into_bytes();
    let mut parameters = simulated();
    parameters.as_object_mut().unwrap().remove("cutters");
    let parameters = parameters.to_string().into_bytes();
    let parts = [("library", library), ("surface", file.clone()), ("parameters", parameters.clone())];
    let answer = app.upload_parts(parts).await.ok();
    let names: Vec<_> = answer["candidates"].as_array().unwrap().iter().map(|candidate| candidate["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"B6") && names.contains(&"T8"), "{names:?}");
    assert_eq!(warnings(&answer), ["other-tools"]);
    let refused = app
        .upload_parts([("library", b"name,type,diameter_mm\nB6,ball_end,-6\n".to_vec()), ("surface", file), ("parameters", parameters)])
        .await;
    assert_eq!(refused.faults(), (422, vec![("/library/0", "out-of-range")]), "{}", refused.body);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_unit_that_a_file_states_is_believed() {
    let app = TestApp::start().await;
    let asked = with(job(), json!({"method": "rectangle"}));
    let lines: Vec<String> = nodes().iter().map(|[x, y, z]| format!("{x},{y},{z}")).collect();
    let text = format!("x_cm,y_cm,z_cm\n{}\n", lines.join("\n"));
    let vertices: Vec<String> = nodes().iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces: Vec<String> = triangles().iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).collect();
    let object = format!("# units: cm\n{}{}", vertices.concat(), faces.concat());
    for file in [text, object] {
        let width = async |parameters: Value| figure(&app.upload(file.clone(), &parameters).await.ok(), "/surface/bounds_mm/max/0");
        let in_mm = width(with(asked.clone(), json!({"unit": "mm"}))).await;
        assert_relative_eq!(width(asked.clone()).await, 10.0 * in_mm, max_relative = 1e-6);
        assert_relative_eq!(width(with(asked.clone(), json!({"unit": "cm"}))).await, 10.0 * in_mm, max_relative = 1e-6);
    }
    let package = three_mf("centimeter", &nodes(), &triangles());
    let stated = app.upload(package.clone(), &asked).await.ok();
    assert_relative_eq!(figure(&stated, "/surface/bounds_mm/max/0"), 240.0, max_relative = 1e-6);
    let contradicted = app.upload(package, &with(asked.clone(), json!({"unit": "inch"}))).await;
    assert_eq!(contradicted.faults(), (422, vec![("/unit", "conflicting-fields")]));
}

/// The search samples the facets of a fine mesh. On a regular grid the sample must not be that of a few lines, along which
/// every direction but theirs would seem fast.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_fine_mesh_of_a_plane_has_the_plan_of_a_coarse_one() {
    let app = TestApp::start().await;
    let climb = 10.0_f32.to_radians().tan();
    let plane = |columns: usize, rows: usize| {
        #[expect(clippy::cast_precision_loss, reason = "at most 241")]
        let part = |number: usize, of: usize| number as f32 / (of - 1) as f32;
        let node =
            |at: usize| [60.0 * part(at % columns, columns), 50.0 * part(at / columns, rows), 50.0 * climb * part(at / columns, rows)];
        let vertices: Vec<[f32; 3]> = (0..columns * rows).map(node).collect();
        let cell = |at: usize| [[at, at + 1, at + columns + 1], [at, at + columns + 1, at + columns]];
        let triangles: Vec<[usize; 3]> = (0..(rows - 1) * columns).filter(|at| at % columns + 1 < columns).flat_map(cell).collect();
        ply("binary_little_endian", &vertices, &triangles)
    };
    let cutters = json!([{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}, {"type": "ball_end", "diameter_mm": 10}]);
    let job = json!({"cutters": cutters, "scallop_height_mm": 0.01, "machine": {"preset": "five_axis_vmc"}});
    let coarse = app.upload(plane(31, 26), &with(job.clone(), json!({"directions_deg": [90]}))).await.ok();
    let seconds = figure(&coarse, "/candidates/0/machining_time_s");
    let fine = plane(241, 201);
    for directions in [json!([90]), json!([0, 90]), json!([45, 90]), Value::Null] {
        let mut asked = job.clone();
        if !directions.is_null() {
            asked["directions_deg"] = directions.clone();
        }
        let answer = app.upload(fine.clone(), &asked).await.ok();
        let best = &answer["candidates"][0];
        assert_eq!(best["cutter"], 0, "directions {directions}");
        // Plans are spaced from random places, and may differ by a line.
        let lines = figure(&coarse, "/candidates/0/passes");
        assert!(figure(best, "machining_time_s") <= (1.0 + 1.0 / lines) * seconds, "directions {directions}: {best:#}, {coarse:#}");
        for candidate in answer["candidates"].as_array().unwrap() {
            let times = candidate["by_direction"]["machining_time_s"].as_array().unwrap();
            assert!(times.iter().all(Value::is_number), "directions {directions}");
        }
    }
}
