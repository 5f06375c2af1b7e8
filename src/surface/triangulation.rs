//! Triangles between points that sample a surface: Delaunay in the XY plane, without the edges that bridge gaps.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

/// An edge is left out when it is longer than this many times the spacing of the points at its ends.
pub const LONG_EDGE: f64 = 4.0;

/// A point of the plane and its number.
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

/// The Delaunay triangulation of the points seen from above, and the points in use. Triangles run counter-clockwise seen from above, so they
/// face up. Of points one above the other the highest is taken. Empty where all points lie in one vertical plane.
///
/// **Long edges.** A Delaunay triangulation fills the convex hull, notches and holes included. So a triangle is left out when one of its edges is
/// longer than [`LONG_EDGE`] times the spacing there. The spacing at a point is the length of its third shortest edge: scan lines have two
/// close neighbours along the line and the third on the next line. At an edge the smaller spacing of its ends counts, or half the median of all
/// points where that is larger, so that two points close together by chance tear no hole.
///
/// **Time** is O(n log n) for all inputs: points go in by rounds of four times as many as before, chosen at random, each round along a Hilbert
/// curve over the points' ranks (a biased randomised insertion order, Amenta, Choi and Rote 2003), after three that are not on one line.
/// The sweep of `spade`'s own bulk loading takes quadratic time for points near a line.
pub(super) fn triangulate(points: Vec<[f64; 3]>) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut points = points;
    for point in &mut points {
        // The library takes no numbers under 1.8e-43 but 0; and -0 is 0.
        point.iter_mut().for_each(|c| *c = if c.abs() < 1e-40 { 0.0 } else { *c });
    }
    points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(b[2].total_cmp(&a[2])));
    points.dedup_by(|b, a| a[..2] == b[..2]);
    let Some(order) = insertion_order(&points) else {
        return (points, Vec::new());
    };
    let mut delaunay = DelaunayTriangulation::<Site>::with_capacity(points.len(), 3 * points.len(), 2 * points.len());
    for &index in &order {
        let [x, y, _] = points[index as usize];
        // Coordinates are in the library's range: finite, at most 1e12 in magnitude, 0 or at least 1e-40.
        if delaunay.insert(Site { at: Point2::new(x, y), index }).is_err() {
            return (points, Vec::new());
        }
    }
    let spacing = spacing(&delaunay, points.len());
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
    let triangles = delaunay
        .inner_faces()
        .map(|face| face.vertices().map(|vertex| vertex.data().index))
        .filter(|&[a, b, c]| short(a, b) && short(b, c) && short(c, a))
        .collect();
    (points, triangles)
}

/// The length of the third shortest edge of each point, or of the longest where it has fewer.
fn spacing(delaunay: &DelaunayTriangulation<Site>, count: usize) -> Vec<f64> {
    let mut shortest = vec![[f64::INFINITY; 3]; count];
    for edge in delaunay.undirected_edges() {
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
    shortest.into_iter().map(|three| three.into_iter().rev().find(|length| length.is_finite()).unwrap_or(0.0)).collect()
}

/// The order in which points are inserted; `None` where all lie on one line. `points` are sorted by x, then y, and differ.
fn insertion_order(points: &[[f64; 3]]) -> Option<Vec<u32>> {
    let coordinate = |point: &[f64; 3]| robust::Coord { x: point[0], y: point[1] };
    let (first, last) = (coordinate(points.first()?), coordinate(points.last()?));
    let off_line = points.iter().position(|point| robust::orient2d(first, last, coordinate(point)) != 0.0)?;
    let count = u32::try_from(points.len()).expect("the bound on points is below 2^32");
    // Ranks rather than coordinates, so that points in tight clusters are ordered within their cluster.
    let mut by_y: Vec<u32> = (0..count).collect();
    by_y.sort_unstable_by(|&a, &b| points[a as usize][1].total_cmp(&points[b as usize][1]).then(a.cmp(&b)));
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
    let (mut start, mut end) = (0, 64);
    while start < order.len() {
        let round = end.min(order.len());
        order[start..round].sort_unstable_by_key(|&index| (keys[index as usize], index));
        (start, end) = (round, 4 * end);
    }
    // Until three points span a triangle each insertion takes time in proportion to the points before it.
    let spanning = [0, count - 1, u32::try_from(off_line).expect("under the count")];
    Some(spanning.into_iter().chain(order.into_iter().filter(|index| !spanning.contains(index))).collect())
}

/// The place of cell (x, y) of 65536 x 65536 along a Hilbert curve.
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
