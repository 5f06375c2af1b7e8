//! The fast search: Newton's method on the ridge's equations at once.
//!
//! At a ridge two neighbouring marks of each of two passes are at the distance 0 from one place. The unknowns are the
//! offset c of one pass, x of its marks, x of the other pass's marks, and one of the three lengths. x is eliminated from
//! each pass; without a feed its equation is that the distance is least.

use super::cutter_body::{CutterBody, SignedDistance};
use super::marks::{MarkPattern, Marks, Which};
use super::search::{Lengths, MarkPlaces, Sought};
use std::ops::Range;

/// The most steps, of which an ordinary contact takes four.
const MOST_STEPS: usize = 14;

/// The relative size of the last step. The error that it leaves is of the order of its square, under the rounding.
const LAST_STEP: f64 = 3e-8;

/// The largest ratio of a length to that of the step before.
const LARGEST_RATIO: f64 = 8.0;

/// The distance in x, as a share of the search's stride, over which second derivatives are taken.
const DIFFERENCE: f64 = 1e-4;

/// The equations of one pass after x is eliminated: `value` + `by_c` dc + `by_level` dp + `by_feed` df = 0, and what x does.
#[derive(Debug, Clone, Copy)]
struct Row {
    value: f64,
    by_c: f64,
    by_level: f64,
    by_step_over: f64,
    by_feed: f64,
    /// The step of x, and its derivatives by c, the level and the feed.
    x_step: [f64; 4],
    /// The gaps of both marks, and whether their slopes oppose each other.
    is_least: bool,
}

impl Row {
    const NONE: Self =
        Self { value: f64::NAN, by_c: 0.0, by_level: 0.0, by_step_over: 0.0, by_feed: 0.0, x_step: [0.0; 4], is_least: false };

    /// Of two marks, of which either moves along the feed by its `moves` for each unit of the feed per tooth.
    fn of_marks(a: &SignedDistance, b: &SignedDistance, moves: [f64; 2]) -> Self {
        let spread = b.by_x - a.by_x;
        let (of_a, of_b) = (b.by_x / spread, -a.by_x / spread);
        let weighted = |a: f64, b: f64| of_a * a + of_b * b;
        let by_feed = [a.by_x * moves[0], b.by_x * moves[1]];
        Self {
            value: weighted(a.value, b.value),
            by_c: weighted(a.by_c, b.by_c),
            by_level: weighted(a.by_level, b.by_level),
            by_step_over: 0.0,
            by_feed: weighted(by_feed[0], by_feed[1]),
            x_step: [a.value - b.value, a.by_c - b.by_c, a.by_level - b.by_level, by_feed[0] - by_feed[1]].map(|part| part / spread),
            is_least: of_a >= 0.0 && of_b >= 0.0,
        }
    }

    /// Of those two of the faces of two marks with a sharp edge whose tangents cross where the greatest of all is least.
    fn of_faces(faces: &[(SignedDistance, f64)]) -> Self {
        opposed(faces, |(face, _)| [face.value, face.by_x])
            .map_or(Self::NONE, |[(a, moves_a), (b, moves_b)]| Self::of_marks(&a, &b, [moves_a, moves_b]))
    }

    /// Without a feed; `b` is the gap at x + `difference`.
    fn of_groove(a: &SignedDistance, b: &SignedDistance, difference: f64) -> Self {
        let bend = (b.by_x - a.by_x) / difference;
        let [by_c, by_level] = [b.by_c - a.by_c, b.by_level - a.by_level].map(|change| change / difference);
        let share = a.by_x / bend;
        Self {
            value: a.value - share * a.by_x,
            by_c: a.by_c - share * by_c,
            by_level: a.by_level - share * by_level,
            by_step_over: 0.0,
            by_feed: 0.0,
            x_step: [-a.by_x, -by_c, -by_level, 0.0].map(|part| part / bend),
            is_least: bend > 0.0,
        }
    }
}

/// Those two tangents, each given by its value and its slope, that cross where the greatest of all is least; first the one that is
/// the greatest here, or the last one on the way.
fn opposed<T: Copy>(tangents: &[T], line: impl Fn(&T) -> [f64; 2]) -> Option<[T; 2]> {
    let mut a = *tangents.iter().max_by(|one, other| line(one)[0].total_cmp(&line(other)[0]))?;
    let sign = line(&a)[1].signum();
    for _ in 0..tangents.len() {
        let [value, slope] = line(&a);
        // The place at which another tangent becomes the greatest.
        let until = |other: &T| sign * (value - line(other)[0]) / (slope - line(other)[1]);
        let flatter = tangents.iter().filter(|other| sign * (slope - line(other)[1]) > 0.0);
        let b = *flatter.min_by(|one, other| until(one).total_cmp(&until(other)))?;
        if sign * line(&b)[1] < 0.0 {
            return Some([a, b]);
        }
        a = b;
    }
    None
}

/// A ridge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ridge {
    pub(super) lengths: Lengths,
    pub(super) places: MarkPlaces,
    /// The marks by which each pass clears its place.
    pub(super) choice: [Which; 2],
}

/// The ridge that the chosen marks of both passes leave near a guess of the sought length, from guessed places. The marks of
/// each pass oppose each other there, and so do the passes: on a plane, where distances are convex, that proves the result.
/// `None` if the search does not converge.
pub(super) fn solve(
    body: &CutterBody,
    pattern: &MarkPattern,
    choice: [Which; 2],
    stride: f64,
    sought: Sought,
    mut lengths: Lengths,
    mut places: MarkPlaces,
) -> Option<Ridge> {
    let mut marks = pattern.marks(lengths.feed);
    let difference = DIFFERENCE * stride;
    for _ in 0..MOST_STEPS {
        if sought == Sought::Feed {
            marks = pattern.marks(lengths.feed);
        }
        let pairs = choice.map(|which| marks.of(which));
        let rows_of = |pass: usize| {
            let c = places.c - [0.0, lengths.step_over][pass];
            rows(body, &marks, pairs[pass].clone(), &places.x[pass], c, lengths.level, difference)
        };
        let (near, mut far) = (rows_of(0), rows_of(1));
        for row in &mut far {
            row.by_step_over = -row.by_c;
        }
        // Far from the ridge all can rise to the same side: then the greatest of each pass.
        let greatest = |[one, other]: [Row; 2]| if one.value > other.value { one } else { other };
        let both = [near[0], near[1], far[0], far[1]];
        let [one, other] = opposed(&both, |row| [row.value, row.by_c]).unwrap_or([greatest(near), greatest(far)]);
        let [by_one, by_other] = [one, other].map(|row| match sought {
            Sought::Level => row.by_level,
            Sought::StepOver => row.by_step_over,
            Sought::Feed => row.by_feed,
        });
        let determinant = one.by_c * by_other - other.by_c * by_one;
        let c_step = (other.value * by_one - one.value * by_other) / determinant;
        let step = (one.value * other.by_c - other.value * one.by_c) / determinant;
        if !(c_step.is_finite() && step.is_finite()) {
            return None;
        }
        let value = lengths.get(sought);
        let next = (value + step).clamp(value / LARGEST_RATIO, value * LARGEST_RATIO);
        let taken = next - value;
        let mut largest_step = (c_step / (lengths.step_over + stride)).abs();
        let move_x = |xs: &mut [f64], rows: &[Row], c_step: f64| {
            for (x, row) in xs.iter_mut().zip(rows) {
                let [own, by_c, by_level, by_feed] = row.x_step;
                let by_length = match sought {
                    Sought::Level => by_level,
                    Sought::StepOver => 0.0,
                    Sought::Feed => by_feed,
                };
                *x += own + by_c * c_step + by_length * taken;
            }
        };
        let before = places.x;
        move_x(&mut places.x[0][pairs[0].clone()], &near, c_step);
        move_x(&mut places.x[1][pairs[1].clone()], &far, c_step - if sought == Sought::StepOver { taken } else { 0.0 });
        for (x, before) in places.x.as_flattened().iter().zip(before.as_flattened()) {
            largest_step = largest_step.max((x - before).abs() / stride);
        }
        places.c += c_step;
        lengths = lengths.with(sought, next);
        if !(places.x.as_flattened().iter().all(|x| x.is_finite())) {
            return None;
        }
        if largest_step.max((taken / next).abs()) <= LAST_STEP && (taken - step).abs() <= LAST_STEP * next {
            // Which pair of marks decides is known where all of them are at their least.
            let [rising, falling] = if one.by_c > 0.0 { [one, other] } else { [other, one] };
            let is_between_passes = rising.by_c > 0.0 && rising.by_step_over == 0.0 && falling.by_step_over > 0.0;
            let is_ridge = is_between_passes && both.iter().all(|row| row.is_least) && one.by_level < 0.0 && other.by_level < 0.0;
            return is_ridge.then_some(Ridge { lengths, places, choice });
        }
    }
    None
}

/// The rows of one or two pairs, in their order; of one, twice the same.
fn rows(body: &CutterBody, marks: &Marks, pairs: Range<usize>, xs: &[f64; 3], c: f64, p: f64, difference: f64) -> [Row; 2] {
    let row = |index: usize| {
        let (pair, x) = (&marks.pairs()[index], xs[index]);
        let has_marks = pair.distance > 0.0;
        let beside = x + if has_marks { pair.distance } else { difference };
        if body.is_sharp() {
            let [first, second] = body.faces(x, c, p - pair.drops[0]).map(|face| (face, 0.0));
            let [third, fourth] = body.faces(beside, c, p - pair.drops[1]).map(|face| (face, pair.by_feed));
            Row::of_faces(&[first, second, third, fourth][..if has_marks { 4 } else { 2 }])
        } else {
            let (a, b) = (body.gap(x, c, p - pair.drops[0]), body.gap(beside, c, p - pair.drops[1]));
            if has_marks { Row::of_marks(&a, &b, [0.0, pair.by_feed]) } else { Row::of_groove(&a, &b, difference) }
        }
    };
    let first = row(pairs.start);
    [first, if pairs.len() > 1 { row(pairs.start + 1) } else { first }]
}
