//! The memory that a surface takes at each stage, counted by the allocator: `cargo bench --bench memory`
//!
//! It prints bytes for each facet: the memory held, the further peak while the stage runs, and the reservation that
//! `planning::memory` makes for it.

#![allow(clippy::cast_precision_loss, reason = "figures to print, under 2^53")]

use peak_alloc::PeakAlloc;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use scallopd::milling::Cutter;
use scallopd::motion::{Machine, Preset};
use scallopd::planning::memory::{Parallelism, RankingSize, bytes_of_mesh, bytes_to_prepare, bytes_to_rank};
use scallopd::planning::reach::ReachMap;
use scallopd::planning::zigzag::{
    CandidateCutter, NoRanking, PlanRoom, SurfaceEvidence, ZigzagSettings, bytes_of_passes, passes, rank_within,
};
use scallopd::quantity::{Angle, Length};
use scallopd::surface::mesh::Selection;
use scallopd::surface::{Facing, MeshBuilder, Sink, Unit};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const FACETS: usize = 500_000;

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

/// The allocator's peak while `stage` ran and its growth afterwards, both over the level at the start, and the result
/// of `stage`.
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
    println!("  {name:28} {:8.1} MB: {at_most:7.1} at most, stated {stated:7.1}, {held:7.1} held", peak as f64 / 1e6);
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
        line(&format!("trying 8 cutters, {threads} threads"), facets, 0, || {
            pool.install(|| tried.par_iter().map(|&cutter| reach.uncut(cutter, mm(0.01)).share).sum::<f64>())
        });
    }
    let machine = Machine::from(Preset::named("five_axis_vmc").expect("a preset").limits);
    for height in [0.01, 1e-4] {
        let settings = ZigzagSettings::new(mm(height), machine);
        for (threads, pool) in pools {
            let parallelism = Parallelism { threads: *threads, candidates: *threads };
            // Beside the facets themselves, of 152 bytes, which are held already.
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

fn main() {
    let pools: Vec<(usize, ThreadPool)> =
        [1, 2].map(|count| (count, ThreadPoolBuilder::new().num_threads(count).build().expect("threads"))).into();
    let builder = || MeshBuilder::with_facet_limit(FACETS);
    println!("200 facets");
    let mut few = builder();
    waves(200, 0.0, |facet| few.facet(facet));
    planned(few, &pools);
    for (name, count, gap) in [("shared corners", FACETS, 0.0), ("facets apart", FACETS, 0.01), ("merged", 4 * FACETS, 0.01)] {
        println!("{name}");
        let stated = builder().bytes_to_take(FACETS, 3 * FACETS);
        let builder = line("building", FACETS, stated, || {
            let mut builder = builder();
            waves(count, gap, |facet| builder.facet(facet));
            builder
        });
        println!("  held by its own account: {} each", builder.held_bytes() / FACETS);
        planned(builder, &pools);
    }
    for count in [FACETS / 50, FACETS] {
        println!("{count} points");
        let stated = builder().bytes_to_take(count, 0);
        let builder = line("building", count, stated, || {
            let mut builder = builder();
            waves(count, 0.0, |[corner, ..]| builder.point(corner));
            builder
        });
        planned(builder, &pools[..1]);
    }
}
