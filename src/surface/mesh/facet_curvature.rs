//! The curvature of the surface that a mesh approximates, estimated at its facets.
//!
//! **Method** (after Rusinkiewicz 2004, doi:10.1109/TDPVT.2004.1335277). Each corner of a facet has a normal: the mean
//! of the normals of the facets around that point, weighted by their angles there. Only facets within
//! [`CREASE_ANGLE_DEG`] of the facet's own normal count. Along each edge from p to q the curvature tensor K turns the
//! normal: K (q - p) = n_q - n_p. K is the symmetric tensor in the facet's plane that fits these equations best by
//! least squares, with each equation divided by the edge's length. The neighbours are the facets that share a point and
//! are within the crease angle. Their equations together have a quarter of the weight of the facet's own.
//!
//! **Planes beside fillets.** CAD systems write a plane as a few large facets, and the fillet that touches it as narrow
//! strips. At the border between them the surface has the normal of the plane; the first strip is a chord, turned by
//! half of its angle. Whether a facet counts at a corner, and as a neighbour, therefore depends on the area of its flat
//! region ([`areas_of_flat_regions`]). Regions smaller than a quarter of the largest at the corner do not count for the corner's
//! normal. Facets whose regions differ by more than this factor are not neighbours. A facet inside a flat region has
//! the curvature 0. As a result, a plane has no curvature up to its border, and the first strip of a fillet has the
//! curvature of the fillet.
//!
//! **Borders and creases.** At a corner with facets on one side only, the mean normal is that of a point further
//! inside. An edge that points into the open side of the fan has a thousandth of the weight of others, so that the
//! neighbours' equations determine the curvature there.
//!
//! **A cylinder of flat facets** has the curvature 1/R of the cylinder through its points, across, and 0 along: at each
//! point the mean of the two facets' normals is the cylinder's own normal. The same holds for a fillet tessellated by a
//! CAD system, if there are at least 11 facets in a full turn (360/11 = 33 deg). With fewer, each edge is a crease and
//! all facets count as plane. The converse: two planes that meet at less than the crease angle get the curvature of the
//! arc that touches both in the middle of their facets, unless one is over four times as large as the other. If a
//! fillet's strips are as large as the plane beside it, the facets on both sides of the border get a value between both
//! curvatures.
//!
//! **Noise.** Errors d of coordinates turn the normals of facets of size L by d/L, and change the curvature by d/L^2:
//! 0.01/mm for a micrometre and facets of 0.01 mm.

use super::{Mesh, Visibility};
use crate::cancellation::collect_until;
use crate::numerics::vector::{cross, difference, dot, length};

/// The angle between normals, in deg, above which facets do not belong to one smooth surface.
pub const CREASE_ANGLE_DEG: f64 = 35.0;

/// The weight of all neighbours' equations together, relative to the facet's own.
const NEIGHBOURS: f64 = 0.25;

/// The smallest ratio of the areas of two flat regions at which their facets count as neighbours.
const LEAST_AREA_RATIO: f64 = 0.25;

/// If a facet's flat region has at least this many times its area, and all normals around the facet are those of the
/// region, the facet has no curvature.
const MUCH_LARGER: f64 = 8.0;

/// The factor by which the weight of an edge's equation is reduced if the edge points into the open side of a fan.
const OPEN_SIDE: f64 = 1e3;

/// The facets as they are seen: for each its unit normal, reversed if its back is seen, its area, and the area of its
/// flat region.
struct Sides<'a> {
    visibility: &'a Visibility,
    normals: Vec<[f64; 3]>,
    own_areas: Vec<f64>,
    region_areas: Vec<f64>,
}

/// The mean normal at a corner, and the side on which its fan is open, as the integral over the fan of the unit vectors
/// from the point: the zero vector for a closed fan.
#[derive(Clone, Copy)]
struct CornerNormal {
    normal: [f64; 3],
    open: [f64; 3],
}

/// The sums over a facet's equations, as symmetric tensors xx, xy, xz, yy, yz, zz.
#[derive(Clone, Copy, Default)]
struct Equations {
    /// The sum of w e e' with unit vectors e along the edges.
    directions: [f64; 6],
    /// The sum of w (d e' + e d')/l with the change d of the normal along an edge of length l.
    turns: [f64; 6],
}

impl Mesh {
    /// The curvature tensor at each of the `wanted` facets, as
    /// [`FinishFacet::curvature`](super::FinishFacet::curvature) describes it. Facets seen from behind count as
    /// turned. Once `stop` returns true, it returns early, and the result must be discarded.
    pub(super) fn curvatures(&self, visibility: &Visibility, wanted: &[u32], stop: &(dyn Fn() -> bool + Sync)) -> Vec<[f64; 6]> {
        let cos_crease = CREASE_ANGLE_DEG.to_radians().cos();
        let count = self.triangles().len();
        let normals_and_areas = collect_until(count, stop, |facet| {
            let (normal, area) = self.normal_and_area(facet);
            (if visibility.is_seen_from_behind(facet) { normal.map(|part| -part) } else { normal }, area)
        });
        if stop() {
            return Vec::new();
        }
        let (normals, own_areas): (Vec<[f64; 3]>, Vec<f64>) = normals_and_areas.into_iter().unzip();
        let Some(fans) = Fans::until(self, stop) else { return Vec::new() };
        let region_areas = areas_of_flat_regions(self.triangles(), &fans, &normals, &own_areas, stop);
        let sides = Sides { visibility, normals, own_areas, region_areas };
        let normals = &sides.normals;
        // If all facets around a point are near their mean normal, and so near each other, all corners there have the
        // same normal.
        let cos_half = (CREASE_ANGLE_DEG / 2.0).to_radians().cos();
        let at_points = collect_until(self.points().len(), stop, |point| {
            let fan = fans.around(point);
            let mean = self.corner_normal(point, fan.iter(), &sides)?;
            fan.iter().all(|&facet| dot(normals[facet as usize], mean.normal) >= cos_half).then_some(mean)
        });
        if stop() {
            return Vec::new();
        }
        let equations = collect_until(count, stop, |facet| {
            let own = normals[facet];
            let corners = self.triangles()[facet].map(|point| {
                let point = point as usize;
                at_points[point].unwrap_or_else(|| {
                    let fan = fans.around(point);
                    let near = fan
                        .iter()
                        .step_by(fan.len().div_ceil(LARGEST_FAN))
                        .filter(|&&other| dot(normals[other as usize], own) >= cos_crease);
                    self.corner_normal(point, near, &sides).unwrap_or(CornerNormal { normal: own, open: [0.0; 3] })
                })
            });
            let is_plane = sides.region_areas[facet] >= MUCH_LARGER * sides.own_areas[facet]
                && corners.iter().all(|corner| {
                    let apart = difference(corner.normal, own);
                    dot(apart, apart) <= SAME_PLANE * SAME_PLANE
                });
            if is_plane { Equations::default() } else { self.equations(facet, corners) }
        });
        if stop() {
            return Vec::new();
        }
        collect_until(wanted.len(), stop, |index| {
            let facet = wanted[index] as usize;
            let own = normals[facet];
            // If the normals do not turn, the facet is in a plane, whatever its neighbours are.
            if equations[facet].turns.iter().all(|&turn| turn == 0.0) {
                return [0.0; 6];
            }
            let (mut around, mut count) = (Equations::default(), 0_u32);
            for point in self.triangles()[facet] {
                let fan = fans.around(point as usize);
                for &other in fan.iter().step_by(fan.len().div_ceil(LARGEST_FAN)) {
                    if other as usize != facet && dot(normals[other as usize], own) >= cos_crease {
                        let ratio = sides.region_areas[other as usize] / sides.region_areas[facet];
                        let ratio = ratio.min(ratio.recip());
                        // The comparison is also false for a facet whose area was rounded to 0.
                        if ratio >= LEAST_AREA_RATIO {
                            around.add(&equations[other as usize], ratio * ratio);
                            count += 1;
                        }
                    }
                }
            }
            let mut sum = equations[facet];
            if count > 0 {
                sum.add(&around, NEIGHBOURS / f64::from(count));
            }
            sum.solve(own)
        })
    }

    /// The mean of the normals of these facets around a point, weighted by their angles there. Facets with too small
    /// flat regions do not count. `None` if there are no facets, or their normals cancel.
    fn corner_normal<'a>(&self, point: usize, facets: impl Iterator<Item = &'a u32> + Clone, sides: &Sides) -> Option<CornerNormal> {
        let (mut sum, mut open) = ([0.0; 3], [0.0; 3]);
        let least = LEAST_AREA_RATIO * facets.clone().fold(0.0, |largest: f64, &facet| largest.max(sides.region_areas[facet as usize]));
        for &facet in facets {
            let triangle = self.triangles()[facet as usize];
            let place = triangle.iter().position(|&corner| corner as usize == point)?;
            let [p, q, r] = [0, 1, 2].map(|step| self.points()[triangle[(place + step) % 3] as usize]);
            let facet = facet as usize;
            let (u, v) = (difference(q, p), difference(r, p));
            // Twice the area is |u x v|.
            let weight = if sides.region_areas[facet] >= least { (2.0 * sides.own_areas[facet]).atan2(dot(u, v)) } else { 0.0 };
            // The contributions of shared edges cancel, so that only the ends of the fan remain. Turned facets have the
            // opposite orientation.
            let (u, v) = if sides.visibility.is_seen_from_behind(facet) { (v, u) } else { (u, v) };
            let (u, v, normal) = (unit(u)?, unit(v)?, sides.normals[facet]);
            for axis in 0..3 {
                sum[axis] += weight * normal[axis];
                open[axis] += v[axis] - u[axis];
            }
        }
        let normal = unit(sum)?;
        // The integral of a unit vector that turns about n from u to v is -n x (v - u).
        Some(CornerNormal { normal, open: cross(open, normal) })
    }

    fn equations(&self, facet: usize, corners: [CornerNormal; 3]) -> Equations {
        let points = self.corners(facet);
        let mut equations = Equations::default();
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let edge = difference(points[j], points[i]);
            let length = length(edge);
            let Some(e) = unit(edge) else { continue };
            let turn = difference(corners[j].normal, corners[i].normal).map(|part| part / length);
            let open = dot(corners[i].open, e).abs().max(dot(corners[j].open, e).abs());
            let weight = 1.0 / (1.0 + OPEN_SIDE * open * open);
            let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
            for (place, (a, b)) in pairs.into_iter().enumerate() {
                equations.directions[place] += weight * e[a] * e[b];
                equations.turns[place] += weight * (turn[a] * e[b] + e[a] * turn[b]);
            }
        }
        equations
    }
}

impl Equations {
    fn add(&mut self, other: &Self, weight: f64) {
        for place in 0..6 {
            self.directions[place] += weight * other.directions[place];
            self.turns[place] += weight * other.turns[place];
        }
    }

    /// The symmetric K in the plane perpendicular to `normal` with the least sum of w |K e - d/l|^2. It solves K S + S
    /// K = Q with S the directions and Q the turns; in the principal axes of S, K_ij = Q_ij/(s_i + s_j).
    fn solve(&self, normal: [f64; 3]) -> [f64; 6] {
        let (t, u) = tangents(normal);
        let (stt, stu, suu) = (between(&self.directions, t, t), between(&self.directions, t, u), between(&self.directions, u, u));
        let (sin, cos) = half_of(2.0 * stu, stt - suu);
        let first = [0, 1, 2].map(|axis| cos * t[axis] + sin * u[axis]);
        let second = [0, 1, 2].map(|axis| cos * u[axis] - sin * t[axis]);
        let (s1, s2) = (between(&self.directions, first, first), between(&self.directions, second, second));
        // The edges of a triangle with an area have at least two directions, but these may differ only by a rounding
        // error.
        let quotient = |turn: f64, weight: f64| if weight > 1e-12 { turn / weight } else { 0.0 };
        let k11 = quotient(between(&self.turns, first, first), 2.0 * s1);
        let k12 = quotient(between(&self.turns, first, second), s1 + s2);
        let k22 = quotient(between(&self.turns, second, second), 2.0 * s2);
        let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        pairs.map(|(a, b)| k11 * first[a] * first[b] + k12 * (first[a] * second[b] + second[a] * first[b]) + k22 * second[a] * second[b])
    }
}

/// a'Mb for a symmetric tensor M as xx, xy, xz, yy, yz, zz.
fn between([xx, xy, xz, yy, yz, zz]: &[f64; 6], a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * (xx * b[0] + xy * b[1] + xz * b[2]) + a[1] * (xy * b[0] + yy * b[1] + yz * b[2]) + a[2] * (xz * b[0] + yz * b[1] + zz * b[2])
}

/// Sine and cosine of half the angle atan2(y, x).
pub(super) fn half_of(y: f64, x: f64) -> (f64, f64) {
    let length = (x * x + y * y).sqrt();
    if length == 0.0 {
        return (0.0, 1.0);
    }
    // The larger of both from the sum without cancellation, the other from the sine of the whole angle.
    let larger = (0.5 * (1.0 + x.abs() / length)).sqrt();
    let smaller = 0.5 * y.abs() / (length * larger);
    let (sin, cos) = if x >= 0.0 { (smaller, larger) } else { (larger, smaller) };
    (sin.copysign(y), cos)
}

/// Two unit vectors perpendicular to a unit vector and to each other.
pub(super) fn tangents(normal: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let [x, y, z] = normal.map(f64::abs);
    // The axis with the largest angle to the normal.
    let axis = if x <= y && x <= z {
        [1.0, 0.0, 0.0]
    } else if y <= z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let across = cross(normal, axis);
    let length = length(across);
    let t = across.map(|part| part / length);
    (t, cross(normal, t))
}

/// The unit vector in this direction; `None` for a vector too short to have one.
fn unit(vector: [f64; 3]) -> Option<[f64; 3]> {
    let length = length(vector);
    let per_length = length.recip();
    (length > 1e-150).then(|| vector.map(|part| part * per_length))
}

/// The largest number of facets around a point that are examined if some are beyond a crease. If there are more, this
/// many are taken, evenly spread in the order of the file. This bounds the time for a million facets around one point.
const LARGEST_FAN: usize = 64;

/// The facets around each point: those of point p are `facets[starts[p]..starts[p + 1]]`.
pub(super) struct Fans {
    starts: Vec<u32>,
    facets: Vec<u32>,
}

/// The number of facets between two checks for cancellation.
const TURN: usize = 65_536;

impl Fans {
    /// The facets around all points; `None` once `stop` returns true.
    pub(super) fn until(mesh: &Mesh, stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let mut starts = vec![0_u32; mesh.points().len() + 1];
        for some in mesh.triangles().chunks(TURN) {
            if stop() {
                return None;
            }
            for &point in some.iter().flatten() {
                starts[point as usize + 1] += 1;
            }
        }
        for point in 1..starts.len() {
            starts[point] += starts[point - 1];
        }
        let mut next = starts.clone();
        let mut facets = vec![0; 3 * mesh.triangles().len()];
        for (first, some) in (0_u32..).step_by(TURN).zip(mesh.triangles().chunks(TURN)) {
            if stop() {
                return None;
            }
            for (facet, triangle) in (first..).zip(some) {
                for &point in triangle {
                    facets[next[point as usize] as usize] = facet;
                    next[point as usize] += 1;
                }
            }
        }
        Some(Self { starts, facets })
    }

    /// The facets around a point.
    pub(super) fn around(&self, point: usize) -> &[u32] {
        &self.facets[self.starts[point] as usize..self.starts[point + 1] as usize]
    }
}

/// The largest angle in rad between normals of one plane. Files in single precision round coordinates of 100 mm by 4e-6
/// mm, which turns the normals of facets of 0.1 mm by 4e-5 rad.
const SAME_PLANE: f64 = 1e-4;

/// The number of facets between two checks for cancellation.
const EXAMINED_AT_ONCE: usize = 1024;

/// For each facet, the area of its flat region in mm^2. A region has all facets that are connected with its first facet
/// by common points and have the same normal. All normals are compared with that of the first facet, so that a gently
/// curved surface does not become one region.
///
/// Points with more than [`LARGEST_FAN`] facets do not extend a region, because the time would grow with the square of
/// their number. The facets of such a fan are also connected at its rim.
///
/// Once `stop` returns true, it returns early, and areas are missing.
fn areas_of_flat_regions(
    triangles: &[[u32; 3]],
    fans: &Fans,
    normals: &[[f64; 3]],
    areas: &[f64],
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<f64> {
    // 1 - cos(x) = x^2/2, to 1e-17 for an angle of 1e-4.
    let least_cos = 1.0 - 0.5 * SAME_PLANE * SAME_PLANE;
    let mut of_regions = vec![f64::NAN; triangles.len()];
    let mut members: Vec<u32> = Vec::new();
    let mut examined = 0_usize;
    for (first, normal) in normals.iter().enumerate() {
        if !of_regions[first].is_nan() {
            continue;
        }
        members.clear();
        #[expect(clippy::cast_possible_truncation, reason = "the bound on facets is below 2^32")]
        members.push(first as u32);
        of_regions[first] = 0.0;
        let (mut next, mut area) = (0, 0.0);
        while next < members.len() {
            let facet = members[next] as usize;
            next += 1;
            examined += 1;
            if examined.is_multiple_of(EXAMINED_AT_ONCE) && stop() {
                return of_regions;
            }
            area += areas[facet];
            for point in triangles[facet] {
                let fan = fans.around(point as usize);
                if fan.len() > LARGEST_FAN {
                    continue;
                }
                for &other in fan {
                    let is_new = of_regions[other as usize].is_nan();
                    if is_new && dot(normals[other as usize], *normal) >= least_cos {
                        of_regions[other as usize] = 0.0;
                        members.push(other);
                    }
                }
            }
        }
        for &member in &members {
            of_regions[member as usize] = area;
        }
    }
    of_regions
}

#[cfg(test)]
mod tests;
