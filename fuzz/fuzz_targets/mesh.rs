//! Fuzz target: the mesh and the simulation on it. The bytes become facets that may degenerate, fold over, intersect
//! and share points. Every figure and every point of the passes must be finite, and shares must add up.

#![no_main]

use scallopd::milling::Cutter;
use scallopd::motion::{Machine, Preset};
use scallopd::planning::SurfaceEvidence;
use scallopd::planning::plan::{CandidateCutter, Directions, PlanSettings, Workpiece, passes, rank};
use scallopd::quantity::{Angle, Length};
use scallopd::surface::mesh::Selection;
use scallopd::surface::{Facing, MeshBuilder, Sink, Unit};
use std::time::{Duration, Instant};

/// The longest time of a ranking.
const LONGEST: Duration = Duration::from_secs(1);

/// A coordinate from a byte: a few values repeat, so that points coincide; others are far away, tiny or nearly equal.
fn coordinate(byte: u8) -> f64 {
    match byte {
        0..=199 => f64::from(byte % 50) * 0.5,
        200..=219 => f64::from(byte) * 1e-9,
        220..=239 => (f64::from(byte) - 230.0) * 1e3,
        _ => 12.0 + f64::from(byte) * 1e-12,
    }
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    // The lowest bits select facets or points, a small or large limit, and the side.
    let mut builder = MeshBuilder::with_facet_limit(if first & 2 == 0 { 8 } else { 4096 });
    let points: Vec<[f64; 3]> = bytes.chunks_exact(3).map(|point| [0, 1, 2].map(|axis| coordinate(point[axis]))).collect();
    if first & 1 == 0 {
        // Each facet takes the two points before it, as a strip, so that facets share points and edges.
        points.windows(3).for_each(|corners| builder.facet([corners[0], corners[1], corners[2]]));
    } else {
        points.iter().for_each(|&point| builder.point(point));
    }
    let facing = if first & 4 == 0 { Facing::Up } else { Facing::Any };
    let Ok(mesh) = builder.finish(Unit::Millimetre, facing, &|| false) else { return };
    let max_slope = Angle::from_degrees(85.0).expect("an angle");
    let pieces = mesh.pieces(&|| false);
    let selected = mesh.selected(&Selection::all(), &pieces).expect("all facets");
    let visibility = mesh.visibility(max_slope, &|| false);
    let shares = visibility.shares();
    assert!((shares.hidden + shares.overhanging + shares.steep + shares.machined - 1.0).abs() < 1e-6);
    let facets = mesh.facets_for_finishing(&visibility, &selected, &|| false);
    for facet in &facets {
        assert!(facet.normal[2] > 0.0 && facet.area > 0.0 && facet.curvature.iter().all(|part| part.is_finite()));
    }
    let cutter = Cutter::toroidal(Length::from_mm(10.0).expect("a length"), Length::from_mm(2.0).expect("a length")).expect("a cutter");
    let height = Length::from_mm(0.01).expect("a length");
    let machine = Machine::from(Preset::named("five_axis_vmc").expect("a preset").limits);
    let directions = Directions::Only(vec![Angle::from_degrees(f64::from(*first)).expect("an angle")]);
    let settings = PlanSettings { directions, max_uncut_share: 1.0, ..PlanSettings::new(height, machine) };
    let workpiece = Workpiece::new(&mesh, &visibility, &selected, None, &|| false);
    let candidate = CandidateCutter::new(cutter);
    // Facets of many metres take longer than a target may; the service's time limit stops them like this.
    let begun = Instant::now();
    let is_late = || begun.elapsed() > LONGEST;
    let Some(ranking) = rank(&workpiece, &[candidate], &settings, SurfaceEvidence::default(), &is_late) else { return };
    for plan in &ranking.plans {
        assert!(plan.time.seconds() > 0.0 && plan.time.seconds().is_finite());
        let Some(passes) = passes(&workpiece, plan, &settings, &|| false) else { continue };
        assert!(!passes.run_starts.is_empty());
        let contacts = passes.points.iter().filter_map(|point| point.cut).flat_map(|cut| cut.contact);
        assert!(passes.points.iter().flat_map(|point| point.tip).chain(contacts).all(f64::is_finite));
    }
});
