//! The sums over the points and facets of a surface while it is being received; facets are summed separately by the
//! direction of their normals.

use super::moments::Piece;
use super::{Basis, LARGEST_COORDINATE, Shape, ShapeError, Sink, Unit};
use crate::numerics::vector::{cross, difference, length};

/// The sums over a surface's points and facets, in fixed memory.
///
/// Facets are summed separately by their normals: up, down, or level (walls). Walls do not count as facing up: a cutter
/// from above reaches a wall only with its side, and most sides of closed solids are walls.
///
/// Coordinates may have any unit, which is a parameter of [`SampledSurface::shape`]. If one is not finite, or is larger
/// than [`LARGEST_COORDINATE`] in magnitude, the shape is an error.
#[derive(Debug, Clone, Default)]
pub struct SampledSurface {
    sums: Option<Sums>,
    /// 0, or NaN after a point with a coordinate that is not finite.
    poison: f64,
}

#[derive(Debug, Clone, Copy)]
struct Sums {
    points: Piece,
    up: Piece,
    /// Walls, whose normals are level.
    level: Piece,
    down: Piece,
    /// The number of facets without area.
    degenerate: u64,
}

/// A facet is a wall if |n_z| of its unit normal is at most this: within 0.006 deg of vertical. Single precision rounds
/// corners by 6e-8 of their coordinates, which turns the normal of a 1 mm facet half a metre from the origin by 3e-5.
const WALL: f64 = 1e-4;

/// The facets from which a shape is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Facing {
    /// The facets that point up, which a three-axis cutter reaches.
    #[default]
    Up,
    /// All facets.
    Any,
}

impl SampledSurface {
    /// Empty sums.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a point that represents an element of area. `normal` has the element's area as its length. The moments have
    /// the point with weight 1; slope and area have the element.
    pub fn sample(&mut self, point: [f64; 3], normal: [f64; 3]) {
        self.poison += 0.0 * (point[0] + point[1] + point[2]);
        Self::sums_about(&mut self.sums, point).points.add_sample(point, normal, length(normal));
    }

    /// Takes a facet that was added out of the sums again. The box around the surface stays.
    pub fn leave_out(&mut self, corners: [[f64; 3]; 3]) {
        if let Some(sums) = &mut self.sums
            && let Some((piece, twice, area)) = sums.piece_of(corners)
        {
            piece.remove_facet(corners, twice, area);
        }
    }

    /// Adds the sums of `other`, as if its points and facets had followed.
    pub fn merge(&mut self, other: &Self) {
        self.poison += other.poison;
        match (&mut self.sums, &other.sums) {
            (Some(own), Some(others)) => own.merge(others),
            (None, sums) => self.sums = *sums,
            (_, None) => {}
        }
    }

    /// The number of points that are not part of a facet.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.sums.map_or(0, |sums| sums.points.count)
    }

    /// The number of facets with an area, in all directions.
    #[must_use]
    pub fn facets(&self) -> u64 {
        self.sums.map_or(0, |sums| sums.facets())
    }

    /// The number of facets without area, which are left out.
    #[must_use]
    pub fn degenerate_facets(&self) -> u64 {
        self.sums.map_or(0, |sums| sums.degenerate)
    }

    /// The shape of the surface, from its facets if it has any, otherwise from its points.
    ///
    /// # Errors
    /// [`ShapeError`] if the points or facets do not spread over a surface, or a coordinate was out of bounds.
    pub fn shape(&self, unit: Unit, facing: Facing) -> Result<Shape, ShapeError> {
        let Some(sums) = self.sums else {
            return Err(ShapeError::TooFewPoints { count: 0 });
        };
        let mut pieces = [sums.points, sums.up, sums.level, sums.down].into_iter();
        // A facet with a NaN coordinate has an area of NaN.
        if self.poison.is_nan() || pieces.any(|piece| piece.area.is_nan() || piece.bounds.largest_magnitude() > LARGEST_COORDINATE) {
            return Err(ShapeError::CoordinateOutOfRange);
        }
        let (basis, piece) = sums.select(facing);
        if basis == Basis::Points && piece.count == 0 && sums.degenerate > 0 {
            return Err(ShapeError::OnlyDegenerateFacets { count: sums.degenerate });
        }
        Shape::of(basis, &piece, unit)
    }

    /// The sums about a shift near the data: the first point.
    #[inline]
    fn sums_about(sums: &mut Option<Sums>, point: [f64; 3]) -> &mut Sums {
        sums.get_or_insert_with(|| {
            let none = Piece::about(point);
            Sums { points: none, up: none, level: none, down: none, degenerate: 0 }
        })
    }
}

impl Sums {
    /// The number of facets with an area.
    fn facets(&self) -> u64 {
        self.up.count + self.level.count + self.down.count
    }

    #[inline]
    fn add_facet(&mut self, corners: [[f64; 3]; 3]) {
        match self.piece_of(corners) {
            Some((piece, normal, area)) => piece.add_facet(corners, normal, area),
            None => self.degenerate += 1,
        }
    }

    /// The piece that a facet belongs to, a vector along the facet's normal, and its area; `None` if it has no area.
    #[inline]
    fn piece_of(&mut self, corners: [[f64; 3]; 3]) -> Option<(&mut Piece, [f64; 3], f64)> {
        let [a, b, c] = corners;
        let twice = cross(difference(b, a), difference(c, a));
        let doubled = length(twice);
        if doubled == 0.0 {
            return None;
        }
        // A facet with NaN is no wall, and makes the sums NaN.
        let limit = WALL * doubled;
        let piece = if twice[2] > limit {
            &mut self.up
        } else if twice[2] < -limit {
            &mut self.down
        } else {
            &mut self.level
        };
        Some((piece, twice, 0.5 * doubled))
    }

    fn merge(&mut self, other: &Self) {
        self.points.merge(&other.points);
        self.up.merge(&other.up);
        self.level.merge(&other.level);
        self.down.merge(&other.down);
        self.degenerate += other.degenerate;
    }

    fn select(&self, facing: Facing) -> (Basis, Piece) {
        match facing {
            _ if self.facets() == 0 => (Basis::Points, self.points),
            Facing::Any => {
                let mut all = self.up;
                all.merge(&self.level);
                all.merge(&self.down);
                (Basis::AllFacets, all)
            }
            Facing::Up if self.up.count > 0 => (Basis::FacetsUp, self.up),
            Facing::Up if self.down.count > 0 => (Basis::FacetsTurnedOver, self.down),
            Facing::Up => (Basis::Walls, self.level),
        }
    }
}

impl Sink for SampledSurface {
    #[inline]
    fn point(&mut self, point: [f64; 3]) {
        let sums = Self::sums_about(&mut self.sums, point);
        self.poison += 0.0 * (point[0] + point[1] + point[2]);
        sums.points.add_point(point);
    }

    #[inline]
    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        Self::sums_about(&mut self.sums, corners[0]).add_facet(corners);
    }

    fn turn_over(&mut self) {
        if let Some(sums) = &mut self.sums {
            std::mem::swap(&mut sums.up, &mut sums.down);
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
mod tests {
    use super::*;
    use crate::surface::Grid;
    use crate::surface::mesh::shapes;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    /// A closed box of 40 x 20 x 10, each side two triangles.
    fn solid_box() -> Vec<[[f64; 3]; 3]> {
        shapes::solid_box([0.0; 3], [40.0, 20.0, 10.0])
    }

    fn of_facets(facets: &[[[f64; 3]; 3]]) -> SampledSurface {
        let mut surface = SampledSurface::new();
        for &facet in facets {
            surface.facet(facet);
        }
        surface
    }

    fn of_points(points: &[[f64; 3]]) -> SampledSurface {
        let mut surface = SampledSurface::new();
        for &point in points {
            surface.point(point);
        }
        surface
    }

    fn shape(surface: &SampledSurface) -> Shape {
        surface.shape(Unit::Millimetre, Facing::Up).unwrap()
    }

    #[test]
    fn only_the_top_of_a_closed_solid_is_used_by_default() {
        let surface = of_facets(&solid_box());
        let top = shape(&surface);
        assert_eq!((top.basis, top.elements, surface.facets()), (Basis::FacetsUp, 2, 12));
        assert_relative_eq!(top.area.unwrap().mm2(), 800.0);
        // The sides of the rectangle are recovered exactly [Herraz et al. 2020, appendix B]: variances w^2/12 and
        // h^2/12.
        assert_relative_eq!(top.form_factor.ratio(), 2.0, max_relative = 1e-14);
        assert_relative_eq!(top.characteristic_size.mm2(), 800.0, max_relative = 1e-14);
        assert_eq!(top.slope.degrees(), 0.0);
        assert_eq!(top.principal_direction.unwrap().degrees(), 0.0);
        assert_eq!((top.steepest_direction, top.direction_gap), (None, None));
        assert_eq!(top.bounds.min, [0.0, 0.0, 10.0]);
    }

    #[test]
    fn facing_any_uses_all_sides() {
        let all = of_facets(&solid_box()).shape(Unit::Millimetre, Facing::Any).unwrap();
        assert_eq!((all.basis, all.elements), (Basis::AllFacets, 12));
        // Two level sides of 800 mm^2, walls of 2 * 400 + 2 * 200 mm^2: 90 deg * 1200/2800.
        assert_relative_eq!(all.mean_slope.unwrap().degrees(), 90.0 * 1200.0 / 2800.0, max_relative = 1e-14);
        assert_relative_eq!(all.area.unwrap().mm2(), 2800.0);
    }

    #[test]
    fn a_surface_that_faces_down_only_counts_as_turned_over() {
        let bottom = of_facets(&solid_box()[2..4]);
        assert_eq!(shape(&bottom).basis, Basis::FacetsTurnedOver);
        assert_relative_eq!(shape(&bottom).area.unwrap().mm2(), 800.0);
        let wall = of_facets(&solid_box()[4..6]);
        assert_eq!(shape(&wall).basis, Basis::Walls);
        assert_relative_eq!(shape(&wall).slope.degrees(), 90.0);
    }

    #[test]
    fn a_square_has_no_principal_direction() {
        let square = of_facets(&[[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], [[0.0; 3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]]);
        assert_eq!(shape(&square).principal_direction, None);
        assert_relative_eq!(shape(&square).form_factor.ratio(), 1.0, max_relative = 1e-15);
    }

    #[test]
    fn facets_without_area_are_counted_and_left_out() {
        let mut surface = of_facets(&solid_box());
        let before = shape(&surface);
        surface.facet([[1.0; 3], [1.0; 3], [2.0; 3]]);
        surface.facet([[0.0; 3], [1.0; 3], [2.0; 3]]);
        assert_eq!(surface.degenerate_facets(), 2);
        assert_eq!(shape(&surface), before);
    }

    #[test]
    fn a_facet_that_is_left_out_again_changes_nothing() {
        let facets = solid_box();
        let mut surface = of_facets(&facets);
        let before = surface.clone();
        for facet in &facets {
            surface.facet(*facet);
        }
        for facet in &facets {
            surface.leave_out(*facet);
        }
        for facing in [Facing::Up, Facing::Any] {
            let [one, other] = [&surface, &before].map(|surface| surface.shape(Unit::Millimetre, facing).unwrap());
            assert_eq!((one.elements, one.bounds), (other.elements, other.bounds));
            assert_relative_eq!(one.area.unwrap().mm2(), other.area.unwrap().mm2(), max_relative = 1e-14);
            assert_relative_eq!(one.form_factor.ratio(), other.form_factor.ratio(), max_relative = 1e-12);
        }
    }

    #[test]
    fn points_and_facets_that_do_not_spread_over_a_surface_are_refused() {
        let refusal = |points: &[[f64; 3]]| of_points(points).shape(Unit::Millimetre, Facing::Up).unwrap_err();
        assert_eq!(refusal(&[]), ShapeError::TooFewPoints { count: 0 });
        assert_eq!(refusal(&[[1.0; 3]]), ShapeError::TooFewPoints { count: 1 });
        assert_eq!(refusal(&[[0.0; 3], [1.0; 3]]), ShapeError::TooFewPoints { count: 2 });
        assert_eq!(refusal(&[[0.1; 3]; 5]), ShapeError::AllPointsEqual);
        assert_eq!(refusal(&[[5e9, 0.1, 0.7]; 5]), ShapeError::AllPointsEqual);
        let line = |origin: f64| (0..9).map(|i| [origin + f64::from(i), 0.3 * f64::from(i), -0.1 * f64::from(i)]).collect::<Vec<_>>();
        assert_eq!(refusal(&line(0.0)), ShapeError::Collinear);
        // A line that is bent by the rounding of its coordinates to 1e-6 mm.
        assert_eq!(refusal(&line(5e9)), ShapeError::Collinear);
        let flat = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]];
        let facets = of_facets(&[flat, flat]);
        assert_eq!(facets.shape(Unit::Millimetre, Facing::Up), Err(ShapeError::OnlyDegenerateFacets { count: 2 }));
    }

    #[test]
    fn coordinates_out_of_bounds_never_become_a_shape() {
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 1.1e12, 1e200] {
            let good = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            for at in 0..9 {
                let mut bad = good;
                bad[at / 3][at % 3] = wrong;
                let (points, mut facets) = (of_points(&bad), of_facets(&[good, bad]));
                facets.facet(good);
                assert_eq!(points.shape(Unit::Millimetre, Facing::Up), Err(ShapeError::CoordinateOutOfRange), "{wrong} at {at}");
                assert_eq!(facets.shape(Unit::Millimetre, Facing::Any), Err(ShapeError::CoordinateOutOfRange), "{wrong} at {at}");
            }
        }
    }

    #[test]
    fn the_largest_coordinates_have_a_shape() {
        let l = LARGEST_COORDINATE;
        let facet = of_facets(&[[[-l, -l, 0.0], [l, -l, 0.0], [-l, l, l]]]).shape(Unit::Metre, Facing::Up).unwrap();
        // Half of 2000 km times the root of 2000^2 + 1000^2 million km^2, in mm^2.
        assert_relative_eq!(facet.area.unwrap().mm2(), 0.5 * 2e15 * 5.0_f64.sqrt() * 1e15, max_relative = 1e-14);
    }

    #[test]
    fn units_scale_lengths_and_leave_ratios() {
        let surface = of_facets(&solid_box());
        let (mm, inch) = (shape(&surface), surface.shape(Unit::Inch, Facing::Up).unwrap());
        assert_relative_eq!(inch.characteristic_size.mm2(), mm.characteristic_size.mm2() * 25.4 * 25.4);
        assert_relative_eq!(inch.area.unwrap().mm2(), mm.area.unwrap().mm2() * 25.4 * 25.4);
        assert_relative_eq!(inch.centroid[0], 20.0 * 25.4);
        assert_relative_eq!(inch.bounds.max[1], 20.0 * 25.4);
        assert_eq!((inch.form_factor, inch.flatness), (mm.form_factor, mm.flatness));
    }

    /// A saddle over 60 x 30, inclined and turned, as a function of two parameters from 0 to 1.
    fn saddle(u: f64, v: f64) -> [f64; 3] {
        let (x, y) = (60.0 * u, 30.0 * v);
        [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y, 0.4 * x - 0.3 * y + 0.004 * x * y]
    }

    fn grid(rows: usize, columns: usize, at: impl Fn(f64, f64) -> [f64; 3]) -> SampledSurface {
        let mut grid = Grid::new(rows, columns).unwrap();
        #[allow(clippy::cast_precision_loss)] // small counts
        let share = |index: usize, count: usize| index as f64 / (count - 1) as f64;
        for i in 0..rows * columns {
            grid.point(at(share(i / columns, rows), share(i % columns, columns)));
        }
        grid.finish().unwrap()
    }

    #[test]
    fn a_grid_faces_up_whichever_way_it_runs() {
        let along = shape(&grid(21, 31, saddle));
        assert_eq!((along.basis, along.elements), (Basis::FacetsUp, 20 * 30 * 2));
        let runs: [(&str, SampledSurface); 3] = [
            ("transposed", grid(31, 21, |u, v| saddle(v, u))),
            ("rows reversed", grid(21, 31, |u, v| saddle(1.0 - u, v))),
            ("columns reversed", grid(21, 31, |u, v| saddle(u, 1.0 - v))),
        ];
        for (run, surface) in runs {
            let other = shape(&surface);
            assert_eq!((other.basis, other.elements), (along.basis, along.elements), "{run}");
            // If rows or columns are reversed, the other diagonal divides the quads. On a quad of 2 x 1.5 mm the two
            // diagonals of the saddle differ by 0.004 * 3 mm = 0.012 mm in the middle, which changes the area by less
            // than a part in 2500.
            assert_relative_eq!(other.area.unwrap().mm2(), along.area.unwrap().mm2(), max_relative = 1.0 / 2500.0);
            assert_relative_eq!(other.form_factor.ratio(), along.form_factor.ratio(), max_relative = 1.0 / 2500.0);
        }
    }

    #[test]
    fn a_grid_of_the_wrong_size_is_refused() {
        use crate::surface::GridError;
        assert_eq!(Grid::new(1, 5).unwrap_err(), GridError::TooFewRowsOrColumns);
        let mut grid = Grid::new(2, 3).unwrap();
        (0..5).for_each(|i| grid.point([f64::from(i), 0.0, 0.0]));
        assert_eq!(grid.clone().finish().unwrap_err(), GridError::WrongNumberOfPoints { expected: 6, received: 5 });
        (0..2).for_each(|_| grid.point([0.0; 3]));
        assert_eq!(grid.finish().unwrap_err(), GridError::WrongNumberOfPoints { expected: 6, received: 7 });
        let promising = Grid::new(usize::MAX, usize::MAX).unwrap();
        assert_eq!(promising.finish().unwrap_err(), GridError::WrongNumberOfPoints { expected: usize::MAX, received: 0 });
    }

    /// A triangle of an inclined plane, cut into pieces of very different sizes.
    fn retessellated(facet: [[f64; 3]; 3], cuts: &[f64]) -> Vec<[[f64; 3]; 3]> {
        let [a, b, mut c] = facet;
        let mut pieces = Vec::new();
        for &t in cuts {
            let d = [0, 1, 2].map(|axis| b[axis] + t * (c[axis] - b[axis]));
            pieces.push([a, d, c]);
            c = d;
        }
        pieces.push([a, b, c]);
        pieces
    }

    fn assert_same_shape(one: &Shape, other: &Shape, relative: f64) {
        assert_relative_eq!(one.form_factor.ratio(), other.form_factor.ratio(), max_relative = relative);
        assert_relative_eq!(one.characteristic_size.mm2(), other.characteristic_size.mm2(), max_relative = relative);
        assert_abs_diff_eq!(one.slope.radians(), other.slope.radians(), epsilon = relative);
        assert_abs_diff_eq!(one.mean_slope.unwrap().radians(), other.mean_slope.unwrap().radians(), epsilon = relative);
        assert_relative_eq!(one.area.unwrap().mm2(), other.area.unwrap().mm2(), max_relative = relative);
        assert_abs_diff_eq!(one.flatness, other.flatness, epsilon = relative);
    }

    #[test]
    fn the_shape_is_the_same_five_thousand_kilometres_from_the_origin() {
        let near = shape(&grid(41, 41, saddle));
        let far = shape(&grid(41, 41, |u, v| {
            let [x, y, z] = saddle(u, v);
            [x + 5e9, y - 5e9, z + 5e9]
        }));
        // Coordinates there are rounded to 2^-21 mm = 5e-7 mm. The facets' sides are at least 0.75 mm, and the errors
        // of many facets average out.
        assert_same_shape(&near, &far, 1e-6);
        assert_relative_eq!(far.centroid[0] - 5e9, near.centroid[0], epsilon = 2e-6);
    }

    proptest! {
        #[test]
        fn the_tessellation_does_not_matter(cuts in prop::collection::vec(0.001..0.999_f64, 0..6)) {
            let facets = [[[0.0; 3], [50.0, 0.0, 20.0], [50.0, 30.0, 14.0]], [[0.0; 3], [50.0, 30.0, 14.0], [0.0, 30.0, -6.0]]];
            let pieces: Vec<_> = facets.into_iter().flat_map(|facet| retessellated(facet, &cuts)).collect();
            let (whole, cut) = (shape(&of_facets(&facets)), shape(&of_facets(&pieces)));
            // Flatness is not compared: it is the square root of a variance of 0, whose rounding error of 1e-15 of l1
            // becomes 1e-8 to 1e-7.
            assert_relative_eq!(whole.form_factor.ratio(), cut.form_factor.ratio(), max_relative = 1e-12);
            assert_relative_eq!(whole.characteristic_size.mm2(), cut.characteristic_size.mm2(), max_relative = 1e-12);
            assert_abs_diff_eq!(whole.slope.radians(), cut.slope.radians(), epsilon = 1e-12);
            prop_assert!(whole.flatness < 1e-7 && cut.flatness < 1e-7);
        }

        #[test]
        fn turning_about_z_turns_the_directions(turn in 0.0..std::f64::consts::TAU) {
            let (sin, cos) = turn.sin_cos();
            let (still, turned) = (shape(&grid(21, 31, saddle)), shape(&grid(21, 31, |u, v| {
                let [x, y, z] = saddle(u, v);
                [cos * x - sin * y, sin * x + cos * y, z]
            })));
            // Coordinates of 60 mm are rounded to 1e-14 mm, normals of facets of 3 mm^2 and their sums to 1e-13.
            assert_same_shape(&still, &turned, 1e-11);
            for (before, after) in [(still.principal_direction, turned.principal_direction), (still.steepest_direction, turned.steepest_direction)] {
                let lines_apart = (after.unwrap().radians() - before.unwrap().radians() - turn).sin();
                assert_abs_diff_eq!(lines_apart, 0.0, epsilon = 1e-11);
            }
            assert_abs_diff_eq!(still.direction_gap.unwrap().radians(), turned.direction_gap.unwrap().radians(), epsilon = 1e-11);
        }

        #[test]
        fn parts_merge_to_the_whole(cut in 0..1200_usize) {
            let mut facets = Vec::new();
            let at = |i: u32, j: u32| saddle(f64::from(i) / 20.0, f64::from(j) / 30.0);
            for (i, j) in (0..20).flat_map(|i| (0..30).map(move |j| (i, j))) {
                facets.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                facets.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
            let whole = of_facets(&facets);
            let mut merged = of_facets(&facets[..cut]);
            merged.merge(&of_facets(&facets[cut..]));
            prop_assert_eq!(merged.facets(), whole.facets());
            assert_same_shape(&shape(&merged), &shape(&whole), 1e-12);
            prop_assert_eq!(shape(&merged).bounds, shape(&whole).bounds);
        }
    }
}
