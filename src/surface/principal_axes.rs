//! The principal axes of a surface: the directions along which it extends most and least.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

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

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

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
