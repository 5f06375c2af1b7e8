//! A path that exists: its lengths, its time, the moves that cut nothing, and the places where it leaves too much or cuts too deep.

#![allow(clippy::cast_precision_loss, reason = "counts are below 2^52")]

use super::finish::{Finish, OVER, Spot, looked_at};
use super::milled::{Left, Milled, Move, MoveKind};
use super::places::{Place, Places};
use crate::motion::{Machine, TimedMove};
use crate::numerics::vector::{difference, length};
use crate::quantity::{Speed, Time};

/// The most places that are listed.
const MOST_FINDINGS: usize = 100;

/// What is wrong at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// A rapid move cuts the part.
    Collision,
    /// A move at the feed rate cuts the part.
    Gouge,
    /// More is left than the tolerance, and the cutter could have reached the place.
    OverTolerance,
    /// Tooth marks leave more than the tolerance where the moves themselves do not.
    FeedTooHigh,
    /// No move comes over the place, and the cutter could have reached it.
    Uncut,
}

/// A place where the path leaves too much or cuts too deep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// What is wrong.
    pub kind: FindingKind,
    /// The place.
    pub place: Place,
    /// What is left and by which move; `None` where the place is uncut.
    pub left: Option<Left>,
}

/// The worst places, those of each kind together and the worst first: at most a hundred, and no two of a kind closer to
/// each other than `distance` in mm. `marked` are places that the moves leave under the tolerance, with what tooth marks leave.
#[must_use]
pub fn findings(finish: &Finish, places: &Places, marked: &[(Place, Left)], tolerance: f64, distance: f64) -> Vec<Finding> {
    let mut all: Vec<Finding> = Vec::new();
    let is_too_high = |left: &Left| left.height > OVER * tolerance;
    all.extend(marked.iter().filter(|(_, left)| is_too_high(left)).map(|(place, left)| Finding {
        kind: FindingKind::FeedTooHigh,
        place: *place,
        left: Some(*left),
    }));
    let of_spot = |kind, spot: &Spot| Finding { kind, place: spot.place, left: Some(spot.left) };
    all.extend(finish.collisions.iter().map(|spot| of_spot(FindingKind::Collision, spot)));
    all.extend(finish.gouges.iter().map(|spot| of_spot(FindingKind::Gouge, spot)));
    let worst = finish.worst.iter().filter(|spot| spot.left.height > OVER * tolerance);
    all.extend(worst.map(|spot| of_spot(FindingKind::OverTolerance, spot)));
    for (index, place) in places.inside().iter().enumerate().filter(|(index, _)| finish.over_reachable[*index]) {
        let left = finish.left[index];
        let kind = if left.is_some() { FindingKind::OverTolerance } else { FindingKind::Uncut };
        all.push(Finding { kind, place: *place, left });
    }
    let size = |finding: &Finding| finding.left.map_or(0.0, |left| left.height.abs());
    all.sort_by(|a, b| a.kind.cmp(&b.kind).then(size(b).total_cmp(&size(a))));
    let mut chosen: Vec<Finding> = Vec::new();
    for finding in all {
        let is_near = |other: &Finding| other.kind == finding.kind && length(difference(other.place.point, finding.place.point)) < distance;
        if chosen.len() < MOST_FINDINGS && !chosen.iter().any(is_near) {
            chosen.push(finding);
        }
    }
    chosen
}

/// The lengths of a path in mm, and its time on a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLengths {
    /// The length of the moves at the feed rate.
    pub cutting: f64,
    /// The length of the rapid moves.
    pub rapid: f64,
    /// The time of all moves.
    pub time: Time,
    /// The moves at the feed rate from stop to stop, on average: the control stops where they meet rapid moves. 0 without any.
    pub moves_per_run: f64,
}

impl PathLengths {
    /// Of these moves, with the feed rate of each; those of rapids do not count.
    ///
    /// # Panics
    /// If there are fewer feed rates than moves.
    #[must_use]
    pub fn new(moves: &[Move], feeds: &[Speed], machine: &Machine) -> Self {
        assert!(feeds.len() >= moves.len(), "a move has no feed rate");
        let of = |rapid: bool| {
            let chosen = moves.iter().filter(|each| (each.kind == MoveKind::Rapid) == rapid);
            // A sum of nothing would be -0.0.
            chosen.map(|each| length(difference(each.to, each.from))).fold(0.0, |sum, length| sum + length)
        };
        let timed = moves.iter().zip(feeds).map(|(each, feed)| TimedMove {
            from: each.from,
            to: each.to,
            feed_rate: (each.kind != MoveKind::Rapid).then_some(*feed),
        });
        let cuts = moves.iter().filter(|each| each.kind != MoveKind::Rapid).count();
        let is_run = |of: &&[Move]| of.first().is_some_and(|first| first.kind != MoveKind::Rapid);
        let goes_on =
            |a: &Move, b: &Move| (a.kind == MoveKind::Rapid) == (b.kind == MoveKind::Rapid) && length(difference(b.from, a.to)) <= 0.0;
        let runs = moves.chunk_by(goes_on).filter(is_run).count();
        #[expect(clippy::cast_precision_loss, reason = "counts are below 2^52")]
        let moves_per_run = cuts as f64 / runs.max(1) as f64;
        Self { cutting: of(false), rapid: of(true), time: machine.time_of(timed), moves_per_run }
    }
}

/// The places over a stretch of the path that must all be untouched by it.
const PLACES_OF_A_STRETCH: f64 = 60.0;

/// The length in mm of the moves at the feed rate that take nothing over `least` mm off what the moves before them left, at
/// any of the places: they could be left out. The stock is higher than all moves.
///
/// Moves near one that cuts count as cutting, within the length of path that has 60 places on average. `None` once `stop`
/// returns true.
#[must_use]
pub fn idle_length(milled: &Milled, moves: &[Move], places: &[Place], least: f64, stop: &(dyn Fn() -> bool + Sync)) -> Option<f64> {
    let mut starts = Vec::with_capacity(moves.len() + 1);
    let mut at = 0.0;
    starts.push(at);
    for each in moves {
        at += if each.kind == MoveKind::Rapid { 0.0 } else { length(difference(each.to, each.from)) };
        starts.push(at);
    }
    let cutting = at;
    let margin = 0.5 * PLACES_OF_A_STRETCH * cutting / places.len().max(1) as f64;
    let cuts = looked_at(places, stop, |_, place| milled.cuts_at(place.point, place.normal, least))?;
    let mut stretches: Vec<[f64; 2]> =
        cuts.into_iter().flatten().map(|index| index as usize).map(|index| [starts[index] - margin, starts[index + 1] + margin]).collect();
    stretches.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut idle, mut reached) = (0.0, 0.0);
    for [from, to] in stretches {
        idle += (from - reached).max(0.0);
        reached = reached.max(to.min(cutting));
    }
    Some(idle + (cutting - reached).max(0.0))
}
