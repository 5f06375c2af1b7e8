//! The height on which the tip of a cutter stands, at any place of the plan view.

use super::bottom::{Bottom, Stand};
use super::facet_tree::{FacetTree, Node};
use crate::milling::Profile;
use crate::surface::Mesh;
use nalgebra::Vector3;
use rayon::prelude::*;

/// What limits the tip by less than this more than another place does is not looked for, in mm: it lets neighbours in one
/// plane be ruled out in spite of rounding.
const INDISTINCT: f64 = 1e-9;

/// The tangent of the slope from which on a facet is a wall, which limits the tip by its edges alone: 1e-8 of its height is
/// as much as the rounding of coordinates of 100 mm displaces it.
const WALL: f64 = 1e8;

/// The length seen from above in mm up to which an edge is vertical: its higher end limits the tip.
const VERTICAL: f64 = 1e-12;

/// A facet higher than this over a point, in mm, hides it.
const HIDES: f64 = 1e-3;

/// The facets of a part, ordered so that those that limit a cutter at a place are found at once. They serve any cutter.
///
/// At the axis (x, y) the tip can go down to
///
/// T(x, y) = max over the facets' points p within R of p_z - low(|p_xy - (x, y)|),
///
/// with R the outer radius and low the height of the profile over the tip. For each facet the largest value is where the
/// cutter stands on the facet's plane, if that contact is in the facet, otherwise on an edge that separates the two: what is
/// maximized is concave over a plane. So T is exact to rounding (1e-9 mm) for any convex profile, with no sampling.
///
/// The outer side of facets does not count: a facet limits from above whichever way it is turned.
#[derive(Debug, Clone)]
pub struct DropCutter {
    nodes: Vec<Node>,
    /// The corners in the order of the tree's leaves.
    corners: Vec<[[f64; 3]; 3]>,
    /// The facet at each place of that order.
    order: Vec<u32>,
    /// The place of each facet.
    places: Vec<u32>,
}

/// How the tip rests at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// The height of the tip in mm.
    pub height: f64,
    /// The facet that is touched. If several are, one of them.
    pub facet: u32,
    /// The part of the facet that is touched.
    pub feature: Feature,
    /// The contact, in mm.
    pub contact: Vector3<f64>,
    /// The unit normal of the cutter's surface at the contact, reversed: it points up, out of the part. At a corner of the
    /// profile, whose normals are a range, the one that is perpendicular to the edge touched, or the nearest to it.
    pub normal: Vector3<f64>,
}

/// A part of a facet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Feature {
    /// Its inside, in which its normal is the cutter's.
    Inside,
    /// The edge from this corner (0, 1 or 2) to the next.
    Edge(u8),
    /// This corner.
    Vertex(u8),
}

/// Planes under the bottom of the cutter steeper than this rule out little, and round more.
const STEEPEST_UNDER: f64 = 100.0;

/// The highest position of the tip found so far.
#[derive(Clone, Copy)]
struct Highest {
    height: f64,
    place: usize,
    feature: Feature,
    contact: [f64; 3],
    /// What lies under this touches no part of the cutter's bottom.
    under: Option<Under>,
}

impl Highest {
    const NONE: Self = Self { height: f64::NEG_INFINITY, place: 0, feature: Feature::Inside, contact: [0.0; 3], under: None };
}

/// A paraboloid nowhere over the bottom of the cutter, which touches it at one point.
#[derive(Clone, Copy)]
struct Under {
    /// The point, seen from the axis.
    at: [f64; 2],
    gradient: [f64; 2],
    /// The height over the tip at the axis of the plane that touches it there.
    plane_at_axis: f64,
    /// Its curvature in every direction, [`Bottom::bend`], and the radius of that; infinite for a plane.
    bend: f64,
    radius: f64,
}

impl Under {
    /// The height to which points in a box seen from the axis raise the tip at most, if they are not over the plane with this height at
    /// the axis and this gradient.
    fn raises(&self, [min, max]: [[f64; 2]; 2], at_axis: f64, gradient: [f64; 2]) -> f64 {
        // The difference of the plane and the paraboloid is a sum of one parabola for each axis.
        let greatest = |axis: usize| {
            let steeper = gradient[axis] - self.gradient[axis];
            let place = (self.at[axis] + steeper * self.radius).max(min[axis]).min(max[axis]);
            let beside = place - self.at[axis];
            steeper * place - 0.5 * self.bend * beside * beside
        };
        at_axis - self.plane_at_axis + greatest(0) + greatest(1)
    }

    /// A height to which the points of a facet, given by its corners from the axis, raise the tip at most.
    fn raises_facet(&self, corners: [[f64; 3]; 3]) -> f64 {
        let over_plane = |[x, y, z]: [f64; 3]| z - self.plane_at_axis - self.gradient[0] * x - self.gradient[1] * y;
        let [a, b, c] = corners;
        let beside = |axis: usize| {
            let least = a[axis].min(b[axis]).min(c[axis]) - self.at[axis];
            let most = a[axis].max(b[axis]).max(c[axis]) - self.at[axis];
            least.max(-most).max(0.0)
        };
        let [x, y] = [beside(0), beside(1)];
        over_plane(a).max(over_plane(b)).max(over_plane(c)) - 0.5 * self.bend * (x * x + y * y)
    }
}

/// The rounding of positions seen from above.
fn rounding_at([x, y]: [f64; 2]) -> f64 {
    1e-12 + 4.0 * f64::EPSILON * (x.abs() + y.abs())
}

/// A cutter over a place.
struct Query {
    bottom: Bottom,
    at: [f64; 2],
    squared_radius: f64,
    /// The rounding of positions.
    rounding: f64,
}

impl DropCutter {
    /// The facets given by their corners in mm, which are finite. If `stop` returns true the result is incomplete and to be
    /// discarded.
    #[must_use]
    pub fn new(facets: &[[[f64; 3]; 3]], stop: &(dyn Fn() -> bool + Sync)) -> Self {
        Self::of(facets.len(), |facet| facets[facet], stop)
    }

    /// All facets of a mesh, with its numbers. If `stop` returns true the result is incomplete and to be discarded.
    #[must_use]
    pub fn of_mesh(mesh: &Mesh, stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let (points, triangles) = (mesh.points(), mesh.triangles());
        Self::of(triangles.len(), |facet| triangles[facet].map(|point| points[point as usize]), stop)
    }

    fn of(count: usize, corners: impl Fn(usize) -> [[f64; 3]; 3] + Sync, stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let tree = FacetTree::of(count, &corners, stop);
        let mut places = vec![0; tree.order.len()];
        #[expect(clippy::cast_possible_truncation, reason = "facets are numbered with 32 bits")]
        tree.order.iter().enumerate().for_each(|(place, &facet)| places[facet as usize] = place as u32);
        let ordered = tree.order.par_iter().with_min_len(4096).map(|&facet| corners(facet as usize)).collect();
        Self { nodes: tree.nodes, corners: ordered, order: tree.order, places }
    }

    /// The number of facets.
    #[must_use]
    pub fn facets(&self) -> usize {
        self.order.len()
    }

    /// The corners of a facet in mm.
    #[must_use]
    pub fn corners(&self, facet: u32) -> [[f64; 3]; 3] {
        self.corners[self.places[facet as usize] as usize]
    }

    /// The bytes that the structure holds.
    #[must_use]
    pub fn held_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.corners.capacity() * size_of::<[[f64; 3]; 3]>()
            + (self.order.capacity() + self.places.capacity()) * size_of::<u32>()
    }

    /// The lowest position of the tip with the axis at (x, y) at which the cutter cuts no facet; `None` where no facet is
    /// within its radius. `guess`, a facet that was touched nearby, saves time; it does not change the height.
    #[must_use]
    pub fn drop(&self, profile: &Profile, x: f64, y: f64, guess: Option<u32>) -> Option<Touch> {
        let query = Query::of(profile, [x, y]);
        let mut highest = self.resting_nearby(&query, guess);
        self.visit(
            |node, highest| query.bound(node, highest),
            |place, highest| query.rest_on(place, &self.corners[place], highest),
            &mut highest,
        );
        highest.height.is_finite().then(|| self.touch(&query, &highest))
    }

    /// Calls `each` with the corners of every facet that lifts the cutter over a tip, until it returns false. Some facets that do not lift
    /// it are among them.
    pub(super) fn each_over(&self, profile: &Profile, [x, y, z]: [f64; 3], mut each: impl FnMut(&[[f64; 3]; 3]) -> bool) {
        let query = Query::of(profile, [x, y]);
        let mut highest = Highest { height: z, ..Highest::NONE };
        let meet = |place: usize, highest: &mut Highest| {
            if highest.height.is_finite() && !each(&self.corners[place]) {
                // No facet is higher: the search ends.
                highest.height = f64::INFINITY;
            }
        };
        self.visit(|node, highest| query.bound(node, highest), meet, &mut highest);
    }

    /// A facet that lifts the cutter over a tip by more than rounding, `None` if none does. `guess`, a facet that was touched
    /// nearby, saves time.
    pub(super) fn lifting(&self, profile: &Profile, [x, y, z]: [f64; 3], guess: Option<u32>) -> Option<u32> {
        let query = Query::of(profile, [x, y]);
        let mut highest = self.resting_nearby(&query, guess);
        if highest.height <= z {
            // What lies under the bottom of the cutter that rests lower lies under its bottom at the tip.
            highest.height = z;
            // The first facet found is enough.
            let bound = |node: &Node, highest: &Highest| if highest.height > z { f64::NEG_INFINITY } else { query.bound(node, highest) };
            let rest_on = |place: usize, highest: &mut Highest| {
                if highest.height <= z {
                    query.rest_on(place, &self.corners[place], highest);
                }
            };
            self.visit(bound, rest_on, &mut highest);
        }
        (highest.height > z).then(|| self.order[highest.place])
    }

    /// Whether a point of a facet, in mm, is seen from above: no other facet is over it.
    #[must_use]
    pub fn is_seen(&self, [x, y, z]: [f64; 3]) -> bool {
        self.highest_over([x, y]).is_none_or(|over| over.height <= z + HIDES)
    }

    /// The highest facet over or under the place (x, y), and its height there in mm.
    #[must_use]
    pub fn facet_over(&self, x: f64, y: f64) -> Option<(u32, f64)> {
        self.highest_over([x, y]).map(|highest| (self.order[highest.place], highest.height))
    }

    fn highest_over(&self, at: [f64; 2]) -> Option<Highest> {
        let rounding = rounding_at(at);
        let mut highest = Highest::NONE;
        let bound = |node: &Node, _: &Highest| if node.squared_distance(at) > rounding * rounding { f64::NEG_INFINITY } else { node.top };
        let over = |place: usize, highest: &mut Highest| {
            let facet = Plane::of(&self.corners[place]);
            if facet.is_wall() || facet.is_outside(at, rounding) {
                return;
            }
            let height = facet.height(at);
            if height > highest.height {
                *highest = Highest { height, place, ..*highest };
            }
        };
        self.visit(bound, over, &mut highest);
        highest.height.is_finite().then_some(highest)
    }

    /// The cutter on two facets that are likely to be the highest: `guess`, and the one under the point where the cutter would touch the
    /// plane of `guess`. On a smooth part it touches one of them inside, and what is found rules out nearly all others.
    fn resting_nearby(&self, query: &Query, guess: Option<u32>) -> Highest {
        let mut highest = Highest::NONE;
        let guess = guess.and_then(|facet| self.places.get(facet as usize)).map(|place| *place as usize);
        let Some(first) = guess.or_else(|| self.highest_over(query.at).map(|over| over.place)) else { return highest };
        // Of two facets in one plane, the one that is touched inside is kept: it comes first.
        if let Some(second) = query.stood_on(&self.corners[first]).and_then(|contact| self.highest_over(contact)) {
            query.rest_on(second.place, &self.corners[second.place], &mut highest);
        }
        query.rest_on(first, &self.corners[first], &mut highest);
        highest
    }

    /// Calls `meet` with the place of every facet that may be higher than the highest found, the most promising first.
    fn visit(&self, bound: impl Fn(&Node, &Highest) -> f64, mut meet: impl FnMut(usize, &mut Highest), highest: &mut Highest) {
        if self.nodes.is_empty() {
            return;
        }
        // Halves of 2^32 facets are at most 32 deep, and each level leaves one child waiting.
        let mut waiting = [(0_u32, 0.0); 33];
        waiting[0] = (0, bound(&self.nodes[0], highest));
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (mut index, mut limit) = waiting[count];
            while limit > highest.height + INDISTINCT {
                let node = &self.nodes[index as usize];
                if node.facets > 0 {
                    (node.next..node.next + node.facets).for_each(|place| meet(place as usize, highest));
                    break;
                }
                let children = [index + 1, node.next].map(|child| (child, bound(&self.nodes[child as usize], highest)));
                let [near, far] = if children[0].1 >= children[1].1 { children } else { [children[1], children[0]] };
                if far.1 > highest.height + INDISTINCT {
                    waiting[count] = far;
                    count += 1;
                }
                (index, limit) = near;
            }
        }
    }

    fn touch(&self, query: &Query, highest: &Highest) -> Touch {
        let corners = &self.corners[highest.place];
        let normal = match highest.feature {
            Feature::Inside => Plane::of(corners).normal(),
            Feature::Edge(edge) | Feature::Vertex(edge) => {
                query.normal_at(highest.contact, [corners[usize::from(edge)], corners[(usize::from(edge) + 1) % 3]])
            }
        };
        Touch {
            height: highest.height,
            facet: self.order[highest.place],
            feature: highest.feature,
            contact: Vector3::from(highest.contact),
            normal,
        }
    }
}

impl Query {
    fn of(profile: &Profile, at: [f64; 2]) -> Self {
        let bottom = Bottom::of(profile);
        let squared_radius = bottom.radius() * bottom.radius();
        Self { bottom, at, squared_radius, rounding: rounding_at(at) }
    }

    /// The point of a plane that the cutter touches if it stands on it, seen from above. A level plane is touched by the
    /// whole flat of the cutter, and so at the axis.
    fn contact(&self, gradient: [f64; 2], tangent: f64, stand: Stand) -> [f64; 2] {
        let uphill = if tangent > 1e-12 { stand.distance / tangent } else { 0.0 };
        [self.at[0] + gradient[0] * uphill, self.at[1] + gradient[1] * uphill]
    }

    /// The point touched by the cutter that stands on the plane of this facet, if it is not in the facet.
    fn stood_on(&self, corners: &[[f64; 3]; 3]) -> Option<[f64; 2]> {
        let plane = Plane::of(corners);
        if plane.is_wall() {
            return None;
        }
        let tangent = plane.tangent();
        let contact = self.contact(plane.gradient, tangent, self.bottom.on_plane(tangent));
        plane.is_outside(contact, self.rounding).then_some(contact)
    }

    /// A height over which none of a node's facets lifts the tip. There are three: for their bounding plane in their box over the
    /// paraboloid under the cutter's bottom, for the top of the box, and for the whole bounding plane. The cheapest is the first, and
    /// the others are sought only if it is not low enough.
    fn bound(&self, node: &Node, highest: &Highest) -> f64 {
        let squared = node.squared_distance(self.at);
        if squared > self.squared_radius {
            return f64::NEG_INFINITY;
        }
        let at_axis = node.plane_at(self.at);
        let from_axis = |corner: [f64; 2]| [corner[0] - self.at[0], corner[1] - self.at[1]];
        let raises = |under: &Under| under.raises([from_axis(node.min), from_axis(node.max)], at_axis, node.gradient);
        let over_under = highest.under.as_ref().map_or(f64::INFINITY, raises);
        if over_under <= highest.height + INDISTINCT {
            return over_under;
        }
        let on_box = over_under.min(node.top - self.bottom.low(squared.sqrt()));
        if on_box <= highest.height + INDISTINCT {
            return on_box;
        }
        on_box.min(at_axis + self.bottom.on_plane(node.tangent).rise)
    }

    /// Raises the highest position to the one on this facet, if that is higher.
    fn rest_on(&self, place: usize, corners: &[[f64; 3]; 3], highest: &mut Highest) {
        let top = corners[0][2].max(corners[1][2]).max(corners[2][2]);
        if top <= highest.height + INDISTINCT {
            return;
        }
        if let Some(under) = &highest.under {
            let from_axis = corners.map(|[x, y, z]| [x - self.at[0], y - self.at[1], z]);
            if under.raises_facet(from_axis) <= highest.height + INDISTINCT {
                return;
            }
        }
        let plane = Plane::of(corners);
        let beyond = if plane.is_wall() {
            [true; 3]
        } else {
            let tangent = plane.tangent();
            let stand = self.bottom.on_plane(tangent);
            let height = plane.height(self.at) + stand.rise;
            if height <= highest.height + INDISTINCT {
                return;
            }
            let contact = self.contact(plane.gradient, tangent, stand);
            let beyond = plane.outside(contact, self.rounding);
            if beyond == [false; 3] {
                let at = [contact[0] - self.at[0], contact[1] - self.at[1]];
                let contact = [contact[0], contact[1], plane.height(contact)];
                let under = Some(self.under([stand.distance, tangent], at, plane.gradient, plane.height(self.at) - height));
                *highest = Highest { height, place, feature: Feature::Inside, contact, under };
                return;
            }
            beyond
        };
        for (edge, _) in (0..).zip(beyond).filter(|(_, beyond)| *beyond) {
            self.rest_on_edge(place, edge, [corners[usize::from(edge)], corners[(usize::from(edge) + 1) % 3]], highest);
        }
    }

    fn rest_on_edge(&self, place: usize, edge: u8, [a, b]: [[f64; 3]; 2], highest: &mut Highest) {
        if a[2].max(b[2]) <= highest.height + INDISTINCT {
            return;
        }
        let along = [b[0] - a[0], b[1] - a[1]];
        let from_axis = [a[0] - self.at[0], a[1] - self.at[1]];
        let length = along[0].hypot(along[1]);
        let radius = self.bottom.radius();
        let next = (edge + 1) % 3;
        if length <= VERTICAL {
            let (top, corner) = if a[2] >= b[2] { (a, edge) } else { (b, next) };
            let squared = from_axis[0] * from_axis[0] + from_axis[1] * from_axis[1];
            if squared <= self.squared_radius {
                let height = top[2] - self.bottom.low(squared.sqrt());
                self.raise(highest, Highest { height, place, feature: Feature::Vertex(corner), contact: top, under: None });
            }
            return;
        }
        // s counts from the point of the line nearest to the axis.
        let start = (from_axis[0] * along[0] + from_axis[1] * along[1]) / length;
        let end = start + length;
        let h = (from_axis[0] * along[1] - from_axis[1] * along[0]).abs() / length;
        let slope = (b[2] - a[2]) / length;
        let Some((s, _)) = self.bottom.over_line(slope, h, [start, end]) else { return };
        let (feature, contact) = if s <= start {
            (Feature::Vertex(edge), a)
        } else if s >= end {
            (Feature::Vertex(next), b)
        } else {
            let share = (s - start) / length;
            (Feature::Edge(edge), [a[0] + share * along[0], a[1] + share * along[1], a[2] + share * (b[2] - a[2])])
        };
        let rho = (h * h + s * s).sqrt().min(radius);
        let height = contact[2] - self.bottom.low(rho);
        self.raise(highest, Highest { height, place, feature, contact, under: None });
    }

    /// Raises the highest position to the one found on an edge, if that is higher.
    fn raise(&self, highest: &mut Highest, found: Highest) {
        if found.height <= highest.height {
            return;
        }
        let out = [found.contact[0] - self.at[0], found.contact[1] - self.at[1]];
        let rho = out[0].hypot(out[1]);
        // At a corner of the profile the flattest of the planes that touch it.
        let (tangent, _) = self.bottom.tangents(rho.min(self.bottom.radius()));
        let under = (tangent < STEEPEST_UNDER).then(|| {
            let gradient = if rho > 0.0 { out.map(|part| part / rho * tangent) } else { [0.0; 2] };
            let plane_at_axis = found.contact[2] - found.height - tangent * rho;
            self.under([rho.min(self.bottom.radius()), tangent], out, gradient, plane_at_axis)
        });
        *highest = Highest { under, ..found };
    }

    /// The paraboloid that touches the bottom at a distance from the axis where the slope has a tangent.
    fn under(&self, [distance, tangent]: [f64; 2], at: [f64; 2], gradient: [f64; 2], plane_at_axis: f64) -> Under {
        let bend = self.bottom.bend(distance, tangent);
        Under { at, gradient, plane_at_axis, bend, radius: bend.recip() }
    }

    /// The reversed normal of the cutter where it touches an edge or its end.
    fn normal_at(&self, contact: [f64; 3], [a, b]: [[f64; 3]; 2]) -> Vector3<f64> {
        let out = [contact[0] - self.at[0], contact[1] - self.at[1]];
        let rho = out[0].hypot(out[1]);
        let (least, most) = self.bottom.tangents(rho.min(self.bottom.radius()));
        // The normal is perpendicular to the edge at the tangent whose product with the share of the edge that leads away
        // from the axis is the edge's slope.
        let outwards = (out[0] * (b[0] - a[0]) + out[1] * (b[1] - a[1])) / rho;
        let perpendicular = (b[2] - a[2]) / outwards;
        let tangent = if perpendicular > least { perpendicular.min(most) } else { least };
        let angle = tangent.atan();
        let (sin, cos) = angle.sin_cos();
        if rho > 0.0 { Vector3::new(-out[0] / rho * sin, -out[1] / rho * sin, cos) } else { Vector3::z() }
    }
}

/// A facet and the gradient of its plane.
struct Plane<'a> {
    corners: &'a [[f64; 3]; 3],
    gradient: [f64; 2],
    /// Twice the area seen from above, negative if the corners run clockwise.
    area: f64,
}

impl<'a> Plane<'a> {
    fn of(corners: &'a [[f64; 3]; 3]) -> Self {
        let [a, b, c] = corners;
        let (u, v) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
        let area = u[0] * v[1] - u[1] * v[0];
        let gradient = [(u[2] * v[1] - u[1] * v[2]) / area, (u[0] * v[2] - u[2] * v[0]) / area];
        Self { corners, gradient, area }
    }

    /// Whether the facet is vertical, or has no area.
    fn is_wall(&self) -> bool {
        // Also where a gradient of 0/0 is not a number.
        let is_sloped = self.gradient[0].abs() < WALL && self.gradient[1].abs() < WALL;
        !is_sloped
    }

    fn tangent(&self) -> f64 {
        (self.gradient[0] * self.gradient[0] + self.gradient[1] * self.gradient[1]).sqrt()
    }

    fn height(&self, [x, y]: [f64; 2]) -> f64 {
        let a = &self.corners[0];
        a[2] + self.gradient[0] * (x - a[0]) + self.gradient[1] * (y - a[1])
    }

    fn normal(&self) -> Vector3<f64> {
        Vector3::new(-self.gradient[0], -self.gradient[1], 1.0).normalize()
    }

    /// For each edge, whether the point is beyond it seen from above by more than `rounding`.
    fn outside(&self, at: [f64; 2], rounding: f64) -> [bool; 3] {
        [0, 1, 2].map(|edge| self.is_beyond(edge, at, rounding))
    }

    fn is_outside(&self, at: [f64; 2], rounding: f64) -> bool {
        (0..3).any(|edge| self.is_beyond(edge, at, rounding))
    }

    fn is_beyond(&self, edge: usize, [x, y]: [f64; 2], rounding: f64) -> bool {
        let (a, b) = (&self.corners[edge], &self.corners[(edge + 1) % 3]);
        let along = [b[0] - a[0], b[1] - a[1]];
        let inwards = self.area.signum() * (along[0] * (y - a[1]) - along[1] * (x - a[0]));
        inwards < -rounding * (along[0].abs() + along[1].abs())
    }
}

#[cfg(test)]
mod tests;
