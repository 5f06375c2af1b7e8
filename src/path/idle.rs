//! The moves that cut nothing.

#![allow(clippy::cast_precision_loss, reason = "counts are below 2^52")]

use super::finish::looked_at;
use super::milled::Milled;
use super::moves::{Move, MoveKind};
use super::places::Place;
use crate::numerics::vector::{difference, length};

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
