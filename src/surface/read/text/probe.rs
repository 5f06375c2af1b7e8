//! The lines before a grid of probed heights as bCNC writes them: `xmin xmax nx`, `ymin ymax ny`, `zmin zmax feed`, blank
//! lines, and then nx times ny points, the first at (xmin, ymin). These three lines look like points.

use super::super::extremes::CoordinateRange;
use crate::file_fault::{FileFault, FileFaultKind, Flaw};
use crate::surface::Sink;

/// The first points of a table, until it is known whether they are lines before a grid.
#[derive(Debug)]
pub(super) enum Probe {
    Open {
        held: Vec<([f64; 3], u64)>,
        /// Whether a blank line has followed the three lines.
        is_blank: bool,
    },
    /// The table is a grid with this many points, as the line says.
    Grid { points: u64, line: u64 },
    /// The lines are points.
    Points(Vec<([f64; 3], u64)>),
}

/// What a point shows about the lines so far.
pub(super) enum Verdict {
    /// It may be a line before a grid.
    Held,
    /// The lines held are points.
    Points,
    /// The lines held were before a grid, whose first point this is.
    Grid,
}

impl Default for Probe {
    fn default() -> Self {
        Self::Open { held: Vec::new(), is_blank: false }
    }
}

impl Probe {
    pub(super) fn is_open(&self) -> bool {
        matches!(self, Self::Open { .. })
    }

    /// Notes a blank line.
    pub(super) fn blank(&mut self) {
        if let Self::Open { held, is_blank } = self {
            *is_blank |= held.len() == 3;
        }
    }

    /// Adds a point while the table is open.
    pub(super) fn add(&mut self, point: [f64; 3], line: u64) -> Verdict {
        let Self::Open { held, is_blank } = self else { return Verdict::Points };
        if held.len() < 3 {
            held.push((point, line));
            return Verdict::Held;
        }
        let promised = grid(held, point).filter(|_| *is_blank);
        let line = held[0].1;
        let held = std::mem::take(held);
        if let Some(points) = promised {
            *self = Self::Grid { points, line };
            Verdict::Grid
        } else {
            *self = Self::Points(held);
            Verdict::Points
        }
    }

    /// Passes on the points that were held.
    pub(super) fn flush(&mut self, points: &mut u64, extremes: &mut CoordinateRange, sink: &mut dyn Sink) {
        if let Self::Open { held, .. } | Self::Points(held) = self {
            for (point, line) in held.drain(..) {
                *points += 1;
                extremes.add(point, line);
                sink.point(point);
            }
        }
    }

    /// The fault of a grid with another number of points than promised.
    pub(super) fn flaw(&self, points: u64) -> Option<FileFault> {
        let Self::Grid { points: promised, line } = *self else { return None };
        (points != promised).then(|| {
            let expected = format!("{promised} points of a grid, as the lines before it promise");
            Flaw::new(FileFaultKind::Truncated, expected, format!("{points}")).at_line(line)
        })
    }
}

/// The number of points that the three lines before a grid promise, if its first point is `first`.
#[expect(clippy::float_cmp, reason = "the file repeats the numbers")]
fn grid(lines: &[([f64; 3], u64)], first: [f64; 3]) -> Option<u64> {
    let [([x_min, x_max, columns], _), ([y_min, y_max, rows], _), _] = lines else { return None };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be whole and small")]
    let count = |number: f64| (number.fract() == 0.0 && (2.0..=1e6).contains(&number)).then_some(number as u64);
    let is_grid = x_min < x_max && y_min < y_max && first[0] == *x_min && first[1] == *y_min;
    Some(count(*columns)? * count(*rows)?).filter(|_| is_grid)
}
