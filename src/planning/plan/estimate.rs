//! The time of a zigzag in one direction, estimated from the stations of a cutter. It is continuous in the direction, and
//! does not depend on which other directions are asked for.

use super::family::{Allowed, Family, Heading, Seen, Spread};
use super::runs::STEP_IN_RADII;
use super::settings::{Pattern, PlanSettings};
use super::spacing::Prepared;
use super::stations::Station;
use super::travel;
use super::workpiece::Workpiece;

/// The mean distances of a strip's stations beyond which two of them belong to different runs: random ones are with a probability
/// of e^-12, and a lift that is none costs seconds.
const GAP: f64 = 12.0;

/// The same for a run beside which another one goes on.
const PASSED: f64 = 4.0;

/// The most lines of a plan.
pub(super) const MOST_LINES: usize = 50_000;

/// The estimated time in s of lines of a family over the stations; `None` if some station has no spacing, or there would be too many
/// lines.
pub(super) fn seconds(
    workpiece: &Workpiece,
    stations: &[Station],
    prepared: &Prepared,
    settings: &PlanSettings,
    family: &Family,
) -> Option<f64> {
    let spread = Spread::new(workpiece, stations, prepared, family, settings.scallop_height.mm());
    let allowed = Allowed::of(&spread, &prepared.candidate, settings.left_out_share);
    let lines = allowed.lines(spread.range, MOST_LINES)?;
    let radius = prepared.profile.outer_radius();
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    let area_of_station = stations.iter().map(|station| station.place.area).sum::<f64>() / stations.len().max(1) as f64;
    let rapid = settings.machine.rapid_rate.mm_s();
    let depth = workpiece.top - workpiece.bounds[0][2];
    let up = settings.machine.clearance_height.mm() + depth / 2.0;
    let lift = |across: f64| {
        2.0 * travel::straight(up, rapid, &settings.machine)
            + travel::straight(across, rapid, &settings.machine)
            + travel::straight(travel::APPROACH_HEIGHT, prepared.link_rate, &settings.machine)
    };
    let mut seconds = 0.0;
    let (mut all_runs, mut most_runs) = (0, 0);
    for (index, &line) in lines.iter().enumerate() {
        let before = if index == 0 { spread.range[0] } else { f64::midpoint(lines[index - 1], line) };
        let after = if index + 1 == lines.len() { spread.range[1] } else { f64::midpoint(line, lines[index + 1]) };
        let width = (after - before).max(1e-9);
        // The stations of a strip are as far apart along it as their share of its area says.
        let runs = runs_of(spread.between(before, after), radius, area_of_station / width);
        for run in &runs {
            seconds += travel::run(run.length / width, run.time / width, &settings.machine);
            // Runs between the same walls follow each other, on one line after the other.
            seconds += match settings.pattern {
                _ if all_runs == 0 => 0.0,
                Pattern::Zigzag => travel::straight(width, prepared.link_rate, &settings.machine),
                Pattern::OneWay => lift(run.length / width),
            };
            all_runs += 1;
        }
        most_runs = most_runs.max(runs.len());
    }
    // One lift from each row of such runs to the next.
    #[expect(clippy::cast_precision_loss, reason = "few runs")]
    let further = most_runs.saturating_sub(1) as f64;
    Some(seconds + further * lift(4.0 * radius))
}

/// The stations of one run, as far as they are known.
struct RunSums<'a> {
    length: f64,
    time: f64,
    last: &'a Seen,
}

/// The stations of a strip, in runs. A run ends where no station follows it, and at walls, which the cutter does not climb at the
/// feed rate. `mean` is the mean distance in mm of the strip's stations along it.
fn runs_of(strip: &[Seen], radius: f64, mean: f64) -> Vec<RunSums<'_>> {
    let gap = (2.0 * radius).max(GAP * mean);
    let passed = (2.0 * radius).max(PASSED * mean);
    let mut along: Vec<&Seen> = strip.iter().collect();
    along.sort_unstable_by(|a, b| a.along.total_cmp(&b.along));
    let mut runs: Vec<RunSums<'_>> = Vec::new();
    // A wall that crosses the strip obliquely has stations of both runs beside each other. Runs of which the other has passed the end
    // have ended.
    let mut open: Vec<usize> = Vec::new();
    for seen in along {
        open.retain(|&run| seen.along - runs[run].last.along <= gap);
        let joined = open.iter().copied().filter(|&run| !runs[run].last.is_walled_off(seen, STEP_IN_RADII * radius));
        let joined = joined.max_by(|&a, &b| runs[a].last.along.total_cmp(&runs[b].last.along));
        let run = joined.unwrap_or_else(|| {
            runs.push(RunSums { length: 0.0, time: 0.0, last: seen });
            open.push(runs.len() - 1);
            runs.len() - 1
        });
        let RunSums { length, time, last } = &mut runs[run];
        (*length, *time, *last) = (*length + seen.length, *time + seen.time, seen);
        open.retain(|&other| seen.along - runs[other].last.along <= passed);
    }
    runs
}

/// A lower bound of the time of any lines: the integral of dA / (v s) over the stations, v s the largest product of feed
/// rate and step-over of any direction there.
pub(super) fn least_seconds(workpiece: &Workpiece, stations: &[Station], prepared: &Prepared, tolerance: f64) -> f64 {
    /// Squared step-overs are nearly linear in cos^2(alpha): the widest lies within 2.5 deg of one of 36 directions and
    /// exceeds its step-over by at most 0.2 %, which the slack covers.
    const DIRECTIONS: u32 = 36;
    const SLACK: f64 = 0.998;
    let directions: Vec<[f64; 2]> =
        (0..DIRECTIONS).map(|step| Heading::of(f64::from(step) * std::f64::consts::PI / f64::from(DIRECTIONS)).along).collect();
    let time = |station: &Station| {
        let tangent = &workpiece.tangents[station.place.target];
        let rate = directions.iter().map(|&along| {
            let (cos_alpha, sin_alpha) = tangent.alpha(along);
            let squared = prepared.spacing.squared(tangent, cos_alpha, sin_alpha);
            (squared / tangent.ratio_squared(cos_alpha)).sqrt() * prepared.feeds.rate(tangent, cos_alpha, 1.0)
        });
        let widest = rate.fold(0.0, f64::max);
        if widest > 0.0 && station.lift <= tolerance { station.place.area / widest } else { 0.0 }
    };
    // Over 600 stations the mean is as exact as the sampled area.
    let step = (stations.len() / 600).max(1);
    let sampled = stations.iter().step_by(step).map(time).sum::<f64>();
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    let scale = stations.len() as f64 / stations.len().div_ceil(step).max(1) as f64;
    SLACK * sampled * scale
}
