//! The stretches of a path along which the cutter holds a point above the surface.

use super::body::{Body, Swept};
use super::milled::Milled;
use super::moves::{Move, MoveKind};
use crate::numerics::vector::{difference, length};

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
