//! The largest feeds along a path with which tooth marks keep a tolerance, and what is left with given feeds: the stretches of
//! the path along which the cutter holds a point above the surface.

#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts are below 2^52")]

use super::body::{Body, Swept};
use super::finish::{NEIGHBOURS, Residual, looked_at};
use super::milled::{Left, Milled, Move, MoveKind};
use super::places::Place;
use crate::motion::{MachineLimits, speed_after};
use crate::numerics::vector::{difference, length};
use crate::quantity::{Length, Speed};

/// The error in mm of a stretch's ends.
const ENDS: f64 = 1e-7;

/// The path's moves with what a valley needs to know of them.
#[derive(Debug)]
pub struct Passage<'a> {
    pub(super) milled: &'a Milled,
    pub(super) moves: &'a [Move],
    /// The arc length at which each move begins, and the end.
    pub(super) starts: Vec<f64>,
}

/// A stretch of the path along which the cutter, standing anywhere on it, holds a given point.
///
/// At the tolerance above a place it is the section of a valley: what is left at the place by a tooth mark somewhere along
/// the path is a function of the arc length, and is under the tolerance along the stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Valley {
    /// The first and the last move.
    pub moves: (u32, u32),
    /// Where it begins and ends along the path in mm.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// Whether it begins or ends where the tool is at rest between a feed move and a rapid. Teeth pass there at any feed.
    pub at_rest: bool,
}

impl Valley {
    /// The length along the path: the largest feed per tooth with which a tooth mark is in the valley in any phase. Infinite
    /// where the tool is at rest in it.
    #[must_use]
    pub fn width(&self) -> f64 {
        if self.at_rest { f64::INFINITY } else { self.to - self.from }
    }
}

/// A part of a move, as shares of its plan length or of its height.
struct Part {
    index: u32,
    from: f64,
    to: f64,
}

impl<'a> Passage<'a> {
    /// Of the moves that were milled.
    #[must_use]
    pub fn new(milled: &'a Milled, moves: &'a [Move]) -> Self {
        let mut starts = Vec::with_capacity(moves.len() + 1);
        let mut at = 0.0;
        starts.push(at);
        for each in moves {
            at += length(difference(each.to, each.from));
            starts.push(at);
        }
        Self { milled, moves, starts }
    }

    /// The valleys at the height `level` in mm over a place with the unit normal n, n_z >= 0, in the order of the path.
    #[must_use]
    pub fn valleys(&self, point: [f64; 3], normal: [f64; 3], level: f64) -> Vec<Valley> {
        let held: [f64; 3] = std::array::from_fn(|axis| point[axis] + level * normal[axis]);
        let mut parts: Vec<Part> = Vec::new();
        self.milled.each_near(held, |body, index| {
            let each = &self.moves[index as usize];
            if let Some((from, to)) = held_part(body, each, held) {
                parts.push(Part { index, from, to });
            }
        });
        parts.sort_unstable_by_key(|part| part.index);
        parts.dedup_by_key(|part| part.index);
        let mut valleys: Vec<Valley> = Vec::new();
        let mut open = false;
        for part in parts {
            let (index, each) = (part.index as usize, &self.moves[part.index as usize]);
            let whole = self.starts[index + 1] - self.starts[index];
            let (from, to) = (self.starts[index] + part.from * whole, self.starts[index] + part.to * whole);
            let touches = |share: f64, end: f64| (share - end).abs() * whole <= 10.0 * ENDS;
            let goes_on = open
                && touches(part.from, 0.0)
                && valleys.last().is_some_and(|last| last.moves.1 + 1 == part.index)
                && joins(self.moves.get(index.wrapping_sub(1)), each);
            let is_start = touches(part.from, 0.0) && !joins(self.moves.get(index.wrapping_sub(1)), each);
            open = touches(part.to, 1.0);
            let rests = is_start || open && !self.moves.get(index + 1).is_some_and(|next| joins(Some(each), next));
            match valleys.last_mut() {
                Some(last) if goes_on => {
                    (last.moves.1, last.to) = (part.index, to);
                    last.at_rest |= rests;
                }
                _ => valleys.push(Valley { moves: (part.index, part.index), from, to, at_rest: rests }),
            }
        }
        valleys
    }
}

/// Whether a feed move goes on in the next without a stop.
pub(super) fn joins(one: Option<&Move>, next: &Move) -> bool {
    one.is_some_and(|one| one.kind != MoveKind::Rapid && next.kind != MoveKind::Rapid && length(difference(one.to, next.from)) <= 0.0)
}

/// The part of a move along which the cutter holds the point, as shares of its length. F is convex along the move: the part
/// is between its two zeros about the least value.
fn held_part(body: &Body, each: &Move, point: [f64; 3]) -> Option<(f64, f64)> {
    let [dx, dy, dz] = difference(each.to, each.from);
    let (plan, whole) = (dx.hypot(dy), length([dx, dy, dz]));
    let (x, y) = (point[0] - each.from[0], point[1] - each.from[1]);
    let at = |share: f64| each.from[2] + share * dz + body.low((x - share * dx).hypot(y - share * dy)) - point[2];
    if plan < 1e-9 {
        // A vertical move holds the point from its lower end up to a height.
        let reach = point[2] - body.low(x.hypot(y));
        let (low, high) = (each.from[2].min(each.to[2]), each.from[2].max(each.to[2]));
        if reach < low {
            return None;
        }
        let share = if high > low { ((reach - low) / (high - low)).min(1.0) } else { 1.0 };
        return Some(if dz < 0.0 { (1.0 - share, 1.0) } else { (0.0, share) });
    }
    let least = body.lowest_along(&Swept::new(each.from, each.to), point) / plan;
    if at(least) > 0.0 {
        return None;
    }
    let zero = |outside: f64| {
        if at(outside) <= 0.0 {
            return outside;
        }
        let (mut inside, mut outside) = (least, outside);
        while (outside - inside).abs() * whole > ENDS {
            let middle = 0.5 * (inside + outside);
            *(if at(middle) <= 0.0 { &mut inside } else { &mut outside }) = middle;
        }
        inside
    };
    Some((zero(0.0), zero(1.0)))
}

/// The share of the area in which the tolerance may be exceeded: places that the path itself leaves at almost the tolerance
/// would ask for no feed at all.
const GIVEN_UP: f64 = 5e-4;

/// The part of the smallest width that is used. Places are drawn at random: the worst place of a ridge has a width some
/// percent below the smallest that is found near it.
const OF_WIDTH: f64 = 0.97;

/// The places given to a stretch of the path of which the smallest width holds for it.
const PLACES_OF_A_STRETCH: f64 = 90.0;

/// The halvings of the level at which a valley is as wide as the feed.
const HALVINGS: u32 = 14;

/// The largest feeds per tooth, and how much of the area they were found for.
#[derive(Debug, Clone)]
pub struct LargestFeeds {
    /// For each move the largest feed per tooth in mm; infinite on rapids and where nothing limits it.
    pub per_tooth: Vec<f64>,
    /// The places that the path leaves under the tolerance at some feed.
    pub kept: usize,
    /// The places that it leaves over the tolerance at any feed.
    pub never_kept: usize,
}

impl LargestFeeds {
    /// The largest feeds per tooth that keep the tolerance in mm at the places. `None` once `stop` returns true.
    ///
    /// A place is kept if a tooth mark of any phase lies in one of its valleys. It is given to its widest valley, and the feed
    /// along it is at most its width. Places whose neighbours are over the tolerance at any feed set none. No formula of a
    /// scallop's height is used.
    #[must_use]
    pub fn new(passage: &Passage<'_>, places: &[Place], tolerance: f64, stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let widest = looked_at(places, stop, |_, place| {
            let valleys = passage.valleys(place.point, place.normal, tolerance);
            valleys.into_iter().max_by(|a, b| a.width().total_cmp(&b.width()))
        })?;
        let never_kept = widest.iter().filter(|valley| valley.is_none()).count();
        let kept = widest.len() - never_kept;
        // Beside area that is over the tolerance at any feed there are always places with hardly a width.
        let inner = widest.chunks(NEIGHBOURS).filter(|group| group.iter().all(Option::is_some));
        let mut given: Vec<Valley> = inner.flatten().flatten().copied().collect();
        given.sort_by(|a, b| a.width().total_cmp(&b.width()));
        let given_up = (GIVEN_UP * given.len() as f64) as usize;
        let length: f64 = passage.moves.iter().filter(|each| each.kind != MoveKind::Rapid).map(length_of).sum();
        let margin = 0.5 * PLACES_OF_A_STRETCH * length / given.len().max(1) as f64;
        let mut per_tooth = vec![f64::INFINITY; passage.moves.len()];
        // The narrowest come first: a move keeps the first width that it is given. `next` skips those that have one.
        let mut next: Vec<u32> = (0..=per_tooth.len() as u32).collect();
        for valley in given.iter().skip(given_up).take_while(|valley| valley.width().is_finite()) {
            let (first, last) = passage.stretch(valley, margin);
            let mut at = free(&mut next, first);
            while at <= last {
                if passage.moves[at].kind != MoveKind::Rapid {
                    per_tooth[at] = OF_WIDTH * valley.width();
                }
                next[at] = at as u32 + 1;
                at = free(&mut next, at + 1);
            }
        }
        Some(Self { per_tooth, kept, never_kept })
    }
}

/// The first move from `at` on that has no feed yet.
fn free(next: &mut [u32], at: usize) -> usize {
    let mut root = at;
    while next[root] as usize != root {
        root = next[root] as usize;
    }
    let mut each = at;
    while next[each] as usize != root {
        each = std::mem::replace(&mut next[each], root as u32) as usize;
    }
    root
}

impl Passage<'_> {
    /// The moves of a valley and those within `margin` mm along the path before and after it, as long as the tool does not
    /// stop between.
    fn stretch(&self, valley: &Valley, margin: f64) -> (usize, usize) {
        let (mut first, mut last) = (valley.moves.0 as usize, valley.moves.1 as usize);
        while first > 0 && self.starts[first] > valley.from - margin && joins(Some(&self.moves[first - 1]), &self.moves[first]) {
            first -= 1;
        }
        while last + 1 < self.moves.len()
            && self.starts[last + 1] < valley.to + margin
            && joins(Some(&self.moves[last]), &self.moves[last + 1])
        {
            last += 1;
        }
        (first, last)
    }

    /// What is left at the places with these feeds per tooth in mm, tooth marks of the worst phase included, where it is under
    /// `cap` in mm. `None` once `stop` returns true.
    #[must_use]
    pub fn with_marks(
        &self,
        places: &[Place],
        per_tooth: &[f64],
        tolerance: f64,
        cap: f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<WithMarks> {
        let left = looked_at(places, stop, |_, place| {
            let has_mark = |level: f64| {
                let valleys = self.valleys(place.point, place.normal, level);
                valleys.iter().any(|valley| valley.at_rest || self.teeth(valley, per_tooth) >= 1.0)
            };
            let swept = self.milled.left_at(place.point, place.normal)?;
            if swept.height < 0.0 {
                return Some(swept);
            }
            if !has_mark(cap) {
                return None;
            }
            let (mut low, mut high) = (swept.height, cap);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                *(if has_mark(middle) { &mut high } else { &mut low }) = middle;
            }
            // The pass that was to keep the tolerance there, and where it is fastest.
            let valleys = self.valleys(place.point, place.normal, tolerance);
            let widest = valleys.into_iter().max_by(|a, b| a.width().total_cmp(&b.width()));
            let by = widest.and_then(|valley| {
                (valley.moves.0..=valley.moves.1).max_by(|a, b| per_tooth[*a as usize].total_cmp(&per_tooth[*b as usize]))
            });
            Some(Left { height: high, by: by.unwrap_or(swept.by) })
        })?;
        Some(WithMarks { residual: Residual::new(left.iter().flatten().map(|left| left.height).collect()), left })
    }

    /// The teeth that pass along a valley.
    fn teeth(&self, valley: &Valley, per_tooth: &[f64]) -> f64 {
        let (first, last) = (valley.moves.0 as usize, valley.moves.1 as usize);
        let part = |at: usize| (self.starts[at + 1].min(valley.to) - self.starts[at].max(valley.from)).max(0.0) / per_tooth[at];
        (first..=last).map(part).sum()
    }
}

/// What is left with tooth marks.
#[derive(Debug, Clone)]
pub struct WithMarks {
    /// For each place the height, and of the moves that were to keep the tolerance there the fastest; `None` over the cap.
    pub left: Vec<Option<Left>>,
    /// Percentiles over the places under the cap.
    pub residual: Option<Residual>,
}

/// Lowers feed rates so that a machine with these limits can follow them: as long as the tool does not stop between, the rate of a
/// move is one that is reached, with limited acceleration and jerk, from every slower move before it and back to every slower one
/// after it.
pub fn smooth(moves: &[Move], feed_rates: &mut [Speed], limits: MachineLimits) {
    let forwards = reached(feed_rates, limits, |at| joins(Some(&moves[at - 1]), &moves[at]).then(|| length_of(&moves[at])));
    feed_rates.reverse();
    let count = moves.len();
    let mut backwards = reached(feed_rates, limits, |at| {
        let (each, next) = (&moves[count - 1 - at], &moves[count - at]);
        joins(Some(each), next).then(|| length_of(each))
    });
    backwards.reverse();
    for ((rate, one), other) in feed_rates.iter_mut().zip(forwards).zip(backwards) {
        *rate = if one.mm_s() < other.mm_s() { one } else { other };
    }
}

/// The rates that are reached from the slower ones before them. `length` is the length in mm of a move that the one before it joins.
fn reached(stated: &[Speed], limits: MachineLimits, length: impl Fn(usize) -> Option<f64>) -> Vec<Speed> {
    let mut rates = stated.to_vec();
    let mut at = 0;
    while at < stated.len() {
        // From here the speed rises, without a limit to acceleration at once, until a move is slower by itself: from there it can
        // rise no faster than a rise that begins there.
        let (start, mut run) = (stated[at], 0.0);
        at += 1;
        while at < stated.len()
            && let Some(length) = length(at)
        {
            run += length;
            let speed = speed_after(start, Length::computed(run), MachineLimits { feed_rate: stated[at], ..limits });
            if speed.mm_s() >= stated[at].mm_s() {
                break;
            }
            rates[at] = speed;
            at += 1;
        }
    }
    rates
}

fn length_of(each: &Move) -> f64 {
    length(difference(each.to, each.from))
}

#[cfg(test)]
mod tests;
