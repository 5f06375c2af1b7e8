//! `POST /v1/cutter-recommendation` by method `surface` on closed solids, as CAD systems export parts.

use crate::app::{TestApp, figure};
use crate::planning::{job, with};
use serde_json::{Value, json};

type Facet = [[f64; 3]; 3];

/// The facets of a quadrilateral.
fn quadrilateral([a, b, c, d]: [[f64; 3]; 4]) -> [Facet; 2] {
    [[a, b, c], [a, c, d]]
}

/// A block from z = -20 mm up to a dome over 60 x 40 mm, and its top alone.
fn block() -> (Vec<Facet>, Vec<Facet>) {
    let top = |i: i32, j: i32| {
        let (x, y) = (f64::from(i), f64::from(j));
        [x, y, 5.0 - (x - 30.0).powi(2) / 200.0 - (y - 20.0).powi(2) / 150.0]
    };
    let base = |i: i32, j: i32| {
        let [x, y, _] = top(i, j);
        [x, y, -20.0]
    };
    let cells = || (0..60).flat_map(|i| (0..40).map(move |j| (i, j)));
    let over = |(i, j)| quadrilateral([top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1)]);
    let under = |(i, j)| quadrilateral([base(i, j), base(i, j + 1), base(i + 1, j + 1), base(i + 1, j)]);
    let wall = |(a, b): ((i32, i32), (i32, i32))| quadrilateral([base(a.0, a.1), base(b.0, b.1), top(b.0, b.1), top(a.0, a.1)]);
    let along = (0..60).flat_map(|i| [((i, 0), (i + 1, 0)), ((i + 1, 40), (i, 40))]);
    let across = (0..40).flat_map(|j| [((60, j), (60, j + 1)), ((0, j + 1), (0, j))]);
    let sheet: Vec<Facet> = cells().flat_map(over).collect();
    let solid = sheet.iter().copied().chain(cells().flat_map(under)).chain(along.chain(across).flat_map(wall)).collect();
    (solid, sheet)
}

/// A mesh of facets, each with its own three points.
pub(super) fn mesh(facets: &[Facet]) -> Value {
    let triangles: Vec<_> = (0..facets.len()).map(|facet| [3 * facet, 3 * facet + 1, 3 * facet + 2]).collect();
    json!({"surface": {"mesh": {"points": facets.concat(), "triangles": triangles}}})
}

fn request(facets: &[Facet]) -> Value {
    with(with(job(), json!({"method": "surface", "directions_deg": [0.0, 90.0]})), mesh(facets))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_underside_of_a_solid_does_not_lower_the_confidence() {
    let app = TestApp::start().await;
    let (solid, sheet) = block();
    let turned: Vec<Facet> = solid.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let of_sheet = app.recommend(&request(&sheet)).await.ok();
    assert_eq!(of_sheet["confidence"], json!({"level": "high", "reasons": []}));
    // A facet is missing.
    let torn = solid[1..].to_vec();
    for (facets, reasons) in [(&solid, vec![]), (&turned, vec![]), (&torn, vec!["not-closed"])] {
        let of_solid = app.recommend(&request(facets)).await.ok();
        let codes: Vec<_> = of_solid["confidence"]["reasons"].as_array().unwrap().iter().map(|reason| reason["code"].clone()).collect();
        assert_eq!(codes, reasons);
        assert_eq!(of_solid["recommended"]["cutter"], of_sheet["recommended"]["cutter"]);
        // Curvatures beside the border differ, because the walls' facets share its points.
        let [sheet, solid] = [&of_sheet, &of_solid].map(|answer| figure(answer, "/recommended/machining_time_s"));
        assert!((solid / sheet - 1.0).abs() < 0.01, "{solid} {sheet}");
        assert!(figure(&of_solid, "/surface/visible_area_share") < 0.75);
    }
    // Without a wall it may be a sheet whose lower side is to be machined as well.
    let open = app.recommend(&request(&solid[..solid.len() - 2])).await.ok();
    assert_eq!((&open["confidence"]["level"], &open["confidence"]["reasons"][0]["code"]), (&json!("low"), &json!("hidden-area")));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn hidden_area_counts_where_it_is_selected() {
    let app = TestApp::start().await;
    let (_, sheet) = block();
    // The same surface 30 mm lower: all of it is hidden.
    let lower: Vec<Facet> = sheet.iter().map(|facet| facet.map(|[x, y, z]| [x, y, z - 30.0])).collect();
    let both = request(&[sheet, lower].concat());
    let hidden = app.recommend(&both).await.ok();
    let reasons = hidden["confidence"]["reasons"].as_array().unwrap();
    let share = reasons.iter().find(|reason| reason["code"] == "hidden-area").map(|reason| figure(reason, "/value")).unwrap();
    assert!((share - 0.5).abs() < 1e-9, "{share}");
    let selected = app.recommend(&with(both, json!({"select": {"pieces": [0]}}))).await.ok();
    assert_eq!(selected["confidence"], json!({"level": "high", "reasons": []}));
}
