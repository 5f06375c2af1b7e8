//! Parts of the plan view: square cells around points.

use std::collections::HashSet;

/// Square cells of the plan view.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    side: f64,
    marked: HashSet<[i64; 2]>,
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

    #[expect(clippy::cast_possible_truncation, reason = "places over sides are under 2^63")]
    fn cell(&self, point: [f64; 2]) -> [i64; 2] {
        point.map(|part| (part / self.side).floor() as i64)
    }

    pub(super) fn contain(&self, point: [f64; 2]) -> bool {
        self.marked.contains(&self.cell(point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_places_far_from_the_origin_are_apart() {
        let cells = Cells::around([[1e6, -1e6]].into_iter(), 1e-6);
        assert!(cells.contain([1e6, -1e6]) && cells.contain([1e6 + 1e-6, -1e6]));
        assert!(!cells.contain([1e6 + 1e-3, -1e6]));
    }
}
