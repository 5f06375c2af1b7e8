//! Rasters: values on square cells, triangles scanned exactly at cell centres, and the Z-order curve (Morton's), which fills
//! the plane: neighbours along it are neighbours in the plane.

use super::scalar::{ceil, floor};

/// The position and size of a raster of square cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The corner with the lowest x and y.
    pub origin: [f64; 2],
    /// The length of a cell's side.
    pub cell: f64,
    /// The number of cells along x.
    pub columns: usize,
    /// The number of cells along y.
    pub rows: usize,
}

impl Frame {
    /// A frame of cells with sides of `cell` over the box from `min` to `max`, at least one in each direction. The box
    /// must be finite and the side positive.
    #[must_use]
    pub fn covering(min: [f64; 2], max: [f64; 2], cell: f64) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "callers bound the quotient; the cast saturates")]
        let count = |axis: usize| (((max[axis] - min[axis]) / cell).ceil().max(1.0)) as usize;
        Self { origin: min, cell, columns: count(0), rows: count(1) }
    }

    /// The smallest side of cells for which triangles visit at most `visits` rows and cells together. `area` is the sum of
    /// their areas and `extent` that of their extents along y: with cells of side c they cover area/c^2 cells in extent/c
    /// rows.
    #[must_use]
    pub fn affordable_cell(area: f64, extent: f64, visits: f64) -> f64 {
        // area/c^2 + extent/c = visits
        (extent + (extent * extent + 4.0 * visits * area).sqrt()) / (2.0 * visits)
    }

    /// The number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// The index of a cell: row by row from the lowest y, and within a row from the lowest x.
    #[must_use]
    pub fn index(&self, column: usize, row: usize) -> usize {
        row * self.columns + column
    }

    /// The centre of a cell.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counts of cells are far under 2^53")]
    pub fn centre(&self, column: usize, row: usize) -> [f64; 2] {
        [self.origin[0] + (column as f64 + 0.5) * self.cell, self.origin[1] + (row as f64 + 0.5) * self.cell]
    }

    /// The column and row of the cell that contains a point of the plane; for a point outside, of the nearest cell.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
    pub fn nearest_cell(&self, point: [f64; 2]) -> (usize, usize) {
        let along = |axis: usize, count: usize| (((point[axis] - self.origin[axis]) / self.cell).max(0.0) as usize).min(count - 1);
        (along(0, self.columns), along(1, self.rows))
    }

    /// Converts x and y of a point to cells, so that cell centres are at whole numbers.
    #[must_use]
    pub fn in_cells(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        [(x - self.origin[0]) / self.cell - 0.5, (y - self.origin[1]) / self.cell - 0.5, z]
    }

    /// Calls `visit` with the index of each cell of `rows` whose centre a triangle covers, as [`scan`] does.
    pub fn scan(&self, triangle: [[f64; 3]; 3], rows: std::ops::Range<usize>, mut visit: impl FnMut(usize, f64, bool)) {
        if rows.is_empty() {
            return;
        }
        let signed = |count: usize| i64::try_from(count).unwrap_or(i64::MAX);
        let last = [signed(self.columns) - 1, signed(rows.end) - 1];
        scan(triangle.map(|corner| self.in_cells(corner)), [0, signed(rows.start)], last, |column, row, z, on_edge| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to the counts of cells, which are usize")]
            visit(row as usize * self.columns + column as usize, z, on_edge);
        });
    }
}

/// Values on the cells of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster<T> {
    /// The position and size.
    pub frame: Frame,
    /// The values of the cells, row by row from the lowest y.
    pub values: Vec<T>,
}

impl<T: Clone> Raster<T> {
    /// A raster with the same value in all cells.
    #[must_use]
    pub fn filled(frame: Frame, value: T) -> Self {
        Self { frame, values: vec![value; frame.cells()] }
    }
}

/// A cell centre counts as on a triangle's edge within this distance, in cells: coordinates of up to a million cells
/// are rounded by 1e-10.
const ON_EDGE: f64 = 1e-9;

/// Calls `visit` for each point with whole coordinates from `first` to `last` that a triangle or its border covers. The
/// arguments are column, row, height, and whether the point is on an edge. The triangle's coordinates are in cells.
///
/// No point between two triangles with a common edge is missed: the crossing of the edge with a row is computed from
/// its ends in the order of their coordinates, so that it is bitwise the same for both triangles. Heights are
/// interpolated between the crossings with the two edges, so that they stay between the corners' heights even in steep
/// triangles.
pub fn scan(mut corners: [[f64; 3]; 3], first: [i64; 2], last: [i64; 2], mut visit: impl FnMut(i64, i64, f64, bool)) {
    let before = |a: &[f64; 3], b: &[f64; 3]| (a[1], a[0]) < (b[1], b[0]);
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if before(&corners[j], &corners[i]) {
            corners.swap(i, j);
        }
    }
    let [a, b, c] = corners;
    let (low, high) = (ceil(a[1]).max(first[1]), floor(c[1]).min(last[1]));
    let crossing = |p: [f64; 3], q: [f64; 3], v: f64| {
        let rise = q[1] - p[1];
        let t = if rise > 0.0 { (v - p[1]) / rise } else { 0.0 };
        (p[0] + t * (q[0] - p[0]), p[2] + t * (q[2] - p[2]))
    };
    for row in low..=high {
        #[expect(clippy::cast_precision_loss, reason = "rows are far under 2^53")]
        let v = row as f64;
        let one = crossing(a, c, v);
        let other = if v < b[1] || (v <= b[1] && a[1] < b[1]) { crossing(a, b, v) } else { crossing(b, c, v) };
        let (left, right) = if one.0 <= other.0 { (one, other) } else { (other, one) };
        let (from, to) = (ceil(left.0).max(first[0]), floor(right.0).min(last[0]));
        let slope = if right.0 > left.0 { (right.1 - left.1) / (right.0 - left.0) } else { 0.0 };
        let level_edge = v - a[1] < ON_EDGE && b[1] - a[1] < ON_EDGE || c[1] - v < ON_EDGE && c[1] - b[1] < ON_EDGE;
        for column in from..=to {
            #[expect(clippy::cast_precision_loss, reason = "columns are far under 2^53")]
            let u = column as f64;
            // The slope of a span narrower than the rounding error is meaningless; the bounds keep the height between
            // the two crossings.
            let z = (left.1 + slope * (u - left.0)).clamp(left.1.min(right.1), left.1.max(right.1));
            visit(column, row, z, level_edge || u - left.0 < ON_EDGE || right.0 - u < ON_EDGE);
        }
    }
}

/// The place along the curve of a cell with these coordinates under 2^16.
pub(crate) fn z_order([x, y]: [u32; 2]) -> u32 {
    interleaved(x) | interleaved(y) << 1
}

/// The 16 low bits with a zero bit after each.
fn interleaved(bits: u32) -> u32 {
    let mut x = bits & 0xffff;
    for (shift, mask) in [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)] {
        x = (x | x << shift) & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn covered(triangle: [[f64; 3]; 3]) -> Vec<(i64, i64, f64)> {
        let mut cells = Vec::new();
        scan(triangle, [-100, -100], [100, 100], |column, row, z, _| cells.push((column, row, z)));
        cells
    }

    #[test]
    fn a_triangle_covers_the_centres_inside_and_on_its_border() {
        let cells = covered([[0.0, 0.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 4.0]]);
        assert_eq!(cells, [(0, 0, 0.0), (1, 0, 1.0), (2, 0, 2.0), (0, 1, 2.0), (1, 1, 3.0), (0, 2, 4.0)]);
        let frame = Frame::covering([10.0, 20.0], [10.9, 21.0], 0.5);
        assert_eq!((frame.columns, frame.rows, frame.cells()), (2, 2, 4));
        let mut indices = Vec::new();
        frame.scan([[10.0, 20.0, 0.0], [10.9, 20.0, 0.0], [10.0, 21.1, 0.0]], 0..2, |index, _, _| indices.push(index));
        assert_eq!(indices, [0, 2]);
        assert_eq!((frame.nearest_cell([10.6, 20.1]), frame.nearest_cell([0.0, 99.0])), ((1, 0), (0, 1)));
    }

    proptest! {
        #[test]
        fn heights_are_those_of_the_plane(
            corners in prop::array::uniform3(prop::array::uniform2(-20.0..20.0_f64)), g in -3.0..3.0_f64, h in -3.0..3.0_f64,
        ) {
            let plane = |[x, y]: [f64; 2]| g * x + h * y + 1.0;
            #[allow(clippy::cast_precision_loss)]
            for (column, row, z) in covered(corners.map(|c| [c[0], c[1], plane(c)])) {
                // Crossings are rounded by 1e-15 of 20 cells, and heights by that times slopes of up to 6. Thin spans
                // are bounded by their ends.
                prop_assert!((z - plane([column as f64, row as f64])).abs() < 1e-11, "{column} {row} {z}");
            }
        }

        #[test]
        fn triangles_around_a_point_leave_no_gap(
            centre in prop::array::uniform2(-3.0..3.0_f64), rim in prop::collection::vec(5.0..9.0_f64, 3..12),
        ) {
            #[allow(clippy::cast_precision_loss)]
            let at = |i: usize| {
                let (sin, cos) = (std::f64::consts::TAU * (i % rim.len()) as f64 / rim.len() as f64).sin_cos();
                [rim[i % rim.len()] * cos, rim[i % rim.len()] * sin, 0.0]
            };
            let mut cells = std::collections::HashSet::new();
            for i in 0..rim.len() {
                cells.extend(covered([[centre[0], centre[1], 0.0], at(i), at(i + 1)]).into_iter().map(|(column, row, _)| (column, row)));
            }
            // The disc of radius 5/2, the inner radius of the smallest triangle, is inside the triangles around its
            // centre; a smaller disc is scanned.
            for column in -1..=1_i64 {
                for row in -1..=1_i64 {
                    prop_assert!(rim.len() < 4 || cells.contains(&(column, row)));
                }
            }
        }
    }
}
