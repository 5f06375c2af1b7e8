//! The builder of a mesh from facets or points as they arrive, within a bound on memory; and what it leaves out: facets without
//! area, and coordinates out of bounds.

use super::merge::HeightLattice;
use super::selection::FileOrder;
use super::thinning::{PointCloud, Welder};
use super::{Mesh, MeshError, twice_area};
use crate::cancellation::CancelFlag;
use crate::surface::{Bounds, Facing, LARGEST_COORDINATE, Sink, Unit, triangulation};

/// A sink that welds facets into a [`Mesh`], or triangulates single points.
///
/// Corners with equal coordinates become one point. Facets without area are counted and left out. If there are facets,
/// single points are ignored; otherwise the points are triangulated in the XY plane.
///
/// # Memory
/// At most N facets are stored, by default 2,000,000 ([`MeshBuilder::with_facet_limit`]). A facet takes 12 bytes, a point 24
/// bytes and 5 to 10 bytes of the welding table. While these grow, old and new storage exist together. A closed mesh
/// has N/2 points: with the default about 70 MB, and at most 140 MB while it grows. The worst case, facets that share
/// no corner, has 3 N points: 230 MB, and 420 MB while it grows.
///
/// At the first facet beyond the bound, the builder merges all facets, earlier and later ones, into the height of the
/// surface seen from above on a square lattice of sqrt(N/2) x sqrt(N/2) nodes, 8 bytes each. The spacing of the
/// lattice, a power of two of the file's unit, is the smallest that covers all facets; [`Mesh::merged_cell`] has it.
/// Heights at the nodes are exact; walls become slopes one spacing wide, and undercuts disappear. At most N/2 single
/// points are stored; if there are more, one point is kept for each cell of a lattice in the same way.
#[derive(Debug)]
pub struct MeshBuilder {
    limit: usize,
    welder: Welder,
    triangles: Vec<[u32; 3]>,
    lattice: Option<HeightLattice>,
    cloud: PointCloud,
    facets: u64,
    /// The facets received, those left out included.
    received: u32,
    /// The number of each stored facet in the order received, once they differ from its place.
    numbers: Option<Vec<u32>>,
    left_out: LeftOut,
    duplicates: u64,
    bounds: Bounds,
    turned_over: bool,
    cancel: CancelFlag,
}

/// The facets and points of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshSize {
    /// The number of facets.
    pub facets: usize,
    /// The number of points.
    pub points: usize,
}

impl Default for MeshBuilder {
    fn default() -> Self {
        Self::with_facet_limit(Self::DEFAULT_FACET_LIMIT)
    }
}

impl MeshBuilder {
    /// The default of N.
    pub const DEFAULT_FACET_LIMIT: usize = 2_000_000;
    /// The largest bound: point numbers must fit 32 bits with three points for each facet.
    pub const LARGEST_FACET_LIMIT: usize = 1_000_000_000;

    /// An empty mesh with the default bound.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty mesh that holds at most `limit` facets, from 8 to [`MeshBuilder::LARGEST_FACET_LIMIT`]; a limit outside
    /// these bounds is set to the nearer bound.
    #[must_use]
    pub fn with_facet_limit(limit: usize) -> Self {
        let limit = limit.clamp(8, Self::LARGEST_FACET_LIMIT);
        Self {
            limit,
            welder: Welder::new(),
            triangles: Vec::new(),
            lattice: None,
            cloud: PointCloud::new(limit / 2),
            facets: 0,
            received: 0,
            numbers: None,
            left_out: LeftOut::default(),
            duplicates: 0,
            bounds: Bounds::NONE,
            turned_over: false,
            cancel: CancelFlag::default(),
        }
    }

    /// The same builder with a cancel flag: once `cancel` is set, no more facets are merged, and the mesh must be
    /// discarded.
    #[must_use]
    pub fn with_cancel_flag(self, cancel: &CancelFlag) -> Self {
        Self { cancel: cancel.clone(), cloud: self.cloud.with_cancel_flag(cancel), ..self }
    }

    /// Leaves out facets that have the same corners as an earlier one, in the same order around the facet, and passes
    /// them to `each`. Facets that were merged on a lattice are not compared: there, a second one changes nothing.
    pub fn leave_out_duplicates(&mut self, mut each: impl FnMut([[f64; 3]; 3])) {
        let first_smallest = |[a, b, c]: [u32; 3]| match a.min(b).min(c) {
            least if least == a => [a, b, c],
            least if least == b => [b, c, a],
            _ => [c, a, b],
        };
        let mut sorted: Vec<([u32; 3], u32)> = self.triangles.iter().map(|triangle| first_smallest(*triangle)).zip(0..).collect();
        sorted.sort_unstable();
        let mut duplicates: Vec<u32> = sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1).collect();
        if duplicates.is_empty() {
            return;
        }
        duplicates.sort_unstable();
        for &duplicate in &duplicates {
            let mut corners = self.triangles[duplicate as usize].map(|corner| self.welder.points()[corner as usize]);
            if self.turned_over {
                corners.swap(1, 2);
            }
            each(corners);
        }
        let is_kept = |place: u32| duplicates.binary_search(&place).is_err();
        let mut numbers = self.numbers.take().unwrap_or_else(|| (0..).take(self.triangles.len()).collect());
        let mut places = 0..;
        numbers.retain(|_| places.next().is_none_or(is_kept));
        let mut places = 0..;
        self.triangles.retain(|_| places.next().is_none_or(is_kept));
        self.numbers = Some(numbers);
        self.duplicates += duplicates.len() as u64;
    }

    /// The number of facets that [`MeshBuilder::leave_out_duplicates`] has left out.
    #[must_use]
    pub fn duplicate_facets(&self) -> u64 {
        self.duplicates
    }

    /// Whether a facet with an area was added.
    #[must_use]
    pub fn has_facets(&self) -> bool {
        self.facets > 0
    }

    /// The largest size that the mesh of all received facets can have.
    #[must_use]
    pub fn size(&self) -> MeshSize {
        if self.lattice.is_some() {
            return MeshSize { facets: self.limit, points: self.limit / 2 };
        }
        if self.triangles.is_empty() {
            // A triangulation has fewer than two triangles for each point.
            return MeshSize { facets: 2 * self.cloud.len(), points: self.cloud.len() };
        }
        MeshSize { facets: self.triangles.len(), points: self.welder.len() }
    }

    /// The mesh, in mm, of all facets or points that were added with coordinates in `unit`.
    ///
    /// With [`Facing::Up`], a surface with facets that point down and none that point up counts as upside down, and is
    /// turned over. A facet whose back is seen from above is handled by [`Mesh::visibility`], for either `facing`.
    ///
    /// It returns early, with any result, once `stop` returns true.
    ///
    /// # Errors
    /// [`MeshError`] if no facet has an area, too few points were added, or a coordinate was out of bounds.
    pub fn finish(self, unit: Unit, facing: Facing, stop: &dyn Fn() -> bool) -> Result<Mesh, MeshError> {
        if self.left_out.is_out_of_range {
            return Err(MeshError::CoordinateOutOfRange);
        }
        let mut merged = None;
        let (mut points, mut triangles, from_points) = if let Some(lattice) = self.lattice {
            merged = Some(lattice.cell() * unit.mm());
            let (points, triangles) = lattice.finish();
            (points, triangles, false)
        } else if self.triangles.is_empty() {
            if self.left_out.degenerate > 0 && self.cloud.is_empty() {
                return Err(MeshError::OnlyDegenerateFacets { count: self.left_out.degenerate });
            }
            let received = self.cloud.received();
            merged = self.cloud.cell().map(|cell| cell * unit.mm());
            let (points, triangles) = triangulation::triangulate(self.cloud.into_points(), stop);
            if triangles.is_empty() {
                return Err(MeshError::NoTriangulation { points: received });
            }
            (points, triangles, true)
        } else {
            (self.welder.into_points(), self.triangles, false)
        };
        for point in &mut points {
            *point = point.map(|coordinate| coordinate * unit.mm());
        }
        let from_above = |[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|&index| points[index as usize]);
            twice_area(a, b, c)[2]
        };
        // The facets of a lattice and of a triangulation face up by construction.
        let given_sides = merged.is_none() && !from_points;
        let mut turned_over = given_sides && self.turned_over;
        if given_sides && facing == Facing::Up {
            let sign = if turned_over { -1.0 } else { 1.0 };
            let mut some_down = false;
            let some_up = triangles.iter().any(|triangle| {
                let side = sign * from_above(triangle);
                some_down |= side < 0.0;
                side > 0.0
            });
            turned_over ^= !some_up && some_down;
        }
        if turned_over {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }
        if triangles.is_empty() {
            // No facet covers a node: all are smaller than the spacing, or walls.
            return Err(MeshError::NothingFromAbove);
        }
        let order = (merged.is_none() && !from_points).then_some(FileOrder { received: self.received, numbers: self.numbers });
        let mesh = Mesh::assembled(points, triangles, self.left_out.degenerate, merged, from_points);
        Ok(Mesh { order, ..mesh })
    }

    /// Adds a facet with an area and coordinates in range.
    fn add(&mut self, corners: [[f64; 3]; 3]) {
        self.facets += 1;
        for corner in corners {
            self.bounds.include(corner);
        }
        if let Some(lattice) = &mut self.lattice {
            // A facet as large as the part takes about a millisecond.
            if !self.cancel.is_cancelled() {
                lattice.add(corners);
            }
        } else if self.triangles.len() == self.limit {
            self.merge().add(corners);
        } else {
            let triangle = corners.map(|corner| self.welder.index(corner));
            self.triangles.push(triangle);
            if let Some(numbers) = &mut self.numbers {
                numbers.push(self.received);
            }
        }
    }

    fn merge(&mut self) -> &mut HeightLattice {
        let (welder, triangles) = (std::mem::take(&mut self.welder), std::mem::take(&mut self.triangles));
        self.numbers = None;
        let bounds = self.bounds;
        let (limit, cancel) = (self.limit, &self.cancel);
        self.lattice.get_or_insert_with(|| {
            let mut lattice = HeightLattice::new(limit, &bounds);
            let points = welder.into_points();
            for triangle in triangles.into_iter().take_while(|_| !cancel.is_cancelled()) {
                lattice.add(triangle.map(|index| points[index as usize]));
            }
            lattice
        })
    }
}

impl Sink for MeshBuilder {
    fn point(&mut self, point: [f64; 3]) {
        if self.left_out.accepts_point(point) && self.facets == 0 {
            self.cloud.add(point);
        }
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        if self.left_out.accepts_facet(corners) {
            self.add(corners);
        } else if self.numbers.is_none() && self.lattice.is_none() {
            self.numbers = Some((0..self.received).collect());
        }
        self.received = self.received.saturating_add(1);
    }

    fn turn_over(&mut self) {
        self.turned_over = !self.turned_over;
    }
}

/// The facets and points that a mesh, or a part of one, has left out so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LeftOut {
    /// The number of facets without area.
    pub(super) degenerate: u64,
    /// Whether a coordinate was out of bounds; such a surface has no mesh.
    pub(super) is_out_of_range: bool,
}

impl LeftOut {
    /// Whether a point belongs to the mesh. A point out of bounds is recorded.
    pub(super) fn accepts_point(&mut self, point: [f64; 3]) -> bool {
        let is_in_range = in_range(point);
        self.is_out_of_range |= !is_in_range;
        is_in_range
    }

    /// Whether a facet belongs to the mesh. A facet out of bounds or without area is recorded.
    #[inline]
    pub(super) fn accepts_facet(&mut self, corners: [[f64; 3]; 3]) -> bool {
        if !corners.into_iter().all(in_range) {
            self.is_out_of_range = true;
            return false;
        }
        let [a, b, c] = corners;
        let [x, y, z] = twice_area(a, b, c);
        let has_area = x != 0.0 || y != 0.0 || z != 0.0;
        self.degenerate += u64::from(!has_area);
        has_area
    }
}

/// Whether all coordinates are numbers of at most [`LARGEST_COORDINATE`] in magnitude.
pub(super) fn in_range(point: [f64; 3]) -> bool {
    point.iter().all(|coordinate| coordinate.abs() <= LARGEST_COORDINATE)
}
