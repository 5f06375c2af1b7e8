//! The height at which a cutter rests on a surface, found without evaluating every cell below it.

use super::profile;
use crate::milling::Cutter;
use crate::numerics::raster::Frame;
use crate::surface::mesh::ViewFromAbove;

/// The heights of a view from above, and the maximum of each block of 2 x 2, 4 x 4, ... cells.
///
/// A block is skipped with all its cells if the cutter, resting on the block's highest point, would be lower than on a
/// cell already found.
#[derive(Debug, Clone)]
pub struct RestingHeights {
    frame: Frame,
    /// The reference height in mm: stored heights are relative to it.
    level: f64,
    /// The cells, then blocks of twice the side each, up to a single block.
    blocks: Vec<Blocks>,
}

/// The highest point of each block of one size, row by row; minus infinity where there is no surface.
#[derive(Debug, Clone)]
struct Blocks {
    columns: usize,
    rows: usize,
    heights: Vec<f32>,
}

impl RestingHeights {
    /// Takes the heights of a view in single precision, which rounds them by up to 6e-8 of the surface's height.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "heights in single precision; the rounding is documented")]
    pub fn new(view: &ViewFromAbove) -> Self {
        let seen = || view.heights.iter().copied().filter(|z| z.is_finite());
        let (low, high) = seen().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        let level = if low <= high { f64::midpoint(low, high) } else { 0.0 };
        let cells = Blocks {
            columns: view.frame.columns,
            rows: view.frame.rows,
            heights: view.heights.iter().map(|z| (z - level) as f32).collect(),
        };
        let mut blocks = vec![cells];
        while let Some(last) = blocks.last().filter(|last| last.heights.len() > 1) {
            let next = last.merged();
            blocks.push(next);
        }
        Self { frame: view.frame, level, blocks }
    }

    /// The reference height in mm of [`RestingHeights::cells`].
    pub(super) fn level(&self) -> f64 {
        self.level
    }

    /// The height of each cell over [`RestingHeights::level`]; minus infinity where there is no surface.
    pub(super) fn cells(&self) -> &[f32] {
        &self.blocks[0].heights
    }

    /// The lowest height in mm to which a tip at `tip` must be raised so that the cutter does not cut into the surface: t(x,
    /// y), or the tip's own height if that is higher or there is no surface under the cutter. The nearer the tip is to
    /// that height, the fewer cells are evaluated.
    ///
    /// On a smooth surface t is too low by up to e^2/(2 r cos^3 S), on a level plane it is exact. Near a sharp edge it is
    /// too low by the change of p over half a cell.
    #[must_use]
    pub fn raised(&self, cutter: Cutter, [x, y, z]: [f64; 3]) -> f64 {
        z.max(self.highest(cutter, [x, y], z - self.level) + self.level)
    }

    /// The greater of `least` and max z(x + u) - p(|u|) over the cells, both relative to the reference height.
    #[expect(clippy::cast_precision_loss, reason = "counts of cells are far under 2^53")]
    fn highest(&self, cutter: Cutter, [x, y]: [f64; 2], least: f64) -> f64 {
        let (radius, cell) = (cutter.outer_radius().mm(), self.frame.cell);
        let [u, v, _] = self.frame.in_cells([x, y, 0.0]);
        // The height at which the cutter would rest on the highest point of a block, if that were at the block's nearest
        // cell; minus infinity beside the cutter.
        let bound = |size: usize, column: usize, row: usize| {
            let side = (1_usize << size) as f64;
            // The distance of the nearest cell centre of the block along one axis, in cells.
            let apart = |first: usize, at: f64| {
                let first = first as f64 * side;
                (first - at).max(at - (first + side - 1.0)).max(0.0)
            };
            // The offsets are far from overflow, and a square root is faster than hypot.
            let [across, along] = [apart(column, u), apart(row, v)];
            let d = cell * (across * across + along * along).sqrt();
            let blocks = &self.blocks[size];
            let z = f64::from(blocks.heights[row * blocks.columns + column]);
            if d > radius || z <= least { f64::NEG_INFINITY } else { z - profile(cutter, d) }
        };
        let mut highest = least;
        let mut open = Vec::with_capacity(4 * self.blocks.len());
        open.push((f64::INFINITY, self.blocks.len() - 1, 0, 0));
        while let Some((most, size, column, row)) = open.pop() {
            if most <= highest {
                continue;
            }
            let Some(smaller) = size.checked_sub(1) else {
                // A cell alone is its own bound.
                highest = if most.is_finite() { most } else { bound(size, column, row).max(highest) };
                continue;
            };
            let cells = &self.blocks[smaller];
            let first = open.len();
            for row in 2 * row..(2 * row + 2).min(cells.rows) {
                for column in 2 * column..(2 * column + 2).min(cells.columns) {
                    let bound = bound(smaller, column, row);
                    if bound > highest {
                        open.push((bound, smaller, column, row));
                    }
                }
            }
            // The block with the largest bound is next, so that more of the others can be skipped.
            open[first..].sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
        }
        highest
    }
}

impl Blocks {
    /// The blocks of twice the side.
    fn merged(&self) -> Self {
        let (columns, rows) = (self.columns.div_ceil(2), self.rows.div_ceil(2));
        let mut heights = vec![f32::NEG_INFINITY; columns * rows];
        for (row, of_row) in self.heights.chunks_exact(self.columns).enumerate() {
            let out = &mut heights[row / 2 * columns..(row / 2 + 1) * columns];
            for (column, &z) in of_row.iter().enumerate() {
                let highest = &mut out[column / 2];
                *highest = if z > *highest { z } else { *highest };
            }
        }
        Self { columns, rows, heights }
    }
}
