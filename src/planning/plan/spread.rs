//! What the stations of a cutter allow in one direction: spacings and lengths of lines by their distance across it.

use super::candidate::CandidateCutter;
use super::prepared::Prepared;
use super::stations::Station;
use super::workpiece::Workpiece;

/// A direction of lines seen from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heading {
    /// The unit vector along the lines.
    pub(super) along: [f64; 2],
    /// The unit vector across them, to the left.
    pub(super) across: [f64; 2],
}

impl Heading {
    pub(super) fn of(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self { along: [cos, sin], across: [-sin, cos] }
    }

    /// The position along and across the lines.
    pub(super) fn of_point(&self, point: [f64; 2]) -> [f64; 2] {
        [self.along[0] * point[0] + self.along[1] * point[1], self.across[0] * point[0] + self.across[1] * point[1]]
    }

    pub(super) fn point(&self, [u, c]: [f64; 2]) -> [f64; 2] {
        [u * self.along[0] + c * self.across[0], u * self.along[1] + c * self.across[1]]
    }
}

/// A station as one direction sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub(super) along: f64,
    pub(super) across: f64,
    /// The squared spacing that it allows, in mm^2.
    pub(super) squared: f64,
    /// Its part of the integral of length over the distance across, in mm^2: its area times the ratio of spacings.
    pub(super) length: f64,
    /// Its part of the integral of time over the distance across, in s mm.
    pub(super) time: f64,
}

/// The stations that the cutter reaches, by their distance across the lines.
pub(super) struct Spread {
    pub(super) seen: Vec<Seen>,
    pub(super) range: [f64; 2],
}

impl Spread {
    pub(super) fn new(workpiece: &Workpiece, stations: &[Station], prepared: &Prepared, heading: &Heading, tolerance: f64) -> Self {
        let mut seen: Vec<Seen> = Vec::with_capacity(stations.len());
        for station in stations {
            if station.lift > tolerance {
                continue;
            }
            let tangent = &workpiece.tangents[station.place.target];
            let (cos_alpha, sin_alpha) = tangent.alpha(heading.along);
            let [along, across] = heading.of_point(station.axis);
            let length = station.place.area * tangent.ratio_squared(cos_alpha).sqrt();
            let time = length / prepared.feeds.rate(tangent, cos_alpha, 1.0);
            let squared = prepared.spacing.squared(tangent, cos_alpha, sin_alpha);
            seen.push(Seen { along, across, squared, length, time });
        }
        seen.sort_unstable_by(|a, b| a.across.total_cmp(&b.across));
        let range = match (seen.first(), seen.last()) {
            (Some(first), Some(last)) => [first.across, last.across],
            _ => [0.0, 0.0],
        };
        Self { seen, range }
    }

    /// The stations from `from` to `to` across the lines.
    pub(super) fn between(&self, from: f64, to: f64) -> &[Seen] {
        let first = self.seen.partition_point(|seen| seen.across < from);
        let end = self.seen.partition_point(|seen| seen.across <= to);
        &self.seen[first..end.max(first)]
    }
}

/// The spacing allowed at distances across the lines: the least squared spacing in each of many equal bins.
#[derive(Debug, Clone)]
pub(super) struct Allowed {
    first: f64,
    width: f64,
    squared: Vec<f64>,
    widest: f64,
}

/// Bins narrower than this share of the widest spacing do not change where lines are.
const BINS_A_SPACING: f64 = 16.0;
const MOST_BINS: f64 = 8192.0;

impl Allowed {
    /// The spacings of a spread. In each bin, the share `left_out` of the area may allow less.
    pub(super) fn of(spread: &Spread, candidate: &CandidateCutter, left_out: f64) -> Self {
        let widest = 2.0 * candidate.cutter.profile().outer_radius() * (1.0 - 1e-6);
        let [first, last] = spread.range;
        let extent = (last - first).max(1e-9);
        let smallest = spread.seen.iter().map(|seen| seen.squared).fold(widest * widest, f64::min).sqrt().max(extent / MOST_BINS);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 8192")]
        let count = (BINS_A_SPACING * extent / smallest).clamp(1.0, MOST_BINS) as usize;
        #[expect(clippy::cast_precision_loss, reason = "at most 8192")]
        let width = extent / count as f64;
        let mut squared = vec![widest * widest; count];
        // Over the whole direction, the stations of the least share of the area are left out.
        let mut by_spacing: Vec<&Seen> = spread.seen.iter().collect();
        by_spacing.sort_unstable_by(|a, b| a.squared.total_cmp(&b.squared));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss, reason = "a share of a count")]
        let omitted = (left_out * by_spacing.len() as f64) as usize;
        for seen in &by_spacing[omitted.min(by_spacing.len())..] {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the bins")]
            let bin = (((seen.across - first) / width) as usize).min(count - 1);
            squared[bin] = f64::min(squared[bin], seen.squared);
        }
        Self { first, width, squared, widest }
    }

    /// The largest spacing of neighbouring lines from `from` on that everything between them allows; 0 if there is none.
    pub(super) fn next(&self, from: f64) -> f64 {
        let mut least = self.widest;
        let mut bin = self.bin(from);
        loop {
            least = least.min(self.squared[bin].sqrt());
            #[expect(clippy::cast_precision_loss, reason = "at most 8192")]
            let end = self.first + (bin + 1) as f64 * self.width;
            if end >= from + least || bin + 1 == self.squared.len() {
                return least;
            }
            bin += 1;
        }
    }

    /// Multiplies the spacings allowed from `from` to `to`.
    pub(super) fn scale(&mut self, from: f64, to: f64, factor: f64) {
        for bin in self.bin(from)..=self.bin(to) {
            self.squared[bin] = (self.squared[bin] * factor * factor).min(self.widest * self.widest);
        }
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the bins")]
    fn bin(&self, across: f64) -> usize {
        ((((across - self.first) / self.width).max(0.0)) as usize).min(self.squared.len() - 1)
    }

    /// The distances across of all lines: the first half a spacing from the border, the last at most half a spacing from
    /// the other border. `None` if some spacing is 0 or there are more than `most`.
    pub(super) fn lines(&self, range: [f64; 2], most: usize) -> Option<Vec<f64>> {
        let [first, last] = range;
        let begin = self.next(first);
        if begin <= 0.0 {
            return None;
        }
        if last - first <= begin {
            return Some(vec![f64::midpoint(first, last)]);
        }
        let mut lines = vec![first + begin / 2.0];
        loop {
            let at = lines[lines.len() - 1];
            let spacing = self.next(at);
            if spacing <= 0.0 || lines.len() >= most {
                return None;
            }
            if at + spacing / 2.0 >= last {
                break;
            }
            lines.push((at + spacing).min(last - 1e-9 * (last - first)));
        }
        Some(evened(lines, last, self))
    }
}

/// The lines moved so that the last one is half of the spacing there from the border: the surplus is divided among all.
fn evened(mut lines: Vec<f64>, last: f64, allowed: &Allowed) -> Vec<f64> {
    let (Some(&begin), Some(&end)) = (lines.first(), lines.last()) else { return lines };
    let wanted = last - allowed.next(end) / 2.0;
    if lines.len() > 1 && wanted < end && wanted > begin {
        let factor = (wanted - begin) / (end - begin);
        for line in &mut lines {
            *line = begin + (*line - begin) * factor;
        }
    }
    lines
}
