//! Measures the recommendation by method `surface`, stage by stage, for surfaces of 12 000, 100 000 and 1 000 000
//! facets: `cargo bench --bench recommendation [n ...]` takes meshes of 2 n^2 facets instead. Writes
//! `target/benches/recommendation.json`.
//!
//! `cargo bench --bench recommendation rank n` measures the ranking alone.
//!
//! `cargo bench --bench recommendation memory n` plans once on a mesh of 2 n^2 facets with the service's limit on
//! facets, and prints the peak memory of the process.
//!
//! Processor time is the system's count for all threads of this process, in ticks of 10 ms, so calls are repeated. 60
//! ms of processor time on two cores are 30 ms of time.

use scallopd::milling::Cutter;
use scallopd::motion::{Machine, Preset};
use scallopd::planning::SurfaceEvidence;
use scallopd::planning::plan::{CandidateCutter, PlanSettings, Ranking, Workpiece, rank};
use scallopd::quantity::{Angle, Length};
use scallopd::surface::mesh::Selection;
use scallopd::surface::{Facing, Mesh, MeshBuilder, Sink, Unit};
use std::hint::black_box;
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const TICKS_A_SECOND: f64 = 100.0;
/// The measured time is at least fifty ticks, so that a tick is 2 %.
const LEAST_ROUND: Duration = Duration::from_millis(500);

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

/// Waves over 60 x 60 mm as a mesh of 2 n^2 facets; convex, concave and twisted, with slopes up to 30 deg.
fn waves(n: u32, facet_limit: usize) -> Mesh {
    let at = |i: u32, j: u32| {
        let (x, y) = (60.0 * f64::from(i) / f64::from(n), 60.0 * f64::from(j) / f64::from(n));
        [x, y, 8.0 * (x / 30.0).sin() * (y / 37.0).cos() + 0.25 * x]
    };
    let mut builder = MeshBuilder::with_facet_limit(facet_limit);
    for i in 0..n {
        for j in 0..n {
            builder.facet([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            builder.facet([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    builder.finish(Unit::Millimetre, Facing::Up, &|| false).expect("a mesh")
}

/// Toroidal and ball-end cutters in turn: two of 10 mm, or more with diameters from 2 to 17 mm.
fn cutters(count: u32) -> Vec<Cutter> {
    let cutter = |index: u32| {
        let diameter = if count <= 2 { mm(10.0) } else { mm(2.0 + 15.0 * f64::from(index) / f64::from(count - 1)) };
        let corner = mm(0.2 * diameter.mm());
        if index.is_multiple_of(2) {
            Cutter::toroidal(diameter, corner).expect("a corner under the radius")
        } else {
            Cutter::ball_end(diameter)
        }
    };
    (0..count).map(cutter).collect()
}

/// The processor time of this process, in s.
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").expect("a system with /proc");
    // The name in parentheses may have blanks; utime and stime are the 14th and 15th fields.
    let fields: Vec<&str> = text[text.rfind(')').expect("a name") + 2..].split(' ').collect();
    fields[11..13].iter().map(|ticks| ticks.parse::<f64>().expect("a count")).sum::<f64>() / TICKS_A_SECOND
}

/// Processor time and time of one call, in ms.
fn measured<T>(mut call: impl FnMut() -> T) -> [f64; 2] {
    black_box(call());
    let (processor, start, mut count) = (processor_seconds(), Instant::now(), 0.0);
    while start.elapsed() < LEAST_ROUND || count < 2.0 {
        black_box(call());
        count += 1.0;
    }
    [1e3 * (processor_seconds() - processor) / count, 1e3 * start.elapsed().as_secs_f64() / count]
}

/// The service's limit on facets.
const SERVICE_LIMIT: usize = 500_000;

/// The ranking of these cutters, with all stages after reading.
fn planned(mesh: &Mesh, cutters: &[Cutter], settings: &PlanSettings) -> Option<Ranking> {
    let selected = mesh.selected(&Selection::all(), &mesh.pieces(&|| false)).expect("a selection");
    let workpiece = Workpiece::new(mesh, &mesh.visibility(settings.max_slope, &|| false), &selected, None, &|| false);
    let candidates: Vec<_> = cutters.iter().copied().map(CandidateCutter::new).collect();
    rank(&workpiece, &candidates, settings, SurfaceEvidence::default(), &|| false)
}

/// The largest memory of this process so far, in MB.
fn largest_memory() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").expect("a system with /proc");
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("the line of the largest memory");
    line.trim().trim_end_matches(" kB").parse::<f64>().expect("a number") / 1e3
}

fn main() {
    let machine = Machine::from(Preset::named("five_axis_vmc").expect("a preset").limits);
    let settings = PlanSettings::new(mm(0.01), machine);
    let max_slope = Angle::from_degrees(85.0).expect("an angle");
    let stated: Vec<u32> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    if std::env::args().any(|argument| argument == "memory") {
        let before = largest_memory();
        for &n in &stated {
            let mesh = waves(n, SERVICE_LIMIT);
            let built = largest_memory();
            black_box(planned(&mesh, &cutters(2), &settings));
            let count = 2 * u64::from(n) * u64::from(n);
            println!("{count} facets: {before:.0} MB at first, {built:.0} MB with the mesh, {:.0} MB at most", largest_memory());
        }
        return;
    }
    let is_ranking_only = std::env::args().any(|argument| argument == "rank");
    let mut lines = Vec::new();
    println!("{:>9}  {:<24} {:>12} {:>9}", "facets", "stage", "processor ms", "ms");
    // 2 x 77^2 = 11 858, 2 x 224^2 = 100 352, 2 x 707^2 = 999 698; others as stated.
    for n in if stated.is_empty() { vec![77, 224, 707] } else { stated } {
        let mesh = waves(n, MeshBuilder::DEFAULT_FACET_LIMIT);
        let facets = mesh.triangles().len();
        let mut report = |stage: &str, call: &mut dyn FnMut()| {
            if is_ranking_only && !stage.starts_with("rank") {
                return;
            }
            let [processor, time] = measured(call);
            println!("{facets:>9}  {stage:<24} {processor:>12.2} {time:>9.2}");
            lines.push(format!(r#"{{"facets":{facets},"stage":"{stage}","processor_ms":{processor:.3},"ms":{time:.3}}}"#));
        };
        report("build", &mut || drop(black_box(waves(n, MeshBuilder::DEFAULT_FACET_LIMIT))));
        report("pieces", &mut || drop(black_box(mesh.pieces(&|| false))));
        let selected = mesh.selected(&Selection::all(), &mesh.pieces(&|| false)).expect("a selection");
        report("visibility", &mut || drop(black_box(mesh.visibility(max_slope, &|| false))));
        let visibility = mesh.visibility(max_slope, &|| false);
        report("workpiece", &mut || drop(black_box(Workpiece::new(&mesh, &visibility, &selected, None, &|| false))));
        let workpiece = Workpiece::new(&mesh, &visibility, &selected, None, &|| false);
        report("view", &mut || drop(black_box(mesh.seen_from_above(256, &|| false))));
        for count in [2, 50] {
            let cutters = cutters(count);
            let candidates: Vec<_> = cutters.iter().copied().map(CandidateCutter::new).collect();
            report(&format!("rank {count}"), &mut || {
                drop(black_box(rank(&workpiece, &candidates, &settings, SurfaceEvidence::default(), &|| false)));
            });
            report(&format!("all, {count} cutters"), &mut || drop(black_box(planned(&mesh, &cutters, &settings))));
        }
    }
    std::fs::create_dir_all("target/benches").expect("a folder to write to");
    std::fs::write("target/benches/recommendation.json", format!("[{}]\n", lines.join(",\n"))).expect("a file to write");
}
