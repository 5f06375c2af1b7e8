//! Vertices and faces of an indexed mesh, for the readers of OBJ and PLY; faces are polygons, which are cut into triangles.

use super::Sink;
use crate::file_fault::{FileFaultKind, Flaw};
use nalgebra::Vector3;

/// Vertices in a block: 96 KiB.
const BLOCK: usize = 4096;

/// Vertices in the order of the file. They are stored because faces refer to them by number, in blocks of a fixed size: a growing
/// vector would copy all of them to twice the memory each time that it is full.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    blocks: Vec<Vec<[f64; 3]>>,
}

impl Vertices {
    pub(super) fn push(&mut self, vertex: [f64; 3]) {
        match self.blocks.last_mut() {
            Some(last) if last.len() < BLOCK => last.push(vertex),
            _ => {
                let mut block = Vec::with_capacity(BLOCK);
                block.push(vertex);
                self.blocks.push(block);
            }
        }
    }

    pub(super) fn get(&self, index: usize) -> Option<&[f64; 3]> {
        self.blocks.get(index / BLOCK)?.get(index % BLOCK)
    }

    pub(super) fn len(&self) -> usize {
        self.blocks.last().map_or(0, |last| (self.blocks.len() - 1) * BLOCK + last.len())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[f64; 3]> {
        self.blocks.iter().flatten()
    }
}

/// The vertices read so far, and the face that is being read.
#[derive(Debug)]
pub(super) struct Faces {
    vertices: Vertices,
    limit: usize,
    face: Polygon,
    facets: u64,
    crossed: u64,
}

impl Faces {
    /// No faces, for at most `limit` vertices; memory grows with the vertices that arrive.
    pub(super) fn new(limit: usize) -> Self {
        Self { vertices: Vertices::default(), limit, face: Polygon::default(), facets: 0, crossed: 0 }
    }

    pub(super) fn vertices(&self) -> &Vertices {
        &self.vertices
    }

    /// The number of facets passed to the sink.
    pub(super) fn facets(&self) -> u64 {
        self.facets
    }

    /// The number of polygons whose outline crosses itself.
    pub(super) fn crossed(&self) -> u64 {
        self.crossed
    }

    pub(super) fn add_vertex(&mut self, vertex: [f64; 3]) -> Result<(), Flaw> {
        if self.vertices.len() >= self.limit {
            return Err(too_many_vertices(self.limit));
        }
        self.vertices.push(vertex);
        Ok(())
    }

    /// Adds the vertex with this number, counted from 0, to the face that is being read.
    pub(super) fn add_corner(&mut self, vertex: usize) -> Option<Result<(), Flaw>> {
        self.vertices.get(vertex).map(|corner| self.face.add(*corner))
    }

    /// Passes a triangle of the vertices with these numbers to the sink, unless a number occurs twice; `None` if a
    /// vertex is missing.
    pub(super) fn add_triangle(&mut self, vertices: [usize; 3], sink: &mut dyn Sink) -> Option<()> {
        let [a, b, c] = vertices;
        let corners = [*self.vertices.get(a)?, *self.vertices.get(b)?, *self.vertices.get(c)?];
        if a != b && b != c && c != a {
            self.facets += 1;
            sink.facet(corners);
        }
        Some(())
    }

    /// Passes the current face to the sink as triangles, and starts the next.
    pub(super) fn close(&mut self, sink: &mut dyn Sink) -> Result<(), Flaw> {
        let corners = self.face.corners().len();
        if corners < 3 {
            let found = ["none", "one", "two"][corners];
            return Err(Flaw::new(FileFaultKind::Malformed, "a face with three corners at least", found));
        }
        let cut = self.face.cut(|corners| sink.facet(corners))?;
        self.facets += (corners - 2) as u64;
        self.crossed += u64::from(cut == Cut::Crossed);
        self.face.clear();
        Ok(())
    }
}

#[cold]
pub(super) fn too_many_vertices(limit: usize) -> Flaw {
    Flaw::new(FileFaultKind::TooLarge, format!("at most {limit} vertices"), "more")
}

/// The largest number of corners of a polygon.
const MOST_CORNERS: usize = 1 << 16;

/// The largest number of corners of a polygon that a fan does not cover: the time of ear clipping grows with its
/// square.
const MOST_CORNERS_BY_EARS: usize = 512;

/// The share of a polygon's area by which a triangle may have the opposite orientation: corners in single precision are
/// rounded by 6e-8 of their size, which reverses triangles whose corners should be collinear.
const NEGLIGIBLE: f64 = 1e-6;

/// How well the triangles represent the polygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cut {
    /// The triangles cover the polygon exactly.
    Exact,
    /// The outline crosses itself: the triangles have its area vector, but some have the opposite orientation.
    Crossed,
}

/// A polygon, and buffers for its triangulation that are reused for the next. The triangles have the polygon's orientation, so
/// that area, moments and normals are the polygon's.
///
/// A fan from the first corner covers every convex polygon and many others. If a triangle of the fan would have the opposite
/// orientation, ear clipping is used instead [Meisters 1975, two ears theorem].
#[derive(Debug, Default)]
pub(super) struct Polygon {
    corners: Vec<[f64; 3]>,
    ring: Ring,
}

impl Polygon {
    pub(super) fn clear(&mut self) {
        self.corners.clear();
    }

    pub(super) fn corners(&self) -> &[[f64; 3]] {
        &self.corners
    }

    pub(super) fn add(&mut self, corner: [f64; 3]) -> Result<(), Flaw> {
        if self.corners.len() >= MOST_CORNERS {
            return Err(Flaw::new(FileFaultKind::TooLarge, format!("at most {MOST_CORNERS} corners in a face"), "more"));
        }
        self.corners.push(corner);
        Ok(())
    }

    /// Passes the triangles to `emit`, in the order of the corners.
    pub(super) fn cut(&mut self, mut emit: impl FnMut([[f64; 3]; 3])) -> Result<Cut, Flaw> {
        let corners = &self.corners[..];
        if let &[a, b, c] = corners {
            emit([a, b, c]);
            return Ok(Cut::Exact);
        }
        let verdict = evaluate(corners);
        if let Fan::Fits | Fan::Crosses = verdict {
            for pair in corners[1..].windows(2) {
                emit([corners[0], pair[0], pair[1]]);
            }
        }
        match verdict {
            Fan::Fits => Ok(Cut::Exact),
            Fan::Crosses => Ok(Cut::Crossed),
            Fan::TurnsOver(_) if corners.len() > MOST_CORNERS_BY_EARS => {
                let expected = format!("at most {MOST_CORNERS_BY_EARS} corners in a face that is not convex");
                Err(Flaw::new(FileFaultKind::TooLarge, expected, corners.len().to_string()))
            }
            Fan::TurnsOver(area) => Ok(self.ring.cut(corners, area, emit)),
        }
    }
}

/// Whether a fan from the first corner covers a polygon.
enum Fan {
    Fits,
    /// Some triangles have the opposite orientation. The field is twice the polygon's area vector.
    TurnsOver(Vector3<f64>),
    /// The triangles cancel each other.
    Crosses,
}

fn evaluate(corners: &[[f64; 3]]) -> Fan {
    let first = corners[0];
    let triangles = || corners[1..].windows(2).map(|pair| edge(first, pair[0]).cross(&edge(first, pair[1])));
    let extent = corners.iter().map(|corner| edge(first, *corner).norm_squared()).fold(0.0, f64::max);
    let mut area = Vector3::zeros();
    let mut sizes = 0.0;
    for triangle in triangles() {
        area += triangle;
        sizes += triangle.norm();
    }
    // The polygon is a line: its triangles have no area, so their orientation does not matter.
    if sizes <= NEGLIGIBLE * extent {
        return Fan::Fits;
    }
    let square = area.norm_squared();
    if square.sqrt() <= NEGLIGIBLE * sizes {
        return Fan::Crosses;
    }
    if triangles().all(|triangle| triangle.dot(&area) >= -NEGLIGIBLE * square) { Fan::Fits } else { Fan::TurnsOver(area) }
}

/// The remaining outline during ear clipping, projected along the polygon's normal, counter-clockwise.
#[derive(Debug, Default)]
struct Ring {
    flat: Vec<[f64; 2]>,
    next: Vec<usize>,
    previous: Vec<usize>,
    /// Reflex corners: only they can lie inside an ear.
    inward: Vec<usize>,
}

impl Ring {
    fn cut(&mut self, corners: &[[f64; 3]], area: Vector3<f64>, mut emit: impl FnMut([[f64; 3]; 3])) -> Cut {
        self.lay_out(corners, area);
        let mut left = corners.len();
        let mut at = 0;
        let mut refused = 0;
        // At first, a corner on the border of an ear blocks it. If that leaves no ear, because two parts of the outline
        // coincide, only corners strictly inside block an ear.
        let mut strict = false;
        // A simple polygon needs a few tests for each corner; this many mean that the polygon is not simple.
        let mut looks = 16 * corners.len();
        while left > 3 && looks > 0 {
            looks -= 1;
            let (before, after) = (self.previous[at], self.next[at]);
            if self.is_ear(at, strict) {
                emit([corners[before], corners[at], corners[after]]);
                self.remove(at);
                left -= 1;
                refused = 0;
                at = before;
            } else {
                refused += 1;
                at = after;
            }
            if refused > left {
                if strict {
                    break;
                }
                strict = true;
                refused = 0;
            }
        }
        self.fan(at, corners, area, emit)
    }

    /// The remaining corners as a fan: a single triangle, unless clipping stopped early.
    fn fan(&self, first: usize, corners: &[[f64; 3]], area: Vector3<f64>, mut emit: impl FnMut([[f64; 3]; 3])) -> Cut {
        let mut cut = Cut::Exact;
        let mut second = self.next[first];
        while self.next[second] != first {
            let third = self.next[second];
            let [a, b, c] = [first, second, third].map(|corner| corners[corner]);
            if edge(a, b).cross(&edge(a, c)).dot(&area) < -NEGLIGIBLE * area.norm_squared() {
                cut = Cut::Crossed;
            }
            emit([a, b, c]);
            second = third;
        }
        cut
    }

    fn lay_out(&mut self, corners: &[[f64; 3]], area: Vector3<f64>) {
        let largest = (0..3).max_by(|a, b| area[*a].abs().total_cmp(&area[*b].abs())).unwrap_or(2);
        let (mut u, mut v) = ((largest + 1) % 3, (largest + 2) % 3);
        if area[largest] < 0.0 {
            std::mem::swap(&mut u, &mut v);
        }
        let count = corners.len();
        self.flat.clear();
        // Relative to the first corner, so that polygons far from the origin keep their precision.
        self.flat.extend(corners.iter().map(|corner| [corner[u] - corners[0][u], corner[v] - corners[0][v]]));
        self.next.clear();
        self.next.extend((1..count).chain([0]));
        self.previous.clear();
        self.previous.extend([count - 1].into_iter().chain(0..count - 1));
        self.inward.clear();
        for corner in 0..count {
            if self.turn(corner) < 0.0 {
                self.inward.push(corner);
            }
        }
    }

    /// Twice the area of the triangle of a corner and its neighbours, negative at a reflex corner.
    fn turn(&self, corner: usize) -> f64 {
        side(self.flat[self.previous[corner]], self.flat[corner], self.flat[self.next[corner]])
    }

    fn is_ear(&self, corner: usize, strict: bool) -> bool {
        let turn = self.turn(corner);
        if turn <= 0.0 {
            // Collinear corners: removing the middle one does not change the area.
            return turn == 0.0;
        }
        let [a, b, c] = [self.previous[corner], corner, self.next[corner]].map(|corner| self.flat[corner]);
        !self.inward.iter().map(|other| self.flat[*other]).any(|p| {
            let sides = [side(a, b, p), side(b, c, p), side(c, a, p)];
            let inside = if strict { sides.iter().all(|side| *side > 0.0) } else { sides.iter().all(|side| *side >= 0.0) };
            inside && [a, b, c].iter().all(|corner| !same(p, *corner))
        })
    }

    fn remove(&mut self, corner: usize) {
        let (before, after) = (self.previous[corner], self.next[corner]);
        self.next[before] = after;
        self.previous[after] = before;
        self.inward.retain(|inward| *inward != corner);
        // Clipping an ear can make its neighbours convex, but not reflex.
        for neighbour in [before, after] {
            if self.turn(neighbour) >= 0.0 {
                self.inward.retain(|inward| *inward != neighbour);
            }
        }
    }
}

/// Whether two corners are the same point, as at the joint of a hole and the outline.
#[allow(clippy::float_cmp, reason = "a point that occurs twice has the same numbers")]
fn same(a: [f64; 2], b: [f64; 2]) -> bool {
    a == b
}

/// Twice the signed area of the triangle a, b, p: positive if p is to the left of the line from a to b.
fn side(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

fn edge(from: [f64; 3], to: [f64; 3]) -> Vector3<f64> {
    Vector3::from(to) - Vector3::from(from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn vertices_keep_their_numbers_across_blocks() {
        let vertex = |index: usize| [f64::from(u32::try_from(index).unwrap()), 1.0, 2.0];
        let mut vertices = Vertices::default();
        assert!(vertices.is_empty() && vertices.get(0).is_none());
        for index in 0..=2 * BLOCK {
            assert_eq!(vertices.len(), index);
            vertices.push(vertex(index));
        }
        assert!((0..vertices.len()).all(|index| vertices.get(index) == Some(&vertex(index))));
        assert_eq!(vertices.get(vertices.len()), None);
        assert!(vertices.iter().copied().eq((0..vertices.len()).map(vertex)));
    }

    /// The triangles of a plane polygon that is placed on a slope.
    fn cut(outline: &[[f64; 2]]) -> (Cut, Vec<[[f64; 3]; 3]>) {
        let mut polygon = Polygon::default();
        for [u, v] in outline {
            // An orthonormal pair, so that areas are preserved.
            polygon.add([0.6 * u + 7.0, *v - 3.0, 0.8 * u + 1.0]).unwrap();
        }
        let mut triangles = Vec::new();
        let cut = polygon.cut(|triangle| triangles.push(triangle)).unwrap();
        (cut, triangles)
    }

    fn along_normal([a, b, c]: [[f64; 3]; 3]) -> f64 {
        edge(a, b).cross(&edge(a, c)).dot(&Vector3::new(-0.8, 0.0, 0.6)) / 2.0
    }

    fn shoelace(outline: &[[f64; 2]]) -> f64 {
        (0..outline.len()).map(|i| (outline[i], outline[(i + 1) % outline.len()])).map(|(p, q)| (p[0] * q[1] - q[0] * p[1]) / 2.0).sum()
    }

    fn must_be_exact(outline: &[[f64; 2]]) {
        let (cut, triangles) = cut(outline);
        let area = shoelace(outline);
        assert_eq!(cut, Cut::Exact);
        assert_eq!(triangles.len(), outline.len() - 2);
        // If all have the polygon's orientation and their areas sum to its area, they cannot overlap.
        assert!(triangles.iter().all(|triangle| along_normal(*triangle) >= -NEGLIGIBLE * area), "{triangles:?}");
        approx::assert_relative_eq!(triangles.iter().map(|triangle| along_normal(*triangle)).sum::<f64>(), area, max_relative = 1e-12);
    }

    #[test]
    fn an_arrow_is_cut_at_its_reflex_corner() {
        let arrow = [[0.0, 0.0], [4.0, -2.0], [1.0, 0.0], [4.0, 2.0]];
        for first in 0..4 {
            let mut turned = arrow;
            turned.rotate_left(first);
            must_be_exact(&turned);
        }
    }

    #[test]
    fn a_comb_and_a_spiral_are_cut_exactly() {
        let mut comb = vec![[0.0, 0.0], [20.0, 0.0], [20.0, 5.0]];
        for tooth in (0..10).rev() {
            let left = 2.0 * f64::from(tooth);
            comb.extend([[left + 1.5, 5.0], [left + 1.5, 1.0], [left + 0.5, 1.0], [left + 0.5, 5.0]]);
        }
        comb.push([0.0, 5.0]);
        must_be_exact(&comb);
        let at = |step: u32, gap: f64| {
            let angle = 0.3 * f64::from(step);
            [(1.0 + angle + gap) * angle.cos(), (1.0 + angle + gap) * angle.sin()]
        };
        let spiral: Vec<[f64; 2]> = (0..60).map(|step| at(step, 3.0)).chain((0..60).rev().map(|step| at(step, 0.0))).collect();
        must_be_exact(&spiral);
    }

    #[test]
    fn a_hole_joined_to_the_outline_stays_a_hole() {
        must_be_exact(&[
            [0.0, 0.0],
            [6.0, 0.0],
            [6.0, 6.0],
            [0.0, 6.0],
            [0.0, 0.0],
            [2.0, 2.0],
            [2.0, 4.0],
            [4.0, 4.0],
            [4.0, 2.0],
            [2.0, 2.0],
        ]);
    }

    #[test]
    fn an_outline_that_crosses_itself_is_reported() {
        assert_eq!(cut(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]).0, Cut::Crossed);
        assert_eq!(cut(&[[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 2.0]]).0, Cut::Crossed);
    }

    #[test]
    fn a_polygon_without_area_is_passed_as_a_fan() {
        let (cut, triangles) = cut(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [3.0, 0.0]]);
        assert_eq!((cut, triangles.len()), (Cut::Exact, 2));
    }

    #[test]
    fn corners_are_limited() {
        let circle = |count: u32| {
            (0..count).map(move |step| (f64::from(step) / f64::from(count) * std::f64::consts::TAU).sin_cos()).map(|(v, u)| [u, v])
        };
        let mut hollow: Vec<[f64; 2]> = circle(512).collect();
        must_be_exact(&hollow);
        hollow.insert(1, [0.0, 0.0]);
        let mut polygon = Polygon::default();
        for [u, v] in &hollow {
            polygon.add([*u, *v, 0.0]).unwrap();
        }
        assert_eq!(polygon.cut(|_| ()).unwrap_err().kind(), FileFaultKind::TooLarge);
        assert!((hollow.len()..MOST_CORNERS).all(|_| polygon.add([0.0; 3]).is_ok()));
        assert_eq!(polygon.add([0.0; 3]).unwrap_err().kind(), FileFaultKind::TooLarge);
    }

    proptest! {
        #[test]
        fn stars_are_cut_exactly(radii in proptest::collection::vec(0.05_f64..10.0, 4..60), first in 0_usize..60) {
            let count = radii.len();
            let at = |index: usize| {
                #[allow(clippy::cast_precision_loss, reason = "under 60")]
                let angle = index as f64 / count as f64 * std::f64::consts::TAU;
                [radii[index] * angle.cos(), radii[index] * angle.sin()]
            };
            let mut star: Vec<[f64; 2]> = (0..count).map(at).collect();
            star.rotate_left(first % count);
            must_be_exact(&star);
        }

        #[test]
        fn the_triangles_of_any_outline_have_its_area_vector(outline in proptest::collection::vec([-10.0_f64..10.0, -10.0..10.0], 3..30)) {
            let (_, triangles) = cut(&outline);
            prop_assert_eq!(triangles.len(), outline.len() - 2);
            // 30 triangles of up to 200 mm2, each rounded to 1e-16 of that.
            approx::assert_abs_diff_eq!(triangles.iter().map(|triangle| along_normal(*triangle)).sum::<f64>(), shoelace(&outline), epsilon = 1e-11);
        }
    }
}
