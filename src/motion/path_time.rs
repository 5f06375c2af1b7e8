//! The time of a path of many straight moves on a control that looks ahead and rounds corners within a tolerance.

use super::{MachineLimits, travel_time};
use crate::numerics::vector::{difference, length};
use crate::quantity::{Length, Speed, Time};

/// The evaluations of a piece's time in the search for its acceleration: golden sections narrow the ratio of 1000 to 1.005.
const SECTIONS: u32 = 16;

/// The smallest acceleration looked at, as a share of the machine's.
const LEAST_ACCELERATION: f64 = 1e-3;

/// A part of the path with one limit of the speed.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    length: f64,
    limit: f64,
}

/// The time of the path through the points, from rest to rest. `feeds` has the feed rate of the move to each point but the
/// first; acceleration and jerk are those of `limits`, whose feed rate does not count.
///
/// The control rounds the corner between moves of the lengths L1 and L2 that turn by 2b with an arc of the radius
/// rho = min(tolerance cos b/(1 - cos b), min(L1, L2)/(2 tan b)), at a speed up to min(sqrt(A rho), cbrt(J rho^2)). If the
/// second radius is the smaller one, the points are of a curve and the speed holds along half of the shorter move on both
/// sides. Under these limits and those of the feeds, speeds change by at most the acceleration; the jerk adds a/J for each
/// change from rest to the feed, for the acceleration a <= A that is best for the part between two local minima of the
/// speed.
///
/// For one straight move it is [`travel_time`]. As the tolerance goes to 0 it becomes the sum over the moves from rest to
/// rest, within 0.4 %.
///
/// # Panics
/// If `feeds` is shorter than the number of moves.
#[must_use]
pub fn path_time(points: &[[f64; 3]], feeds: &[Speed], limits: MachineLimits, tolerance: Length) -> Time {
    let (acceleration, jerk) = (limits.acceleration.mm_s2(), limits.jerk.mm_s3());
    let stretches = stretches(points, feeds, acceleration, jerk, tolerance.mm());
    let mut nodes = Vec::with_capacity(stretches.len() + 1);
    speeds(&stretches, 0.0, 0.0, acceleration, &mut nodes);
    let mut total = 0.0;
    let mut first = 0;
    let mut scratch = Vec::new();
    // The node to which the speed fell, while it has not risen since.
    let mut lowest = None;
    for (at, stretch) in stretches.iter().enumerate() {
        let peak = peak(*stretch, nodes[at], nodes[at + 1], acceleration);
        if let Some(minimum) = lowest
            && peak > nodes[at]
        {
            total += piece_time(&stretches[first..minimum], nodes[first], nodes[minimum], limits, &mut scratch);
            first = minimum;
            lowest = None;
        }
        if nodes[at + 1] < peak {
            lowest = Some(at + 1);
        }
    }
    if first < stretches.len() {
        total += piece_time(&stretches[first..], nodes[first], 0.0, limits, &mut scratch);
    }
    Time::computed(total)
}

/// The largest speed in a stretch.
fn peak(stretch: Stretch, v0: f64, v1: f64, acceleration: f64) -> f64 {
    (acceleration * stretch.length + 0.5 * (v0 * v0 + v1 * v1)).sqrt().min(stretch.limit).max(v0).max(v1)
}

/// The stretches of all moves that have a length. Between two, the speed is at most the smaller limit; a sharp corner is a
/// stretch without length.
fn stretches(points: &[[f64; 3]], feeds: &[Speed], acceleration: f64, jerk: f64, tolerance: f64) -> Vec<Stretch> {
    struct Straight {
        direction: [f64; 3],
        length: f64,
        feed: f64,
    }
    let moves: Vec<Straight> = points
        .windows(2)
        .zip(feeds)
        .filter_map(|(ends, feed)| {
            let step = difference(ends[1], ends[0]);
            let length = length(step);
            (length > 0.0).then(|| Straight { direction: step.map(|part| part / length), length, feed: feed.mm_s() })
        })
        .collect();
    let mut stretches = Vec::with_capacity(3 * moves.len());
    let mut taken = 0.0;
    for (at, this) in moves.iter().enumerate() {
        let Some(next) = moves.get(at + 1) else {
            stretches.push(Stretch { length: this.length - taken, limit: this.feed });
            break;
        };
        // b is half the angle between the directions: |u - v| = 2 sin b, |u + v| = 2 cos b.
        let cosine = 0.5 * length::<3>(std::array::from_fn(|axis| this.direction[axis] + next.direction[axis]));
        let sine = 0.5 * length(difference(this.direction, next.direction));
        let shorter = this.length.min(next.length);
        // 1 - cos b = sin^2 b/(1 + cos b), without cancellation.
        let sharp = if sine > 0.0 { tolerance * cosine * (1.0 + cosine) / (sine * sine) } else { f64::INFINITY };
        let fine = if sine > 0.0 { 0.5 * shorter * cosine / sine } else { f64::INFINITY };
        let radius = sharp.min(fine);
        let by_corner = (acceleration * radius).sqrt().min((jerk * radius * radius).cbrt());
        let limit = by_corner.min(this.feed).min(next.feed);
        let half = if fine < sharp { 0.5 * shorter } else { 0.0 };
        stretches.push(Stretch { length: (this.length - taken - half).max(0.0), limit: this.feed });
        stretches.push(Stretch { length: 2.0 * half, limit });
        taken = half;
    }
    stretches
}

/// The speeds at the ends of the stretches: the largest ones that change by at most this acceleration.
fn speeds(stretches: &[Stretch], start: f64, end: f64, acceleration: f64, nodes: &mut Vec<f64>) {
    nodes.clear();
    nodes.push(start);
    for (at, stretch) in stretches.iter().enumerate() {
        let reached = (nodes[at] * nodes[at] + 2.0 * acceleration * stretch.length).sqrt();
        let next = stretches.get(at + 1).map_or(end, |next| next.limit);
        nodes.push(reached.min(stretch.limit).min(next));
    }
    for at in (0..stretches.len()).rev() {
        let reached = (nodes[at + 1] * nodes[at + 1] + 2.0 * acceleration * stretches[at].length).sqrt();
        nodes[at] = nodes[at].min(reached);
    }
}

/// The time of a part that begins and ends at a local minimum of the speed.
fn piece_time(stretches: &[Stretch], start: f64, end: f64, limits: MachineLimits, nodes: &mut Vec<f64>) -> f64 {
    let (most, jerk) = (limits.acceleration.mm_s2(), limits.jerk.mm_s3());
    let length: f64 = stretches.iter().map(|stretch| stretch.length).sum();
    let fastest = stretches.iter().map(|stretch| stretch.limit).fold(0.0, f64::max);
    let from_rest_to_rest = start == 0.0 && end == 0.0 && length > 0.0;
    let straight = || travel_time(Length::computed(length), MachineLimits { feed_rate: Speed::computed(fastest), ..limits }).seconds();
    if from_rest_to_rest && stretches.iter().all(|stretch| stretch.limit >= fastest || stretch.length <= 0.0) {
        return straight();
    }
    let mut whole = |acceleration: f64| {
        speeds(stretches, start, end, acceleration, nodes);
        let (mut sum, mut top) = (0.0, 0.0_f64);
        for (at, stretch) in stretches.iter().enumerate() {
            let (v0, v1) = (nodes[at], nodes[at + 1]);
            let peak = peak(*stretch, v0, v1, acceleration);
            top = top.max(peak);
            if peak > 0.0 {
                let ramps = 0.5 * ((peak - v0) * (peak + v0) + (peak - v1) * (peak + v1)) / acceleration;
                sum += (2.0 * peak - v0 - v1) / acceleration + (stretch.length - ramps).max(0.0) / peak;
            }
        }
        let share = if top > 0.0 { (1.0 - (start + end) / (2.0 * top)).max(0.0) } else { 0.0 };
        sum + acceleration / jerk * share
    };
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    // The acceleration must lead from the speed at one end to that at the other.
    let least_acceleration = if length > 0.0 { ((end - start) * (end + start)).abs() / (2.0 * length * most) } else { 1.0 };
    let (mut low, mut high) = (least_acceleration.clamp(LEAST_ACCELERATION, 1.0).ln(), 0.0);
    let (mut x, mut y) = (high - golden * (high - low), low + golden * (high - low));
    let at_most = whole(most);
    let (mut at_x, mut at_y) = (whole(most * x.exp()), whole(most * y.exp()));
    let mut least = at_most.min(at_x).min(at_y);
    for _ in 0..SECTIONS {
        if at_x < at_y {
            (high, y, at_y) = (y, x, at_x);
            x = high - golden * (high - low);
            at_x = whole(most * x.exp());
        } else {
            (low, x, at_x) = (x, y, at_y);
            y = low + golden * (high - low);
            at_y = whole(most * y.exp());
        }
        least = least.min(at_x).min(at_y);
    }
    if from_rest_to_rest { least.max(straight()) } else { least }
}
