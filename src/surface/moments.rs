//! Sums over points and triangles of a surface: the box around them, weight, first and second moments, slopes; and the
//! principal axes that follow.

use crate::numerics::vector::{difference, length};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

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

/// The eigenvalues l1 >= l2 >= l3 of a covariance matrix and their unit eigenvectors, in a fixed order and sense:
///
/// - e3, the normal of the best-fit plane, points up;
/// - e1, along which the surface extends most, points to the half plane y > 0 (along +X on its border, up if it is
///   vertical);
/// - e2 = e3 x e1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrincipalAxes {
    variances: [f64; 3],
    directions: [[f64; 3]; 3],
}

impl PrincipalAxes {
    /// The axes of a covariance matrix, whose entries must be finite.
    #[must_use]
    pub fn of(covariance: Matrix3<f64>) -> Self {
        let eigen = SymmetricEigen::new(covariance);
        // The solver returns the eigenvalues in no particular order.
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        // A variance is not negative, but a difference of rounded sums can be.
        let variances = order.map(|i| eigen.eigenvalues[i].max(0.0));
        let vector = |rank: usize| eigen.eigenvectors.column(order[rank]).into_owned();
        let (e1, e3) = (pointing(vector(0), [1, 0, 2]), pointing(vector(2), [2, 1, 0]));
        Self { variances, directions: [e1, e3.cross(&e1), e3].map(Into::into) }
    }

    /// l1 >= l2 >= l3 >= 0, the variances along e1, e2 and e3.
    #[must_use]
    pub fn variances(&self) -> [f64; 3] {
        self.variances
    }

    /// e1, e2 and e3, of length 1.
    #[must_use]
    pub fn directions(&self) -> [[f64; 3]; 3] {
        self.directions
    }
}

/// `v` or its opposite, so that the first component that is not 0, in the order of `axes`, is positive.
fn pointing(v: Vector3<f64>, axes: [usize; 3]) -> Vector3<f64> {
    let decisive = axes.into_iter().map(|axis| v[axis]).find(|&component| component != 0.0);
    if decisive.is_some_and(|component| component < 0.0) { -v } else { v }
}

/// The smallest box with sides along the axes around all points that were added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The smallest x, y and z.
    pub min: [f64; 3],
    /// The largest x, y and z.
    pub max: [f64; 3],
}

impl Bounds {
    /// The empty box.
    pub(super) const NONE: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// Enlarges the box to contain a point.
    #[inline]
    pub(super) fn include(&mut self, point: [f64; 3]) {
        for (axis, coordinate) in point.into_iter().enumerate() {
            // A comparison is one instruction. `f64::min` also tests for NaN, which would add a tenth to the time for a
            // facet.
            self.min[axis] = if coordinate < self.min[axis] { coordinate } else { self.min[axis] };
            self.max[axis] = if coordinate > self.max[axis] { coordinate } else { self.max[axis] };
        }
    }

    /// Enlarges the box to contain the other box.
    pub(super) fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
    }

    /// The box with its coordinates times `factor`.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { min: self.min.map(|c| c * factor), max: self.max.map(|c| c * factor) }
    }

    /// The largest magnitude of a coordinate in the box; 0 for the empty box.
    pub(super) fn largest_magnitude(&self) -> f64 {
        if self.min[0] > self.max[0] {
            return 0.0;
        }
        self.min.iter().chain(&self.max).fold(0.0, |largest, c| c.abs().max(largest))
    }
}

/// The sums over some points or facets of a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) count: u64,
    pub(super) moments: Moments,
    pub(super) bounds: Bounds,
    pub(super) area: f64,
    /// The sum of the slopes, in rad, each multiplied by its weight in the moments.
    pub(super) slope_by_weight: f64,
}

impl Piece {
    pub(super) fn about(shift: [f64; 3]) -> Self {
        Self { count: 0, moments: Moments::about(shift), bounds: Bounds::NONE, area: 0.0, slope_by_weight: 0.0 }
    }

    #[inline]
    pub(super) fn add_point(&mut self, point: [f64; 3]) {
        self.count += 1;
        self.moments.add_point(point);
        self.bounds.include(point);
    }

    /// Adds a point that represents an element of area with this normal.
    pub(super) fn add_sample(&mut self, point: [f64; 3], normal: [f64; 3], area: f64) {
        self.add_point(point);
        self.area += area;
        self.slope_by_weight += slope(normal);
    }

    /// Adds a facet of this area; `normal` may have any length.
    #[inline]
    pub(super) fn add_facet(&mut self, corners: [[f64; 3]; 3], normal: [f64; 3], area: f64) {
        self.count += 1;
        self.moments.add_triangle(corners, area);
        for corner in corners {
            self.bounds.include(corner);
        }
        self.area += area;
        self.slope_by_weight += area * slope(normal);
    }

    /// Takes a facet out of the sums. The box stays.
    pub(super) fn remove_facet(&mut self, corners: [[f64; 3]; 3], normal: [f64; 3], area: f64) {
        self.count -= 1;
        self.moments.add_triangle(corners, -area);
        self.area -= area;
        self.slope_by_weight -= area * slope(normal);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.moments.merge(&other.moments);
        self.bounds.merge(&other.bounds);
        self.area += other.area;
        self.slope_by_weight += other.slope_by_weight;
    }
}

/// The angle between a normal and the vertical, whether it points up or down: 0 to pi/2, exact near both ends.
#[inline]
fn slope(normal: [f64; 3]) -> f64 {
    length([normal[0], normal[1]]).atan2(normal[2].abs())
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

    proptest! {
        #[test]
        fn axes_diagonalise_the_matrix_in_order_and_sense(rows in prop::array::uniform3(prop::array::uniform3(-10.0..10.0_f64))) {
            let factor = Matrix3::from_fn(|i, j| rows[i][j]);
            let covariance = factor * factor.transpose();
            let axes = PrincipalAxes::of(covariance);
            let [l1, l2, l3] = axes.variances();
            prop_assert!(l1 >= l2 && l2 >= l3 && l3 >= 0.0);
            let basis = axes.directions().map(Vector3::from);
            prop_assert!(basis[2].z >= 0.0 && basis[0].y >= 0.0);
            // Entries of up to 300, rounded a few hundred times in the solver's rotations.
            assert_relative_eq!(basis[0].cross(&basis[1]), basis[2], epsilon = 1e-12);
            for (variance, direction) in axes.variances().into_iter().zip(basis) {
                assert_relative_eq!(covariance * direction, direction * variance, epsilon = 1e-11);
            }
        }
    }
}
