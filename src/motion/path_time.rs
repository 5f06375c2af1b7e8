//! The time of a path of many straight moves on a control that looks ahead and rounds corners within a tolerance.

use super::{MachineLimits, travel_time};
use crate::numerics::vector::{difference, length};
use crate::quantity::{Length, Speed, Time};
use rayon::prelude::*;

/// The evaluations of a piece's time in the search for its acceleration: golden sections narrow the ratio of 10^4 to 1.001.
const SECTIONS: u32 = 19;

/// The smallest acceleration looked at, as a share of the machine's.
const LEAST_ACCELERATION: f64 = 1e-4;

/// A minimum of the speed that is shallower than this share of it is none: roundings of coordinates leave as much.
const SHALLOW: f64 = 1e-4;

/// The share of a stretch along which a speed is held at least, if it is.
const HELD: f64 = 1e-3;

/// The length in mm of the shortest stretch: roundings of coordinates leave shorter ones between moves of equal lengths.
const SHORTEST: f64 = 1e-5;

/// The share of a piece's greatest limit below which its ends are at rest.
const REST: f64 = 1e-3;

/// The pieces that one thread times at once.
const AT_ONCE: usize = 256;

/// A part of the path with one limit of the speed, and the limit at its end.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    length: f64,
    limit: f64,
    at_end: f64,
}

/// The time of the path through the points, from rest to rest. `feeds` has the feed rate of the move to each point but the
/// first; acceleration and jerk are those of `limits`, whose feed rate does not count.
///
/// The control rounds the corner between moves of the lengths L1 and L2 that turn by 2b with an arc of the radius
/// rho = min(tolerance cos b/(1 - cos b), min(L1, L2)/(2 tan b)), at a speed up to min(sqrt(A rho), cbrt(J rho^2)). If the
/// second radius is the smaller one, the points are of a curve and the speed holds along half of the shorter move on both
/// sides. Under these limits and those of the feeds, speeds change by at most the acceleration. The jerk adds
/// (a/J) (1 - (v0 + v1)/(2 v_top)) to each piece from one local minimum of the speed, v0, to the next, v1, over the top
/// speed v_top, for the acceleration a <= A that is best for the piece. A speed that is held before it rises or after it has
/// fallen is a minimum at both ends: the acceleration is zero there.
///
/// For one straight move it is [`travel_time`]. As the tolerance goes to 0 it becomes the sum over the moves from rest to
/// rest, within 0.4 %.
///
/// # Panics
/// If `feeds` is shorter than the number of moves.
#[must_use]
pub fn path_time(points: &[[f64; 3]], feeds: &[Speed], limits: MachineLimits, tolerance: Length) -> Time {
    assert!(feeds.len() + 1 >= points.len(), "a move has no feed rate");
    let (acceleration, jerk) = (limits.acceleration.mm_s2(), limits.jerk.mm_s3());
    let stretches = stretches(points, feeds, acceleration, jerk, tolerance.mm());
    let mut nodes = Vec::with_capacity(stretches.len() + 1);
    speeds(&stretches, 0.0, 0.0, acceleration, &mut nodes);
    let pieces = pieces(&stretches, &nodes, limits);
    let time_of = |pieces: &[Piece<'_>]| {
        let mut scratch = Vec::new();
        pieces.iter().map(|piece| piece.time(&mut scratch)).sum::<f64>()
    };
    // Sums of equal parts in their order, so that the threads' order does not change the roundings.
    let sums: Vec<f64> = pieces.par_chunks(AT_ONCE).map(time_of).collect();
    Time::computed(sums.into_iter().sum())
}

/// The parts of the path between the local minima of the speeds at the ends of its stretches.
fn pieces<'a>(stretches: &'a [Stretch], nodes: &[f64], limits: MachineLimits) -> Vec<Piece<'a>> {
    let is_end = |at: &usize| is_minimum(stretches, nodes, *at, limits.acceleration.mm_s2());
    let ends: Vec<usize> = std::iter::once(0).chain((1..stretches.len()).filter(is_end)).chain([stretches.len()]).collect();
    let between = |pair: &[usize]| {
        let (first, last) = (pair[0], pair[1]);
        (first < last).then(|| Piece { stretches: &stretches[first..last], start: nodes[first], end: nodes[last], limits })
    };
    ends.windows(2).filter_map(between).collect()
}

/// Whether the speed is least at the node between two stretches: it falls or is held before and rises or is held after, and
/// is not held on both sides.
fn is_minimum(stretches: &[Stretch], nodes: &[f64], at: usize, acceleration: f64) -> bool {
    // On one side, from the node to the other end of the stretch: whether the speed is higher there, and whether it changes
    // by the acceleration all the way from a lower one.
    let side = |stretch: Stretch, other: f64| {
        let (node, most) = (nodes[at], 2.0 * acceleration * stretch.length);
        let higher = peak(stretch, node, other, acceleration) > node * (1.0 + SHALLOW);
        (higher, !higher && (node - other) * (node + other) >= most * (1.0 - HELD))
    };
    let (before, after) = (side(stretches[at - 1], nodes[at - 1]), side(stretches[at], nodes[at + 1]));
    !before.1 && !after.1 && (before.0 || after.0)
}

/// The largest speed in a stretch.
fn peak(stretch: Stretch, v0: f64, v1: f64, acceleration: f64) -> f64 {
    (acceleration * stretch.length + 0.5 * (v0 * v0 + v1 * v1)).sqrt().min(stretch.limit).max(v0).max(v1)
}

/// The stretches of all moves that have a length. Where one ends, the speed is at most both limits, and that of a sharp
/// corner.
fn stretches(points: &[[f64; 3]], feeds: &[Speed], acceleration: f64, jerk: f64, tolerance: f64) -> Vec<Stretch> {
    struct Straight {
        direction: [f64; 3],
        length: f64,
        feed: f64,
    }
    let straight = |(ends, feed): (&[[f64; 3]], &Speed)| {
        let step = difference(ends[1], ends[0]);
        let length = length(step);
        (length > 0.0).then(|| Straight { direction: step.map(|part| part / length), length, feed: feed.mm_s() })
    };
    // What is too short to be a stretch belongs to the one before it.
    let push = |stretches: &mut Vec<Stretch>, length: f64, limit: f64, at_end: f64| match stretches.last_mut() {
        Some(before) if length <= SHORTEST => {
            before.length += length.max(0.0);
            before.at_end = before.at_end.min(limit).min(at_end);
        }
        _ => stretches.push(Stretch { length: length.max(0.0), limit, at_end: limit.min(at_end) }),
    };
    let mut moves = points.windows(2).zip(feeds).filter_map(straight).peekable();
    let mut stretches = Vec::with_capacity(2 * points.len());
    let mut taken = 0.0;
    while let Some(this) = moves.next() {
        let Some(next) = moves.peek() else {
            push(&mut stretches, this.length - taken, this.feed, this.feed);
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
        push(&mut stretches, this.length - taken - half, this.feed, limit);
        push(&mut stretches, 2.0 * half, limit, next.feed);
        taken = half;
    }
    stretches
}

/// The speeds at the ends of the stretches: the largest ones that change by at most this acceleration.
fn speeds(stretches: &[Stretch], start: f64, end: f64, acceleration: f64, nodes: &mut Vec<f64>) {
    nodes.clear();
    nodes.push(start);
    let mut speed = start;
    for stretch in stretches {
        speed = (speed * speed + 2.0 * acceleration * stretch.length).sqrt().min(stretch.at_end);
        nodes.push(speed);
    }
    speed = speed.min(end);
    nodes[stretches.len()] = speed;
    for at in (0..stretches.len()).rev() {
        speed = nodes[at].min((speed * speed + 2.0 * acceleration * stretches[at].length).sqrt());
        nodes[at] = speed;
    }
}

/// A part of the path between two local minima of the speed.
struct Piece<'a> {
    stretches: &'a [Stretch],
    start: f64,
    end: f64,
    limits: MachineLimits,
}

impl Piece<'_> {
    fn time(&self, nodes: &mut Vec<f64>) -> f64 {
        let most = self.limits.acceleration.mm_s2();
        let length: f64 = self.stretches.iter().map(|stretch| stretch.length).sum();
        if length <= 0.0 {
            return 0.0;
        }
        let fastest = self.stretches.iter().map(|stretch| stretch.limit).fold(0.0, f64::max);
        let is_at_rest = self.start.max(self.end) <= REST * fastest;
        let straight =
            || travel_time(Length::computed(length), MachineLimits { feed_rate: Speed::computed(fastest), ..self.limits }).seconds();
        if self.start.max(self.end) <= 0.0 && self.stretches.iter().all(|stretch| stretch.at_end >= fastest) {
            return straight();
        }
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let mut at = |share: f64| self.time_with(most * share.exp(), nodes);
        let (mut low, mut high) = (LEAST_ACCELERATION.ln(), 0.0);
        let (mut x, mut y) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_x, mut at_y) = (at(x), at(y));
        let mut least = at(0.0).min(at_x).min(at_y);
        for _ in 0..SECTIONS {
            // Where the acceleration is too small for the ends, the time is infinite: larger ones are looked at.
            if at_x < at_y {
                (high, y, at_y) = (y, x, at_x);
                x = high - golden * (high - low);
                at_x = at(x);
            } else {
                (low, x, at_x) = (x, y, at_y);
                y = low + golden * (high - low);
                at_y = at(y);
            }
            least = least.min(at_x).min(at_y);
        }
        // Without speeds at the ends the jerk lengthens short pieces more than the sum says.
        if is_at_rest { least.max(straight()) } else { least }
    }

    /// The time with this acceleration; infinite if it does not lead from the speed at one end to that at the other.
    fn time_with(&self, acceleration: f64, nodes: &mut Vec<f64>) -> f64 {
        speeds(self.stretches, self.start, self.end, acceleration, nodes);
        let (first, last) = (nodes[0], nodes[self.stretches.len()]);
        if first < self.start * (1.0 - 1e-9) || last < self.end * (1.0 - 1e-9) {
            return f64::INFINITY;
        }
        let (mut sum, mut top) = (0.0, 0.0_f64);
        for (stretch, ends) in self.stretches.iter().zip(nodes.windows(2)) {
            let (v0, v1) = (ends[0], ends[1]);
            let peak = peak(*stretch, v0, v1, acceleration);
            top = top.max(peak);
            if peak > 0.0 {
                let ramps = 0.5 * ((peak - v0) * (peak + v0) + (peak - v1) * (peak + v1)) / acceleration;
                sum += (2.0 * peak - v0 - v1) / acceleration + (stretch.length - ramps).max(0.0) / peak;
            }
        }
        let share = if top > 0.0 { (1.0 - (self.start + self.end) / (2.0 * top)).max(0.0) } else { 0.0 };
        sum + acceleration / self.limits.jerk.mm_s3() * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Acceleration, Jerk};
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn limits(feed: f64, acceleration: f64, jerk: f64) -> MachineLimits {
        MachineLimits {
            feed_rate: Speed::from_mm_min(feed).unwrap(),
            acceleration: Acceleration::from_m_s2(acceleration).unwrap(),
            jerk: Jerk::from_m_s3(jerk).unwrap(),
        }
    }

    fn time(points: &[[f64; 3]], limits: MachineLimits, tolerance: f64) -> f64 {
        path_time(points, &vec![limits.feed_rate; points.len() - 1], limits, Length::computed(tolerance)).seconds()
    }

    /// Zigzags, curves in chords and random corners.
    fn paths() -> impl Strategy<Value = (Vec<[f64; 3]>, MachineLimits)> {
        let points = prop::collection::vec((0.1..5.0_f64, 0.3..1.5_f64, any::<bool>()), 2..60).prop_map(|steps| {
            let (mut at, mut angle) = ([0.0; 3], 0.0_f64);
            let walk = steps.into_iter().map(|(step, turn, left)| {
                angle += if left { turn } else { -turn };
                at = [at[0] + step * angle.cos(), at[1] + step * angle.sin(), at[2] + 0.1 * step];
                at
            });
            std::iter::once([0.0; 3]).chain(walk).collect::<Vec<_>>()
        });
        (points, 500.0..10_000.0_f64, 0.3..15.0_f64, 5.0..200.0_f64)
            .prop_map(|(points, feed, acceleration, jerk)| (points, limits(feed, acceleration, jerk)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn a_straight_move_takes_the_time_of_a_straight_move(length in 0.001..1000.0_f64, (_, limits) in paths(), parts in 1..9_u32) {
            let points: Vec<[f64; 3]> = (0..=parts).map(|part| [length * f64::from(part) / f64::from(parts), 0.0, 0.0]).collect();
            let expected = travel_time(Length::computed(length), limits).seconds();
            assert_relative_eq!(time(&points, limits, 0.01), expected, max_relative = 1e-12);
        }

        #[test]
        fn without_a_tolerance_the_tool_stops_at_corners((points, limits) in paths()) {
            let stops: f64 = points.windows(2).map(|ends| time(ends, limits, 0.01)).sum();
            let time = time(&points, limits, 1e-12);
            // Section 17 of the model states 0.4 %.
            assert_relative_eq!(time, stops, max_relative = 0.004);
        }

        #[test]
        fn a_path_takes_at_least_the_time_of_its_length_at_the_feed_rate((points, limits) in paths(), tolerance in 1e-3..0.1_f64) {
            let length: f64 = points.windows(2).map(|ends| length(difference(ends[1], ends[0]))).sum();
            let time = time(&points, limits, tolerance);
            prop_assert!(time >= length / limits.feed_rate.mm_s() && time.is_finite());
        }
    }

    /// The search for the best acceleration of a piece, against 3000 accelerations.
    #[test]
    fn no_acceleration_gives_a_piece_a_shorter_time() {
        // A curve in chords that turn left and right: the speeds at the ends of most pieces bound the acceleration from below.
        let (mut at, mut angle, mut random) = ([0.0; 3], 0.0_f64, 7_u32);
        let points: Vec<[f64; 3]> = (0..200)
            .map(|_| {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                angle += 0.16 * (f64::from(random) / f64::from(u32::MAX) - 0.5);
                at = [at[0] + 0.3 * angle.cos(), at[1] + 0.3 * angle.sin(), 0.0];
                at
            })
            .collect();
        let limits = limits(3000.0, 12.0, 5.0);
        let (feeds, most) = (vec![limits.feed_rate; points.len() - 1], limits.acceleration.mm_s2());
        let stretches = stretches(&points, &feeds, most, limits.jerk.mm_s3(), 0.01);
        let (mut nodes, mut scratch) = (Vec::new(), Vec::new());
        speeds(&stretches, 0.0, 0.0, most, &mut nodes);
        let pieces = pieces(&stretches, &nodes, limits);
        assert!(pieces.len() > 50);
        let (mut found, mut tried) = (0.0, 0.0);
        for piece in pieces {
            let time = piece.time(&mut scratch);
            let accelerations = (0..=3000).map(|step| most * LEAST_ACCELERATION.powf(f64::from(step) / 3000.0));
            let least = accelerations.map(|a| piece.time_with(a, &mut scratch)).fold(f64::INFINITY, f64::min);
            assert!(time <= least * (1.0 + 1e-3), "{time} {least}");
            (found, tried) = (found + time, tried + least);
        }
        assert_relative_eq!(found, tried, max_relative = 2e-3);
    }

    /// A square with rounded sides in chords: the time does not grow with the tolerance.
    #[test]
    fn time_falls_as_the_tolerance_grows() {
        let zigzag: Vec<[f64; 3]> =
            (0..40).map(|row| [if row % 4 == 0 || row % 4 == 3 { 0.0 } else { 30.0 }, f64::from(row / 2), 0.0]).collect();
        let curve: Vec<[f64; 3]> = (0..400).map(|step| 0.05 * f64::from(step)).map(|x| [x, 3.0 * x.sin(), 0.5 * (2.0 * x).cos()]).collect();
        for points in [zigzag, curve] {
            let times: Vec<f64> =
                [0.001, 0.003, 0.01, 0.03, 0.1].iter().map(|tolerance| time(&points, limits(4000.0, 3.0, 25.0), *tolerance)).collect();
            assert!(times.is_sorted_by(|a, b| b <= a), "{times:?}");
            assert!(times[4] < 0.99 * times[0], "{times:?}");
        }
    }
}
