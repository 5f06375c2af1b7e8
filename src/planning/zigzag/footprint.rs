//! Where the surface is, seen from above: the ends of runs on sampled facets.
//!
//! A sample of facets shows how long the cuts of a plane are and how fast, but not where they end: the facet at the
//! border is mostly not in it. Runs that end at the wrong place, or are interrupted by gaps of the sample, have wrong
//! links.

use super::heading::Heading;
use crate::numerics::raster::Frame;

/// The number of cells along the longer side. The ends of runs are uncertain by half a cell.
const SIDE: u32 = 256;

/// The largest number of rows and cells that facets may cover in all. If many facets each cover the whole part, the cells
/// become larger.
const VISITS: f64 = 2e7;

/// The number of facets between two checks for cancellation.
const TURN: usize = 8192;

/// The height of the surface at the centres of cells.
#[derive(Debug)]
pub(super) struct Footprint {
    frame: Frame,
    /// The largest height in each cell; minus infinity where there is no surface.
    heights: Vec<f32>,
}

/// A part of a line that the surface covers: its two ends, each with the coordinate along the line and the height.
pub(super) type CoveredPart = [[f64; 2]; 2];

/// The parts of parallel lines that the surface covers. The lines are a cell apart.
#[derive(Debug)]
pub(super) struct Outline {
    /// The coordinate of the first line across the passes.
    first: f64,
    apart: f64,
    parts: Vec<CoveredPart>,
    /// The end of each line's parts.
    ends: Vec<usize>,
}

impl Footprint {
    /// The footprint of facets, given by their corners. Once `stop` returns true, it returns early, and the result must be discarded.
    pub(super) fn new(facets: &[[[f64; 3]; 3]], stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut area, mut extent) = (0.0, 0.0);
        for corners in facets {
            for [x, y, _] in corners {
                (low, high) = ([low[0].min(*x), low[1].min(*y)], [high[0].max(*x), high[1].max(*y)]);
            }
            let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = *corners;
            area += ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay)).abs() / 2.0;
            extent += ay.max(by).max(cy) - ay.min(by).min(cy);
        }
        let stated = (high[0] - low[0]).max(high[1] - low[1]) / f64::from(SIDE);
        let frame = Frame::covering(low, high, stated.max(Frame::affordable_cell(area, extent, VISITS)).max(f64::MIN_POSITIVE));
        let mut heights = vec![f32::NEG_INFINITY; frame.cells()];
        for corners in facets.chunks(TURN).take_while(|_| !stop()).flatten() {
            frame.scan(*corners, 0..frame.rows, |cell, height, _| {
                #[expect(clippy::cast_possible_truncation, reason = "heights of links need few digits")]
                let height = height as f32;
                heights[cell] = heights[cell].max(height);
            });
        }
        Self { frame, heights }
    }

    /// The side of a cell, within which ends are uncertain.
    pub(super) fn cell(&self) -> f64 {
        self.frame.cell
    }

    /// The parts of lines in a direction that the surface covers.
    pub(super) fn outline(&self, heading: Heading) -> Outline {
        let Frame { origin, cell, columns, rows } = self.frame;
        #[expect(clippy::cast_precision_loss, reason = "at most 256 cells")]
        let size = [columns as f64 * cell, rows as f64 * cell];
        let corners = [[0.0, 0.0], [size[0], 0.0], [0.0, size[1]], size].map(|[x, y]| [origin[0] + x, origin[1] + y]);
        let across = corners.map(|[x, y]| heading.across(x, y));
        let (low, high) = across.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let first = low + cell / 2.0;
        let mut outline = Outline { first, apart: cell, parts: Vec::new(), ends: Vec::new() };
        // As far apart as the frame's corners: at most 256 cells along each side.
        let lines = (0..2 * SIDE).map(|line| first + f64::from(line) * cell).take_while(|at| *at < high);
        for at in lines {
            self.add_parts(heading, at, &mut outline.parts);
            outline.ends.push(outline.parts.len());
        }
        outline
    }

    /// Adds the covered parts of the line at `at`, whose points are compared at distances of a cell.
    fn add_parts(&self, heading: Heading, at: f64, parts: &mut Vec<CoveredPart>) {
        let Frame { origin, cell, columns, rows } = self.frame;
        let [e, n] = heading.e;
        // The point at 0 along the line, and its steps, in cells.
        let start = [(-n * at - origin[0]) / cell, (e * at - origin[1]) / cell];
        #[expect(clippy::cast_precision_loss, reason = "at most 256 cells")]
        let sides = [columns as f64, rows as f64];
        // The interval along the line, in cells, within the frame.
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        for (axis, step) in [e, n].into_iter().enumerate() {
            let ends = [-start[axis] / step, (sides[axis] - start[axis]) / step];
            if step != 0.0 {
                (from, to) = (from.max(ends[0].min(ends[1])), to.min(ends[0].max(ends[1])));
            } else if !(0.0..=sides[axis]).contains(&start[axis]) {
                return;
            }
        }
        let mut open: Option<CoveredPart> = None;
        let mut along = from + 0.5;
        while along < to {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the frame, up to rounding")]
            let [column, row] = [(start[0] + along * e) as usize, (start[1] + along * n) as usize];
            let height = f64::from(self.heights[row.min(rows - 1) * columns + column.min(columns - 1)]);
            if height.is_finite() {
                let end = [(along + 0.5) * cell, height];
                match &mut open {
                    Some(part) => part[1] = end,
                    None => open = Some([[(along - 0.5) * cell, height], end]),
                }
            } else {
                parts.extend(open.take());
            }
            along += 1.0;
        }
        parts.extend(open);
    }
}

impl Outline {
    /// The covered parts of the line that is nearest to a coordinate across the passes.
    pub(super) fn parts(&self, at: f64) -> &[CoveredPart] {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
        let line = (((at - self.first) / self.apart).round().max(0.0) as usize).min(self.ends.len().saturating_sub(1));
        let start = line.checked_sub(1).map_or(0, |before| self.ends[before]);
        self.ends.get(line).map_or(&[], |&end| &self.parts[start..end])
    }
}

#[cfg(test)]
mod tests {
    use super::super::workpiece::Workpiece;
    use super::*;
    use crate::quantity::Angle;
    use crate::surface::FinishFacet;
    use approx::assert_abs_diff_eq;

    /// A plane z = x/2 over two rectangles: x from 0 to 40 and from 60 to 100, y from 0 to 30, in squares of 2 mm.
    fn two_rectangles() -> Workpiece {
        let point = |x: f64, y: f64| [x, y, x / 2.0];
        let length = 1.25_f64.sqrt();
        let facet = |corners: [[f64; 3]; 3]| FinishFacet {
            corners,
            area: 2.0 * length,
            normal: [-0.5 / length, 0.0, 1.0 / length],
            curvature: [0.0; 6],
        };
        let mut facets = Vec::new();
        for column in (0..50).filter(|column| !(20..30).contains(column)) {
            for row in 0..15 {
                let (x, y) = (2.0 * f64::from(column), 2.0 * f64::from(row));
                facets.push(facet([point(x, y), point(x + 2.0, y), point(x + 2.0, y + 2.0)]));
                facets.push(facet([point(x, y), point(x + 2.0, y + 2.0), point(x, y + 2.0)]));
            }
        }
        Workpiece::new(&facets, 0.1, &|| false)
    }

    #[test]
    fn the_outline_has_the_ends_of_the_surface_along_any_direction() {
        let workpiece = two_rectangles();
        let footprint = Footprint::new(&workpiece.corners, &|| false);
        let cell = footprint.cell();
        assert_abs_diff_eq!(cell, 100.0 / 256.0, epsilon = 1e-12);
        for (degrees, at, ends) in [
            (0.0, 0.0, vec![[-50.0, -10.0], [10.0, 50.0]]),
            (180.0, 3.0, vec![[-50.0, -10.0], [10.0, 50.0]]),
            // x from 10 to 50 lies at -x across passes along y.
            (90.0, -30.0, vec![[-15.0, 15.0]]),
            (90.0, 0.0, vec![]),
            // The diagonal y = x - 30 from (15, -15) to (45, 15).
            (45.0, -30.0 * 0.5_f64.sqrt(), vec![[0.0, 60.0 * 0.5_f64.sqrt()]]),
        ] {
            let heading = Heading::new(Angle::from_degrees(degrees).unwrap());
            let outline = footprint.outline(heading);
            let parts = outline.parts(at);
            assert_eq!(parts.len(), ends.len(), "{degrees} {parts:?}");
            for (part, ends) in parts.iter().zip(ends) {
                for (part, end) in part.iter().zip(ends) {
                    assert_abs_diff_eq!(part[0], end, epsilon = 1.5 * cell);
                    let x = end * heading.e[0] - at * heading.e[1];
                    assert_abs_diff_eq!(part[1], x / 2.0, epsilon = cell);
                }
            }
        }
    }
}
