//! The sure search: how far a place is from being cleared, by nested searches each of which keeps a bracket.
//!
//! On planes the distance of a point from the cutter's body is convex in the contact and the height together. So is
//!
//! - V(c, p), the least over x of the greater distance of a pair of marks at x and x + f, both at the offset c;
//! - W(p), the least over c of the greater of V(c, p) and V(c - s, p), which are two passes s apart.
//!
//! W falls with p, and grows with s and f. The height is the root of W in p, the inverses are those in s and f. A minimum of
//! the greater of two convex functions is where both are equal or where the greater is least; in both cases the weights with
//! which the two slopes cancel give the derivatives by all other variables. Newton's method from where W is positive
//! approaches the root from one side.

use super::body::{Body, Gap};
use super::marks::{Marks, Pair, Pattern};

/// The most steps of one search. Convex functions take four to ten; a bisection of the whole range of numbers that occur
/// takes 100.
const MOST_STEPS: usize = 60;

/// What is left of an improvement, as a share of the height, when a minimum counts as found.
const ROUNDING: f64 = 1e-15;

/// The derivative of the distance by the height under which a body's side is upright.
const TOUCHING: f64 = 1e-6;

/// A place that is to be cleared: the pass at the offset c and the next one at c - s, with a feed per tooth, down to p.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lengths {
    pub(super) level: f64,
    pub(super) step_over: f64,
    pub(super) feed: f64,
}

/// Which of the lengths is sought; the others are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sought {
    Level,
    StepOver,
    Feed,
}

impl Lengths {
    pub(super) fn get(&self, sought: Sought) -> f64 {
        match sought {
            Sought::Level => self.level,
            Sought::StepOver => self.step_over,
            Sought::Feed => self.feed,
        }
    }

    pub(super) fn with(mut self, sought: Sought, value: f64) -> Self {
        match sought {
            Sought::Level => self.level = value,
            Sought::StepOver => self.step_over = value,
            Sought::Feed => self.feed = value,
        }
        self
    }
}

/// V with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowGap {
    pub(super) value: f64,
    pub(super) by_c: f64,
    pub(super) by_level: f64,
    pub(super) by_feed: f64,
}

/// W with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct RidgeGap {
    pub(super) value: f64,
    by_level: f64,
    by_step_over: f64,
    by_feed: f64,
}

impl RidgeGap {
    fn by(&self, sought: Sought) -> f64 {
        match sought {
            Sought::Level => self.by_level,
            Sought::StepOver => self.by_step_over,
            Sought::Feed => self.by_feed,
        }
    }
}

/// The places from which the next searches start: x of each pair of marks in both passes, and the offset.
#[derive(Debug, Clone, Copy)]
pub(super) struct Places {
    pub(super) x: [[f64; 3]; 2],
    pub(super) c: f64,
}

/// The sure search at one contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) body: &'a Body,
    pub(super) pattern: &'a Pattern,
}

impl Search<'_> {
    /// The least over x of the greater distance of two marks at the offset c.
    fn pair_gap(&self, pair: &Pair, stride: f64, x: &mut f64, c: f64, p: f64) -> RowGap {
        let mut last = [Gap::NONE; 2];
        let found = lowest_of_two(*x, stride, ROUNDING * p + self.body.rounding(), |x| {
            last = [self.body.gap(x, c, p - pair.drops[0]), self.body.gap(x + pair.distance, c, p - pair.drops[1])];
            last.map(|gap| (gap.value, gap.by_x))
        });
        *x = found.x;
        let weighted = |part: fn(&Gap) -> f64| found.weights[0] * part(&last[0]) + found.weights[1] * part(&last[1]);
        RowGap {
            value: last[0].value.max(last[1].value),
            by_c: weighted(|gap| gap.by_c),
            by_level: weighted(|gap| gap.by_level),
            by_feed: found.weights[1] * last[1].by_x * pair.by_feed,
        }
    }

    /// V(c, p).
    fn row_gap(&self, marks: &Marks, stride: f64, x: &mut [f64; 3], c: f64, p: f64) -> RowGap {
        let mut rows = [RowGap::NONE; 3];
        for ((row, pair), x) in rows.iter_mut().zip(marks.pairs()).zip(x) {
            *row = self.pair_gap(pair, stride, x, c, p);
        }
        rows[marks.deciding(|index| rows[index].value)]
    }

    /// W at these lengths.
    pub(super) fn ridge_gap(&self, lengths: &Lengths, places: &mut Places) -> RidgeGap {
        let marks = self.pattern.marks(lengths.feed);
        let Lengths { level, step_over, .. } = *lengths;
        let mut last = [RowGap::NONE; 2];
        let [near, far] = &mut places.x;
        let stride = (step_over + marks.pairs()[0].distance) / 4.0;
        let found = lowest_of_two(places.c, stride, ROUNDING * level + self.body.rounding(), |c| {
            last = [self.row_gap(&marks, stride, near, c, level), self.row_gap(&marks, stride, far, c - step_over, level)];
            last.map(|row| (row.value, row.by_c))
        });
        places.c = found.x;
        let weighted = |part: fn(&RowGap) -> f64| found.weights[0] * part(&last[0]) + found.weights[1] * part(&last[1]);
        RidgeGap {
            value: last[0].value.max(last[1].value),
            by_level: weighted(|row| row.by_level),
            by_step_over: -found.weights[1] * last[1].by_c,
            by_feed: weighted(|row| row.by_feed),
        }
    }

    /// The value of the sought length from `least` to `most` at which W is 0, from the guess in `lengths`.
    pub(super) fn solve(&self, sought: Sought, mut lengths: Lengths, least: f64, most: f64, places: &mut Places) -> Outcome {
        // W falls with the level and grows with the others.
        let sign = if sought == Sought::Level { 1.0 } else { -1.0 };
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut value = lengths.get(sought).clamp(least, most);
        let (mut width, mut stalled) = (f64::INFINITY, 0);
        let (start, mut last) = (*places, value);
        for _ in 0..MOST_STEPS {
            lengths = lengths.with(sought, value);
            // The places of a far length can lie in another valley.
            if (value - last).abs() > 0.2 * value.min(last) {
                *places = start;
            }
            last = value;
            let gap = self.ridge_gap(&lengths, places);
            // Where two circles just touch, the distance is 0 up to rounding from some height on.
            let is_touching = sought == Sought::Level && gap.value.abs() <= 100.0 * self.body.rounding() && gap.by_level.abs() <= TOUCHING;
            if is_touching {
                high = value;
            } else if sign * gap.value > 0.0 || gap.value == 0.0 && sought != Sought::Level {
                low = value;
            } else {
                high = value;
            }
            if low >= most {
                return Outcome::Above;
            }
            if high <= least {
                return Outcome::Below;
            }
            let newton = value - gap.value / gap.by(sought);
            if (newton - value).abs() <= 2.0 * f64::EPSILON * value || high.is_finite() && high - low <= 2.0 * f64::EPSILON * high {
                return Outcome::At(value);
            }
            stalled += 1;
            if high - low < width / 2.0 {
                (width, stalled) = (high - low, 0);
            }
            value = if newton > low && newton < high && stalled < 6 {
                newton.clamp(value / 64.0, value * 8.0)
            } else if high == f64::INFINITY {
                8.0 * value
            } else if low == 0.0 {
                value / 64.0
            } else {
                stalled = 0;
                (low * high).sqrt()
            };
            value = value.clamp(least, most);
        }
        Outcome::At(if sought == Sought::Level { high } else { low })
    }
}

/// Where a sought length is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outcome {
    /// At this value.
    At(f64),
    /// Above the largest: no length up to it exceeds the tolerance, or no height up to it is cleared.
    Above,
    /// Below the least.
    Below,
}

impl RowGap {
    const NONE: Self = Self { value: 0.0, by_c: 0.0, by_level: 0.0, by_feed: 0.0 };
}

/// Where the greater of two functions is least, and the weights with which their slopes cancel there.
struct Lowest {
    x: f64,
    weights: [f64; 2],
}

/// One end of a bracket: the place, the value and the slope of the greater function, and which one it is.
#[derive(Clone, Copy)]
struct End {
    x: f64,
    value: f64,
    slope: f64,
    is_first: bool,
}

/// The minimum of the greater of two convex functions, each given with its slope, from `start`. It ends where no more than
/// `tolerance` can be gained; the last call of `at` is at the minimum.
#[expect(clippy::float_cmp, reason = "a step that changes nothing is the last")]
fn lowest_of_two(start: f64, mut stride: f64, tolerance: f64, mut at: impl FnMut(f64) -> [(f64, f64); 2]) -> Lowest {
    let (mut low, mut high): (Option<End>, Option<End>) = (None, None);
    let mut x = start;
    let mut lowest = Lowest { x, weights: [1.0, 0.0] };
    let mut narrowed = f64::INFINITY;
    let mut stalled = 0;
    let first_stride = stride;
    for _ in 0..MOST_STEPS {
        let [(first, by_first), (second, by_second)] = at(x);
        let is_first = first >= second;
        let (value, slope) = if is_first { (first, by_first) } else { (second, by_second) };
        lowest = Lowest { x, weights: if is_first { [1.0, 0.0] } else { [0.0, 1.0] } };
        let here = End { x, value, slope, is_first };
        let apart = by_second - by_first;
        let crosses = by_first * by_second < 0.0;
        let mut target = f64::NAN;
        if crosses {
            let step = (first - second) / apart;
            target = x + step;
            lowest.weights = [by_second / apart, -by_first / apart];
            if (slope * step).abs() <= tolerance || x + step == x {
                return lowest;
            }
        } else if slope == 0.0 {
            return lowest;
        }
        let other = if slope > 0.0 { low } else { high };
        if !crosses && let Some(end) = other {
            // Where the tangents cross, which no value between is under.
            let crossing = (end.value - value + end.slope * (x - end.x)) / (slope - end.slope);
            if (slope * crossing).abs() <= tolerance {
                return lowest;
            }
            // Where the slope is 0, linearly between both, unless it jumps.
            let smooth = slope * (end.x - x) / (slope - end.slope);
            let is_smooth = end.is_first == is_first && stalled < 2;
            target = x + if is_smooth { smooth } else { crossing };
        } else if !crosses
            && let Some(end) = if slope > 0.0 { high } else { low }
            && end.is_first == is_first
        {
            // Beyond both, by the change of the slope.
            let step = slope * (end.x - x) / (slope - end.slope);
            if (slope * step).abs() <= tolerance {
                return lowest;
            }
            target = x + step;
        }
        if slope > 0.0 {
            high = Some(here);
        } else {
            low = Some(here);
        }
        let next = if let (Some(low), Some(high)) = (low, high) {
            let width = high.x - low.x;
            if width <= 2.0 * f64::EPSILON * (low.x.abs() + high.x.abs() + first_stride) {
                return lowest;
            }
            stalled += 1;
            if width <= narrowed / 2.0 {
                (narrowed, stalled) = (width, 0);
            }
            if target > low.x && target < high.x && stalled < 4 {
                target
            } else {
                stalled = 0;
                f64::midpoint(low.x, high.x)
            }
        } else {
            let direction = -slope.signum();
            let ahead = direction * (target - x);
            stride *= 2.0;
            if ahead > 0.0 && ahead < 4.0 * stride { target } else { x + direction * stride }
        };
        if next == x {
            return lowest;
        }
        x = next;
    }
    lowest
}
