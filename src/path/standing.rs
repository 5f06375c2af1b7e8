//! Where a cutter can stand on a part without cutting it.

#![allow(clippy::cast_precision_loss, reason = "counts are below 2^52")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap,
    reason = "cells and moves are fewer than 2^32"
)]

use super::body::{Body, Ray, Swept};
use super::places::{Place, Places, twice_area};
use crate::milling::Profile;
use crate::numerics::vector::{difference, dot};
use crate::surface::Mesh;
use std::sync::atomic::{AtomicU8, Ordering};

/// The sine of the slope under which a flat bottom is set on a place in several ways: rounded corners tilt the normal of
/// level facets.
const NEARLY_LEVEL: f64 = 0.02;

/// The most cells of the grid.
const MOST_CELLS: f64 = 1e6;

/// The facets that limit a cutter, in the cells of a grid in plan view. Facets that point down do not limit a cutter that
/// comes from above more than those over them.
#[derive(Debug, Clone)]
pub struct Obstacles {
    facets: Vec<Obstacle>,
    origin: [f64; 2],
    cell: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    entries: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Obstacle {
    corners: [[f64; 3]; 3],
    normal: [f64; 3],
    top: f64,
}

/// Which places a cutter could reach, if a path led it there: one that stands still, touches the place and cuts no other
/// place by more than a tolerance. It depends on no path, is found where it is asked for, and kept.
#[derive(Debug)]
pub struct Reach<'a> {
    obstacles: &'a Obstacles,
    places: &'a Places,
    bodies: Vec<Body>,
    tolerance: f64,
    known: Vec<AtomicU8>,
}

const UNKNOWN: u8 = 0;
const CAN: u8 = 1;
const CANNOT: u8 = 2;

impl Obstacles {
    /// All facets of the mesh that do not point down.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let facets: Vec<Obstacle> = (0..mesh.triangles().len())
            .filter_map(|facet| {
                let (corners, normal) = (mesh.corners(facet), mesh.normal_and_area(facet).0);
                let top = corners.iter().fold(f64::NEG_INFINITY, |top, corner| top.max(corner[2]));
                (dot(normal, normal) > 0.0 && normal[2] >= -1e-4).then_some(Obstacle { corners, normal, top })
            })
            .collect();
        let bounds = mesh.bounds();
        let [width, height] = [0, 1].map(|axis| bounds.max[axis] - bounds.min[axis]);
        let cell = (width * height / (facets.len() as f64).clamp(1.0, MOST_CELLS)).sqrt().max(width.max(height) / 1e3).max(1e-6);
        let (columns, rows) = ((width / cell) as usize + 1, (height / cell) as usize + 1);
        let origin = [bounds.min[0], bounds.min[1]];
        let mut grid = Self { facets, origin, cell, columns, rows, starts: vec![0; columns * rows + 1], entries: Vec::new() };
        let boxes: Vec<[usize; 4]> = grid.facets.iter().map(|facet| grid.cells(least(facet.corners), greatest(facet.corners))).collect();
        for at in boxes.iter().flat_map(|range| cells_of(*range, columns)) {
            grid.starts[at + 1] += 1;
        }
        for at in 1..grid.starts.len() {
            grid.starts[at] += grid.starts[at - 1];
        }
        let mut next = grid.starts.clone();
        grid.entries = vec![0; grid.starts[columns * rows] as usize];
        for (number, range) in boxes.iter().enumerate() {
            for at in cells_of(*range, columns) {
                grid.entries[next[at] as usize] = number as u32;
                next[at] += 1;
            }
        }
        grid
    }

    /// The first and last column, and the first and last row, of the cells in a box.
    fn cells(&self, min: [f64; 2], max: [f64; 2]) -> [usize; 4] {
        let at = |value: f64, axis: usize, count: usize| (((value - self.origin[axis]) / self.cell).max(0.0) as usize).min(count - 1);
        [at(min[0], 0, self.columns), at(max[0], 0, self.columns), at(min[1], 1, self.rows), at(max[1], 1, self.rows)]
    }

    /// Whether a cutter with its tip there cuts a facet by more than the tolerance.
    fn are_cut(&self, body: &Body, tip: [f64; 3], tolerance: f64) -> bool {
        let radius = body.outer_radius();
        let range = self.cells([tip[0] - radius, tip[1] - radius], [tip[0] + radius, tip[1] + radius]);
        cells_of(range, self.columns).any(|at| {
            self.entries[self.starts[at] as usize..self.starts[at + 1] as usize]
                .iter()
                .any(|&facet| self.facets[facet as usize].is_cut(body, tip, tolerance))
        })
    }
}

impl Obstacle {
    /// Material is cut to the depth at which the ray from a place along the normal enters the cutter. The depth is concave
    /// over the facet: it is largest where the cutter's tangent plane has the facet's normal, if that is inside the facet,
    /// else on its border.
    fn is_cut(&self, body: &Body, tip: [f64; 3], tolerance: f64) -> bool {
        if self.top <= tip[2] {
            return false;
        }
        let ray = body.ray(self.corners[0], self.normal);
        if Swept::new(tip, tip).tangent_plane(&ray) >= -tolerance {
            return false;
        }
        let contact = difference(tip, ray.tip);
        if self.contains(contact) {
            return true;
        }
        (0..3).any(|corner| {
            let (from, to) = (self.corners[corner], self.corners[(corner + 1) % 3]);
            // The cutter at the tip against the edge is the cutter moved back along the edge against its first corner.
            let back = std::array::from_fn(|axis| tip[axis] - (to[axis] - from[axis]));
            body.entry(&Swept::new(tip, back), &body.ray(from, self.normal), -tolerance).is_some()
        })
    }

    /// Whether the foot of the point on the facet's plane is in the facet.
    fn contains(&self, point: [f64; 3]) -> bool {
        (0..3).all(|corner| {
            let (from, to) = (self.corners[corner], self.corners[(corner + 1) % 3]);
            let moved = std::array::from_fn(|axis| point[axis] - dot(self.normal, difference(point, from)) * self.normal[axis]);
            dot(twice_area([from, to, moved]), self.normal) >= 0.0
        })
    }
}

impl<'a> Reach<'a> {
    /// What a cutter of this profile can reach among the places; the tolerance in mm, > 0.
    #[must_use]
    pub fn new(profile: &Profile, obstacles: &'a Obstacles, places: &'a Places, tolerance: f64) -> Self {
        Self::of_several(&[*profile], obstacles, places, tolerance)
    }

    /// What any of several cutters can reach.
    #[must_use]
    pub fn of_several(profiles: &[Profile], obstacles: &'a Obstacles, places: &'a Places, tolerance: f64) -> Self {
        let known = places.inside.iter().map(|_| AtomicU8::new(UNKNOWN)).collect();
        Self { obstacles, places, bodies: profiles.iter().map(Body::new).collect(), tolerance, known }
    }

    /// Whether the cutter could reach the place with this index.
    #[must_use]
    pub fn includes(&self, index: usize) -> bool {
        match self.known[index].load(Ordering::Relaxed) {
            UNKNOWN => {
                let can = self.can_touch(&self.places.inside[index]);
                self.known[index].store(if can { CAN } else { CANNOT }, Ordering::Relaxed);
                can
            }
            known => known == CAN,
        }
    }

    /// Whether the cutter can touch a place without cutting any other by more than the tolerance.
    #[must_use]
    pub fn can_touch(&self, place: &Place) -> bool {
        self.bodies.iter().any(|body| {
            let ray = body.ray(place.point, place.normal);
            stands(body, &ray).into_iter().any(|tip| !self.obstacles.are_cut(body, tip, self.tolerance))
        })
    }

    /// The largest depth by which the cutter may cut.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }
}

/// The tips with which the cutter touches the place: one, but for a bottom that is flat about the axis.
fn stands(body: &Body, ray: &Ray) -> Vec<[f64; 3]> {
    let tip = |offset: [f64; 3]| std::array::from_fn(|axis| ray.point[axis] + offset[axis]);
    let mut tips = vec![tip(ray.tip)];
    let first = body.profile().arcs()[0];
    let level = ray.normal[0].hypot(ray.normal[1]) < NEARLY_LEVEL;
    if level && first.from == 0.0 && first.centre_offset > 0.0 {
        tips.push(tip([0.0, 0.0, ray.tip[2].max(0.0)]));
        for eighth in 0..8 {
            let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(eighth)).sin_cos();
            for share in [1.0, 0.5] {
                let offset = share * first.centre_offset;
                // Over a facet that leans a little, the flat must stand on its higher side.
                let lean = offset * ray.normal[0].hypot(ray.normal[1]);
                tips.push(tip([offset * cos, offset * sin, lean]));
            }
        }
    }
    tips
}

fn least(corners: [[f64; 3]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| corners.iter().fold(f64::INFINITY, |least, corner| least.min(corner[axis])))
}

fn greatest(corners: [[f64; 3]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| corners.iter().fold(f64::NEG_INFINITY, |most, corner| most.max(corner[axis])))
}

fn cells_of([left, right, low, high]: [usize; 4], columns: usize) -> impl Iterator<Item = usize> {
    (low..=high).flat_map(move |row| (left..=right).map(move |column| row * columns + column))
}
