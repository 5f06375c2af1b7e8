//! The way from the worst of random places to the worst place.

use super::milled::Left;
use super::places::Place;
use crate::numerics::vector::mixed;
use crate::surface::Mesh;
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

/// The worst place that is reached from the given ones on their facets, corners and edges included.
pub(super) fn climbed(
    mesh: &Mesh,
    spots: impl Iterator<Item = Spot>,
    towards: Climbed,
    level: &(dyn Fn(&Place) -> Option<Left> + Sync),
) -> Option<Spot> {
    let worst_first = |a: &Spot, b: &Spot| match towards {
        Climbed::Highest => b.left.height.total_cmp(&a.left.height),
        Climbed::Lowest => a.left.height.total_cmp(&b.left.height),
    };
    let mut spots: Vec<Spot> = spots.collect();
    let most = (64 * STARTS).min(spots.len());
    if most < spots.len() {
        spots.select_nth_unstable_by(most, worst_first);
        spots.truncate(most);
    }
    spots.sort_by(worst_first);
    let mut seen = HashSet::new();
    spots.retain(|spot| seen.insert(spot.place.facet));
    spots.truncate(STARTS);
    spots
        .par_iter()
        .map(|spot| on_facet(mesh, *spot, towards, level))
        .reduce_with(|a, b| if towards.is_worse(b.left.height, a.left.height) { b } else { a })
}

/// A climb by steps towards the three corners and away from them, halved when none leads on. Steps end at the border.
fn on_facet(mesh: &Mesh, start: Spot, towards: Climbed, level: &(dyn Fn(&Place) -> Option<Left> + Sync)) -> Spot {
    let corners = mesh.corners(start.place.facet as usize);
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
