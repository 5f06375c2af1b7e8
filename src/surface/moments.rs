//! Weight, first and second moments of points and triangles, from which the principal axes of a surface follow.

use crate::numerics::vector::difference;
use nalgebra::{Matrix3, Vector3};

/// The moments of a set of weighted points, or of a surface, of order 0 to 2.
///
/// They are computed about a shift near the data: the covariance is a difference of second moments, which would cancel
/// about a distant origin. The moments are ten numbers, however many elements there are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    shift: [f64; 3],
    weight: f64,
    first: [f64; 3],
    /// xx, xy, xz, yy, yz, zz
    second: [f64; 6],
}

impl Moments {
    /// Moments of an empty set, about `shift`.
    #[must_use]
    pub fn about(shift: [f64; 3]) -> Self {
        Self { shift, weight: 0.0, first: [0.0; 3], second: [0.0; 6] }
    }

    /// Adds a point of weight 1.
    #[inline]
    pub fn add_point(&mut self, point: [f64; 3]) {
        let p = difference(point, self.shift);
        self.weight += 1.0;
        for (sum, c) in self.first.iter_mut().zip(p) {
            *sum += c;
        }
        for (sum, product) in self.second.iter_mut().zip(products(p)) {
            *sum += product;
        }
    }

    /// Adds a triangle with corners a, b, c, centroid g and area F: F to the weight, F g to the first moment, and to
    /// the second F/12 (aa' + bb' + cc' + 9 gg'), which is the integral of xx' over the triangle, exactly.
    ///
    /// With the sides u = b - a, v = c - a it equals F (gg' + ss'/72 + dd'/24), s = u + v, d = u - v, which takes a
    /// quarter fewer operations.
    #[inline]
    pub fn add_triangle(&mut self, corners: [[f64; 3]; 3], area: f64) {
        let [a, b, c] = corners;
        let (from_shift, u, v) = (difference(a, self.shift), difference(b, a), difference(c, a));
        let (s, d) = ([u[0] + v[0], u[1] + v[1], u[2] + v[2]], difference(u, v));
        let g = [from_shift[0] + s[0] / 3.0, from_shift[1] + s[1] / 3.0, from_shift[2] + s[2] / 3.0];
        self.weight += area;
        for (first, g) in self.first.iter_mut().zip(g) {
            *first += area * g;
        }
        let (gg, ss, dd) = (products(g), products(s), products(d));
        for (i, second) in self.second.iter_mut().enumerate() {
            *second += area * (gg[i] + ss[i] * (1.0 / 72.0) + dd[i] * (1.0 / 24.0));
        }
    }

    /// Adds the moments of `other`, which may have another shift.
    pub fn merge(&mut self, other: &Self) {
        let d = difference(other.shift, self.shift);
        // With x = d + y: sum xx' = sum yy' + d (sum y)' + (sum y) d' + W dd'.
        let (f, w) = (other.first, other.weight);
        let cross = |i: usize, j: usize| d[i] * f[j] + f[i] * d[j] + w * d[i] * d[j];
        let crosses = [cross(0, 0), cross(0, 1), cross(0, 2), cross(1, 1), cross(1, 2), cross(2, 2)];
        self.weight += w;
        for i in 0..3 {
            self.first[i] += f[i] + w * d[i];
        }
        for (i, extra) in crosses.into_iter().enumerate() {
            self.second[i] += other.second[i] + extra;
        }
    }

    /// The sum of the weights: the number of points, or the area of the triangles.
    #[must_use]
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// The centroid; `None` without weight.
    #[must_use]
    pub fn centroid(&self) -> Option<[f64; 3]> {
        let mean = self.mean_from_shift()?;
        Some([self.shift[0] + mean.x, self.shift[1] + mean.y, self.shift[2] + mean.z])
    }

    /// The covariance matrix, divided by the weight itself (n, not n - 1) [Herraz et al. 2020, eq. 16]; `None` without
    /// weight.
    #[must_use]
    pub fn covariance(&self) -> Option<Matrix3<f64>> {
        let mean = self.mean_from_shift()?;
        let [xx, xy, xz, yy, yz, zz] = self.second.map(|sum| sum / self.weight);
        Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - mean * mean.transpose())
    }

    fn mean_from_shift(&self) -> Option<Vector3<f64>> {
        (self.weight > 0.0).then(|| Vector3::from(self.first) / self.weight)
    }
}

/// The six different entries of vv'.
#[inline]
fn products(v: [f64; 3]) -> [f64; 6] {
    [v[0] * v[0], v[0] * v[1], v[0] * v[2], v[1] * v[1], v[1] * v[2], v[2] * v[2]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn area([a, b, c]: [[f64; 3]; 3]) -> f64 {
        let (u, v) = (Vector3::from(difference(b, a)), Vector3::from(difference(c, a)));
        u.cross(&v).norm() / 2.0
    }

    fn of_triangle(corners: [[f64; 3]; 3], shift: [f64; 3]) -> Moments {
        let mut moments = Moments::about(shift);
        moments.add_triangle(corners, area(corners));
        moments
    }

    fn coordinates() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-50.0..50.0_f64)
    }

    #[test]
    fn the_unit_right_triangle_has_its_textbook_moments() {
        let moments = of_triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [0.0; 3]);
        // Area 1/2; variance of x and y 1/18, their covariance -1/36.
        let covariance = moments.covariance().unwrap();
        assert_relative_eq!(moments.weight(), 0.5);
        assert_relative_eq!(covariance[(0, 0)], 1.0 / 18.0, epsilon = 1e-16);
        assert_relative_eq!(covariance[(1, 1)], 1.0 / 18.0, epsilon = 1e-16);
        assert_relative_eq!(covariance[(0, 1)], -1.0 / 36.0, epsilon = 1e-16);
        assert_relative_eq!(covariance[(2, 2)], 0.0);
    }

    #[test]
    fn an_empty_set_has_no_covariance() {
        assert_eq!(Moments::about([1.0; 3]).covariance(), None);
        assert_eq!(Moments::about([1.0; 3]).centroid(), None);
    }

    /// The quadrature with the three edge midpoints, which is exact for polynomials of degree 2 over a triangle and
    /// independent of the formula.
    fn by_edge_midpoints(corners: [[f64; 3]; 3]) -> (Vector3<f64>, Matrix3<f64>) {
        let [a, b, c] = corners.map(Vector3::from);
        let midpoints = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
        let mean = (a + b + c) / 3.0;
        (mean, midpoints.iter().map(|m| (m - mean) * (m - mean).transpose()).sum::<Matrix3<f64>>() / 3.0)
    }

    proptest! {
        #[test]
        fn a_triangle_agrees_with_quadrature(corners in prop::array::uniform3(coordinates()), shift in coordinates()) {
            prop_assume!(area(corners) > 1e-3);
            let moments = of_triangle(corners, shift);
            let (mean, covariance) = by_edge_midpoints(corners);
            // Second moments of up to 3 * 100^2 mm^2 before the subtraction, rounded by 1e-16 of their size about ten
            // times.
            assert_relative_eq!(moments.covariance().unwrap(), covariance, epsilon = 1e-10);
            assert_relative_eq!(Vector3::from(moments.centroid().unwrap()), mean, epsilon = 1e-12);
        }

        #[test]
        fn splitting_a_triangle_changes_nothing(corners in prop::array::uniform3(coordinates()), t in 0.01..0.99_f64) {
            prop_assume!(area(corners) > 1e-3);
            let [a, b, c] = corners;
            let d = [0, 1, 2].map(|i| b[i] + t * (c[i] - b[i]));
            let mut split = of_triangle([a, b, d], a);
            split.merge(&of_triangle([a, d, c], c));
            let whole = of_triangle(corners, b);
            assert_relative_eq!(split.weight(), whole.weight(), max_relative = 1e-9);
            // The area of a sliver is good to 1e-14 * 100 mm * its length, which over the area of 1e-3 mm^2 is the
            // relative error of a moment; here 1e-9 of 1e4 mm^2.
            assert_relative_eq!(split.covariance().unwrap(), whole.covariance().unwrap(), epsilon = 1e-5, max_relative = 1e-9);
        }

        #[test]
        fn merging_parts_equals_taking_all(points in prop::collection::vec(coordinates(), 2..40), cut in 0.0..1.0_f64) {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // a share of under 40
            let cut = 1 + (cut * (points.len() - 1) as f64) as usize;
            let sum = |points: &[[f64; 3]]| {
                let mut moments = Moments::about(points[0]);
                for &point in points {
                    moments.add_point(point);
                }
                moments
            };
            let all = sum(&points);
            let mut merged = sum(&points[..cut]);
            if cut < points.len() {
                merged.merge(&sum(&points[cut..]));
            }
            // As above: rounding of moments of 1e4 mm^2.
            assert_relative_eq!(merged.covariance().unwrap(), all.covariance().unwrap(), epsilon = 1e-10);
            assert_relative_eq!(Vector3::from(merged.centroid().unwrap()), Vector3::from(all.centroid().unwrap()), epsilon = 1e-12);
        }
    }
}
