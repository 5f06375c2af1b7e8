//! Triangulation of sample points: Delaunay in the XY plane, without the triangles that bridge gaps.

use robust::{Coord, incircle, orient2d};

/// The length of an edge, in multiples of the spacing of the points at its ends, above which its triangles are left
/// out.
pub const LONG_EDGE: f64 = 4.0;

/// The number of edges or triangles that are visited between two checks for cancellation: about a millisecond.
const LISTED_AT_ONCE: usize = 16_384;

/// The Delaunay triangulation of the points seen from above, and the points that it uses. The corners of triangles are
/// counter-clockwise seen from above, so that they face up. Of points above each other, the highest is used. The result
/// is empty if all points lie in one vertical plane.
///
/// **Long edges.** A Delaunay triangulation fills the convex hull, including notches and holes. A triangle is therefore
/// left out if one of its edges is longer than [`LONG_EDGE`] times the spacing there. The spacing at a point is the
/// length of its third shortest edge: a point of a scan line has two close neighbours along the line and the third on
/// the next line. The spacing at an edge is the smaller spacing of its ends, but at least half the median of all
/// points, so that two points close together by chance leave no hole.
///
/// **Time** is O(n log n) for all inputs, by divide and conquer.
///
/// Once `stop` returns true the triangulation ends within milliseconds, without triangles.
pub(super) fn triangulate(points: Vec<[f64; 3]>, stop: &dyn Fn() -> bool) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut points = points;
    for point in &mut points {
        // -0 becomes 0, and tiny numbers whose products would underflow do too.
        for c in point {
            *c = if c.abs() < 1e-40 { 0.0 } else { *c };
        }
    }
    points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(b[2].total_cmp(&a[2])));
    points.dedup_by(|b, a| a[..2] == b[..2]);
    let sites: Vec<Point> = points.iter().map(|&[x, y, _]| Point { x, y }).collect();
    if stop() {
        return (points, Vec::new());
    }
    let Some(delaunay) = Delaunay::of(&sites, stop) else {
        return (points, Vec::new());
    };
    let Some(spacing) = spacing(&delaunay, &sites, stop) else {
        return (points, Vec::new());
    };
    let length = |a: u32, b: u32| {
        let (a, b) = (points[a as usize], points[b as usize]);
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    let median = {
        let mut sorted = spacing.clone();
        let middle = sorted.len() / 2;
        if sorted.is_empty() {
            return (points, Vec::new());
        }
        *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let short = |a: u32, b: u32| {
        let local = spacing[a as usize].min(spacing[b as usize]);
        length(a, b) <= LONG_EDGE * local.max(median / 2.0)
    };
    let mut triangles = Vec::new();
    for (count, [a, b, c]) in delaunay.triangles().enumerate() {
        if count.is_multiple_of(LISTED_AT_ONCE) && stop() {
            return (points, Vec::new());
        }
        if short(a, b) && short(b, c) && short(c, a) {
            triangles.push([a, b, c]);
        }
    }
    (points, triangles)
}

/// The length of the third shortest edge of each point, or of the longest if it has fewer; `None` once `stop` returns
/// true.
fn spacing(delaunay: &Delaunay, sites: &[Point], stop: &dyn Fn() -> bool) -> Option<Vec<f64>> {
    let mut shortest = vec![[f64::INFINITY; 3]; sites.len()];
    for (count, [a, b]) in delaunay.edges().enumerate() {
        if count.is_multiple_of(LISTED_AT_ONCE) && stop() {
            return None;
        }
        let (p, q) = (sites[a as usize], sites[b as usize]);
        let length = (p.x - q.x).hypot(p.y - q.y);
        for point in [a, b] {
            let three = &mut shortest[point as usize];
            if length < three[2] {
                three[2] = length;
                three.sort_unstable_by(f64::total_cmp);
            }
        }
    }
    let third = |three: [f64; 3]| three.into_iter().rev().find(|length| length.is_finite()).unwrap_or(0.0);
    Some(shortest.into_iter().map(third).collect())
}

/// A point of the plane.
pub(super) type Point = Coord<f64>;

/// The Delaunay triangulation of points in the plane, by divide and conquer [Guibas and Stolfi 1985, Primitives for the
/// manipulation of general subdivisions and the computation of Voronoi diagrams, ACM Trans. Graph. 4(2)].
///
/// It takes O(n log n) time for any n points: the halves of a sorted set are triangulated, and the seam between them is closed
/// from below, where each step adds an edge and deletes those that it proves wrong. Signs of determinants are exact (Shewchuk's
/// adaptive predicates), so that it is correct for points on lines and circles too.
///
/// Each edge is two directed ones: `edge` and its reverse `edge ^ 1`. The directed edges that start at a point form a ring.
pub(super) struct Delaunay<'a> {
    points: &'a [Point],
    /// The point where a directed edge starts, by the edge; [`DELETED`] for a deleted edge.
    origin: Vec<u32>,
    /// The next directed edge of the ring, counter-clockwise.
    next: Vec<u32>,
    /// The one before.
    previous: Vec<u32>,
    /// Deleted edges, whose numbers are used again.
    free: Vec<u32>,
    steps: usize,
    stop: &'a dyn Fn() -> bool,
}

const DELETED: u32 = u32::MAX;

/// The number of edges added between two checks for cancellation: about a millisecond.
const STEPS_AT_ONCE: usize = 1024;

impl<'a> Delaunay<'a> {
    /// The triangulation of distinct points, sorted by x and then y; fewer than two have no edges. `None` once `stop`
    /// returns true.
    pub(super) fn of(points: &'a [Point], stop: &'a dyn Fn() -> bool) -> Option<Self> {
        // A triangulation has fewer than 3 n edges.
        let directed = 6 * points.len();
        let (origin, next, previous) = (Vec::with_capacity(directed), Vec::with_capacity(directed), Vec::with_capacity(directed));
        let mut delaunay = Self { points, origin, next, previous, free: Vec::new(), steps: 0, stop };
        let count = u32::try_from(points.len()).expect("the bound on points is below 2^32");
        if count >= 2 {
            delaunay.divide(0, count)?;
        }
        Some(delaunay)
    }

    /// The edges, each in one direction, as two points.
    pub(super) fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        (0..self.origin.len())
            .step_by(2)
            .filter(|edge| self.origin[*edge] != DELETED)
            .map(|edge| [self.origin[edge], self.origin[edge + 1]])
    }

    /// The triangles, counter-clockwise.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        (0_u32..).zip(&self.origin).filter(|(_, origin)| **origin != DELETED).filter_map(|(edge, _)| {
            let second = self.next_left(edge);
            let third = self.next_left(second);
            let is_triangle = edge < second && edge < third && self.next_left(third) == edge;
            let corners = [edge, second, third].map(|edge| self.from(edge));
            // The outer face of a single triangle has three edges too, clockwise.
            (is_triangle && self.is_left_turn(corners[0], corners[1], corners[2])).then_some(corners)
        })
    }

    /// Triangulates the points from `first` up to `end`, at least two. Returns the directed edge of the hull that starts
    /// at the leftmost point, counter-clockwise, and the one that starts at the rightmost point, clockwise.
    fn divide(&mut self, first: u32, end: u32) -> Option<[u32; 2]> {
        match end - first {
            2 => {
                let edge = self.add(first, first + 1);
                Some([edge, edge ^ 1])
            }
            3 => {
                let (a, b) = (self.add(first, first + 1), self.add(first + 1, first + 2));
                self.splice(a ^ 1, b);
                if self.is_left_turn(first, first + 1, first + 2) {
                    self.connect(b, a);
                    Some([a, b ^ 1])
                } else if self.is_left_turn(first, first + 2, first + 1) {
                    let c = self.connect(b, a);
                    Some([c ^ 1, c])
                } else {
                    Some([a, b ^ 1])
                }
            }
            count => {
                let middle = first + count / 2;
                let left = self.divide(first, middle)?;
                let right = self.divide(middle, end)?;
                self.merge(left, right)
            }
        }
    }

    /// Closes the seam between two triangulations.
    fn merge(&mut self, [mut left_outer, mut left_inner]: [u32; 2], [mut right_inner, mut right_outer]: [u32; 2]) -> Option<[u32; 2]> {
        // The common tangent below both.
        loop {
            if self.is_left_of(self.from(right_inner), left_inner) {
                left_inner = self.next_left(left_inner);
            } else if self.is_right_of(self.from(left_inner), right_inner) {
                right_inner = self.next[(right_inner ^ 1) as usize];
            } else {
                break;
            }
        }
        let mut base = self.connect(right_inner ^ 1, left_inner);
        if self.from(left_inner) == self.from(left_outer) {
            left_outer = base ^ 1;
        }
        if self.from(right_inner) == self.from(right_outer) {
            right_outer = base;
        }
        loop {
            self.steps += 1;
            if self.steps.is_multiple_of(STEPS_AT_ONCE) && (self.stop)() {
                return None;
            }
            // The edges that rise from both ends of the base, without those that the next one proves wrong.
            let mut left = self.next[(base ^ 1) as usize];
            if self.is_above(left, base) {
                while self.is_in_circle(self.to(base), self.from(base), self.to(left), self.to(self.next[left as usize])) {
                    let after = self.next[left as usize];
                    self.delete(left);
                    left = after;
                }
            }
            let mut right = self.previous[base as usize];
            if self.is_above(right, base) {
                while self.is_in_circle(self.to(base), self.from(base), self.to(right), self.to(self.previous[right as usize])) {
                    let after = self.previous[right as usize];
                    self.delete(right);
                    right = after;
                }
            }
            base = match (self.is_above(left, base), self.is_above(right, base)) {
                (false, false) => return Some([left_outer, right_outer]),
                (true, true) if self.is_in_circle(self.to(left), self.from(left), self.from(right), self.to(right)) => {
                    self.connect(right, base ^ 1)
                }
                (false, true) => self.connect(right, base ^ 1),
                (true, _) => self.connect(base ^ 1, left ^ 1),
            };
        }
    }

    /// Adds an edge that is connected to no other.
    fn add(&mut self, from: u32, to: u32) -> u32 {
        let edge = self.free.pop().unwrap_or_else(|| {
            let edge = u32::try_from(self.origin.len()).expect("under six times the number of points");
            for ring in [&mut self.origin, &mut self.next, &mut self.previous] {
                ring.extend([0, 0]);
            }
            edge
        });
        for (edge, origin) in [(edge, from), (edge ^ 1, to)] {
            self.origin[edge as usize] = origin;
            self.next[edge as usize] = edge;
            self.previous[edge as usize] = edge;
        }
        edge
    }

    /// Adds an edge from the end of `a` to the start of `b`, to the left of both.
    fn connect(&mut self, a: u32, b: u32) -> u32 {
        let edge = self.add(self.to(a), self.from(b));
        let after = self.next_left(a);
        self.splice(edge, after);
        self.splice(edge ^ 1, b);
        edge
    }

    fn delete(&mut self, edge: u32) {
        for edge in [edge, edge ^ 1] {
            let previous = self.previous[edge as usize];
            self.splice(edge, previous);
            self.origin[edge as usize] = DELETED;
        }
        self.free.push(edge & !1);
    }

    /// Joins the rings of two edges, or divides them if they are one.
    fn splice(&mut self, a: u32, b: u32) {
        let (after_a, after_b) = (self.next[a as usize], self.next[b as usize]);
        self.previous.swap(after_a as usize, after_b as usize);
        self.next.swap(a as usize, b as usize);
    }

    fn from(&self, edge: u32) -> u32 {
        self.origin[edge as usize]
    }

    fn to(&self, edge: u32) -> u32 {
        self.origin[(edge ^ 1) as usize]
    }

    /// The next edge around the face to the left, counter-clockwise.
    fn next_left(&self, edge: u32) -> u32 {
        self.previous[(edge ^ 1) as usize]
    }

    fn at(&self, point: u32) -> Point {
        self.points[point as usize]
    }

    fn is_left_turn(&self, a: u32, b: u32, c: u32) -> bool {
        orient2d(self.at(a), self.at(b), self.at(c)) > 0.0
    }

    fn is_left_of(&self, point: u32, edge: u32) -> bool {
        self.is_left_turn(point, self.from(edge), self.to(edge))
    }

    fn is_right_of(&self, point: u32, edge: u32) -> bool {
        self.is_left_turn(point, self.to(edge), self.from(edge))
    }

    /// Whether an edge from an end of the base rises above it.
    fn is_above(&self, edge: u32, base: u32) -> bool {
        self.is_right_of(self.to(edge), base)
    }

    /// Whether `d` lies inside the circle through a, b and c, which are counter-clockwise.
    fn is_in_circle(&self, a: u32, b: u32, c: u32, d: u32) -> bool {
        incircle(self.at(a), self.at(b), self.at(c), self.at(d)) > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::cell::Cell;
    use std::time::{Duration, Instant};

    fn triangulate(points: Vec<[f64; 3]>) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        super::triangulate(points, &|| false)
    }

    /// The area of the triangles seen from above.
    fn area((points, triangles): &(Vec<[f64; 3]>, Vec<[u32; 3]>)) -> f64 {
        let twice = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|index| points[index as usize]);
            let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert!(twice > 0.0, "a triangle that does not face up");
            twice
        };
        triangles.iter().map(|triangle| twice(triangle) / 2.0).sum()
    }

    /// Points of a lattice of `dx` x `dy` over `columns` x `rows`, moved by up to `shake` of the spacing, where
    /// `inside` holds.
    fn lattice(columns: u32, rows: u32, [dx, dy]: [f64; 2], shake: f64, inside: impl Fn(f64, f64) -> bool) -> Vec<[f64; 3]> {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            f64::from(u32::try_from(state >> 32).unwrap()) / f64::from(u32::MAX) - 0.5
        };
        (0..columns * rows)
            .map(|i| [dx * (f64::from(i % columns) + shake * random()), dy * (f64::from(i / columns) + shake * random()), f64::from(i)])
            .filter(|&[x, y, _]| inside(x, y))
            .collect()
    }

    #[test]
    fn the_notch_of_an_l_stays_open() {
        for (spacing, shake) in [([1.0, 1.0], 0.0), ([1.0, 1.0], 0.8), ([0.2, 1.0], 0.0)] {
            let l = lattice(if spacing[0] < 1.0 { 201 } else { 41 }, 41, spacing, shake, |x, y| x <= 20.1 || y <= 20.1);
            let found = area(&triangulate(l));
            // 1200 mm^2; the convex hull has 1400. In the notch, triangles with edges of up to 4 spacings remain: an
            // area of 4^2/2 at its corner. A displaced border loses up to half a spacing along its 160 mm.
            assert!(found > 1200.0 - if shake > 0.0 { 80.0 } else { 1e-9 } && found < 1210.0 + 20.0 * shake, "{spacing:?} {shake} {found}");
        }
    }

    #[test]
    fn a_hole_stays_open_and_a_dense_cloud_is_closed() {
        let ring = lattice(61, 61, [0.5, 0.5], 0.9, |x, y| (x - 15.0).hypot(y - 15.0) >= 6.0);
        let found = area(&triangulate(ring));
        // A square of 30 mm minus a disc of 6 mm, 787 mm^2, minus half a spacing along borders of 120 mm and 38 mm.
        assert!((found - 787.0).abs() < 40.0, "{found}");
        let whole = area(&triangulate(lattice(61, 61, [0.5, 0.5], 0.9, |_, _| true)));
        assert!(whole > 860.0 && whole < 930.0, "{whole}");
    }

    #[test]
    fn of_points_above_each_other_the_highest_is_taken() {
        let (points, triangles) = triangulate(vec![[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 5.0], [0.0, 0.0, 3.0]]);
        assert_eq!((points.len(), triangles.len()), (3, 1));
        assert!(points.contains(&[0.0, 0.0, 5.0]));
    }

    #[test]
    fn points_on_one_line_have_no_triangles() {
        for points in [vec![], vec![[1.0, 2.0, 3.0]; 1000], (0..1000).map(|i| [f64::from(i), 3.0 * f64::from(i), 1.0]).collect()] {
            assert_eq!(triangulate(points).1.len(), 0);
        }
    }

    #[test]
    fn a_triangulation_that_is_cancelled_ends_without_triangles() {
        let points = lattice(100, 100, [1.0, 1.0], 0.5, |_, _| true);
        let asked = Cell::new(0);
        let stop_at = |count: usize| {
            asked.set(0);
            super::triangulate(points.clone(), &|| {
                asked.set(asked.get() + 1);
                asked.get() >= count
            })
        };
        assert!(!stop_at(usize::MAX).1.is_empty());
        let in_all = asked.get();
        // The seams of ten thousand points have some 30 000 edges, a thousand at a time.
        assert!(in_all >= 14, "{in_all}");
        for count in 1..=in_all {
            assert_eq!(stop_at(count).1.len(), 0, "stopped at {count} of {in_all}");
            assert_eq!(asked.get(), count);
        }
    }

    #[test]
    fn points_near_a_line_a_circle_or_two_lines_take_no_longer_than_others() {
        let count = 20_000_u32;
        let each = |at: &dyn Fn(f64) -> [f64; 2]| (0..count).map(|i| at(f64::from(i))).map(|[x, y]| [x, y, 0.0]).collect::<Vec<_>>();
        let clouds = [
            // Rounding moves these points off the line.
            each(&|i| [0.1 * i, 0.3 * i]),
            each(&|i| [(i * 1e-3).cos(), (i * 1e-3).sin()]),
            each(&|i| [i % 2.0, (i / 2.0).floor()]),
            each(&|i| [1e9 * (i % 2.0) + (i * 0.618).fract(), 1e9 * (i % 2.0) + (i * 0.414).fract()]),
            each(&|i| [10.0_f64.powf(i * 1e-3 - 10.0) * (i * 0.618).fract(), (i * 0.414).fract()]),
            // A parabola, two axes, and needles: incremental insertion took seconds to a minute.
            each(&|i| [i * 1e-3, i * i * 1e-6]),
            each(&|i| if i % 2.0 == 0.0 { [i, 0.0] } else { [0.0, i] }),
            each(&|i| [1e3 * (i % 2.0), i * 1e-4]),
            each(&|i| [i * 1e-3, (i % 2.0) * 1e3]),
            each(&|i| [i * i * 1e-6, i * 1e-3]),
        ];
        for (number, cloud) in clouds.into_iter().enumerate() {
            let start = Instant::now();
            triangulate(cloud);
            // Some 50 ms; quadratic time would be minutes.
            assert!(start.elapsed() < Duration::from_secs(5), "{number} {:?}", start.elapsed());
        }
    }

    fn sorted(points: impl IntoIterator<Item = [f64; 2]>) -> Vec<Point> {
        let mut points: Vec<Point> = points.into_iter().map(|[x, y]| Coord { x: x + 0.0, y: y + 0.0 }).collect();
        points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        points
    }

    /// Checks the definition: no point lies inside the circle of a triangle, and the triangles fill the convex hull, by
    /// Euler's formula: 2 n - 2 - h triangles and 3 n - 3 - h edges for h points on the hull's border.
    fn check(points: &[Point]) {
        let delaunay = Delaunay::of(points, &|| false).unwrap();
        let triangles: Vec<[u32; 3]> = delaunay.triangles().collect();
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|corner| points[corner as usize]);
            assert!(orient2d(a, b, c) > 0.0);
            assert!(points.iter().all(|d| incircle(a, b, c, *d) <= 0.0), "{triangle:?}");
        }
        let edges = delaunay.edges().count();
        let Some(last) = points.len().checked_sub(1) else { return };
        if points.iter().all(|point| orient2d(points[0], points[last], *point) == 0.0) {
            assert_eq!((triangles.len(), edges), (0, last));
            return;
        }
        // Each border edge has one triangle, each other edge two: 2 edges - border = 3 triangles.
        let border = 2 * edges - 3 * triangles.len();
        assert_eq!(triangles.len() + border, 2 * points.len() - 2);
        // Every border edge has all points on one side.
        let hull = |[a, b]: [u32; 2]| {
            let side = |point: &Point| orient2d(points[a as usize], points[b as usize], *point);
            points.iter().all(|point| side(point) >= 0.0) || points.iter().all(|point| side(point) <= 0.0)
        };
        assert!(delaunay.edges().filter(|edge| hull(*edge)).count() >= border);
    }

    proptest! {
        #[test]
        fn no_point_lies_in_the_circle_of_a_triangle(points in proptest::collection::vec([-10.0..10.0_f64, -10.0..10.0], 0..60)) {
            check(&sorted(points));
        }

        #[test]
        fn points_on_lines_and_circles_are_triangulated(points in proptest::collection::vec([0_u8..7, 0_u8..7], 0..40)) {
            check(&sorted(points.into_iter().map(|point| point.map(f64::from))));
        }
    }

    #[test]
    fn points_on_a_line_have_edges_but_no_triangles() {
        check(&sorted((0..50).map(|i| [f64::from(i), 3.0 * f64::from(i)])));
        check(&sorted((0..50).map(|i| [1.0, f64::from(i)])));
    }
}
