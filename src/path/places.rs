//! Places on a surface at which what a path leaves is looked at.

#![allow(clippy::cast_precision_loss, reason = "counts are below 2^52")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap,
    reason = "cells and moves are fewer than 2^32"
)]

use super::drop_cutter::DropCutter;
use crate::numerics::random::Random;
use crate::numerics::raster::z_order;
use crate::numerics::vector::{cross, difference, length, mixed};
use crate::surface::Mesh;
use rayon::prelude::*;

/// About how many corners and places on edges are looked at for cuts into the part.
pub const ON_EDGES: usize = 20_000;

/// How far in mm a place is moved off its facet to tell whether it is seen: a place on a wall is exactly under the border of the top above it.
const OFF_THE_FACET: f64 = 1e-4;

/// A place on a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// In mm.
    pub point: [f64; 3],
    /// The unit normal of the facet on its upper side, which is out of the part where the facet is seen from above.
    pub normal: [f64; 3],
    /// The index of the facet in its mesh.
    pub facet: u32,
}

/// Places on facets of a mesh: one at random in each of many parts of equal area, in an order in which neighbours are
/// close to each other, and, if wanted, some without area for cuts into the part.
#[derive(Debug, Clone)]
pub struct Places {
    pub(super) inside: Vec<Place>,
    pub(super) for_cuts: Vec<Place>,
    area: f64,
}

impl Places {
    /// Draws `count` places on the facets, which are indices of the mesh. The same arguments give the same places. Facets without area
    /// get none; without any area there are no places.
    #[must_use]
    pub fn draw(mesh: &Mesh, facets: &[u32], count: usize, seed: u64) -> Self {
        let facets = in_local_order(mesh, facets);
        let mut random = Random::new(seed);
        let area = |facet: u32| mesh.normal_and_area(facet as usize).1;
        let mut inside = Vec::with_capacity(count);
        let total = strata(&facets, area, count, &mut random, |facet, share, parts, random| {
            let Some(UpperSide { corners, normal, .. }) = upper_side(mesh, facet) else { return };
            inside.push(Place { point: inside_facet(corners, share, parts, random), normal, facet });
        });
        Self { inside, for_cuts: Vec::new(), area: total }
    }

    /// Those of the places that are seen from above.
    #[must_use]
    pub fn seen_from_above(self, drop: &DropCutter) -> Self {
        let drawn = self.inside.len().max(1);
        let inside: Vec<Place> = self.inside.into_par_iter().with_min_len(64).filter(|place| drop.is_seen(place.point)).collect();
        let area = self.area * inside.len() as f64 / drawn as f64;
        Self { inside, area, ..self }
    }

    /// With [`places_for_cuts`].
    #[must_use]
    pub fn with_cuts(self, mesh: &Mesh, facets: &[u32], drop: &DropCutter, count: usize) -> Self {
        Self { for_cuts: places_for_cuts(mesh, facets, drop, count), ..self }
    }

    /// The places inside facets, each of which stands for the same area.
    #[must_use]
    pub fn inside(&self) -> &[Place] {
        &self.inside
    }

    /// The area that the places stand for in mm^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }
}

/// Places for cuts into the part that are seen from above: about `count` on the corners and edges of these facets, as many on those of
/// the others of the mesh, and as many inside the others.
#[must_use]
pub fn places_for_cuts(mesh: &Mesh, facets: &[u32], drop: &DropCutter, count: usize) -> Vec<Place> {
    let mut is_other = vec![true; mesh.size().facets];
    for facet in facets {
        is_other[*facet as usize] = false;
    }
    let others: Vec<u32> = (0..).zip(is_other).filter_map(|(facet, is_other)| is_other.then_some(facet)).collect();
    let on_edges = |facets: &[u32]| places_on_edges(facets.iter().filter_map(|facet| upper_side(mesh, *facet)), count);
    let inside_others = Places::draw(mesh, &others, count, 1).inside;
    let all = [on_edges(facets), on_edges(&others), inside_others].concat();
    all.into_par_iter().with_min_len(64).filter(|place| is_seen_beside(drop, place)).collect()
}

/// A facet of a mesh; `None` for one without area.
fn upper_side(mesh: &Mesh, facet: u32) -> Option<UpperSide> {
    let (normal, area) = mesh.normal_and_area(facet as usize);
    let normal = if normal[2] < 0.0 { normal.map(|part| -part) } else { normal };
    (area > 0.0).then(|| UpperSide { facet, corners: mesh.corners(facet as usize), normal })
}

/// Whether a place is seen from above on one side of its facet.
fn is_seen_beside(drop: &DropCutter, place: &Place) -> bool {
    let Place { point: [x, y, z], normal, .. } = *place;
    [0.0, OFF_THE_FACET, -OFF_THE_FACET].into_iter().any(|off| drop.is_seen([x + off * normal[0], y + off * normal[1], z]))
}

/// Divides the facets' sizes, in their order, into `count` equal parts and calls `each` with a random place of each: the
/// facet, how far into its size the place is from 0 to 1, and the number of parts in the facet. The sum of the sizes.
fn strata(
    facets: &[u32],
    size: impl Fn(u32) -> f64,
    count: usize,
    random: &mut Random,
    mut each: impl FnMut(u32, f64, f64, &mut Random),
) -> f64 {
    let total: f64 = facets.iter().map(|&facet| size(facet)).sum();
    if total <= 0.0 {
        return 0.0;
    }
    let step = total / count as f64;
    let (mut done, mut before) = (0, 0.0);
    let mut wanted = step * random.unit();
    for &facet in facets {
        let size = size(facet);
        while done < count && wanted < before + size {
            each(facet, ((wanted - before) / size).clamp(0.0, 1.0), size / step, random);
            done += 1;
            wanted = step * (done as f64 + random.unit());
        }
        before += size;
    }
    total
}

/// The place at this share of the facet's area along a curve that fills it: halves across the longest edge, again and
/// again, until a part holds less than one place; there at random.
fn inside_facet(corners: [[f64; 3]; 3], share: f64, parts: f64, random: &mut Random) -> [f64; 3] {
    let [mut a, mut b, mut c] = corners;
    let (mut share, mut size) = (share, parts);
    while size > 0.5 {
        // The longest edge becomes a to b.
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| length(difference(to, from)));
        if bc > ab && bc >= ca {
            (a, b, c) = (b, c, a);
        } else if ca > ab {
            (a, b, c) = (c, a, b);
        }
        let middle = mixed(a, b, 0.5);
        share *= 2.0;
        if share < 1.0 {
            (a, b, c) = (c, a, middle);
        } else {
            share -= 1.0;
            (a, b, c) = (b, c, middle);
        }
        size *= 0.5;
    }
    let root = random.unit().sqrt();
    mixed(a, mixed(b, c, random.unit()), root)
}

/// A facet with its normal on the upper side.
#[derive(Debug, Clone, Copy)]
struct UpperSide {
    facet: u32,
    corners: [[f64; 3]; 3],
    normal: [f64; 3],
}

/// About `count` places on edges: corners of the facets, evenly of all if they are many, and else places between them as well.
/// Sharp points and edges are cut deepest, and few random places are near them.
fn places_on_edges(facets: impl Iterator<Item = UpperSide> + Clone, count: usize) -> Vec<Place> {
    let edges = facets.clone().flat_map(|UpperSide { facet, corners, normal }| {
        [0, 1, 2].map(|first| (Place { point: corners[first], normal, facet }, corners[(first + 1) % 3]))
    });
    let step = (3 * facets.count()).div_ceil(count).max(1);
    // By threes it would be the same corner of every facet, never the points of pyramids that are all listed alike.
    let step = if step.is_multiple_of(3) { step + 1 } else { step };
    let mut places: Vec<Place> = edges.clone().map(|(corner, _)| corner).step_by(step).collect();
    let whole: f64 = edges.clone().map(|(from, to)| length(difference(to, from.point))).sum();
    let per_mm = count.saturating_sub(places.len()) as f64 / whole;
    for (from, to) in edges {
        let between = (per_mm * length(difference(to, from.point))).floor();
        // The neighbour's edge runs the other way: its places are half-way between these.
        let shares = (1..=between as u32).map(|index| (f64::from(index) - 0.25) / between);
        places.extend(shares.map(|share| Place { point: mixed(from.point, to, share), ..from }));
    }
    places
}

/// The facets along a Z-order curve of the plan view.
fn in_local_order(mesh: &Mesh, facets: &[u32]) -> Vec<u32> {
    let bounds = mesh.bounds();
    let width = (bounds.max[0] - bounds.min[0]).max(bounds.max[1] - bounds.min[1]).max(f64::MIN_POSITIVE);
    let key = |facet: u32| {
        let [a, b, c] = mesh.corners(facet as usize);
        let of = |axis: usize| (65535.0 * ((a[axis] + b[axis] + c[axis]) / 3.0 - bounds.min[axis]) / width) as u32;
        z_order([of(0), of(1)])
    };
    let mut keyed: Vec<(u32, u32)> = facets.iter().map(|&facet| (key(facet), facet)).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, facet)| facet).collect()
}

/// The normal of the plane through three corners, twice the area long.
pub(super) fn twice_area(corners: [[f64; 3]; 3]) -> [f64; 3] {
    cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_corner_of_alike_facets_is_among_the_places_on_edges() {
        let facet = |facet: u32| UpperSide { facet, corners: [[0.0; 3], [1.0; 3], [2.0; 3]], normal: [0.0, 0.0, 1.0] };
        for (facets, count) in [(10, 100), (30, 30), (40, 20), (100, 20)] {
            let places = places_on_edges((0..facets).map(facet), count);
            assert!(places.len() <= count + 30, "{} of {count}", places.len());
            for corner in 0..3 {
                let found = places.iter().filter(|place| place.point[0].to_bits() == f64::from(corner).to_bits()).count();
                assert!(found > 0, "no corner {corner} of {facets} facets with {count} places");
            }
        }
    }
}
