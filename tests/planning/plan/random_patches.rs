//! The fastest cutter on random smooth patches, compared with an independent simulation on samples of the patch in
//! place of facets.

use super::surfaces::{BezierPatch, Patch, cross, dot, facets, unit};
use super::{published_cutters, ranked, settings, workpiece};
use scallopd::milling::Model;
use scallopd::motion::{Preset, travel_time};
use scallopd::planning::plan::estimated_times;
use scallopd::quantity::Length;

/// The number of patches.
const PATCHES: u32 = 40;

/// The number of samples along each parameter. The worst sample of a strip represents its worst point; with a quarter
/// as many, the step-over is up to a sixth too large.
const SAMPLES: u32 = 120;

/// Pseudo-random numbers from 0 to 1 (Knuth's multiplier).
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    f64::from(u32::try_from(*state >> 32).unwrap()) / f64::from(u32::MAX)
}

/// A patch of 30 to 120 mm with a bulge or hollow of up to a fifth of that, tilted by up to 45 deg and turned about Z.
fn patch(state: &mut u64) -> BezierPatch {
    let [w, h] = [0, 1].map(|_| 30.0 + 90.0 * random(state));
    let (tilt_sin, tilt_cos) = (45.0 * random(state)).to_radians().sin_cos();
    let (sin, cos) = (360.0 * random(state)).to_radians().sin_cos();
    let mut point = |i: u32, j: u32| {
        let (x, y) = (w * f64::from(i) / 3.0, h * f64::from(j) / 3.0);
        let z = 0.2 * w.min(h) * (2.0 * random(state) - 1.0);
        let (y, z) = (y * tilt_cos - z * tilt_sin, y * tilt_sin + z * tilt_cos);
        [cos * x - sin * y, sin * x + cos * y, z]
    };
    let net = (0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect();
    BezierPatch { net }
}

/// A sample of a patch: point, unit normal, area seen from above.
struct Sample {
    place: [f64; 3],
    normal: [f64; 3],
    area: f64,
}

fn samples(patch: &BezierPatch) -> Vec<Sample> {
    let count = f64::from(SAMPLES);
    let at = |i: u32, j: u32| {
        let [place, ru, rv, ..] = patch.at((f64::from(i) + 0.5) / count, (f64::from(j) + 0.5) / count);
        let n = cross(ru, rv);
        let n = if n[2] < 0.0 { n.map(|c| -c) } else { n };
        Sample { place, normal: unit(n), area: dot(n, [0.0, 0.0, 1.0]) / (count * count) }
    };
    (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| at(i, j))).collect()
}

/// The time of zigzag passes in one direction by the rules of the paper: the spacing of each strip is that of its worst
/// sample, the length of a pass that of the samples in a window around its plane, and links are as long as the spacing.
fn time(samples: &[Sample], direction: f64, core: f64, corner: f64) -> f64 {
    let limits = Preset::named("five_axis_vmc").unwrap().limits;
    let (sin, cos) = direction.to_radians().sin_cos();
    let h = 0.01;
    let mut strips: Vec<(f64, f64, f64)> = samples
        .iter()
        .map(|Sample { place, normal: n, area }| {
            let horizontal = n[0].hypot(n[1]);
            let cos_alpha = if horizontal > 0.0 { (n[0] * cos + n[1] * sin) / horizontal } else { 1.0 };
            let ratio_squared = 1.0 - horizontal * horizontal * (1.0 - cos_alpha * cos_alpha);
            let radius = if core > 0.0 { core * cos_alpha * cos_alpha / (horizontal * ratio_squared) + corner } else { corner };
            let step_over = 2.0 * (2.0 * radius * h - h * h).sqrt();
            let spacing = (step_over * ratio_squared.sqrt()).min(10.0);
            let climb = (n[0] * cos + n[1] * sin) / n[2];
            (cos * place[1] - sin * place[0], spacing, area * climb.hypot(1.0))
        })
        .collect();
    strips.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (low, high) = (strips[0].0, strips[strips.len() - 1].0);
    let next = |at: f64| {
        let from = strips.partition_point(|&(q, ..)| q < at);
        let mut widest = f64::INFINITY;
        for &(q, spacing, _) in &strips[from..] {
            if q - at >= widest {
                break;
            }
            widest = widest.min(spacing.max(q - at));
        }
        widest
    };
    let seconds = |length: f64| travel_time(Length::from_mm(length.max(1e-6)).unwrap(), limits).seconds();
    let window = ((high - low) / f64::from(SAMPLES) * 4.0).min(high - low);
    let (mut at, mut total) = (low + next(low) / 2.0, 0.0);
    while at < high {
        let (from, to) = ((at - window / 2.0).max(low), (at + window / 2.0).min(high));
        let range = strips.partition_point(|&(q, ..)| q < from)..strips.partition_point(|&(q, ..)| q < to);
        total += seconds(strips[range].iter().map(|&(.., length)| length).sum::<f64>() / (to - from));
        let spacing = next(at);
        total += seconds(spacing.min(high - at));
        at += spacing;
    }
    total
}

/// How much longer the cutter with the shorter time of `named` takes than the faster one, by the independent simulation.
fn loss(patch: &BezierPatch, named: [f64; 2]) -> f64 {
    let samples = samples(patch);
    let times = [(3.0, 2.0), (0.0, 5.0)].map(|(core, corner)| {
        let directions = (0..12).map(|step| 15.0 * f64::from(step));
        directions.map(|direction| time(&samples, direction, core, corner)).fold(f64::INFINITY, f64::min)
    });
    println!("{named:.2?} s, {times:.2?} s by the independent simulation");
    times[usize::from(named[1] < named[0])] / times[0].min(times[1]) - 1.0
}

/// Estimates choose the cutters and directions that are milled.
#[test]
fn estimates_name_the_faster_cutter_on_random_patches() {
    let mut state = 12;
    let settings = settings(Model::Analytic);
    // Some patches have hollows that the cutters do not fit into, which the independent simulation does not know.
    let mut losses: Vec<f64> = (0..PATCHES)
        .filter_map(|_| {
            let patch = patch(&mut state);
            // At the edges between concave facets of 5 mm, a ball of 5 mm stands 0.01 mm over the crease.
            let part = workpiece(&facets(&patch, 80, 80));
            let times = estimated_times(&part, &published_cutters(), &settings, &|| false).unwrap();
            Some(loss(&patch, [times[0]?.seconds(), times[1]?.seconds()]))
        })
        .collect();
    assert!(losses.len() >= 20, "{} of {PATCHES} patches are reached", losses.len());
    losses.sort_by(f64::total_cmp);
    let [median, most] = [losses[losses.len() / 2], losses[losses.len() * 95 / 100]];
    println!("losses: {median:.4} in the median, {most:.4} at 95 %, {:.4} at most", losses[losses.len() - 1]);
    assert!(median <= 0.01 && most <= 0.04, "{losses:?}");
}

#[test]
fn the_faster_cutter_is_recommended_on_random_patches() {
    let mut state = 12;
    for _ in 0..3 {
        let patch = patch(&mut state);
        let ranking = ranked(&facets(&patch, 24, 24), &published_cutters(), &settings(Model::Analytic));
        if !ranking.not_ranked.is_empty() {
            continue;
        }
        let seconds = |cutter: usize| ranking.plans.iter().find(|plan| plan.candidate == cutter).map(|plan| plan.time.seconds());
        let loss = loss(&patch, [0, 1].map(|cutter| seconds(cutter).unwrap()));
        assert!(loss <= 0.04, "{loss}");
    }
}
