//! Surfaces for the tests, as facets with the exact curvatures: Bezier patches, planes, quadrics.

use scallopd::surface::FinishFacet;

/// A surface over two parameters from 0 to 1 with its derivatives.
pub(crate) trait Patch {
    /// The point, its first derivatives by u and v, and its second ones by uu, uv and vv.
    fn at(&self, u: f64, v: f64) -> [[f64; 3]; 6];
}

/// A tensor-product Bezier patch.
#[derive(Debug, Clone)]
pub(crate) struct BezierPatch {
    pub(crate) net: Vec<Vec<[f64; 3]>>,
}

/// Bernstein polynomials of one degree at t with their first two derivatives, by the product rule on each one's own
/// form.
fn bernstein(degree: i32, t: f64) -> Vec<[f64; 3]> {
    let power = |base: f64, exponent: i32| if exponent < 0 { 0.0 } else { base.powi(exponent) };
    let mut binomial = 1.0;
    (0..=degree)
        .map(|i| {
            if i > 0 {
                binomial *= f64::from(degree - i + 1) / f64::from(i);
            }
            let (a, b, m, n) = (t, 1.0 - t, f64::from(i), f64::from(degree - i));
            let (i, j) = (i, degree - i);
            [
                binomial * power(a, i) * power(b, j),
                binomial * (m * power(a, i - 1) * power(b, j) - n * power(a, i) * power(b, j - 1)),
                binomial
                    * (m * (m - 1.0) * power(a, i - 2) * power(b, j) - 2.0 * m * n * power(a, i - 1) * power(b, j - 1)
                        + n * (n - 1.0) * power(a, i) * power(b, j - 2)),
            ]
        })
        .collect()
}

impl Patch for BezierPatch {
    #[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "a handful of control points")]
    fn at(&self, u: f64, v: f64) -> [[f64; 3]; 6] {
        let along = bernstein(self.net.len() as i32 - 1, u);
        let across = bernstein(self.net[0].len() as i32 - 1, v);
        let mut sums = [[0.0; 3]; 6];
        for (row, a) in self.net.iter().zip(&along) {
            for (point, b) in row.iter().zip(&across) {
                let weights = [a[0] * b[0], a[1] * b[0], a[0] * b[1], a[2] * b[0], a[1] * b[1], a[0] * b[2]];
                for (sum, weight) in sums.iter_mut().zip(weights) {
                    (0..3).for_each(|axis| sum[axis] += weight * point[axis]);
                }
            }
        }
        sums
    }
}

/// A surface z = f over a rectangle, with f's value, gradient and second derivatives by xx, xy, yy.
pub(crate) struct Height<F: Fn(f64, f64) -> [f64; 6]> {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
    pub(crate) surface: F,
}

impl<F: Fn(f64, f64) -> [f64; 6]> Patch for Height<F> {
    fn at(&self, u: f64, v: f64) -> [[f64; 3]; 6] {
        let size = [self.high[0] - self.low[0], self.high[1] - self.low[1]];
        let (x, y) = (self.low[0] + u * size[0], self.low[1] + v * size[1]);
        let [z, zx, zy, zxx, zxy, zyy] = (self.surface)(x, y);
        [
            [x, y, z],
            [size[0], 0.0, zx * size[0]],
            [0.0, size[1], zy * size[1]],
            [0.0, 0.0, zxx * size[0] * size[0]],
            [0.0, 0.0, zxy * size[0] * size[1]],
            [0.0, 0.0, zyy * size[1] * size[1]],
        ]
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|c| c / length)
}

/// The curvature tensor of a patch, positive where convex seen against the upward normal, as xx, xy, xz, yy, yz, zz.
///
/// With the dual vectors g^u, g^v of the tangents the tensor is -(L g^u g^u + M (g^u g^v + g^v g^u) + N g^v g^v), L = n
/// r_uu and so on.
pub(crate) fn curvature([_, ru, rv, ruu, ruv, rvv]: [[f64; 3]; 6]) -> [f64; 6] {
    let up = |n: [f64; 3]| if n[2] < 0.0 { n.map(|c| -c) } else { n };
    let n = up(unit(cross(ru, rv)));
    let (e, f, g) = (dot(ru, ru), dot(ru, rv), dot(rv, rv));
    let determinant = e * g - f * f;
    let gu = [0, 1, 2].map(|axis| (g * ru[axis] - f * rv[axis]) / determinant);
    let gv = [0, 1, 2].map(|axis| (e * rv[axis] - f * ru[axis]) / determinant);
    let (l, m, k) = (dot(n, ruu), dot(n, ruv), dot(n, rvv));
    let entry = |i: usize, j: usize| -(l * gu[i] * gu[j] + m * (gu[i] * gv[j] + gv[i] * gu[j]) + k * gv[i] * gv[j]);
    [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)]
}

/// The patch as 2 n m triangles, each with its own normal and area and the patch's curvature in its middle.
pub(crate) fn facets(patch: &impl Patch, n: usize, m: usize) -> Vec<FinishFacet> {
    #[expect(clippy::cast_precision_loss, reason = "hundreds")]
    let at = |i: f64, j: f64| patch.at(i / n as f64, j / m as f64);
    let mut facets = Vec::with_capacity(2 * n * m);
    for i in 0..n {
        for j in 0..m {
            #[expect(clippy::cast_precision_loss, reason = "hundreds")]
            let (i, j) = (i as f64, j as f64);
            let corners = [at(i, j)[0], at(i + 1.0, j)[0], at(i + 1.0, j + 1.0)[0], at(i, j + 1.0)[0]];
            for (a, b, c, u, v) in [(0, 1, 2, 2.0 / 3.0, 1.0 / 3.0), (0, 2, 3, 1.0 / 3.0, 2.0 / 3.0)] {
                facets.push(facet([corners[a], corners[b], corners[c]], curvature(at(i + u, j + v))));
            }
        }
    }
    facets
}

/// A facet with its corners counter-clockwise seen from above.
pub(crate) fn facet(corners: [[f64; 3]; 3], curvature: [f64; 6]) -> FinishFacet {
    let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    let corners = if normal[2] < 0.0 { [corners[0], corners[2], corners[1]] } else { corners };
    let normal = if normal[2] < 0.0 { normal.map(|c| -c) } else { normal };
    FinishFacet { corners, normal: unit(normal), area: dot(normal, normal).sqrt() / 2.0, curvature }
}

/// The facets turned about Z by an angle in degrees and moved.
pub(crate) fn placed(facets: &[FinishFacet], degrees: f64, [x, y, z]: [f64; 3]) -> Vec<FinishFacet> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let turn = |p: [f64; 3]| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1], p[2]];
    let turned = |facet: &FinishFacet| {
        let [xx, xy, xz, yy, yz, zz] = facet.curvature;
        let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(turn);
        let columns = [0, 1, 2].map(|column| turn([rows[0][column], rows[1][column], rows[2][column]]));
        FinishFacet {
            corners: facet.corners.map(|corner| {
                let p = turn(corner);
                [p[0] + x, p[1] + y, p[2] + z]
            }),
            normal: turn(facet.normal),
            area: facet.area,
            curvature: [columns[0][0], columns[1][0], columns[2][0], columns[1][1], columns[2][1], columns[2][2]],
        }
    };
    facets.iter().map(turned).collect()
}

/// One of the two surfaces of Herraz et al. 2020, from `tests/data/herraz_2020.json`.
pub(crate) fn published(index: usize) -> BezierPatch {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/herraz_2020.json")).unwrap();
    let data: serde_json::Value = serde_json::from_str(&text).unwrap();
    let net = serde_json::from_value(data["surfaces"][index]["control_points_mm"].clone()).unwrap();
    BezierPatch { net }
}
