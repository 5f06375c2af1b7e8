//! The fastest direction of each cutter.

use super::march::Spaced;
use super::settings::Directions;
use super::simulate::{Operation, simulate};
use super::spacing::CutterSpacing;
use super::sweep::Sweep;
use super::workpiece::Workpiece;
use crate::quantity::Angle;
use rayon::prelude::*;

/// A cutter as the search sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contender<'a> {
    pub(super) spacing: &'a CutterSpacing,
    pub(super) operation: Operation<'a>,
    /// The cutter's diameter in mm.
    pub(super) diameter: f64,
}

/// The time of one direction, in s; `None` where no spacing keeps the scallop height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeOfDirection {
    pub(super) direction: Angle,
    pub(super) seconds: Option<f64>,
    /// Whether it is from the first pass on sampled facets, and rougher than the others.
    pub(super) is_rough: bool,
}

/// Facets beyond this number are sampled in the first pass over all directions, whose times then err by about 1 %.
const MOST_AT_FIRST: usize = 5_000;

/// Facets beyond this number are sampled around the best direction as well, where times then err by some 0.3 %.
const MOST_FACETS: usize = 60_000;

/// The times of each contender in the directions that are asked for, in rising order of direction.
pub(super) fn times_by_direction(
    workpiece: &Workpiece,
    contenders: &[Contender],
    directions: &Directions,
    left_out: f64,
) -> Vec<Vec<TimeOfDirection>> {
    let around = sampled(workpiece, MOST_FACETS);
    let around = around.as_ref().unwrap_or(workpiece);
    let mut times: Vec<Vec<TimeOfDirection>> = vec![Vec::new(); contenders.len()];
    let simulated = |facets: &Workpiece, wanted: Vec<(usize, Angle)>, found: &mut Vec<Vec<TimeOfDirection>>| {
        let is_rough = facets.len() < around.len();
        simulate_all(facets, contenders, wanted, Fineness { left_out, is_rough }, found);
    };
    match directions {
        Directions::Only(only) => simulated(around, for_all(contenders, only), &mut times),
        Directions::All { beside } => {
            let mut coarse: Vec<Angle> = (0..36).map(|step| half_degrees(10 * step)).collect();
            coarse.extend(beside.iter().filter(|angle| !is_among(&coarse, **angle)).copied().collect::<Vec<_>>());
            let first = sampled(workpiece, MOST_AT_FIRST);
            simulated(first.as_ref().unwrap_or(workpiece), for_all(contenders, &coarse), &mut times);
            // The best are simulated again with the facets of those around them, so that they compare.
            if first.is_some() {
                let best = take_fastest(&mut times);
                simulated(around, best, &mut times);
            }
            // Every degree within 4 deg of the best, then half a degree on both sides of the best of those.
            for steps in [&[-8, -6, -4, -2, 2, 4, 6, 8][..], &[-1, 1][..]] {
                let near = |(contender, found): (usize, &Vec<TimeOfDirection>)| {
                    let best = fastest(found);
                    steps.iter().filter_map(move |&step| best.map(|best| (contender, turned(best.direction, step)))).collect::<Vec<_>>()
                };
                let wanted = times.iter().enumerate().flat_map(near).filter(|&(contender, direction)| {
                    let tried: Vec<Angle> = times[contender].iter().map(|time| time.direction).collect();
                    !is_among(&tried, direction)
                });
                let wanted = wanted.collect();
                simulated(around, wanted, &mut times);
            }
        }
    }
    for times in &mut times {
        times.sort_by(|a, b| a.direction.radians().total_cmp(&b.direction.radians()));
    }
    times
}

/// The direction that takes least, a rough time counting only where there are no others.
pub(super) fn fastest(times: &[TimeOfDirection]) -> Option<TimeOfDirection> {
    let least = |is_rough: bool| {
        let found = times.iter().filter(|time| time.is_rough == is_rough).filter_map(|time| time.seconds.map(|seconds| (seconds, time)));
        found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, time)| *time)
    };
    least(false).or_else(|| least(true))
}

/// About `count` of the facets, where there are more.
fn sampled(workpiece: &Workpiece, count: usize) -> Option<Workpiece> {
    (workpiece.len() > count).then(|| workpiece.sampled(count))
}

/// Takes the two fastest directions of each contender out of the times, and returns them.
fn take_fastest(times: &mut [Vec<TimeOfDirection>]) -> Vec<(usize, Angle)> {
    let mut taken = Vec::new();
    for (contender, times) in times.iter_mut().enumerate() {
        for _ in 0..2 {
            if let Some(best) = fastest(times) {
                times.retain(|time| time.direction != best.direction);
                taken.push((contender, best.direction));
            }
        }
    }
    taken
}

fn for_all(contenders: &[Contender], directions: &[Angle]) -> Vec<(usize, Angle)> {
    directions.iter().flat_map(|&direction| (0..contenders.len()).map(move |contender| (contender, direction))).collect()
}

/// How exact simulated times are.
#[derive(Debug, Clone, Copy)]
struct Fineness {
    /// The share of a strip's area that may allow less than its spacing.
    left_out: f64,
    is_rough: bool,
}

/// Simulates pairs of contender and direction; the order of the facets is shared by all contenders of a direction.
fn simulate_all(
    workpiece: &Workpiece,
    contenders: &[Contender],
    mut wanted: Vec<(usize, Angle)>,
    fineness: Fineness,
    found: &mut [Vec<TimeOfDirection>],
) {
    wanted.sort_by(|a, b| a.1.radians().total_cmp(&b.1.radians()));
    let by_direction: Vec<&[(usize, Angle)]> = wanted.chunk_by(|a, b| a.1 == b.1).collect();
    let times: Vec<Vec<(usize, TimeOfDirection)>> = by_direction
        .par_iter()
        .map(|of_direction| {
            let direction = of_direction[0].1;
            let sweep = Sweep::new(workpiece, direction);
            let time = |&(contender, _): &(usize, Angle)| {
                let Contender { spacing, operation, diameter } = contenders[contender];
                let spaced = Spaced::new(workpiece, &sweep, spacing, diameter, fineness.left_out);
                let seconds = simulate(&spaced, operation).ok().map(|simulated| simulated.figures.seconds);
                (contender, TimeOfDirection { direction, seconds, is_rough: fineness.is_rough })
            };
            of_direction.par_iter().with_min_len(4).map(time).collect()
        })
        .collect();
    for (contender, time) in times.into_iter().flatten() {
        found[contender].push(time);
    }
}

/// A direction of a whole number of half degrees, from 0 to under 360.
fn half_degrees(count: i32) -> Angle {
    // Whole half degrees are always finite.
    Angle::from_degrees(f64::from(count.rem_euclid(360)) / 2.0).unwrap_or(Angle::ZERO)
}

/// The line turned by half degrees, within [0, 180) deg.
fn turned(direction: Angle, half_degrees: i32) -> Angle {
    let degrees = (direction.degrees() + f64::from(half_degrees) / 2.0).rem_euclid(180.0);
    Angle::from_degrees(degrees).unwrap_or(direction)
}

/// Whether a line is among others, to a thousandth of a degree.
fn is_among(lines: &[Angle], line: Angle) -> bool {
    lines.iter().any(|other| {
        let apart = (other.degrees() - line.degrees()).abs();
        apart.min(180.0 - apart) < 1e-3
    })
}
