//! The memory that a surface takes at each stage, counted by the allocator: `cargo bench --bench memory`
//!
//! It prints bytes for each facet: the memory held, the further peak while the stage runs, and the reservation for it.
//! It ends with exit code 1 if a stage takes more than its reservation. With `-- --quick`, surfaces have a tenth of the
//! facets.

#![allow(clippy::cast_precision_loss, reason = "figures to print, under 2^53")]
#![allow(clippy::cast_possible_truncation, reason = "coordinates of files")]

use peak_alloc::PeakAlloc;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use scallopd::milling::Cutter;
use scallopd::motion::{Machine, Preset};
use scallopd::planning::memory::{Parallelism, RankingSize, bytes_of_mesh, bytes_to_prepare, bytes_to_rank, bytes_to_try};
use scallopd::planning::reach::ReachMap;
use scallopd::planning::zigzag::{
    CandidateCutter, NoRanking, PlanRoom, SurfaceEvidence, ZigzagSettings, bytes_of_passes, passes, rank_within,
};
use scallopd::quantity::{Angle, Length};
use scallopd::surface::mesh::Selection;
use scallopd::surface::read::{FormatHint, Reader};
use scallopd::surface::{Bezier, Facing, MeshBuilder, MeshPart, PartedSink, Sink, Unit};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// The facets of a surface; a tenth with `--quick`.
const FACETS: usize = 500_000;

/// Whether a stage took more than its reservation.
static IS_EXCEEDED: AtomicBool = AtomicBool::new(false);

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

/// The allocator's peak while `stage` ran and its level afterwards, both relative to the level at the start, and the
/// result of `stage`.
fn counted<T>(stage: impl FnOnce() -> T) -> (usize, isize, T) {
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    let result = stage();
    let after = ALLOCATOR.current_usage();
    (ALLOCATOR.peak_usage() - before, after.cast_signed() - before.cast_signed(), result)
}

/// Prints the line of a stage, with its figures divided by `facets`.
fn line<T>(name: &str, facets: usize, stated: usize, stage: impl FnOnce() -> T) -> T {
    let (peak, held, result) = counted(stage);
    let each = |bytes: f64| bytes / facets as f64;
    let (at_most, held, stated) = (each(peak as f64), each(held as f64), each(stated as f64));
    let verdict = if at_most > stated { " EXCEEDED" } else { "" };
    println!("  {name:28} {:8.1} MB: {at_most:7.1} at most, stated {stated:7.1}, {held:7.1} held{verdict}", peak as f64 / 1e6);
    IS_EXCEEDED.fetch_or(at_most > stated, Ordering::Relaxed);
    result
}

/// Facets of waves over 100 x 100 mm. With `gap` over 0, no two facets share a corner.
fn waves(count: usize, gap: f64, mut take: impl FnMut([[f64; 3]; 3])) {
    let side = (count / 2).isqrt();
    let step = 100.0 / side as f64;
    let at = |x: f64, y: f64| [x, y, 6.0 * (0.1 * x).sin() * (0.12 * y).cos()];
    for i in 0..side {
        for j in 0..side {
            let (x, y) = (step * i as f64, step * j as f64);
            let wide = step * (1.0 - gap);
            take([at(x, y), at(x + wide, y), at(x + wide, y + wide * (1.0 - gap))]);
            take([at(x, y + step * gap), at(x + wide * (1.0 - gap), y + wide), at(x, y + wide)]);
        }
    }
}

fn planned(builder: MeshBuilder, pools: &[(usize, ThreadPool)]) {
    let size = builder.size();
    let stated = bytes_of_mesh(size) + builder.bytes_to_finish();
    let mesh = line("finish", size.facets, stated, || builder.finish(Unit::Millimetre, Facing::Up)).expect("a mesh");
    let size = mesh.size();
    println!("  {} points, {} facets", size.points, size.facets);
    let facets = size.facets;
    let finish = line("preparing", facets, bytes_to_prepare(size), || {
        let selected = mesh.selected(&Selection::all(), &mesh.pieces()).expect("a selection");
        let visibility = mesh.visibility(Angle::from_degrees(85.0).expect("an angle"));
        mesh.facets_for_finishing(&visibility, &selected)
    });
    let view = mesh.seen_from_above(256);
    let reach = ReachMap::new(&mesh, &view, &vec![true; facets]);
    let toroidal = |index: u32| Cutter::toroidal(mm(6.0 + 0.1 * f64::from(index)), mm(1.0)).expect("a cutter");
    let cutters: Vec<CandidateCutter> = (0..8).map(|index| CandidateCutter::new(toroidal(index))).collect();
    let tried: Vec<Cutter> = cutters.iter().map(|candidate| candidate.cutter).collect();
    for (threads, pool) in pools {
        line(&format!("trying 8 cutters, {threads} threads"), facets, bytes_to_try(*threads), || {
            pool.install(|| tried.par_iter().map(|&cutter| reach.uncut(cutter, mm(0.01)).share).sum::<f64>())
        });
    }
    for (threads, pool) in pools {
        for diameters in [60, 200] {
            let size = RankingSize { facets, candidates: 8, diameters };
            let side = size.reach_side();
            line(&format!("raster of {side}, {threads} threads"), facets, size.bytes_of_fine_reach(*threads), || {
                let reach = ReachMap::new(&mesh, &mesh.seen_from_above(side), &vec![true; facets]);
                let small = (1..=8).map(|index| Cutter::ball_end(mm(0.25 * f64::from(index)))).collect::<Vec<_>>();
                pool.install(|| small.par_iter().map(|&cutter| reach.uncut(cutter, mm(0.01)).share).sum::<f64>())
            });
        }
    }
    let machine = Machine::from(Preset::named("five_axis_vmc").expect("a preset").limits);
    for height in [0.01, 1e-4] {
        let settings = ZigzagSettings::new(mm(height), machine);
        for (threads, pool) in pools {
            let parallelism = Parallelism { threads: *threads, candidates: *threads };
            // In addition to the facets themselves, of 152 bytes, which are already in memory.
            let ranked = |room: PlanRoom| {
                let size = RankingSize { facets, candidates: cutters.len(), diameters: 24 };
                let stated = bytes_to_rank(size, parallelism, room) - 152 * facets;
                let name = format!("8 cutters, {threads} threads, {height}, {} planes", room.planes);
                let evidence = SurfaceEvidence::default();
                line(&name, facets, stated, || pool.install(|| rank_within(&finish, &cutters, &settings, evidence, room, &|| false)))
            };
            let ranking = match ranked(PlanRoom::USUAL) {
                Err(NoRanking::NoRoom) => ranked(PlanRoom::LARGEST),
                ranking => ranking,
            };
            let plan = ranking.as_ref().ok().and_then(|ranking| ranking.plans.first()).expect("a plan");
            let candidate = &cutters[plan.candidate];
            let size = RankingSize { facets, candidates: 1, diameters: 24 };
            let stated_one = bytes_to_rank(size, Parallelism { threads: *threads, candidates: 1 }, PlanRoom::LARGEST) - 152 * facets;
            let stated = stated_one + bytes_of_passes(plan, &finish, 100_000);
            let points =
                line("passes", facets, stated, || pool.install(|| passes(plan, &finish, candidate, &settings, &|tip| tip[2], 100_000)));
            println!("  {} planes, {:?} points", plan.planes, points.map(|passes| passes.points.len()));
        }
    }
}

/// A sink that takes parts, as the service's.
struct Received(MeshBuilder);

impl Sink for Received {
    fn point(&mut self, point: [f64; 3]) {
        self.0.point(point);
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        self.0.facet(corners);
    }
}

impl PartedSink for Received {
    type Part = MeshPart;

    fn part(&self) -> MeshPart {
        self.0.part()
    }

    fn append(&mut self, part: MeshPart) {
        self.0.append(part);
    }
}

/// The least number of parts into which a file is divided.
const PARTS: usize = 3;

/// Reads a file in blocks as an upload, and compares the memory of each.
fn read(name: &str, file: &[u8]) {
    let mut reader = Reader::new(FormatHint::default());
    let mut sink = Received(MeshBuilder::with_facet_limit(FACETS));
    let block = (1 << 20).min(file.len() / PARTS);
    for (number, block) in file.chunks(block).take(8).enumerate() {
        let push = reader.most_of_push(block.len());
        let vertices = reader.held_bytes() / size_of::<[f64; 3]>();
        let stated = push.held + sink.0.bytes_to_take(push.facets, push.corners + vertices);
        line(&format!("{name}, block {number}"), block.len(), stated, || reader.push_in_parallel([block], &mut sink).expect("a file"));
    }
}

/// The files that make the most of their bytes.
fn files() {
    println!("reading, for each byte of a block");
    let mut stl = vec![0; 80];
    stl.extend(120_000_u32.to_le_bytes());
    let mut text = String::new();
    let mut obj = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    waves(120_000, 0.01, |corners| {
        stl.extend([0; 12]);
        stl.extend(corners.iter().flatten().flat_map(|&coordinate| (coordinate as f32).to_le_bytes()));
        stl.extend([0; 2]);
    });
    stl.truncate(84 + (stl.len() - 84) / 50 * 50);
    let count = u32::try_from((stl.len() - 84) / 50).expect("a count");
    stl[80..84].copy_from_slice(&count.to_le_bytes());
    (0..1000).for_each(|index| text.extend(["1 2 3\n", "4 5 6\n"].map(|line| line.repeat(500 + index % 2))));
    (0..40_000).for_each(|_| obj.extend(["f", &" 1 2 3".repeat(40), "\n"]));
    let ply_of = |index: &str, vertices: usize, of_vertices: &[u8], faces: usize, of_face: &[u8]| {
        let header = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty char x\nproperty char y\nproperty char z\n\
             element face {faces}\nproperty list uchar {index} vertex_indices\nend_header\n"
        );
        [header.as_bytes(), of_vertices, &of_face.repeat(faces)].concat()
    };
    let ply = |vertices, of_vertices, faces, of_face| ply_of("uchar", vertices, of_vertices, faces, of_face);
    let circle: Vec<u8> = (0..250)
        .flat_map(|index| {
            let (sin, cos) = (f64::from(index) / 250.0 * std::f64::consts::TAU).sin_cos();
            [((120.0 * cos) as i8).cast_unsigned(), ((120.0 * sin) as i8).cast_unsigned(), 1]
        })
        .collect();
    let polygon: Vec<u8> = std::iter::once(250).chain(0..250).collect();
    read("STL", &stl);
    read("text", text.as_bytes());
    read("OBJ", obj.as_bytes());
    read("PLY of triangles", &ply(3, &[0, 0, 0, 9, 0, 0, 0, 9, 0], 1_000_000, &[3, 0, 1, 2]));
    let wide = |corners: [i32; 3]| std::iter::once(3).chain(corners.into_iter().flat_map(i32::to_le_bytes)).collect::<Vec<u8>>();
    read("PLY of triangles, wide", &ply_of("int", 3, &[0, 0, 0, 9, 0, 0, 0, 9, 0], 300_000, &wide([0, 1, 2])));
    let wide_polygon: Vec<u8> = std::iter::once(250).chain((0..250_i32).flat_map(i32::to_le_bytes)).collect();
    read("PLY of polygons, wide", &ply_of("int", 250, &circle, 3000, &wide_polygon));
    read("PLY of polygons", &ply(250, &circle, 12_000, &polygon));
}

/// A patch with as many samples as it may have.
fn patch() {
    println!("a patch of a million samples");
    let net: Vec<Vec<[f64; 3]>> =
        (0..4).map(|x| (0..4).map(|y| [f64::from(20 * x), f64::from(20 * y), f64::from(x * y % 7)]).collect()).collect();
    let patch = Bezier::new(&net).expect("a patch");
    line("tessellated", 2_000_000, 48 << 20, || patch.tessellate(1000, MeshBuilder::with_facet_limit(FACETS)).expect("facets"));
}

fn main() -> ExitCode {
    let is_quick = std::env::args().any(|argument| argument == "--quick");
    let facets = if is_quick { FACETS / 10 } else { FACETS };
    let pools: Vec<(usize, ThreadPool)> =
        [1, 2].map(|count| (count, ThreadPoolBuilder::new().num_threads(count).build().expect("threads"))).into();
    let builder = || MeshBuilder::with_facet_limit(facets);
    files();
    patch();
    println!("200 facets");
    let mut few = builder();
    waves(200, 0.0, |facet| few.facet(facet));
    planned(few, &pools);
    for (name, count, gap) in [("shared corners", facets, 0.0), ("facets apart", facets, 0.01), ("merged", 4 * facets, 0.01)] {
        println!("{name}");
        let stated = builder().bytes_to_take(count, 3 * count);
        let builder = line("building", facets, stated, || {
            let mut builder = builder();
            waves(count, gap, |facet| builder.facet(facet));
            builder
        });
        println!("  held by its own account: {} each", builder.held_bytes() / facets);
        planned(builder, &pools);
    }
    for count in [facets / 50, facets] {
        println!("{count} points");
        let stated = builder().bytes_to_take(count, 0);
        let builder = line("building", count, stated, || {
            let mut builder = builder();
            waves(count, 0.0, |[corner, ..]| builder.point(corner));
            builder
        });
        planned(builder, &pools[..1]);
    }
    if IS_EXCEEDED.load(Ordering::Relaxed) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
