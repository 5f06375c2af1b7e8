//! Triangulation of sample points: Delaunay in the XY plane, without the triangles that bridge gaps.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

/// The length of an edge, in multiples of the spacing of the points at its ends, above which its triangles are left
/// out.
pub const LONG_EDGE: f64 = 4.0;

/// The number of points inserted between two checks for cancellation: about a millisecond.
const INSERTED_AT_ONCE: usize = 1024;

/// The number of edges or triangles that are visited between two checks for cancellation: about a millisecond.
const LISTED_AT_ONCE: usize = 16_384;

/// A point of the plane with its index.
struct Site {
    at: Point2<f64>,
    index: u32,
}

impl HasPosition for Site {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

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
/// **Time** is O(n log n) for all inputs. Three points that are not on one line are inserted first. The others follow
/// in random rounds, each four times as large as the one before and sorted along a Hilbert curve over the points' ranks
/// (a biased randomised insertion order, Amenta, Choi and Rote 2003). The sweep of `spade`'s own bulk loading takes
/// quadratic time for points near a line.
///
/// Once `stop` returns true the triangulation ends within milliseconds, without triangles.
pub(super) fn triangulate(points: Vec<[f64; 3]>, stop: &dyn Fn() -> bool) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut points = points;
    for point in &mut points {
        // The library refuses magnitudes under 1.8e-43 except 0. -0 becomes 0.
        for c in point {
            *c = if c.abs() < 1e-40 { 0.0 } else { *c };
        }
    }
    points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(b[2].total_cmp(&a[2])));
    points.dedup_by(|b, a| a[..2] == b[..2]);
    let Some(order) = insertion_order(&points, stop) else {
        return (points, Vec::new());
    };
    let mut delaunay = DelaunayTriangulation::<Site>::with_capacity(points.len(), 3 * points.len(), 2 * points.len());
    for (count, &index) in order.iter().enumerate() {
        if count.is_multiple_of(INSERTED_AT_ONCE) && stop() {
            return (points, Vec::new());
        }
        let [x, y, _] = points[index as usize];
        // Coordinates are in the library's range: finite, at most 1e12 in magnitude, 0 or at least 1e-40.
        if delaunay.insert(Site { at: Point2::new(x, y), index }).is_err() {
            return (points, Vec::new());
        }
    }
    let Some(spacing) = spacing(&delaunay, points.len(), stop) else {
        return (points, Vec::new());
    };
    let length = |a: u32, b: u32| {
        let (a, b) = (points[a as usize], points[b as usize]);
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    let median = {
        let mut sorted = spacing.clone();
        let middle = sorted.len() / 2;
        *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let short = |a: u32, b: u32| {
        let local = spacing[a as usize].min(spacing[b as usize]);
        length(a, b) <= LONG_EDGE * local.max(median / 2.0)
    };
    let mut triangles = Vec::new();
    for (count, face) in delaunay.inner_faces().enumerate() {
        if count.is_multiple_of(LISTED_AT_ONCE) && stop() {
            return (points, Vec::new());
        }
        let [a, b, c] = face.vertices().map(|vertex| vertex.data().index);
        if short(a, b) && short(b, c) && short(c, a) {
            triangles.push([a, b, c]);
        }
    }
    (points, triangles)
}

/// The length of the third shortest edge of each point, or of the longest if it has fewer; `None` once `stop` returns
/// true.
fn spacing(delaunay: &DelaunayTriangulation<Site>, count: usize, stop: &dyn Fn() -> bool) -> Option<Vec<f64>> {
    let mut shortest = vec![[f64::INFINITY; 3]; count];
    for (count, edge) in delaunay.undirected_edges().enumerate() {
        if count.is_multiple_of(LISTED_AT_ONCE) && stop() {
            return None;
        }
        let [a, b] = edge.vertices();
        let (p, q) = (a.position(), b.position());
        let length = (p.x - q.x).hypot(p.y - q.y);
        for vertex in [a, b] {
            let three = &mut shortest[vertex.data().index as usize];
            if length < three[2] {
                three[2] = length;
                three.sort_unstable_by(f64::total_cmp);
            }
        }
    }
    let third = |three: [f64; 3]| three.into_iter().rev().find(|length| length.is_finite()).unwrap_or(0.0);
    Some(shortest.into_iter().map(third).collect())
}

/// The order in which points are inserted; `None` if all lie on one line or `stop` returns true. `points` must be
/// sorted by x, then y, and distinct.
fn insertion_order(points: &[[f64; 3]], stop: &dyn Fn() -> bool) -> Option<Vec<u32>> {
    if stop() {
        return None;
    }
    let coordinate = |point: &[f64; 3]| robust::Coord { x: point[0], y: point[1] };
    let (first, last) = (coordinate(points.first()?), coordinate(points.last()?));
    let off_line = points.iter().position(|point| robust::orient2d(first, last, coordinate(point)) != 0.0)?;
    let count = u32::try_from(points.len()).expect("the bound on points is below 2^32");
    // Ranks in place of coordinates order the points within tight clusters.
    let mut by_y: Vec<u32> = (0..count).collect();
    by_y.sort_unstable_by(|&a, &b| points[a as usize][1].total_cmp(&points[b as usize][1]).then(a.cmp(&b)));
    if stop() {
        return None;
    }
    let mut keys = vec![0_u32; points.len()];
    let scaled = |rank: usize| u32::try_from((rank * 65_536) / points.len()).expect("under 65536");
    for (rank, &index) in by_y.iter().enumerate() {
        keys[index as usize] = hilbert(scaled(index as usize), scaled(rank));
    }
    let mut order = by_y;
    // A fixed generator (Knuth's multiplier): the same file gives the same triangles.
    let mut state = 1_u64;
    for i in (1..order.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        order.swap(i, usize::try_from((state >> 33) % (i as u64 + 1)).expect("at most i"));
    }
    if stop() {
        return None;
    }
    let (mut start, mut end) = (0, 64);
    while start < order.len() {
        let round = end.min(order.len());
        order[start..round].sort_unstable_by_key(|&index| (keys[index as usize], index));
        (start, end) = (round, 4 * end);
    }
    // Until three points span a triangle, each insertion takes time in proportion to the number of points before it.
    let spanning = [0, count - 1, u32::try_from(off_line).expect("under the count")];
    Some(spanning.into_iter().chain(order.into_iter().filter(|index| !spanning.contains(index))).collect())
}

/// The position of cell (x, y) of 65536 x 65536 along a Hilbert curve.
fn hilbert(mut x: u32, mut y: u32) -> u32 {
    let mut place = 0_u32;
    let mut half = 1_u32 << 15;
    while half > 0 {
        let (right, upper) = (u32::from(x & half > 0), u32::from(y & half > 0));
        place = place.wrapping_add((half * half).wrapping_mul((3 * right) ^ upper));
        if upper == 0 {
            if right == 1 {
                (x, y) = (65_535 - x, 65_535 - y);
            }
            std::mem::swap(&mut x, &mut y);
        }
        half /= 2;
    }
    place
}

#[cfg(test)]
mod tests {
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
        // Ten checks for ten thousand points, a thousand at a time, and those before and after.
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
        ];
        for (number, cloud) in clouds.into_iter().enumerate() {
            let start = Instant::now();
            triangulate(cloud);
            // Some 50 ms; quadratic time would be minutes.
            assert!(start.elapsed() < Duration::from_secs(5), "{number} {:?}", start.elapsed());
        }
    }
}
