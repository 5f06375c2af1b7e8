//! Parts of the plan view: square cells around points.

use std::collections::HashSet;

/// Square cells of the plan view.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    side: f64,
    marked: HashSet<[i32; 2]>,
}

impl Cells {
    /// The cells of points, and those around them.
    pub(super) fn around(points: impl Iterator<Item = [f64; 2]>, side: f64) -> Self {
        let mut cells = Self { side, marked: HashSet::new() };
        for [x, y] in points.map(|point| cells.cell(point)).collect::<HashSet<_>>() {
            cells.marked.extend((-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy])));
        }
        cells
    }

    #[expect(clippy::cast_possible_truncation, reason = "extents over sides are under 2^31")]
    fn cell(&self, point: [f64; 2]) -> [i32; 2] {
        point.map(|part| (part / self.side).floor() as i32)
    }

    pub(super) fn contain(&self, point: [f64; 2]) -> bool {
        self.marked.contains(&self.cell(point))
    }
}
