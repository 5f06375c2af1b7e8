//! The lines of a plan, whole or in part.

use super::family::{Family, Heading};

/// Lines of a family in order, and where they are cut.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CutLines {
    /// The number of each line in its family: the distance across of planes, the height of levels.
    pub(super) at: Vec<f64>,
    /// Which parts of planes are cut; `None` for all.
    parts: Option<Parts>,
}

#[derive(Debug, Clone, PartialEq)]
struct Parts {
    columns: Columns,
    /// For each column whether each line is cut there.
    is_cut: Vec<Vec<bool>>,
}

/// Columns of equal width across the lines of a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Columns {
    pub(super) heading: Heading,
    first: f64,
    width: f64,
    pub(super) count: usize,
}

impl Columns {
    /// Columns about `width` mm wide over the places at these distances along some lines.
    pub(super) fn over(heading: Heading, along: impl Iterator<Item = f64>, width: f64, lines: usize) -> Self {
        let (first, last) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), along| (low.min(along), high.max(along)));
        let length = (last - first).max(0.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count, which saturates")]
        let count = ((length / width).ceil() as usize).clamp(1, (MOST_CELLS / lines.max(1)).max(1));
        #[expect(clippy::cast_precision_loss, reason = "thousands")]
        let width = (length / count as f64).max(f64::MIN_POSITIVE);
        Self { heading, first, width, count }
    }

    /// The column of a distance along the lines; the outermost ones go on outwards.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the columns")]
    pub(super) fn at(&self, along: f64) -> usize {
        (((along - self.first) / self.width).max(0.0) as usize).min(self.count - 1)
    }

    /// A column and those beside it.
    pub(super) fn around(&self, column: usize) -> std::ops::RangeInclusive<usize> {
        column.saturating_sub(1)..=(column + 1).min(self.count - 1)
    }

    /// Where a column begins along the lines.
    #[expect(clippy::cast_precision_loss, reason = "thousands")]
    fn begin(&self, column: usize) -> f64 {
        match column {
            0 => f64::NEG_INFINITY,
            _ if column == self.count => f64::INFINITY,
            _ => self.first + column as f64 * self.width,
        }
    }
}

/// The distance in mm from a line up to which a tip is on it.
const SAME: f64 = 1e-6;

/// The most cells of columns and lines, a byte each. Where there are more, columns are wider.
const MOST_CELLS: usize = 4_000_000;

impl CutLines {
    pub(super) fn whole(at: Vec<f64>) -> Self {
        Self { at, parts: None }
    }

    /// Lines that are cut in some columns each: `is_cut` by column and line. Gaps between them under `shortest` mm are cut too.
    pub(super) fn in_part(at: Vec<f64>, columns: Columns, mut is_cut: Vec<Vec<bool>>, shortest: f64) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "thousands")]
        let length = |columns_between: usize| columns_between as f64 * columns.width;
        for line in 0..at.len() {
            let mut last: Option<usize> = None;
            for column in 0..columns.count {
                if is_cut[column][line] {
                    if let Some(last) = last.filter(|last| length(column - last - 1) < shortest) {
                        is_cut[last + 1..column].iter_mut().for_each(|is_cut| is_cut[line] = true);
                    }
                    last = Some(column);
                }
            }
        }
        Self { at, parts: Some(Parts { columns, is_cut }) }
    }

    /// The number of lines that are cut anywhere.
    pub(super) fn count(&self) -> usize {
        match &self.parts {
            None => self.at.len(),
            Some(parts) => (0..self.at.len()).filter(|line| parts.is_cut.iter().any(|is_cut| is_cut[*line])).count(),
        }
    }

    /// The stretches along a line over which it is cut.
    pub(super) fn stretches(&self, line: usize) -> Vec<[f64; 2]> {
        let Some(Parts { columns, is_cut }) = &self.parts else { return vec![[f64::NEG_INFINITY, f64::INFINITY]] };
        let (mut stretches, mut begin) = (Vec::new(), None);
        for column in 0..=columns.count {
            match (begin, is_cut.get(column).is_some_and(|is_cut| is_cut[line])) {
                (None, true) => begin = Some(column),
                (Some(first), false) => {
                    stretches.push([first, column].map(|column| columns.begin(column)));
                    begin = None;
                }
                _ => {}
            }
        }
        stretches
    }

    /// The distances between neighbouring lines where they are cut.
    pub(super) fn spacings(&self) -> Vec<f64> {
        let gaps = |lines: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            let mut last: Option<f64> = None;
            lines.filter_map(|line| last.replace(line).map(|last| line - last)).collect()
        };
        match &self.parts {
            None => gaps(&mut self.at.iter().copied()),
            Some(parts) => {
                let of_column =
                    |is_cut: &Vec<bool>| gaps(&mut self.at.iter().zip(is_cut).filter(|(_, is_cut)| **is_cut).map(|(at, _)| *at));
                parts.is_cut.iter().flat_map(of_column).collect()
            }
        }
    }

    /// The distance from a tip to the farther of the lines beside it that are cut there; that to the border is not known, and counts
    /// as 0.
    pub(super) fn farther_neighbour(&self, family: &Family, tip: [f64; 3]) -> f64 {
        let number = family.number(tip);
        let (own, above) = (self.at.partition_point(|line| *line < number - SAME), self.at.partition_point(|line| *line <= number + SAME));
        let column = self.parts.as_ref().map(|Parts { columns, is_cut }| {
            let at = columns.at(columns.heading.of_point([tip[0], tip[1]])[0]);
            // A run ends at the border of its last column, where the next one begins.
            let of_run = std::iter::once(at).chain(columns.around(at)).find(|column| is_cut[*column][own..above].contains(&true));
            &is_cut[of_run.unwrap_or(at)]
        });
        let is_cut = |line: &usize| column.is_none_or(|is_cut| is_cut[*line]);
        let distance = |line: Option<usize>| line.map_or(0.0, |line| (self.at[line] - number).abs());
        distance((0..own).rev().find(is_cut)).max(distance((above..self.at.len()).find(is_cut)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three lines 1 mm apart along X, over six columns 2 mm wide; the middle one is cut in the columns 0, 2, 5.
    fn lines(shortest: f64) -> CutLines {
        let columns = Columns::over(Heading::of(0.0), [0.0, 12.0].into_iter(), 2.0, 3);
        let is_cut = [0, 1, 2, 3, 4, 5].map(|column| vec![true, [0, 2, 5].contains(&column), true]);
        CutLines::in_part(vec![0.0, 1.0, 2.0], columns, is_cut.to_vec(), shortest)
    }

    #[test]
    fn short_gaps_are_cut_and_the_outermost_stretches_go_on() {
        let ends = |shortest: f64| lines(shortest).stretches(1);
        assert_eq!(ends(1.0), [[f64::NEG_INFINITY, 2.0], [4.0, 6.0], [10.0, f64::INFINITY]]);
        assert_eq!(ends(3.0), [[f64::NEG_INFINITY, 6.0], [10.0, f64::INFINITY]]);
        assert_eq!(ends(5.0), [[f64::NEG_INFINITY, f64::INFINITY]]);
        assert_eq!(CutLines::whole(vec![0.0, 1.0, 2.0]).stretches(1), [[f64::NEG_INFINITY, f64::INFINITY]]);
    }

    #[test]
    fn neighbours_are_those_that_are_cut_beside_a_place() {
        let (lines, family) = (lines(3.0), Family::Planes(Heading::of(0.0)));
        let farther = |x: f64, y: f64| lines.farther_neighbour(&family, [x, y, 0.0]);
        // The middle line is cut up to 6 mm.
        for (x, y, distance) in [(1.0, 0.0, 1.0), (7.0, 0.0, 2.0), (7.0, 2.0, 2.0), (11.0, 2.0, 1.0)] {
            assert!((farther(x, y) - distance).abs() < 1e-12, "{x}, {y}");
        }
        // The ends of its stretches count to them.
        for x in [6.0, 10.0] {
            assert!((farther(x, 1.0) - 1.0).abs() < 1e-12, "{x}");
        }
        // Of a tip between two lines, those are the neighbours.
        assert!((farther(1.0, 1.25) - 0.75).abs() < 1e-12);
        assert!((farther(7.0, 1.25) - 1.25).abs() < 1e-12);
        // Two columns have the outer lines alone, four have all three.
        assert_eq!(lines.spacings().len(), 2 + 4 * 2);
        assert!(CutLines::whole(vec![3.0]).farther_neighbour(&family, [0.0, 3.0, 0.0]).abs() < 1e-12);
    }
}
