//! The mesh stage: building, visibility, curvature and reach. `cargo bench --bench mesh`

use criterion::{Criterion, criterion_group, criterion_main};
use scallopd::milling::Cutter;
use scallopd::planning::reach::ReachMap;
use scallopd::quantity::{Angle, Length};
use scallopd::surface::mesh::Selection;
use scallopd::surface::{Facing, Mesh, MeshBuilder, Sink, Unit};
use std::hint::black_box;
use std::time::Duration;

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

/// 2 x `columns` x `rows` facets of a wavy surface of 100 x 80 mm.
fn facets(columns: u32, rows: u32) -> Vec<[[f64; 3]; 3]> {
    let at = |i: u32, j: u32| {
        let (x, y) = (100.0 * f64::from(i) / f64::from(columns), 80.0 * f64::from(j) / f64::from(rows));
        [x, y, 6.0 * (0.1 * x).sin() * (0.12 * y).cos()]
    };
    let quad = |i: u32, j: u32| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    (0..rows).flat_map(|j| (0..columns).flat_map(move |i| quad(i, j))).collect()
}

fn build(facets: &[[[f64; 3]; 3]]) -> Mesh {
    let mut builder = MeshBuilder::new();
    for &facet in facets {
        builder.facet(facet);
    }
    builder.finish(Unit::Millimetre, Facing::Up).expect("a mesh")
}

fn stages(criterion: &mut Criterion) {
    let max_slope = Angle::from_degrees(85.0).expect("an angle");
    let mut group = criterion.benchmark_group("mesh");
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    for (name, columns, rows) in [("12 000 facets", 87, 69), ("100 000 facets", 250, 200), ("1 000 000 facets", 791, 632)] {
        let facets = facets(columns, rows);
        group.bench_function(format!("weld {name}"), |b| b.iter(|| build(black_box(&facets))));
        let mesh = build(&facets);
        group.bench_function(format!("classify {name}"), |b| b.iter(|| mesh.visibility(max_slope)));
        group.bench_function(format!("pieces of {name}"), |b| b.iter(|| mesh.pieces()));
        let visibility = mesh.visibility(max_slope);
        let selected = mesh.selected(&Selection::all(), &mesh.pieces()).expect("a selection");
        group.bench_function(format!("curvature of {name}"), |b| b.iter(|| mesh.facets_for_finishing(&visibility, &selected)));
    }
    group.finish();
}

fn reach(criterion: &mut Criterion) {
    let mesh = build(&facets(250, 200));
    let machined = vec![true; mesh.triangles().len()];
    let map = ReachMap::new(&mesh, &mesh.seen_from_above(256), &machined);
    let cutters: Vec<Cutter> = (0..50).map(|i| Cutter::ball_end(mm(2.0 + 0.4 * f64::from(i)))).collect();
    let mut group = criterion.benchmark_group("reach");
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    group.bench_function("50 cutters", |b| b.iter(|| map.uncut_of_each(black_box(&cutters), mm(0.01))));
    group.finish();
}

criterion_group!(benches, stages, reach);
criterion_main!(benches);
