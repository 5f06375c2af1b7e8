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

use super::cutter_body::{CutterBody, SignedDistance};
use super::marks::{MarkPair, MarkPattern, Marks, Which};

/// The most steps of one search. Convex functions take four to ten; a bisection of the whole range of numbers that occur
/// takes 100.
const MOST_STEPS: usize = 60;

/// The most steps without a bracket half as wide, before the search leaves Newton's steps, and how many of them it then takes at
/// once.
const MOST_STALLED: usize = 6;
const OVERSHOOT: f64 = 8.0;

/// What is left of an improvement, as a share of the height, when a minimum counts as found.
const ROUNDING: f64 = 1e-15;

/// The share of a height by which another must be lower to count.
const LOWER: f64 = 1e-11;

/// How far beside a minimum another is searched, in strides.
const BESIDE: f64 = 4.0;

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

/// A distance with its derivatives: of a mark, of a row (V) or of a ridge (W).
#[derive(Debug, Clone, Copy)]
struct Distance {
    value: f64,
    by_x: f64,
    by_c: f64,
    by_level: f64,
    by_step_over: f64,
    by_feed: f64,
}

impl Distance {
    const NONE: Self = Self { value: f64::NEG_INFINITY, by_x: 0.0, by_c: 0.0, by_level: 0.0, by_step_over: 0.0, by_feed: 0.0 };

    /// `moves` is how far the mark moves along the feed for each unit of the feed per tooth.
    fn of(gap: &SignedDistance, moves: f64) -> Self {
        let SignedDistance { value, by_x, by_c, by_level } = *gap;
        Self { value, by_x, by_c, by_level, by_step_over: 0.0, by_feed: by_x * moves }
    }

    /// The greater of two distances where `share` of the one and the rest of the other do not depend on the place.
    fn mixed(&self, share: f64, other: &Self) -> Self {
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        Self {
            value: self.value.max(other.value),
            by_x: mix(self.by_x, other.by_x),
            by_c: mix(self.by_c, other.by_c),
            by_level: mix(self.by_level, other.by_level),
            by_step_over: mix(self.by_step_over, other.by_step_over),
            by_feed: mix(self.by_feed, other.by_feed),
        }
    }

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
pub(super) struct MarkPlaces {
    pub(super) x: [[f64; 3]; 2],
    pub(super) c: f64,
}

/// The sure search at one contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) body: &'a CutterBody,
    pub(super) pattern: &'a MarkPattern,
    /// Whether distances are convex in x, c and the level.
    pub(super) is_convex: bool,
    /// Whether rows are searched in several valleys.
    pub(super) is_thorough: bool,
}

impl Search<'_> {
    /// The least over x of the greater distance of two marks at the offset c. On curved surfaces there can be several minima, of
    /// which the lowest counts whose marks and those between them all clear the place.
    fn pair_gap(&self, pair: &MarkPair, stride: f64, x: &mut f64, c: f64, p: f64) -> Distance {
        let mut row = self.valley(pair, stride, x, c, p);
        if self.is_thorough && pair.distance > 0.0 {
            let near = *x;
            for aside in [-1.0, 1.0] {
                let mut start = near + aside * BESIDE * stride;
                let other = self.valley(pair, stride, &mut start, c, p);
                if other.value < row.value - self.body.rounding() {
                    (row, *x) = (other, start);
                }
            }
        }
        row
    }

    /// A minimum over x of the greater distance of two marks, or the distance of the one half-way between them if that is greater.
    fn valley(&self, pair: &MarkPair, stride: f64, x: &mut f64, c: f64, p: f64) -> Distance {
        let is_sharp = self.body.is_sharp();
        let (found, row) = lowest(*x, stride, ROUNDING * p + self.body.rounding(), |x| {
            let mut faces = [Distance::NONE; 4];
            let [first, second] = self.body.faces(x, c, p - pair.drops[0]);
            faces[0] = Distance::of(&first, 0.0);
            if is_sharp {
                faces[1] = Distance::of(&second, 0.0);
            }
            if pair.distance > 0.0 {
                let [first, second] = self.body.faces(x + pair.distance, c, p - pair.drops[1]);
                faces[2] = Distance::of(&first, pair.by_feed);
                if is_sharp {
                    faces[3] = Distance::of(&second, pair.by_feed);
                }
            }
            faces.map(|face| (face, face.by_x))
        });
        *x = found;
        if self.is_convex || pair.distance == 0.0 {
            return row;
        }
        let between = self.body.gap(found + pair.distance / 2.0, c, p - pair.half_way_drop());
        if between.value > row.value { Distance::of(&between, pair.by_feed / 2.0) } else { row }
    }

    /// V(c, p) for some of the pairs of marks.
    fn row_gap(&self, marks: &Marks, which: Which, stride: f64, x: &mut [f64; 3], c: f64, p: f64) -> Distance {
        let mut row = Distance::NONE;
        for index in marks.of(which) {
            let other = self.pair_gap(&marks.pairs()[index], stride, &mut x[index], c, p);
            if other.value > row.value {
                row = other;
            }
        }
        row
    }

    /// How far the pass at the offset c is from clearing its place down to p, by whichever of its marks are the closest; x is where
    /// the search begins.
    pub(super) fn pass_gap(&self, marks: &Marks, stride: f64, x: &mut [f64; 3], c: f64, p: f64) -> f64 {
        let deepest = self.row_gap(marks, Which::Deepest, stride, x, c, p).value;
        if marks.pairs().len() == 1 { deepest } else { deepest.min(self.row_gap(marks, Which::Neighbours, stride, x, c, p).value) }
    }

    /// Moves `places` to the offset at which one pass clears the most, from where they are.
    pub(super) fn centre(&self, lengths: &Lengths, places: &mut MarkPlaces) {
        let choice =
            if lengths.feed > 0.0 && self.pattern.marks(lengths.feed).pairs().len() > 1 { Which::Neighbours } else { Which::Deepest };
        self.gap_of_passes([choice; 2], &Lengths { step_over: 0.0, ..*lengths }, places);
    }

    /// V of both passes by the marks of a choice.
    fn rows_of_passes(&self, choice: [Which; 2], lengths: &Lengths, places: &mut MarkPlaces) -> [Distance; 2] {
        let marks = &self.pattern.marks(lengths.feed);
        let stride = (lengths.step_over + marks.pairs()[0].distance) / 4.0;
        [0, 1].map(|pass| {
            let c = places.c - [0.0, lengths.step_over][pass];
            self.row_gap(marks, choice[pass], stride, &mut places.x[pass], c, lengths.level)
        })
    }

    /// A choice of the marks that leaves less than a ridge of another `choice`, or that choice if none does.
    pub(super) fn better_choice(&self, choice: [Which; 2], lengths: &Lengths, places: &mut MarkPlaces) -> [Which; 2] {
        let others = choice.map(Which::others);
        let gaps = self.rows_of_passes(others, lengths, places);
        // Where distances are convex, marks that do not clear the place of a pass do so no further out either.
        if gaps.iter().all(|gap| gap.value > 0.0) && gaps[0].by_c > 0.0 && gaps[1].by_c < 0.0 {
            return choice;
        }
        let is_better = |other: &[Which; 2]| {
            let gap = self.ridge_gap(*other, lengths, &mut { *places });
            gap.value < -LOWER * lengths.level - self.body.rounding()
        };
        // If they clear places further out alone, these do not meet those that the chosen marks clear: then both passes have to.
        let one_changed = [[others[0], choice[1]], [choice[0], others[1]]];
        let one_changed = gaps.iter().zip(one_changed).filter(|(gap, _)| gap.value <= 0.0).map(|(_, other)| other);
        one_changed.chain([others]).find(is_better).unwrap_or(choice)
    }

    /// Whether a place is cleared by both of these marks of one pass; otherwise something is left between passes of which the one
    /// clears its place by the one and the next by the other.
    pub(super) fn meet(&self, choice: [Which; 2], lengths: &Lengths, places: &MarkPlaces) -> bool {
        choice[0] == choice[1] || self.meeting(choice, lengths, places).value <= 0.0
    }

    /// How far one pass is from clearing a place by the marks of both choices, where it is the nearest to that.
    fn meeting(&self, choice: [Which; 2], lengths: &Lengths, places: &MarkPlaces) -> Distance {
        self.gap_of_passes(choice, &Lengths { step_over: 0.0, ..*lengths }, &mut MarkPlaces { c: 0.0, ..*places })
    }

    /// W at these lengths, where each pass clears its place by some of its marks. If those differ, there must be a place that both
    /// clear, so that none is left between.
    fn ridge_gap(&self, choice: [Which; 2], lengths: &Lengths, places: &mut MarkPlaces) -> Distance {
        let ridge = self.gap_of_passes(choice, lengths, places);
        if choice[0] == choice[1] {
            return ridge;
        }
        let meeting = self.meeting(choice, lengths, places);
        if meeting.value > ridge.value { Distance { by_step_over: 0.0, ..meeting } } else { ridge }
    }

    fn gap_of_passes(&self, choice: [Which; 2], lengths: &Lengths, places: &mut MarkPlaces) -> Distance {
        let marks = &self.pattern.marks(lengths.feed);
        let Lengths { level, step_over, .. } = *lengths;
        let [near, far] = &mut places.x;
        let stride = (step_over + marks.pairs()[0].distance) / 4.0;
        let (found, ridge) = lowest(places.c, stride, ROUNDING * level + self.body.rounding(), |c| {
            let one = self.row_gap(marks, choice[0], stride, near, c, level);
            let mut other = self.row_gap(marks, choice[1], stride, far, c - step_over, level);
            other.by_step_over = -other.by_c;
            [(one, one.by_c), (other, other.by_c)]
        });
        places.c = found;
        ridge
    }

    /// The length from `least` to `most` at which W is 0, from the guess in `lengths`: the least height, or the largest
    /// step-over or feed, of those of all choices of the marks by which both passes clear their places, and on curved surfaces
    /// of several valleys.
    pub(super) fn solve(&self, sought: Sought, mut lengths: Lengths, least: f64, most: f64, places: &mut MarkPlaces) -> Outcome {
        let start = *places;
        let mut found: Option<Outcome> = None;
        for &choice in self.pattern.choices(lengths.feed > 0.0 || sought == Sought::Feed) {
            let mut tried = start;
            for is_thorough in [false, true] {
                if is_thorough && (self.is_convex || lengths.feed == 0.0) {
                    continue;
                }
                let search = Self { is_thorough, ..*self };
                if let Some(Outcome::At(length)) = found {
                    lengths = lengths.with(sought, length);
                    if search.ridge_gap(choice, &lengths, &mut tried).value >= -LOWER * lengths.level - self.body.rounding() {
                        continue;
                    }
                }
                let outcome = search.solve_by(choice, sought, lengths, least, most, &mut tried);
                if found.is_none_or(|found| outcome.is_better(sought, &found)) {
                    (found, *places) = (Some(outcome), tried);
                }
            }
        }
        found.unwrap_or(Outcome::Above)
    }

    fn solve_by(
        &self,
        choice: [Which; 2],
        sought: Sought,
        mut lengths: Lengths,
        least: f64,
        most: f64,
        places: &mut MarkPlaces,
    ) -> Outcome {
        // W falls with the level and grows with the others.
        let sign = if sought == Sought::Level { 1.0 } else { -1.0 };
        let (mut low, mut high, mut beyond) = (0.0, f64::INFINITY, f64::INFINITY);
        let mut uncut = None;
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
            let gap = self.ridge_gap(choice, &lengths, places);
            // Where two circles just touch, the distance is 0 up to rounding from some height on.
            let rounding = 100.0 * self.body.rounding() + 8.0 * f64::EPSILON * value;
            let is_touching = sought == Sought::Level && gap.value.abs() <= rounding && gap.by_level.abs() <= TOUCHING;
            let is_beyond = sought == Sought::Level && gap.value > 0.0 && gap.by_level > 0.0;
            if is_touching {
                high = value;
            } else if is_beyond {
                // On a wall the place passes through the cutter. If the tangents on both sides cross over 0, it is not cleared.
                beyond = value;
                let (before, slope) = uncut.unwrap_or((0.0, 0.0));
                let place = (before - gap.value + gap.by_level * value - slope * low) / (gap.by_level - slope);
                if place <= 0.0 || before + slope * (place - low) > rounding {
                    return Outcome::Above;
                }
            } else if sign * gap.value > 0.0 || gap.value == 0.0 && sought != Sought::Level {
                low = value;
                uncut = Some((gap.value, gap.by(sought)));
            } else {
                high = value;
            }
            let highest = high.min(beyond);
            if low >= most || highest - low <= 2.0 * f64::EPSILON * highest && high > beyond {
                return Outcome::Above;
            }
            if high <= least {
                return Outcome::Below;
            }
            let newton = value - gap.value / gap.by(sought);
            let rounding = self.body.rounding() / gap.by(sought).abs().max(TOUCHING);
            if (newton - value).abs() <= 2.0 * f64::EPSILON * value + rounding
                || high.is_finite() && high - low <= 2.0 * f64::EPSILON * high
            {
                return Outcome::At(value);
            }
            stalled += 1;
            if highest - low < width / 2.0 {
                (width, stalled) = (highest - low, 0);
            }
            let is_ahead = newton > low && newton < highest;
            value = if is_ahead && stalled < MOST_STALLED {
                newton.clamp(value / 64.0, value * 8.0)
            } else if is_ahead && (highest == f64::INFINITY || low == 0.0) {
                // Beyond the root, which Newton's method approaches from one side.
                (newton + OVERSHOOT * (newton - value)).clamp(value / 64.0, value * 8.0)
            } else if highest == f64::INFINITY {
                8.0 * value
            } else if low == 0.0 {
                value / 64.0
            } else {
                stalled = 0;
                (low * highest).sqrt()
            };
            value = value.clamp(least, most);
        }
        match sought {
            Sought::Level if high == f64::INFINITY => Outcome::Above,
            Sought::Level => Outcome::At(high),
            _ => Outcome::At(low),
        }
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

impl Outcome {
    /// Whether it is a lower height, or a larger step-over or feed.
    pub(super) fn is_better(&self, sought: Sought, other: &Self) -> bool {
        let value = |outcome: &Self| match outcome {
            Self::At(length) => *length,
            Self::Above => f64::INFINITY,
            Self::Below => 0.0,
        };
        if sought == Sought::Level { value(self) < value(other) } else { value(self) > value(other) }
    }
}

/// One of the functions at a place.
#[derive(Clone, Copy)]
struct At {
    x: f64,
    distance: Distance,
    slope: f64,
    /// The number of the function.
    which: usize,
}

/// Where the greatest of some convex functions is least, from `start`, and its derivatives there. Each function is given with
/// its slope. The search ends where the tangents show that no more than `tolerance` can be gained; the last call of `at` is at
/// the minimum.
#[expect(clippy::float_cmp, reason = "a step that changes nothing is the last")]
fn lowest<const N: usize>(start: f64, mut stride: f64, tolerance: f64, mut at: impl FnMut(f64) -> [(Distance, f64); N]) -> (f64, Distance) {
    let (mut low, mut high): (Option<At>, Option<At>) = (None, None);
    let (mut x, first_stride) = (start, stride);
    let (mut narrowed, mut stalled) = (f64::INFINITY, 0);
    for step_number in 0.. {
        let mut which = 0;
        let functions = at(x);
        for (number, (distance, _)) in functions.iter().enumerate() {
            if distance.value > functions[which].0.value {
                which = number;
            }
        }
        let here = At { x, distance: functions[which].0, slope: functions[which].1, which };
        let is_rising = here.slope > 0.0;
        let (before, beyond) = if is_rising { (low, high) } else { (high, low) };
        if here.slope == 0.0 || step_number == MOST_STEPS {
            return (x, before.map_or(here.distance, |end| mixed(&here, &end)));
        }
        // Where the tangents cross.
        let lines = functions.iter().enumerate().filter(|(_, (distance, _))| distance.value > f64::NEG_INFINITY);
        let lines = lines.map(|(which, &(distance, slope))| At { x, distance, slope, which });
        let mut target = f64::NAN;
        if let Some((place, line)) = least_of_lines(&here, &lines) {
            if (here.slope * (place - x)).abs() <= tolerance || place == x {
                return (x, mixed(&here, &line));
            }
            target = place;
        } else if let Some(end) = before {
            // Where the slope of a smooth function is 0, linearly between both ends, and where it jumps the crossing of tangents.
            let smooth = here.slope * (end.x - x) / (here.slope - end.slope);
            if end.which == here.which && (here.slope * smooth).abs() <= tolerance {
                return (x, mixed(&here, &end));
            }
            let crossing = (end.distance.value - here.distance.value + end.slope * (x - end.x)) / (here.slope - end.slope);
            target = x + if end.which == here.which && stalled < 2 { smooth } else { crossing };
        } else if let Some(end) = beyond
            && end.which == here.which
        {
            // Beyond both, by the change of the slope.
            let step = here.slope * (end.x - x) / (here.slope - end.slope);
            if (here.slope * step).abs() <= tolerance {
                return (x, here.distance);
            }
            target = x + step;
        }
        *(if is_rising { &mut high } else { &mut low }) = Some(here);
        let next = if let (Some(low), Some(high)) = (low, high) {
            let width = high.x - low.x;
            if width <= 2.0 * f64::EPSILON * (low.x.abs() + high.x.abs() + first_stride) {
                return (x, mixed(&low, &high));
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
            let direction = -here.slope.signum();
            let ahead = direction * (target - x);
            stride *= 2.0;
            if ahead > 0.0 && ahead < 4.0 * stride { target } else { x + direction * stride }
        };
        if next == x {
            return (x, here.distance);
        }
        x = next;
    }
    unreachable!("the loop returns at MOST_STEPS")
}

/// The distance at a place between two, with the weights with which their slopes cancel.
fn mixed(one: &At, other: &At) -> Distance {
    let apart = other.slope - one.slope;
    if one.slope * other.slope < 0.0 {
        Distance { value: one.distance.value, ..one.distance.mixed(other.slope / apart, &other.distance) }
    } else {
        one.distance
    }
}

/// Where the greatest of some lines is least, starting on the greatest at `here.x`, and the line that rises from there against
/// it; `None` if none does.
fn least_of_lines(here: &At, lines: &(impl Iterator<Item = At> + Clone)) -> Option<(f64, At)> {
    let (mut place, mut line) = (here.x, *here);
    loop {
        let sign = here.slope.signum();
        let mut next: Option<(f64, At)> = None;
        for other in lines.clone() {
            if sign * (line.slope - other.slope) > 0.0 {
                let lead = (line.distance.value + line.slope * (place - line.x)) - (other.distance.value + other.slope * (place - other.x));
                let step = -sign * lead.max(0.0) / (sign * (line.slope - other.slope));
                let crossing = place + step;
                if next.is_none_or(|(best, _)| sign * (crossing - best) > 0.0) {
                    next = Some((crossing, other));
                }
            }
        }
        let (crossing, other) = next?;
        if sign * other.slope < 0.0 {
            // The gain is counted along the line from `here`, which is at least that of all lines.
            return Some((crossing, other));
        }
        (place, line) = (crossing, other);
    }
}
