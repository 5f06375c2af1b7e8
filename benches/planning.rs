//! Times the parts of a recommendation: travel time, critical slope in closed form and by bracketing, principal axes.
//! `cargo bench --bench planning`

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Matrix3;
use scallopd::milling::{Cutter, Model};
use scallopd::motion::{Preset, travel_time};
use scallopd::planning::{CutterComparison, InclinedRectangle, critical_slope};
use scallopd::quantity::Length;
use scallopd::surface::PrincipalAxes;
use std::hint::black_box;

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

fn planning(criterion: &mut Criterion) {
    let machine = Preset::named("five_axis_vmc").expect("a preset").limits;
    let toroidal = Cutter::toroidal(mm(10.0), mm(2.0)).expect("a corner under 5 mm");
    let job = CutterComparison::new(toroidal, Cutter::ball_end(mm(10.0)), mm(0.01), machine, Model::Analytic).expect("a job");
    let mut group = criterion.benchmark_group("planning");
    for (name, length) in [("0.1 mm", 0.1), ("5 mm", 5.0), ("500 mm", 500.0)] {
        group.bench_function(format!("travel time of {name}"), |b| b.iter(|| travel_time(black_box(mm(length)), machine)));
    }
    // Passes of 2 mm do not reach the feed rate, which the closed form assumes.
    for (name, height) in [("in closed form", 60.0), ("by bracketing", 2.0)] {
        let rectangle = InclinedRectangle::from_sides(mm(100.0), mm(height)).expect("width above height");
        group.bench_function(format!("critical slope {name}"), |b| b.iter(|| critical_slope(black_box(&job), rectangle)));
    }
    let covariance = Matrix3::new(312.0, 11.0, 3.0, 11.0, 219.0, 2.0, 3.0, 2.0, 3.2);
    group.bench_function("principal axes", |b| b.iter(|| PrincipalAxes::of(black_box(covariance))));
    group.finish();
}

criterion_group!(benches, planning);
criterion_main!(benches);
