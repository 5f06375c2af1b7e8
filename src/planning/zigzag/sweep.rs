//! The facets of a workpiece in the order in which planes of one direction meet them.

use super::workpiece::Workpiece;
use crate::quantity::Angle;

/// A direction of passes: e along the passes, q across them to the left, both seen from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heading {
    pub(super) e: [f64; 2],
}

impl Heading {
    pub(super) fn new(direction: Angle) -> Self {
        Self { e: [direction.cos(), direction.sin()] }
    }

    /// The coordinate along the passes.
    pub(super) fn along(&self, x: f64, y: f64) -> f64 {
        self.e[0] * x + self.e[1] * y
    }

    /// The coordinate across the passes.
    pub(super) fn across(&self, x: f64, y: f64) -> f64 {
        self.e[0] * y - self.e[1] * x
    }
}

/// A facet and the stretch across the passes that it covers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Covered {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) facet: u32,
}

/// The facets in rising order of where they begin across the passes.
#[derive(Debug)]
pub(super) struct Sweep {
    pub(super) heading: Heading,
    pub(super) covered: Vec<Covered>,
    /// The least and largest coordinate along the passes.
    pub(super) along: [f64; 2],
}

impl Sweep {
    pub(super) fn new(workpiece: &Workpiece, direction: Angle) -> Self {
        let heading = Heading::new(direction);
        let mut along = [f64::INFINITY, f64::NEG_INFINITY];
        let mut across = [f64::INFINITY, f64::NEG_INFINITY];
        let unordered: Vec<Covered> = (0_u32..)
            .zip(&workpiece.corners)
            .map(|(facet, corners)| {
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for &[x, y, _] in corners {
                    let (p, q) = (heading.along(x, y), heading.across(x, y));
                    along = [along[0].min(p), along[1].max(p)];
                    (low, high) = (low.min(q), high.max(q));
                }
                across = [across[0].min(low), across[1].max(low)];
                Covered { low, high, facet }
            })
            .collect();
        Self { heading, covered: ordered(unordered, across), along }
    }

    /// The stretches across the passes that facets cover without a gap wider than `gap`, each as the facets in it and its two ends.
    pub(super) fn bands(&self, gap: f64) -> Vec<Band> {
        let mut bands = Vec::new();
        let mut current: Option<Band> = None;
        for (index, covered) in self.covered.iter().enumerate() {
            match &mut current {
                Some(band) if covered.low <= band.high + gap => {
                    band.high = band.high.max(covered.high);
                    band.end = index + 1;
                }
                _ => {
                    bands.extend(current.take());
                    current = Some(Band { start: index, end: index + 1, low: covered.low, high: covered.high });
                }
            }
        }
        bands.extend(current);
        bands
    }
}

/// A stretch across the passes that is covered without wide gaps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    /// The first of its facets in the order of the sweep.
    pub(super) start: usize,
    /// One past the last of its facets.
    pub(super) end: usize,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Sorts by `low`, of which `range` holds the least and the largest: a counting sort into as many buckets as there are facets, then
/// insertion within each, because comparing all takes three times as long.
fn ordered(unordered: Vec<Covered>, range: [f64; 2]) -> Vec<Covered> {
    let count = unordered.len();
    let width = range[1] - range[0];
    if count < 64 || width <= 0.0 {
        let mut sorted = unordered;
        sorted.sort_by(|a, b| a.low.total_cmp(&b.low));
        return sorted;
    }
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    let per_width = (count - 1) as f64 / width;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to count - 1")]
    let bucket = |covered: &Covered| (((covered.low - range[0]) * per_width) as usize).min(count - 1);
    let mut starts = vec![0_u32; count + 1];
    for covered in &unordered {
        starts[bucket(covered) + 1] += 1;
    }
    for index in 0..count {
        starts[index + 1] += starts[index];
    }
    let mut sorted = vec![Covered { low: 0.0, high: 0.0, facet: 0 }; count];
    for covered in &unordered {
        let place = &mut starts[bucket(covered)];
        sorted[*place as usize] = *covered;
        *place += 1;
    }
    // Facets of meshes in rows begin at the same places by the hundred; such a run is long but in order, or sorted by comparison.
    if sorted.windows(2).any(|pair| pair[0].low > pair[1].low) {
        let mut start = 0;
        for end in 1..=count {
            if end == count || bucket(&sorted[end]) != bucket(&sorted[start]) {
                if end - start > 1 {
                    sorted[start..end].sort_by(|a, b| a.low.total_cmp(&b.low));
                }
                start = end;
            }
        }
    }
    sorted
}
