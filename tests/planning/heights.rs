//! The scallop heights of passes against those of the batch of contacts.

use crate::app::{TestApp, figure};
use crate::planning::{job, with};
use serde_json::{Value, json};

/// Waves that are convex, concave and twisted, with a level saddle and level tops, on a grid of 2 mm.
fn waves(rows: u8, columns: u8) -> Value {
    let points: Vec<[f64; 3]> = (0..rows)
        .flat_map(|row| {
            (0..columns).map(move |column| {
                let (x, y) = (2.0 * f64::from(column), 2.0 * f64::from(row));
                [x, y, 0.15 * x + 6.0 * (x / 18.0).sin() * (y / 22.0).cos() + 0.004 * y * y]
            })
        })
        .collect();
    json!({"surface": {"grid": {"rows": rows, "columns": columns, "points": points}}, "directions_deg": [27], "include": ["passes"]})
}

/// The positions of the points with a contact.
fn with_contact(passes: &Value) -> Vec<usize> {
    let contacts = passes["contact_mm"].as_array().unwrap().iter();
    contacts.enumerate().filter(|(_, contact)| !contact.is_null()).map(|(index, _)| index).collect()
}

/// The points of the passes that have a contact, as the contacts of a batch.
fn contacts(passes: &Value, direction_deg: f64) -> Value {
    let those = with_contact(passes);
    let column = |column: &Value| -> Vec<Value> { those.iter().map(|index| column[*index].clone()).collect() };
    let (sin, cos) = direction_deg.to_radians().sin_cos();
    let feed = |normal: &Value| {
        let [x, y, z] = [0, 1, 2].map(|axis| normal[axis].as_f64().unwrap());
        json!([cos, sin, -(x * cos + y * sin) / z])
    };
    let feeds: Vec<Value> = column(&passes["normal"]).iter().map(feed).collect();
    let mut contacts = json!({"feed": feeds});
    for name in ["normal", "step_over_mm", "feed_per_tooth_mm"] {
        if let Some(values) = passes.get(name) {
            contacts[name] = json!(column(values));
        }
    }
    for name in ["along_per_mm", "across_per_mm", "twist_per_mm"] {
        contacts["surface_curvature"][name] = json!(column(&passes["surface_curvature"][name]));
    }
    contacts
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_point_of_the_passes_has_the_height_of_the_batch() {
    let app = TestApp::start().await;
    let cutters = [
        json!({"type": "ball_end", "diameter_mm": 8}),
        json!({"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}),
        json!({"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 0.5}),
        json!({"type": "flat_end", "diameter_mm": 6}),
        json!({"type": "oval", "diameter_mm": 8, "tip_radius_mm": 2, "side_radius_mm": 40}),
        json!({"type": "lens", "diameter_mm": 8, "lens_radius_mm": 20, "corner_radius_mm": 0.5}),
    ];
    for cutter in cutters {
        for drive in [json!({}), json!({"teeth": 2, "spindle_speed_rpm": 12_000})] {
            let driven = with(cutter.clone(), drive.clone());
            let request = with(with(job(), waves(13, 19)), json!({"method": "surface", "cutters": [driven], "max_uncut_share": 1}));
            let answer = app.recommend(&request).await.ok();
            let passes = &answer["passes"];
            let contacts = contacts(passes, figure(&answer, "/recommended/direction_deg"));
            let request = json!({"cutter": cutter, "model": "envelope", "contacts": contacts});
            let batch = app.answer("/v1/scallop-height/batch", &request).await;
            let those = with_contact(passes);
            let of_passes: Vec<&Value> = those.iter().map(|index| &passes["scallop_height_mm"][*index]).collect();
            let of_batch = batch["scallop_height_mm"].as_array().unwrap();
            let mut compared = 0_u32;
            for (index, (one, other)) in of_passes.iter().zip(of_batch).enumerate() {
                let at = || format!("{cutter} {drive} {index}: normal {}", passes["normal"][those[index]]);
                assert_eq!(one.is_null(), other.is_null(), "{}: {one} {other}", at());
                if let (Some(one), Some(other)) = (one.as_f64(), other.as_f64()) {
                    assert!((one / other - 1.0).abs() <= 1e-6, "{}: {one} {other}", at());
                    compared += 1;
                }
            }
            println!("{cutter} {drive}: {compared} of {} points have a height", of_passes.len());
            assert!(compared > 500 && of_passes.len() == of_batch.len());
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_tips_of_a_run_lie_in_one_plane_of_the_direction() {
    let app = TestApp::start().await;
    let request = with(with(job(), waves(19, 25)), json!({"method": "surface"}));
    let answer = app.recommend(&request).await.ok();
    let (sin, cos) = figure(&answer, "/recommended/direction_deg").to_radians().sin_cos();
    let passes = &answer["passes"];
    let tips = passes["tip_mm"].as_array().unwrap();
    let across = |index: usize| cos * tips[index][1].as_f64().unwrap() - sin * tips[index][0].as_f64().unwrap();
    let mut starts: Vec<usize> = serde_json::from_value(passes["run_starts"].clone()).unwrap();
    starts.push(tips.len());
    // A few runs go along the feet of walls; all others are in a plane of the direction.
    let (mut in_planes, mut along_feet) = (0, 0);
    for pair in starts.windows(2) {
        let cut: Vec<usize> = (pair[0] + 1..pair[1]).filter(|index| passes["move"][*index] == "cut").collect();
        let off = cut.iter().map(|index| (across(*index) - across(pair[0])).abs()).fold(0.0, f64::max);
        *if off <= 1e-9 { &mut in_planes } else { &mut along_feet } += cut.len();
    }
    assert!(in_planes > 20 * along_feet, "{in_planes} and {along_feet}");
}
