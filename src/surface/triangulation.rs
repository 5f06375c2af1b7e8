//! Triangulation of sample points: Delaunay in the XY plane, without the triangles that bridge gaps.

use super::delaunay::{Delaunay, Point};

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
}
