//! Bezier patches, sampled evenly in their parameters.

use super::{Grid, LARGEST_COORDINATE, SampledSurface, Sink};
use crate::quantity::OutOfRange;
use std::fmt;

/// A tensor-product Bezier patch: P(u, v) = sum over i, j of B_i(u) B_j(v) P_ij with the Bernstein polynomials B and 0
/// <= u, v <= 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Bezier {
    rows: usize,
    columns: usize,
    /// Row by row.
    control_points: Vec<[f64; 3]>,
}

/// The reason why control points do not describe a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BezierError {
    /// The number of rows is out of bounds.
    Rows(OutOfRange),
    /// The number of points in the first row is out of bounds.
    Columns(OutOfRange),
    /// A row has another number of points than the first.
    RaggedRow {
        /// The row, from 0.
        row: usize,
        /// The number of points in the first row.
        expected: usize,
        /// The number of points in this row.
        found: usize,
    },
    /// A coordinate is not finite, or beyond [`LARGEST_COORDINATE`].
    Coordinate {
        /// The point's row, from 0.
        row: usize,
        /// The point's position in its row, from 0.
        column: usize,
    },
}

impl fmt::Display for BezierError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rows(bounds) => write!(f, "the number of rows of control points {bounds}"),
            Self::Columns(bounds) => write!(f, "the number of control points in a row {bounds}"),
            Self::RaggedRow { row, expected, found } => {
                write!(f, "row {row} has {found} control points where the first has {expected}")
            }
            Self::Coordinate { row, column } => {
                write!(f, "control point {column} of row {row} must have finite coordinates of at most {LARGEST_COORDINATE:e} in magnitude")
            }
        }
    }
}

impl std::error::Error for BezierError {}

/// The Bernstein polynomials of one degree, or their derivatives, at one parameter: one for each control point.
type Weights = [f64; Bezier::LARGEST_ORDER];

impl Bezier {
    /// The largest number of control points along each parameter. Published surfaces have up to a dozen; patches of
    /// higher degree are split in practice.
    pub const LARGEST_ORDER: usize = 20;
    /// The largest number of samples along each parameter.
    pub const LARGEST_SAMPLES: usize = 1000;

    /// A patch from its control points, row by row: 2 to [`Bezier::LARGEST_ORDER`] rows, each with the same number of
    /// points, which is also from 2 to [`Bezier::LARGEST_ORDER`].
    ///
    /// # Errors
    /// [`BezierError`] if a number of points or a coordinate is out of bounds, or the rows differ in length.
    pub fn new(net: &[Vec<[f64; 3]>]) -> Result<Self, BezierError> {
        order_in_bounds(net.len()).map_err(BezierError::Rows)?;
        let columns = net[0].len();
        order_in_bounds(columns).map_err(BezierError::Columns)?;
        for (row, points) in net.iter().enumerate() {
            if points.len() != columns {
                return Err(BezierError::RaggedRow { row, expected: columns, found: points.len() });
            }
            // The comparison makes NaN out of bounds.
            let in_bounds = |point: &[f64; 3]| point.iter().all(|c| c.abs() <= LARGEST_COORDINATE);
            if let Some(column) = points.iter().position(|point| !in_bounds(point)) {
                return Err(BezierError::Coordinate { row, column });
            }
        }
        Ok(Self { rows: net.len(), columns, control_points: net.concat() })
    }

    /// Samples the patch at the centres of `samples` x `samples` equal cells of its parameters, each with its element
    /// of area
    /// |P_u x P_v| du dv; `samples` is from 2 to [`Bezier::LARGEST_SAMPLES`].
    ///
    /// Once `stop` returns true, the other samples are left out.
    ///
    /// # Errors
    /// [`OutOfRange`] for another number of samples.
    pub fn sampled(&self, samples: usize, stop: &dyn Fn() -> bool) -> Result<SampledSurface, OutOfRange> {
        count_in_bounds(samples, 2, Self::LARGEST_SAMPLES)?;
        #[allow(clippy::cast_precision_loss)] // up to 1000
        let step = (samples as f64).recip();
        #[allow(clippy::cast_precision_loss)]
        let centre = |index: usize| (index as f64 + 0.5) * step;
        let across: Vec<_> = (0..samples).map(|j| weights(self.columns, centre(j))).collect();
        let mut surface = SampledSurface::new();
        for i in (0..samples).take_while(|_| !stop()) {
            let (along, along_slope) = weights(self.rows, centre(i));
            let (curve, curve_u) = (self.curve(&along), self.curve(&along_slope));
            for (weights, slopes) in &across {
                let (p, p_u, p_v) = (blend(&curve, weights), blend(&curve_u, weights), blend(&curve, slopes));
                let normal = [p_u[1] * p_v[2] - p_u[2] * p_v[1], p_u[2] * p_v[0] - p_u[0] * p_v[2], p_u[0] * p_v[1] - p_u[1] * p_v[0]];
                surface.sample(p, normal.map(|c| c * step * step));
            }
        }
        Ok(surface)
    }

    /// Passes the facets of the patch to `sink`: 2 x `samples`^2 of them, with corners at the corners of the cells of
    /// [`Bezier::sampled`].
    ///
    /// Once `stop` returns true, the facets of the other cells are left out.
    ///
    /// # Errors
    /// [`OutOfRange`] for a number of samples outside 2 to [`Bezier::LARGEST_SAMPLES`].
    ///
    /// # Panics
    /// Never: the grid receives rows times columns points.
    pub fn tessellate<S: Sink>(&self, samples: usize, sink: S, stop: &dyn Fn() -> bool) -> Result<S, OutOfRange> {
        count_in_bounds(samples, 2, Self::LARGEST_SAMPLES)?;
        #[expect(clippy::cast_precision_loss, reason = "up to 1000")]
        let corner = |index: usize| index as f64 / samples as f64;
        let across: Vec<_> = (0..=samples).map(|j| weights(self.columns, corner(j)).0).collect();
        let mut grid = Grid::into_sink(samples + 1, samples + 1, sink).expect("at least 3 rows and columns");
        for i in 0..=samples {
            let curve = self.curve(&weights(self.rows, corner(i)).0);
            if stop() {
                return Ok(grid.unfinished());
            }
            for weights in &across {
                grid.point(blend(&curve, weights));
            }
        }
        Ok(grid.finish().expect("as many points as rows times columns"))
    }

    /// The control points of the curve at a fixed u, or of its derivative.
    fn curve(&self, weights: &Weights) -> [[f64; 3]; Self::LARGEST_ORDER] {
        let mut curve = [[0.0; 3]; Self::LARGEST_ORDER];
        for (row, weight) in self.control_points.chunks_exact(self.columns).zip(weights) {
            for (sum, point) in curve.iter_mut().zip(row) {
                (0..3).for_each(|axis| sum[axis] += weight * point[axis]);
            }
        }
        curve
    }
}

/// The sum of the points with their weights; unused weights are 0.
fn blend(points: &[[f64; 3]; Bezier::LARGEST_ORDER], weights: &Weights) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (point, weight) in points.iter().zip(weights) {
        (0..3).for_each(|axis| sum[axis] += weight * point[axis]);
    }
    sum
}

/// The Bernstein polynomials for `order` control points at t, and their derivatives.
///
/// B_i of degree n is (1 - t) B_i + t B_{i-1} of degree n - 1, which for 0 <= t <= 1 adds up positive terms only; its
/// derivative is n (B_{i-1} - B_i), of degree n - 1.
fn weights(order: usize, t: f64) -> (Weights, Weights) {
    let (mut values, mut slopes) = ([0.0; Bezier::LARGEST_ORDER], [0.0; Bezier::LARGEST_ORDER]);
    values[0] = 1.0;
    for degree in 1..order {
        if degree == order - 1 {
            #[allow(clippy::cast_precision_loss)] // under 20
            let n = degree as f64;
            for i in 0..order {
                slopes[i] = n * (if i > 0 { values[i - 1] } else { 0.0 } - values[i]);
            }
        }
        for i in (0..=degree).rev() {
            values[i] = (1.0 - t) * values[i] + if i > 0 { t * values[i - 1] } else { 0.0 };
        }
    }
    (values, slopes)
}

fn order_in_bounds(order: usize) -> Result<(), OutOfRange> {
    count_in_bounds(order, 2, Bezier::LARGEST_ORDER)
}

#[allow(clippy::cast_precision_loss)] // counts are far below 2^53; a larger one is out of bounds even when rounded
fn count_in_bounds(count: usize, minimum: usize, maximum: usize) -> Result<(), OutOfRange> {
    OutOfRange::check(count as f64, minimum as f64, maximum as f64).map(|_| ())
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
mod tests {
    use super::*;
    use crate::surface::{Facing, Shape, Unit};
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    /// The point of a Bezier curve by repeated linear interpolation (de Casteljau), independently of Bernstein
    /// polynomials.
    fn interpolated(mut points: Vec<[f64; 3]>, t: f64) -> [f64; 3] {
        while points.len() > 1 {
            points = points.windows(2).map(|pair| [0, 1, 2].map(|axis| (1.0 - t) * pair[0][axis] + t * pair[1][axis])).collect();
        }
        points[0]
    }

    fn shape(surface: &SampledSurface) -> Shape {
        surface.shape(Unit::Millimetre, Facing::Up).unwrap()
    }

    #[test]
    fn a_bilinear_patch_of_a_plane_is_the_plane() {
        // 40 x 30 horizontally, rising 30 over the 30: 45 deg, area 40 * 30 sqrt(2).
        let net = [vec![[0.0; 3], [0.0, 30.0, 30.0]], vec![[40.0, 0.0, 0.0], [40.0, 30.0, 30.0]]];
        let plane = shape(&Bezier::new(&net).unwrap().sampled(50, &|| false).unwrap());
        assert_relative_eq!(plane.area.unwrap().mm2(), 1200.0 * 2.0_f64.sqrt(), max_relative = 1e-13);
        assert_relative_eq!(plane.slope.degrees(), 45.0, max_relative = 1e-13);
        assert_relative_eq!(plane.mean_slope.unwrap().degrees(), 45.0, max_relative = 1e-13);
        assert_abs_diff_eq!(plane.steepest_direction.unwrap().degrees(), 90.0, epsilon = 1e-9);
        // The centres of n quads spread by 1 - 1/n^2 of the variance of the whole: 50^2 = 2500.
        assert_relative_eq!(plane.characteristic_size.mm2(), 1200.0 * 2.0_f64.sqrt() * (1.0 - 1.0 / 2500.0), max_relative = 1e-13);
    }

    #[test]
    fn invalid_control_points_are_refused() {
        let point = [0.0; 3];
        let orders = OutOfRange { minimum: 2.0, maximum: 20.0 };
        assert_eq!(Bezier::new(&[]), Err(BezierError::Rows(orders)));
        assert_eq!(Bezier::new(&vec![vec![point; 3]; 21]), Err(BezierError::Rows(orders)));
        assert_eq!(Bezier::new(&[vec![], vec![]]), Err(BezierError::Columns(orders)));
        assert_eq!(Bezier::new(&vec![vec![point; 21]; 2]), Err(BezierError::Columns(orders)));
        assert_eq!(Bezier::new(&[vec![point; 3], vec![point; 2]]), Err(BezierError::RaggedRow { row: 1, expected: 3, found: 2 }));
        let wrong = [vec![point; 2], vec![point, [0.0, f64::NAN, 0.0]]];
        assert_eq!(Bezier::new(&wrong), Err(BezierError::Coordinate { row: 1, column: 1 }));
        let patch = Bezier::new(&[vec![point; 2], vec![point; 2]]).unwrap();
        assert_eq!(patch.sampled(1, &|| false).unwrap_err(), OutOfRange { minimum: 2.0, maximum: 1000.0 });
        assert!(patch.sampled(1001, &|| false).is_err());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn samples_agree_with_repeated_interpolation(
            rows in 2..=Bezier::LARGEST_ORDER, columns in 2..=Bezier::LARGEST_ORDER, seed in prop::collection::vec(-50.0..50.0_f64, 1200),
            i in 0..7_usize, j in 0..7_usize,
        ) {
            let net: Vec<Vec<[f64; 3]>> =
                seed.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect::<Vec<_>>().chunks_exact(columns).take(rows).map(<[_]>::to_vec).collect();
            let patch = Bezier::new(&net).unwrap();
            #[allow(clippy::cast_precision_loss)]
            let (u, v) = ((i as f64 + 0.5) / 7.0, (j as f64 + 0.5) / 7.0);
            let at = |u: f64, v: f64| interpolated(net.iter().map(|row| interpolated(row.clone(), v)).collect(), u);
            let ((along, along_slope), (across, across_slope)) = (weights(rows, u), weights(columns, v));
            let (curve, curve_u) = (patch.curve(&along), patch.curve(&along_slope));
            let expected = at(u, v);
            let step = 1e-6;
            for axis in 0..3 {
                assert_abs_diff_eq!(blend(&curve, &across)[axis], expected[axis], epsilon = 1e-12);
                // Central differences have an error of step^2/6 times a third derivative of up to 19^3 * 8 * 50, which
                // is 5e-7, and of the rounding of 50 mm over the step, 1e-8.
                let by_u = (at(u + step, v)[axis] - at(u - step, v)[axis]) / (2.0 * step);
                let by_v = (at(u, v + step)[axis] - at(u, v - step)[axis]) / (2.0 * step);
                assert_abs_diff_eq!(blend(&curve_u, &across)[axis], by_u, epsilon = 1e-6);
                assert_abs_diff_eq!(blend(&curve, &across_slope)[axis], by_v, epsilon = 1e-6);
            }
        }
    }
}
