//! The raster of a surface dilated and eroded with a cutter's profile: the heights of the tip, and those that it leaves.
//! Only every second, third, ... cell is used for a cutter that is large compared with the cells.

use super::{ReachMap, profile};
use crate::milling::Cutter;
use crate::numerics::raster::Frame;

/// The largest product of the number of cells, including those around the surface, and the number of offsets in the
/// disc: about 10 ms for each cutter. A cutter with a larger product is evaluated on every second, third, ... cell. A
/// surface of 100 x 80 mm on 256 cells is evaluated on all cells for discs of up to 6.5 mm.
const WORK: f64 = 6e7;

/// The smallest stride from cell to cell at which the work for a cutter of this radius, in mm, is at most [`WORK`].
#[expect(clippy::cast_precision_loss, reason = "strides are under 2^53")]
pub(super) fn stride(frame: Frame, radius: f64) -> usize {
    let work = |stride: usize| {
        let stride = stride as f64;
        let offset = (radius / (frame.cell * stride)).floor();
        let (columns, rows) = ((frame.columns as f64 / stride).ceil() + 2.0 * offset, (frame.rows as f64 / stride).ceil() + 2.0 * offset);
        columns * rows * (std::f64::consts::PI * offset * offset).max(1.0)
    };
    // The work falls with the stride. With a stride as long as the surface, only one cell is left, which takes no work.
    let most = frame.columns.max(frame.rows);
    let (mut least, mut enough) = (1_usize, 1_usize);
    while enough < most && work(enough) > WORK {
        (least, enough) = (enough, (2 * enough).min(most));
    }
    while least < enough {
        let middle = least.midpoint(enough);
        if work(middle) > WORK { least = middle + 1 } else { enough = middle }
    }
    least
}

/// The surface on every stride-th cell, with a border of empty cells: `pad` cells for the tips outside the surface, and
/// `pad` more for the cells that these would touch.
pub(super) struct Coarse {
    pub(super) cell: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) pad: usize,
    /// Cells in a row: columns + 4 pad.
    width: usize,
    heights: Vec<f32>,
}

/// p at the offsets of a quarter of the disc, in cells.
pub(super) struct Disc {
    /// For each offset along y, beginning with 0: p at the offsets along x, beginning with 0.
    rows: Vec<Vec<f32>>,
    cell: f64,
}

impl Disc {
    #[expect(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "single precision; its rounding is part of the error")]
    pub(super) fn new(cutter: Cutter, cell: f64, pad: usize) -> Self {
        let radius = cutter.outer_radius().mm();
        let along = |dy: usize| {
            let distances = (0..=pad).map(|dx| cell * (dx as f64).hypot(dy as f64));
            distances.take_while(|&d| d <= radius).map(|d| profile(cutter, d) as f32).collect::<Vec<f32>>()
        };
        Self { rows: (0..=pad).map(along).take_while(|row| !row.is_empty()).collect(), cell }
    }

    /// All offsets of the disc, in a raster whose rows are `width` cells.
    #[expect(clippy::cast_precision_loss, reason = "offsets are bounded by the work")]
    fn offsets(&self, width: usize) -> Vec<Offset> {
        let width = width.cast_signed();
        let mut offsets = Vec::new();
        for (dy, profile) in self.rows.iter().enumerate() {
            for (dx, &p) in profile.iter().enumerate() {
                let d = self.cell * (dx as f64).hypot(dy as f64);
                let (dx, dy) = (dx.cast_signed(), dy.cast_signed());
                offsets.extend([dy * width + dx, dy * width - dx, dx - dy * width, -dx - dy * width].map(|step| Offset { step, p, d }));
            }
        }
        offsets
    }
}

/// A cell of the disc: its offset in memory, p there, and its distance from the axis in mm.
struct Offset {
    step: isize,
    p: f32,
    d: f64,
}

impl Coarse {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "offsets are bounded by the work"
    )]
    pub(super) fn of(map: &ReachMap, stride: usize, radius: f64) -> Self {
        let (columns, rows) = (map.frame.columns.div_ceil(stride), map.frame.rows.div_ceil(stride));
        let cell = map.frame.cell * stride as f64;
        // A single cell is the contact and needs no border.
        let pad = if columns == 1 && rows == 1 { 0 } else { (radius / cell).floor() as usize };
        let width = columns + 4 * pad;
        let mut heights = vec![f32::NEG_INFINITY; width * (rows + 4 * pad)];
        for row in 0..rows {
            for column in 0..columns {
                heights[(row + 2 * pad) * width + column + 2 * pad] = map.heights.cells()[map.frame.index(column * stride, row * stride)];
            }
        }
        Self { cell, columns, rows, pad, width, heights }
    }

    /// t at all cells of the surface and `pad` cells around it, in the same layout as the heights.
    pub(super) fn tips(&self, disc: &Disc) -> Vec<f32> {
        let mut tips = vec![f32::NEG_INFINITY; self.heights.len()];
        let mut pairs = vec![0.0; self.width];
        for row in self.pad..self.rows + 3 * self.pad {
            let out = row * self.width + self.pad..(row + 1) * self.width - self.pad;
            for (dy, profile) in disc.rows.iter().enumerate() {
                greater_of_each(&mut pairs, self.row(&self.heights, row + dy), self.row(&self.heights, row - dy));
                for (dx, &p) in profile.iter().enumerate() {
                    rest_on(&mut tips[out.clone()], &pairs, self.pad + dx, self.pad - dx, p);
                }
            }
        }
        tips
    }

    /// m at the cells of the surface, row by row. Computed as -(max of -t - p), the same operation as for the tips.
    pub(super) fn cut(&self, tips: &[f32], disc: &Disc) -> Vec<f32> {
        let upside_down: Vec<f32> = tips.iter().map(|t| -t).collect();
        let mut cut = vec![f32::NEG_INFINITY; self.columns * self.rows];
        let mut pairs = vec![0.0; self.width];
        for (row, out) in cut.chunks_exact_mut(self.columns).enumerate() {
            let row = row + 2 * self.pad;
            for (dy, profile) in disc.rows.iter().enumerate() {
                greater_of_each(&mut pairs, self.row(&upside_down, row + dy), self.row(&upside_down, row - dy));
                for (dx, &p) in profile.iter().enumerate() {
                    rest_on(out, &pairs, 2 * self.pad + dx, 2 * self.pad - dx, p);
                }
            }
            for value in out {
                *value = -*value;
            }
        }
        cut
    }

    fn row<'a>(&self, values: &'a [f32], row: usize) -> &'a [f32] {
        &values[row * self.width..(row + 1) * self.width]
    }

    /// The distance of the contact from the axis, for the tip that cuts deepest at a cell.
    pub(super) fn rest(&self, cell: usize, tips: &[f32], disc: &Disc) -> f64 {
        let place = (cell / self.columns + 2 * self.pad) * self.width + cell % self.columns + 2 * self.pad;
        let offsets = disc.offsets(self.width);
        // The sums stay inside the padded rows: tips are within `pad` of the surface, and the cells that they touch
        // within `pad` of the tips.
        let at = |place: usize, step: isize| place.wrapping_add_signed(step);
        let cuts = offsets.iter().map(|offset| (at(place, offset.step), tips[at(place, offset.step)] + offset.p));
        let Some((tip, _)) = cuts.min_by(|a, b| a.1.total_cmp(&b.1)) else { return 0.0 };
        let contacts = offsets.iter().map(|offset| (offset.d, self.heights[at(tip, offset.step)] - offset.p));
        contacts.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |(d, _)| d)
    }
}

/// The greater of two numbers at each index. A comparison is one vector instruction; `f32::max` also tests for NaN.
fn greater_of_each(out: &mut [f32], a: &[f32], b: &[f32]) {
    for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
        *out = if a > b { a } else { b };
    }
}

/// out[i] = max(out[i], max(values[i + right], values[i + left]) - p)
fn rest_on(out: &mut [f32], values: &[f32], right: usize, left: usize, p: f32) {
    let count = out.len();
    let (right, left) = (&values[right..right + count], &values[left..left + count]);
    for ((out, &a), &b) in out.iter_mut().zip(right).zip(left) {
        let higher = (if a > b { a } else { b }) - p;
        *out = if *out > higher { *out } else { higher };
    }
}
