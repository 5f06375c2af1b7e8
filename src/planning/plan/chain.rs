//! Chains of tips along a curve, of which some stretches are cut.

use super::runs::{Run, RunTip};
use super::travel;
use crate::path::Contour;

/// The tips along a curve. A closed one does not repeat its first tip.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    pub(super) tips: Vec<RunTip>,
    pub(super) closed: bool,
}

/// Points along a contour at most `apart` mm apart.
pub(super) fn points_along(contour: &Contour, apart: f64) -> Vec<[f64; 3]> {
    let ends = contour.tips.iter().zip(contour.tips.iter().skip(1).chain(contour.tips.first().filter(|_| contour.closed)));
    let mut points: Vec<[f64; 3]> = Vec::new();
    for (from, to) in ends.map(|(from, to)| (from.position, to.position)) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of parts")]
        let parts = ((travel::distance(from, to) / apart).ceil().max(1.0)) as u32;
        points.extend((0..parts).map(|part| {
            let share = f64::from(part) / f64::from(parts);
            [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        }));
    }
    points.extend(contour.tips.last().filter(|_| !contour.closed).map(|last| last.position));
    points
}

impl Chain {
    /// The runs over the tips that are wanted, joined over gaps up to `gap` mm along the chain. `line` is the position of their
    /// line.
    pub(super) fn runs(&self, mut wanted: Vec<bool>, gap: f64, line: Option<usize>) -> Vec<Run> {
        let count = self.tips.len();
        let Some(first) = wanted.iter().position(|wanted| *wanted) else { return Vec::new() };
        // Gaps are closed along the chain, a closed one from its first wanted tip all around.
        let around: Vec<usize> = if self.closed { (first..count).chain(0..first).collect() } else { (0..count).collect() };
        let mut open: Vec<usize> = Vec::new();
        let mut length = 0.0;
        let mut last: Option<usize> = None;
        for &index in around.iter().chain(self.closed.then_some(&first)) {
            length += last.map_or(0.0, |last| travel::distance(self.tips[last].tip, self.tips[index].tip));
            if wanted[index] {
                if length <= gap {
                    for between in &open {
                        wanted[*between] = true;
                    }
                }
                open.clear();
                length = 0.0;
            } else {
                open.push(index);
            }
            last = Some(index);
        }
        let run = |tips: Vec<RunTip>, closed| Run::along_curve(line, tips, closed);
        if self.closed && wanted.iter().all(|wanted| *wanted) {
            return vec![run(self.tips.clone(), true)];
        }
        let start = if self.closed { around.iter().position(|index| !wanted[*index]).unwrap_or(0) } else { 0 };
        let turned: Vec<usize> = around[start..].iter().chain(&around[..start]).copied().collect();
        let stretches = turned.split(|index| !wanted[*index]).filter(|stretch| stretch.len() > 1);
        stretches.map(|stretch| run(stretch.iter().map(|index| self.tips[*index]).collect(), false)).collect()
    }
}
