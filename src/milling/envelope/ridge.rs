//! The fast search: Newton's method on the ridge's equations at once.
//!
//! At a ridge two neighbouring marks of each of two passes are at the distance 0 from one place. The unknowns are the
//! offset c of one pass, x of its marks, x of the other pass's marks, and one of the three lengths. x is eliminated from
//! each pass; without a feed its equation is that the distance is least.

use super::cutter_body::{CutterBody, SignedDistance};
use super::marks::{MarkPattern, Marks, Which};
use super::search::{Lengths, MarkPlaces, Sought};

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
    by_feed: f64,
    /// The step of x, and its derivatives by c, the level and the feed.
    x_step: [f64; 4],
    /// The gaps of both marks, and whether their slopes oppose each other.
    is_least: bool,
}

impl Row {
    const NONE: Self = Self { value: 0.0, by_c: 0.0, by_level: 0.0, by_feed: 0.0, x_step: [0.0; 4], is_least: false };

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
            by_feed: weighted(by_feed[0], by_feed[1]),
            x_step: [a.value - b.value, a.by_c - b.by_c, a.by_level - b.by_level, by_feed[0] - by_feed[1]].map(|part| part / spread),
            is_least: of_a >= 0.0 && of_b >= 0.0,
        }
    }

    /// Of those two of the faces of two marks with a sharp edge whose tangents cross where the greatest of all is least.
    fn of_faces(faces: &[(SignedDistance, f64)]) -> Self {
        let greatest = |one: &&(SignedDistance, f64), other: &&(SignedDistance, f64)| one.0.value.total_cmp(&other.0.value);
        let Some(&(mut a, mut moves)) = faces.iter().max_by(greatest) else { return Self::NONE };
        let sign = a.by_x.signum();
        for _ in 0..faces.len() {
            // The place at which another tangent becomes the greatest.
            let until = |face: &(SignedDistance, f64)| sign * (a.value - face.0.value) / (a.by_x - face.0.by_x);
            let flatter = faces.iter().filter(|(face, _)| sign * (a.by_x - face.by_x) > 0.0);
            let Some((b, moves_b)) = flatter.min_by(|one, other| until(one).total_cmp(&until(other))) else { break };
            if sign * b.by_x < 0.0 {
                return Self::of_marks(&a, b, [moves, *moves_b]);
            }
            (a, moves) = (*b, *moves_b);
        }
        Self { value: f64::NAN, ..Self::NONE }
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
            by_feed: 0.0,
            x_step: [-a.by_x, -by_c, -by_level, 0.0].map(|part| part / bend),
            is_least: bend > 0.0,
        }
    }
}

/// A ridge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ridge {
    pub(super) lengths: Lengths,
    pub(super) places: MarkPlaces,
    /// The marks by which both passes clear their places.
    pub(super) by: Which,
}

/// The ridge near a guess of the sought length, from guessed places. The marks of each pass oppose each other there, and so
/// do the passes: on a plane, where distances are convex, that proves the result. `None` if the search does not converge.
pub(super) fn solve(
    body: &CutterBody,
    pattern: &MarkPattern,
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
        let near = rows(body, &marks, &places.x[0], places.c, lengths.level, difference);
        let far = rows(body, &marks, &places.x[1], places.c - lengths.step_over, lengths.level, difference);
        let deciding = [&near, &far].map(|rows| marks.deciding(|index| rows[index].value));
        let (one, other) = (near[deciding[0]], far[deciding[1]]);
        let (by_one, by_other) = match sought {
            Sought::Level => (one.by_level, other.by_level),
            Sought::StepOver => (0.0, -other.by_c),
            Sought::Feed => (one.by_feed, other.by_feed),
        };
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
        let move_x = |xs: &mut [f64; 3], rows: &[Row; 3], c_step: f64| {
            for (x, row) in xs.iter_mut().zip(rows).take(marks.pairs().len()) {
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
        move_x(&mut places.x[0], &near, c_step);
        move_x(&mut places.x[1], &far, c_step - if sought == Sought::StepOver { taken } else { 0.0 });
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
            let is_least = |rows: &[Row; 3]| rows[..marks.pairs().len()].iter().all(|row| row.is_least);
            let opposed =
                is_least(&near) && is_least(&far) && one.by_c > 0.0 && other.by_c < 0.0 && one.by_level < 0.0 && other.by_level < 0.0;
            // Whether deep marks and others clear a place together, the sure search finds.
            let is_alike = marks.are_neighbours() || (deciding[0] == 0) == (deciding[1] == 0);
            let by = if deciding[0] == 0 { Which::Deepest } else { Which::Neighbours };
            return (opposed && is_alike).then_some(Ridge { lengths, places, by });
        }
    }
    None
}

fn rows(body: &CutterBody, marks: &Marks, xs: &[f64; 3], c: f64, p: f64, difference: f64) -> [Row; 3] {
    let mut rows = [Row::NONE; 3];
    for ((row, pair), &x) in rows.iter_mut().zip(marks.pairs()).zip(xs) {
        let has_marks = pair.distance > 0.0;
        let beside = x + if has_marks { pair.distance } else { difference };
        *row = if body.is_sharp() {
            let [first, second] = body.faces(x, c, p - pair.drops[0]).map(|face| (face, 0.0));
            let [third, fourth] = body.faces(beside, c, p - pair.drops[1]).map(|face| (face, pair.by_feed));
            Row::of_faces(&[first, second, third, fourth][..if has_marks { 4 } else { 2 }])
        } else {
            let (a, b) = (body.gap(x, c, p - pair.drops[0]), body.gap(beside, c, p - pair.drops[1]));
            if has_marks { Row::of_marks(&a, &b, [0.0, pair.by_feed]) } else { Row::of_groove(&a, &b, difference) }
        };
    }
    rows
}
