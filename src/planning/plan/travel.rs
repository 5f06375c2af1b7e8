//! Times of runs and links, each a move from rest to rest.

use crate::motion::{Machine, MachineLimits, travel_time};
use crate::quantity::{Length, Speed};

/// The height in mm over a run's first tip at which a rapid approach ends; the rest of the way down is a move at the feed
/// rate.
pub const APPROACH_HEIGHT: f64 = 1.0;

/// A distance in mm far below the rounding of programs.
pub(super) const NEGLIGIBLE: f64 = 1e-5;

/// The time in s of a straight move of `length` mm at most at `rate` mm/s.
pub(super) fn straight(length: f64, rate: f64, machine: &Machine) -> f64 {
    if length <= 0.0 {
        return 0.0;
    }
    let limits = MachineLimits { feed_rate: Speed::computed(rate), ..machine.limits };
    machine.time_factor * travel_time(Length::computed(length), limits).seconds()
}

/// The time in s of a run from rest to rest at its mean speed: `length` mm that take `seconds` without stops.
pub(super) fn run(length: f64, seconds: f64, machine: &Machine) -> f64 {
    if length <= 0.0 || seconds <= 0.0 { 0.0 } else { straight(length, length / seconds, machine) }
}

/// The time in s of a lift from one tip to another over the height `clearance`: up, across and down at the rapid rate, the
/// last millimetre at `plunge_rate` in mm/s.
pub(super) fn lift(from: [f64; 3], to: [f64; 3], clearance: f64, plunge_rate: f64, machine: &Machine) -> f64 {
    let rapid = machine.rapid_rate.mm_s();
    let across = (to[0] - from[0]).hypot(to[1] - from[1]);
    straight(clearance - from[2], rapid, machine)
        + straight(across, rapid, machine)
        + straight(clearance - to[2] - APPROACH_HEIGHT, rapid, machine)
        + straight(APPROACH_HEIGHT, plunge_rate, machine)
}

/// The length in mm of a chain of points.
pub(super) fn length_of<'a>(points: impl Iterator<Item = &'a [f64; 3]>) -> f64 {
    let mut last: Option<[f64; 3]> = None;
    points.map(|&point| last.replace(point).map_or(0.0, |last| distance(last, point))).sum()
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}
