//! Zigzag passes simulated on the surface: all directions, for two and for fifty cutters. `cargo bench --bench zigzag`
//!
//! Targets on two cores: 12,000 facets and two cutters 30 ms, fifty cutters 0.6 s; a million facets and two cutters 1.5 s.

use criterion::{Criterion, criterion_group, criterion_main};
use scallopd::milling::Cutter;
use scallopd::motion::{Machine, Preset};
use scallopd::planning::zigzag::{CandidateCutter, SurfaceEvidence, ZigzagSettings, rank};
use scallopd::quantity::Length;
use scallopd::surface::FinishFacet;
use std::hint::black_box;
use std::time::Duration;

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

/// z and its derivatives x, y, xx, xy, yy.
fn waves(x: f64, y: f64) -> [f64; 6] {
    let (a, p, q) = (8.0, 30.0, 37.0);
    let ((sx, cx), (sy, cy)) = ((x / p).sin_cos(), (y / q).sin_cos());
    [
        a * sx * cy + 0.25 * x,
        a * cx * cy / p + 0.25,
        -a * sx * sy / q,
        -a * sx * cy / (p * p),
        -a * cx * sy / (p * q),
        -a * sx * cy / (q * q),
    ]
}

/// Waves over 60 x 60 mm as 2 n^2 facets, each with the normal of its plane and the curvature of the surface at its middle.
fn facets(n: u32) -> Vec<FinishFacet> {
    let at = |i: f64, j: f64| {
        let (x, y) = (60.0 * i / f64::from(n), 60.0 * j / f64::from(n));
        [x, y, waves(x, y)[0]]
    };
    let facet = |corners: [[f64; 3]; 3]| {
        let [a, b, c] = corners;
        let (u, v) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
        let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt();
        let middle = [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0];
        let [_, zx, zy, xx, xy, yy] = waves(middle[0], middle[1]);
        // The curvature tensor of a graph: -P H P / sqrt(1 + |grad|^2), P the projection on the tangent plane, H the second derivatives.
        let root = (1.0 + zx * zx + zy * zy).sqrt();
        let normal = [-zx / root, -zy / root, 1.0 / root];
        let hessian = [[xx, xy, 0.0], [xy, yy, 0.0], [0.0; 3]];
        let project = |i: usize, j: usize| f64::from(u8::from(i == j)) - normal[i] * normal[j];
        let entry = |i: usize, j: usize| {
            -(0..3).flat_map(|k| (0..3).map(move |l| (k, l))).map(|(k, l)| project(i, k) * hessian[k][l] * project(l, j)).sum::<f64>()
                / root
        };
        FinishFacet {
            corners,
            normal: cross.map(|c| c / length),
            area: 0.5 * length,
            curvature: [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)],
        }
    };
    (0..n)
        .flat_map(|i| (0..n).map(move |j| (f64::from(i), f64::from(j))))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1.0, j), at(i + 1.0, j + 1.0), at(i, j + 1.0)];
            [facet([a, b, c]), facet([a, c, d])]
        })
        .collect()
}

fn cutters(count: u32) -> Vec<CandidateCutter> {
    (0..count)
        .map(|index| {
            let diameter = mm(10.0 + 0.1 * f64::from(index));
            let cutter =
                if index % 2 == 0 { Cutter::toroidal(diameter, mm(2.0)).expect("a corner under 5 mm") } else { Cutter::ball_end(diameter) };
            CandidateCutter::new(cutter)
        })
        .collect()
}

fn zigzag(criterion: &mut Criterion) {
    let machine = Machine::from(Preset::named("five_axis_vmc").expect("a preset").limits);
    let settings = ZigzagSettings::new(mm(0.01), machine);
    let mut group = criterion.benchmark_group("zigzag");
    group.sample_size(10).measurement_time(Duration::from_secs(8));
    for (name, n, count) in
        [("12,000 facets, 2 cutters", 77, 2), ("12,000 facets, 50 cutters", 77, 50), ("a million facets, 2 cutters", 707, 2)]
    {
        let (facets, cutters) = (facets(n), cutters(count));
        group.bench_function(name, |b| b.iter(|| rank(black_box(&facets), &cutters, &settings, SurfaceEvidence::default())));
    }
    group.finish();
}

criterion_group!(benches, zigzag);
criterion_main!(benches);
