//! The way from the worst of random places to the worst place.

use super::milled::{Left, Milled};
use super::places::Place;
use crate::numerics::vector::mixed;
use rayon::prelude::*;
use std::collections::HashSet;

/// A place and what is left there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// The place.
    pub place: Place,
    /// The level and the move that decides.
    pub left: Left,
}

/// The corners of a facet.
pub(super) type Corners<'a> = dyn Fn(u32) -> [[f64; 3]; 3] + Sync + 'a;

/// The number of facets on which a climb begins.
const STARTS: usize = 48;

/// Halvings of the step: from a third of the facet to a millionth.
const HALVINGS: u32 = 18;

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Climbed {
    Highest,
    Lowest,
}

impl Climbed {
    fn is_worse(self, one: f64, other: f64) -> bool {
        match self {
            Self::Highest => one > other,
            Self::Lowest => one < other,
        }
    }
}

/// The deepest cut into the part that is reached from the given places, with the depths found there as negative heights. `corners`
/// are those of a facet.
#[must_use]
pub fn deepest_cut(milled: &Milled, corners: &Corners<'_>, places: impl Iterator<Item = (Place, f64)>) -> Option<Spot> {
    climbed(corners, places.filter(|(_, height)| *height < 0.0), Climbed::Lowest, &|place| milled.left_at(place.point, place.normal))
}

/// The worst place that is reached from the given ones on their facets, corners and edges included.
pub(super) fn climbed(
    corners: &Corners<'_>,
    places: impl Iterator<Item = (Place, f64)>,
    towards: Climbed,
    level: &(dyn Fn(&Place) -> Option<Left> + Sync),
) -> Option<Spot> {
    let worst_first = |a: &(Place, f64), b: &(Place, f64)| match towards {
        Climbed::Highest => b.1.total_cmp(&a.1),
        Climbed::Lowest => a.1.total_cmp(&b.1),
    };
    let mut places: Vec<(Place, f64)> = places.collect();
    let most = (64 * STARTS).min(places.len());
    if most < places.len() {
        places.select_nth_unstable_by(most, worst_first);
        places.truncate(most);
    }
    places.sort_by(worst_first);
    let mut seen = HashSet::new();
    places.retain(|(place, _)| seen.insert(place.facet));
    places.truncate(STARTS);
    places
        .par_iter()
        .filter_map(|(place, _)| Some(on_facet(corners(place.facet), Spot { place: *place, left: level(place)? }, towards, level)))
        .reduce_with(|a, b| if towards.is_worse(b.left.height, a.left.height) { b } else { a })
}

/// A climb by steps towards the three corners and away from them, halved when none leads on. Steps end at the border.
fn on_facet(corners: [[f64; 3]; 3], start: Spot, towards: Climbed, level: &(dyn Fn(&Place) -> Option<Left> + Sync)) -> Spot {
    let mut best = start;
    let mut weights = barycentric(corners, start.place.point);
    let mut step: f64 = 1.0 / 3.0;
    let mut tried = 0;
    for _ in 0..HALVINGS {
        let mut leads_on = true;
        while leads_on && tried < 400 {
            leads_on = false;
            for (from, to) in [(0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)] {
                let by = step.min(weights[from]);
                if by <= 0.0 {
                    continue;
                }
                let mut moved = weights;
                moved[from] -= by;
                moved[to] += by;
                let place = Place { point: at(corners, moved), ..best.place };
                tried += 1;
                if let Some(left) = level(&place)
                    && towards.is_worse(left.height, best.left.height)
                {
                    best = Spot { place, left };
                    weights = moved;
                    leads_on = true;
                }
            }
        }
        step *= 0.5;
    }
    best
}

fn at([a, b, c]: [[f64; 3]; 3], weights: [f64; 3]) -> [f64; 3] {
    let to_c = weights[2];
    let to_b = if weights[0] + weights[1] > 0.0 { weights[1] / (weights[0] + weights[1]) } else { 0.0 };
    mixed(mixed(a, b, to_b), c, to_c)
}

/// The weights of the corners at a point of the facet.
fn barycentric(corners: [[f64; 3]; 3], point: [f64; 3]) -> [f64; 3] {
    use super::places::twice_area;
    use crate::numerics::vector::dot;
    let whole = twice_area(corners);
    let part = |from: [f64; 3], to: [f64; 3]| (dot(twice_area([from, to, point]), whole) / dot(whole, whole)).clamp(0.0, 1.0);
    let (a, b) = (part(corners[1], corners[2]), part(corners[2], corners[0]));
    let b = b.min(1.0 - a);
    [a, b, 1.0 - a - b]
}
