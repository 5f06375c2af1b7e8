//! Surfaces for the tests: Bezier patches and height fields, as facets.

/// The corners of a facet in mm, counter-clockwise seen from outside the part.
pub(crate) type Facet = [[f64; 3]; 3];

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

/// The patch as 2 n m triangles.
pub(crate) fn facets(patch: &impl Patch, n: usize, m: usize) -> Vec<Facet> {
    #[expect(clippy::cast_precision_loss, reason = "hundreds")]
    let at = |i: usize, j: usize| patch.at(i as f64 / n as f64, j as f64 / m as f64)[0];
    let quad = |(i, j): (usize, usize)| quadrilateral([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).flat_map(quad).collect()
}

/// Two facets of a quadrilateral.
pub(crate) fn quadrilateral([a, b, c, d]: [[f64; 3]; 4]) -> [Facet; 2] {
    [[a, b, c], [a, c, d]]
}

/// The facets turned about Z by an angle in degrees and moved.
pub(crate) fn placed(facets: &[Facet], degrees: f64, [x, y, z]: [f64; 3]) -> Vec<Facet> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let place = |p: [f64; 3]| [cos * p[0] - sin * p[1] + x, sin * p[0] + cos * p[1] + y, p[2] + z];
    facets.iter().map(|facet| facet.map(place)).collect()
}

/// One of the two surfaces of Herraz et al. 2020, from `tests/data/herraz_2020.json`.
pub(crate) fn published(index: usize) -> BezierPatch {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/herraz_2020.json")).unwrap();
    let data: serde_json::Value = serde_json::from_str(&text).unwrap();
    let net = serde_json::from_value(data["surfaces"][index]["control_points_mm"].clone()).unwrap();
    BezierPatch { net }
}
