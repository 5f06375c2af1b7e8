//! Times the calculations at one contact: heights and both inverses, in both models. `cargo bench --bench contact`

use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main, measurement::WallTime};
use scallopd::milling::{Analytic, Contact, Cutter, Envelope, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::Length;
use std::hint::black_box;

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

/// A cutter of R = 5 mm with the corner radius `corner`, at slope and alpha in degrees.
fn pass(corner: f64, slope: f64, alpha: f64) -> Pass {
    let cutter = match corner {
        0.0 => Cutter::flat_end(mm(10.0)),
        5.0 => Cutter::ball_end(mm(10.0)),
        r => Cutter::toroidal(mm(10.0), mm(r)).expect("a corner under 5 mm"),
    };
    let contact = Contact::from_degrees(slope, alpha).expect("a contact");
    Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None }
}

/// Times heights and inverses of one model; `black_box` keeps the compiler from computing them in advance.
macro_rules! time_model {
    ($group:expr, $model:ident, $name:literal, $pass:expr) => {
        $group.bench_function(concat!($name, " heights"), |b| {
            b.iter(|| $model::new(black_box($pass)).and_then(|model| model.scallop_height(mm(0.6), Some(mm(0.15)))))
        });
        $group.bench_function(concat!($name, " max feed"), |b| {
            b.iter(|| $model::new(black_box($pass)).and_then(|model| model.max_feed_per_tooth(mm(0.03), mm(0.6))))
        });
        $group.bench_function(concat!($name, " max step-over"), |b| {
            b.iter(|| $model::new(black_box($pass)).and_then(|model| model.max_step_over(mm(0.03), Some(mm(0.15)))))
        });
    };
}

fn time_pass(group: &mut BenchmarkGroup<'_, WallTime>, pass: Pass) {
    time_model!(group, Analytic, "analytic", pass);
    time_model!(group, Envelope, "envelope", pass);
}

fn contacts(criterion: &mut Criterion) {
    let hollow = SurfaceCurvature::from_radius_mm(-50.0).expect("a radius");
    for (name, pass) in [
        ("toroidal, oblique", pass(2.0, 40.0, 30.0)),
        ("toroidal, near the floor", pass(2.0, 0.5, 10.0)),
        ("toroidal, near the wall", pass(2.0, 88.0, 80.0)),
        ("toroidal, oblique in a hollow", Pass { surface: hollow, ..pass(2.0, 40.0, 30.0) }),
        ("flat-end, oblique", pass(0.0, 40.0, 30.0)),
        ("ball-end", pass(5.0, 40.0, 30.0)),
    ] {
        let mut group = criterion.benchmark_group(name);
        time_pass(&mut group, pass);
        group.finish();
    }
}

criterion_group!(benches, contacts);
criterion_main!(benches);
