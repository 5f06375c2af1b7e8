//! The moves of a path in the cells of a grid in plan view.

#![allow(clippy::cast_precision_loss, reason = "counts are below 2^52")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap,
    reason = "cells and moves are fewer than 2^32"
)]

use super::body::Swept;

/// The most cells and the most moves in cells: 16 MB and 64 MB.
const MOST_CELLS: f64 = 4e6;
const MOST_ENTRIES: f64 = 1.6e7;

/// The moves in a cell for which its size is chosen.
const IN_A_CELL: f64 = 6.0;

/// For each cell the moves that cross it.
#[derive(Debug, Clone)]
pub(super) struct MoveGrid {
    origin: [f64; 2],
    cell: f64,
    columns: usize,
    rows: usize,
    /// Where the moves of each cell begin in `entries`, and the end.
    starts: Vec<u32>,
    entries: Vec<u32>,
    /// The lowest height of a tip in each cell; infinite if there is none.
    lowest: Vec<f64>,
}

/// A range of columns and rows, the last ones included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cells {
    pub(super) columns: (isize, isize),
    pub(super) rows: (isize, isize),
}

impl MoveGrid {
    /// `None` if there are no moves, or once `stop` returns true.
    pub(super) fn new(moves: &[Swept], radius: f64, stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let (mut min, mut max, mut length) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], 0.0);
        for swept in moves {
            for [x, y, _] in [swept.start(), swept.end()] {
                (min[0], max[0]) = (min[0].min(x), max[0].max(x));
                (min[1], max[1]) = (min[1].min(y), max[1].max(y));
            }
            length += swept.length();
        }
        if moves.is_empty() {
            return None;
        }
        let cell = cell_size(moves.len(), length, [max[0] - min[0], max[1] - min[1]], radius);
        let count = |axis: usize| ((max[axis] - min[axis]) / cell) as usize + 1;
        let (columns, rows) = (count(0), count(1));
        let mut grid = Self {
            origin: min,
            cell,
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            entries: Vec::new(),
            lowest: vec![f64::INFINITY; columns * rows],
        };
        for (number, swept) in moves.iter().enumerate() {
            if number % 65536 == 0 && stop() {
                return None;
            }
            let mut counted = std::mem::take(&mut grid.starts);
            let mut lowest = std::mem::take(&mut grid.lowest);
            grid.for_each_cell(swept, |at, z| {
                counted[at + 1] += 1;
                lowest[at] = lowest[at].min(z);
            });
            (grid.starts, grid.lowest) = (counted, lowest);
        }
        for at in 1..grid.starts.len() {
            grid.starts[at] += grid.starts[at - 1];
        }
        let mut next = grid.starts.clone();
        let mut entries = vec![0_u32; *grid.starts.last()? as usize];
        for (number, swept) in moves.iter().enumerate() {
            if number % 65536 == 0 && stop() {
                return None;
            }
            grid.for_each_cell(swept, |at, _| {
                entries[next[at] as usize] = number as u32;
                next[at] += 1;
            });
        }
        grid.entries = entries;
        Some(grid)
    }

    /// Calls `each` with every cell that the move crosses and a bound from below of its heights there.
    fn for_each_cell(&self, swept: &Swept, mut each: impl FnMut(usize, f64)) {
        let (a, b) = (swept.start(), swept.end());
        // Cells are widened by a rounding error on all sides.
        let margin = 1e-9 * self.cell;
        let place = |value: f64, axis: usize, count: usize| (((value - self.origin[axis]) / self.cell).max(0.0) as usize).min(count - 1);
        let clip = |low: f64, high: f64, axis: usize, range: (f64, f64)| {
            let (from, step) = (a[axis], b[axis] - a[axis]);
            if step == 0.0 {
                return range;
            }
            let (one, other) = ((low - from) / step, (high - from) / step);
            (range.0.max(one.min(other)), range.1.min(one.max(other)))
        };
        let (first_row, last_row) = (place(a[1].min(b[1]) - margin, 1, self.rows), place(a[1].max(b[1]) + margin, 1, self.rows));
        for row in first_row..=last_row {
            let low = self.origin[1] + row as f64 * self.cell;
            let in_row = if first_row == last_row { (0.0, 1.0) } else { clip(low - margin, low + self.cell + margin, 1, (0.0, 1.0)) };
            let x_at = |t: f64| a[0] + t * (b[0] - a[0]);
            let (x0, x1) = (x_at(in_row.0), x_at(in_row.1));
            let (first, last) = (place(x0.min(x1) - margin, 0, self.columns), place(x0.max(x1) + margin, 0, self.columns));
            for column in first..=last {
                let low = self.origin[0] + column as f64 * self.cell;
                let range = if first == last { in_row } else { clip(low - margin, low + self.cell + margin, 0, in_row) };
                let z_at = |t: f64| a[2] + t * (b[2] - a[2]);
                let lowest = if range.0 <= range.1 { z_at(range.0).min(z_at(range.1)) } else { swept.lowest };
                each(row * self.columns + column, lowest);
            }
        }
    }

    /// The column and row of a place, also outside the grid.
    #[inline]
    pub(super) fn place(&self, x: f64, y: f64) -> (isize, isize) {
        (((x - self.origin[0]) / self.cell).floor() as isize, ((y - self.origin[1]) / self.cell).floor() as isize)
    }

    /// The cells within the distance `radius` of the place along each axis.
    #[inline]
    pub(super) fn around(&self, x: f64, y: f64, radius: f64) -> Cells {
        let (low, high) = (self.place(x - radius, y - radius), self.place(x + radius, y + radius));
        Cells { columns: (low.0.max(0), high.0.min(self.columns as isize - 1)), rows: (low.1.max(0), high.1.min(self.rows as isize - 1)) }
    }

    /// The lowest tip in a cell of the grid, and the distance in plan view of the place from the cell.
    #[inline]
    pub(super) fn bound(&self, column: isize, row: isize, x: f64, y: f64) -> (f64, f64) {
        let lowest = self.lowest[row as usize * self.columns + column as usize];
        let beyond = |value: f64, axis: usize, at: isize| {
            let low = self.origin[axis] + at as f64 * self.cell;
            (low - value).max(value - low - self.cell).max(0.0)
        };
        let (dx, dy) = (beyond(x, 0, column), beyond(y, 1, row));
        (lowest, (dx * dx + dy * dy).sqrt())
    }

    /// For tips in a cell at `lowest` or higher, the least of n.D, with D from the place `at` to the tip, and the distance in plan view of
    /// `at` from the cell.
    #[inline]
    pub(super) fn least_along(&self, column: isize, row: isize, lowest: f64, at: [f64; 3], normal: [f64; 3]) -> (f64, f64) {
        let (mut along, mut distance) = (normal[2] * (lowest - at[2]), 0.0);
        for (axis, place) in [column, row].into_iter().enumerate() {
            let low = self.origin[axis] + place as f64 * self.cell - at[axis];
            let high = low + self.cell;
            along += (normal[axis] * low).min(normal[axis] * high);
            distance += low.max(-high).max(0.0).powi(2);
        }
        (along, distance.sqrt())
    }

    #[inline]
    pub(super) fn moves_in(&self, column: isize, row: isize) -> &[u32] {
        let at = row as usize * self.columns + column as usize;
        &self.entries[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
}

/// The size of cells that hold a few moves each: between a sixteenth of the cutter's radius and the radius, and larger
/// where the grid would need too much memory.
fn cell_size(moves: usize, length: f64, [width, height]: [f64; 2], radius: f64) -> f64 {
    let count = moves as f64;
    // Lines of this length per area and moves per area give cell (cell moves + length) per cell.
    let area = (width.max(radius)) * (height.max(radius));
    let (per_area, line) = (count / area, length / area);
    let ideal = ((line * line + 4.0 * per_area * IN_A_CELL).sqrt() - line) / (2.0 * per_area);
    let most_entries = (MOST_ENTRIES - 4.0 * count).max(0.25 * MOST_ENTRIES);
    ideal
        .clamp(radius / 16.0, radius)
        .max((width * height / MOST_CELLS).sqrt())
        .max(width.max(height) / MOST_CELLS)
        .max(1.3 * length / most_entries)
        .max(1e-6)
}
