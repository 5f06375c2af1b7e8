//! The part as plans see it: the facets to machine, all facets for the drop-cutter, which facets meet at a contact, and the
//! tightest hollows.

use super::tangent::Tangent;
use crate::path::{DropCutter, Feature, ON_EDGES, Place, Touch, places_for_cuts};
use crate::quantity::{Angle, Area, Length};
use crate::surface::mesh::{FacetClass, Visibility};
use crate::surface::{FinishFacet, Mesh};
use nalgebra::Vector3;

/// The position among the targets of a facet that is not to be machined.
const NONE: u32 = u32::MAX;

/// While the tip leaves a facet around a border or a wall's upper edge, the facet counts as touched until the contact's
/// normal has turned by this cosine: 2 deg, over which a corner of 1 mm falls by 0.6 um.
const STILL_TOUCHED: f64 = 0.999_39;

/// The part: the facets to machine and all that a cutter must not cut.
#[derive(Debug)]
pub struct Workpiece {
    pub(super) drop: DropCutter,
    pub(super) targets: Vec<FinishFacet>,
    pub(super) tangents: Vec<Tangent>,
    /// The facet of each target.
    facets: Vec<u32>,
    /// The target of each facet, or [`NONE`].
    target_of: Vec<u32>,
    /// All facets: those of the surface, and then those that are not to be cut.
    mesh: Mesh,
    /// The facets around each point, those of point p from `around_starts[p]` to `around_starts[p + 1]`.
    around: Vec<u32>,
    around_starts: Vec<u32>,
    /// The lowest and the highest point of the targets and of everything.
    pub(super) bounds: [[f64; 3]; 2],
    pub(super) top: f64,
    /// The visible area in mm^2 of what is machined.
    area: f64,
    /// That of what is selected and too steep to be machined, walls excepted.
    steep_area: f64,
}

impl Workpiece {
    /// The part of a mesh: what is selected, seen from above and not too steep is machined, all else is not to be cut. `avoid`
    /// is a second mesh that is not to be cut. Once `stop` returns true, the result must be discarded.
    #[must_use]
    pub fn new(mesh: &Mesh, visibility: &Visibility, selected: &[bool], avoid: Option<&Mesh>, stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let mut planned = mesh.facets_for_finishing(visibility, selected, stop).into_iter();
        let mut targets: Vec<(u32, FinishFacet)> = Vec::new();
        let (mut area, mut steep_area) = (0.0, 0.0);
        for ((facet, class), _) in (0_u32..).zip(visibility.classes()).zip(selected).filter(|(_, selected)| **selected) {
            if !matches!(class, FacetClass::Machined | FacetClass::Steep { wall: false }) {
                continue;
            }
            let Some(planned) = planned.next() else { continue };
            let visible = visibility.visible_share(facet as usize) * planned.area;
            if *class == FacetClass::Machined {
                area += visible;
                targets.push((facet, planned));
            } else {
                steep_area += visible;
            }
        }
        let mut mesh = mesh.clone();
        if let Some(avoid) = avoid {
            mesh.append(avoid);
        }
        let (points, triangles) = (mesh.points(), mesh.triangles());
        let drop = DropCutter::of_mesh(&mesh, stop);
        let mut around_starts = vec![0_u32; points.len() + 1];
        for corner in triangles.iter().flatten() {
            around_starts[*corner as usize + 1] += 1;
        }
        for point in 0..points.len() {
            around_starts[point + 1] += around_starts[point];
        }
        let mut next = around_starts.clone();
        let mut around = vec![0; 3 * triangles.len()];
        for (facet, corners) in (0..).zip(triangles) {
            for corner in corners {
                around[next[*corner as usize] as usize] = facet;
                next[*corner as usize] += 1;
            }
        }
        let mut target_of = vec![NONE; triangles.len()];
        for (target, (facet, _)) in (0..).zip(&targets) {
            target_of[*facet as usize] = target;
        }
        let (facets, targets): (Vec<u32>, Vec<FinishFacet>) = targets.into_iter().unzip();
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for corner in targets.iter().flat_map(|target| &target.corners) {
            for axis in 0..3 {
                bounds[0][axis] = bounds[0][axis].min(corner[axis]);
                bounds[1][axis] = bounds[1][axis].max(corner[axis]);
            }
        }
        let top = points.iter().map(|point| point[2]).fold(f64::NEG_INFINITY, f64::max);
        let tangents = targets.iter().map(Tangent::of).collect();
        Self { drop, targets, tangents, facets, target_of, mesh, around, around_starts, bounds, top, area, steep_area }
    }

    /// Places on all facets at which cuts into the part are looked for.
    pub(super) fn places_for_cuts(&self) -> Vec<Place> {
        places_for_cuts(&self.mesh, &self.facets, &self.drop, ON_EDGES)
    }

    /// The facet of a target in the mesh.
    pub(super) fn facet_of(&self, target: usize) -> u32 {
        self.facets[target]
    }

    /// The visible area in mm^2 of what is machined.
    pub(super) fn area(&self) -> f64 {
        self.area
    }

    /// Whether the slope of a target is between two, in rad.
    pub(super) fn is_sloped(&self, target: usize, [from, to]: [f64; 2]) -> bool {
        (from..=to).contains(&self.tangents[target].slope)
    }

    /// The number of facets that are machined.
    #[must_use]
    pub fn machined_facets(&self) -> usize {
        self.targets.len()
    }

    /// The position of a facet among those that are to be machined.
    #[must_use]
    pub fn target_of(&self, facet: u32) -> Option<usize> {
        let target = self.target_of[facet as usize];
        (target != NONE).then_some(target as usize)
    }

    fn facets_around(&self, point: u32) -> &[u32] {
        let range = self.around_starts[point as usize] as usize..self.around_starts[point as usize + 1] as usize;
        &self.around[range]
    }

    /// The target that a contact finishes: the one whose inside, edge or corner is touched. At an edge or corner that
    /// other facets share, the contact's normal must still be that of the target; between targets it may have any.
    pub(super) fn finished_by(&self, touch: &Touch) -> Option<usize> {
        let shared: Vec<u32> = match touch.feature {
            Feature::Inside => return self.target_of(touch.facet),
            Feature::Vertex(corner) => self.facets_around(self.mesh.triangles()[touch.facet as usize][usize::from(corner)]).to_vec(),
            Feature::Edge(_) => self.facets_beside(self.edge_of(touch)),
        };
        let is_inner = match touch.feature {
            Feature::Vertex(corner) => !self.is_on_border(self.mesh.triangles()[touch.facet as usize][usize::from(corner)], &shared),
            _ => shared.len() > 1,
        };
        if is_inner && shared.iter().all(|facet| self.target_of[*facet as usize] != NONE) {
            return self.target_of(shared[0]);
        }
        let turned = |facet: &u32| {
            let target = self.target_of(*facet)?;
            let cos = Vector3::from(self.targets[target].normal).normalize().dot(&touch.normal);
            (cos >= STILL_TOUCHED).then_some((target, cos))
        };
        shared.iter().filter_map(turned).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(target, _)| target)
    }

    /// The ends of the edge that a contact touches.
    fn edge_of(&self, touch: &Touch) -> [u32; 2] {
        let triangle = self.mesh.triangles()[touch.facet as usize];
        let first = if let Feature::Edge(first) = touch.feature { usize::from(first) } else { 0 };
        [triangle[first], triangle[(first + 1) % 3]]
    }

    /// The corners of a facet.
    pub(super) fn corners_of(&self, facet: u32) -> [Vector3<f64>; 3] {
        self.mesh.corners(facet as usize).map(Vector3::from)
    }

    /// The facet on the other side of the edge that begins at a corner; `None` if there are none or several.
    pub(super) fn neighbour_of(&self, facet: u32, first: usize) -> Option<u32> {
        let corners = self.mesh.triangles()[facet as usize];
        let mut beside = self.facets_beside([corners[first], corners[(first + 1) % 3]]).into_iter().filter(|other| *other != facet);
        beside.next().filter(|_| beside.next().is_none())
    }

    fn facets_beside(&self, [a, b]: [u32; 2]) -> Vec<u32> {
        self.facets_around(a).iter().filter(|facet| self.mesh.triangles()[**facet as usize].contains(&b)).copied().collect()
    }

    /// Whether a point with these facets around it is on an edge that belongs to one facet only.
    fn is_on_border(&self, point: u32, around: &[u32]) -> bool {
        let mut others: Vec<u32> =
            around.iter().flat_map(|facet| self.mesh.triangles()[*facet as usize]).filter(|corner| *corner != point).collect();
        others.sort_unstable();
        others.chunk_by(|a, b| a == b).any(|same| same.len() == 1)
    }

    /// The distance in mm of a target from the surface that it stands for, the smaller of two estimates. A surface that turns by t from a
    /// facet to the next over the width w is w t/8 off a facet, and the turns at the three edges add up: far too much where plane faces
    /// meet. A surface of the curvature k is k s^2/8 off a square with the side s, twice the target: far too much for a long strip.
    pub(super) fn sagitta_of(&self, target: usize) -> f64 {
        let [steepest, twist, level] = self.tangents[target].curvature;
        let of_square = (steepest * steepest + level * level + 2.0 * twist * twist).sqrt() * 2.0 * self.targets[target].area / 8.0;
        let turns = self.turns_of(target).filter(|turn| turn.angle <= EDGE);
        turns.map(|turn| turn.angle * turn.narrower / 8.0).sum::<f64>().min(of_square)
    }

    /// The figures of what is machined.
    #[must_use]
    pub fn figures(&self) -> SurfaceFigures {
        let mut sums = [0.0; 2];
        for (tangent, target) in self.tangents.iter().zip(&self.targets) {
            sums[0] += target.area;
            sums[1] += target.area * tangent.slope;
        }
        let [area, slopes] = sums;
        let seen = self.area + self.steep_area;
        #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
        let count = self.targets.len().max(1) as f64;
        SurfaceFigures {
            area: Area::computed(seen),
            mean_slope: Angle::from_radians(if area > 0.0 { slopes / area } else { 0.0 }),
            steep_area_share: if seen > 0.0 { self.steep_area / seen } else { 0.0 },
            facet_size: Length::computed((2.0 * area / count).sqrt()),
        }
    }
}

/// The figures of the surface to machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFigures {
    /// The area of all selected facets as far as they are seen from above.
    pub area: Area,
    /// The mean slope over the area that is machined.
    pub mean_slope: Angle,
    /// The share of the area that is steeper than the largest slope and not machined.
    pub steep_area_share: f64,
    /// The side of a square with twice the area of the mean facet: squares of this side, each split into two triangles,
    /// are as many facets.
    pub facet_size: Length,
}

/// Two facets that meet in a hollow at a larger angle than this, in rad, are an edge, not a tessellated fillet: 30 deg.
const EDGE: f64 = 0.52;

/// Facets that meet at less than this, in rad, are one plane with rounded corners.
const FLAT: f64 = 1e-4;

/// The share of the length of hollow edges that may be tighter: scanned and repaired meshes have a few.
const LEFT_OUT: f64 = 0.01;

impl Workpiece {
    /// The radius of the tightest hollow of what is machined, 0 for a sharp inner edge; `None` without hollows. A ball or a corner
    /// of a larger radius leaves material there.
    #[must_use]
    pub fn smallest_concave_radius(&self) -> Option<Length> {
        let mut hollows: Vec<(f64, f64)> = (0..self.targets.len()).flat_map(|target| self.hollows_of(target)).collect();
        hollows.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let whole: f64 = hollows.iter().map(|(_, length)| length).sum();
        let mut passed = 0.0;
        let tightest = hollows.iter().find(|(_, length)| {
            passed += length;
            passed > LEFT_OUT * whole
        });
        tightest.map(|(radius, _)| Length::computed(*radius))
    }

    /// Radius and length of each edge of a target beyond which the part rises.
    fn hollows_of(&self, target: usize) -> impl Iterator<Item = (f64, f64)> {
        let hollow = self.turns_of(target).filter(|turn| turn.is_hollow && turn.angle >= FLAT);
        // A fillet of the radius r in strips of the width w turns by w/r from strip to strip.
        hollow.map(|turn| (if turn.angle > EDGE { 0.0 } else { turn.width / turn.angle }, turn.length))
    }

    /// The turns of the surface at the edges of a target that one other facet shares.
    fn turns_of(&self, target: usize) -> impl Iterator<Item = Turn> {
        let facet = self.facet_of(target);
        let corners = self.corners_of(facet);
        let normal_of = |[a, b, c]: [Vector3<f64>; 3]| (b - a).cross(&(c - a));
        let own = normal_of(corners);
        (0..3).filter_map(move |first| {
            let [from, to] = [corners[first], corners[(first + 1) % 3]];
            let other = self.neighbour_of(facet, first)?;
            let beyond = self.corners_of(other);
            let apex = *beyond.iter().max_by(|a, b| off(**a, from, to).total_cmp(&off(**b, from, to)))?;
            let (upwards, beside) = (upright(own), upright(normal_of(beyond)));
            let widths = [off(corners[(first + 2) % 3], from, to), off(apex, from, to)];
            Some(Turn {
                is_hollow: (apex - from).dot(&upwards) > 0.0,
                angle: upwards.cross(&beside).norm().atan2(upwards.dot(&beside)),
                width: f64::midpoint(widths[0], widths[1]),
                narrower: widths[0].min(widths[1]),
                length: (to - from).norm(),
            })
        })
    }
}

/// An edge between two facets.
struct Turn {
    /// Whether the part rises beyond it.
    is_hollow: bool,
    /// The angle in rad between the normals.
    angle: f64,
    /// The mean of the facets' widths across the edge, and the width of the narrower one, in mm.
    width: f64,
    narrower: f64,
    /// The length of the edge in mm.
    length: f64,
}

/// The unit vector that points upwards.
fn upright(normal: Vector3<f64>) -> Vector3<f64> {
    let unit = normal.normalize();
    if unit.z < 0.0 { -unit } else { unit }
}

/// The distance of a point from the line through two others.
fn off(point: Vector3<f64>, from: Vector3<f64>, to: Vector3<f64>) -> f64 {
    (point - from).cross(&(to - from)).norm() / (to - from).norm().max(f64::MIN_POSITIVE)
}
