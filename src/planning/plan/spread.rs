//! What the stations of a cutter allow in one family of lines: spacings and lengths of lines by their number.

use super::candidate::CandidateCutter;
use super::family::Family;
use super::prepared::Prepared;
use super::stations::Station;
use super::workpiece::Workpiece;

/// A station as one family of lines sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub(super) along: f64,
    pub(super) across: f64,
    /// The height of the tip.
    tip: f64,
    /// The tangent of the slope.
    rise: f64,
    /// The squared spacing that it allows, in mm^2.
    pub(super) squared: f64,
    /// Whether it is nearly level: the spacing is that of the cutter's flat, and hardly more of it leaves far more height.
    is_level: bool,
    /// Its part of the integral of length over the distance across, in mm^2: its area times the ratio of spacings.
    pub(super) length: f64,
    /// Its part of the integral of time over the distance across, in s mm.
    pub(super) time: f64,
}

impl Seen {
    /// Whether a step of more than `step` mm lies between two stations, beyond what their slopes explain.
    pub(super) fn is_walled_off(&self, other: &Self, step: f64) -> bool {
        let distance = (other.along - self.along).hypot(other.across - self.across);
        (other.tip - self.tip).abs() > step + self.rise.max(other.rise) * distance
    }
}

/// The stations that the cutter reaches, by their distance across the lines.
pub(super) struct Spread {
    pub(super) seen: Vec<Seen>,
    pub(super) range: [f64; 2],
}

/// The sine of the slope up to which a place is nearly level.
const NEARLY_LEVEL: f64 = 0.05;

impl Spread {
    pub(super) fn new(workpiece: &Workpiece, stations: &[Station], prepared: &Prepared, family: &Family, tolerance: f64) -> Self {
        let mut seen: Vec<Seen> = Vec::with_capacity(stations.len());
        for station in stations {
            if station.lift > tolerance {
                continue;
            }
            let tangent = &workpiece.tangents[station.place.target];
            let (cos_alpha, _) = tangent.alpha(family.along(tangent));
            let [along, across] = family.of_station(station);
            let length = station.place.area * family.ratio(tangent);
            let time = length / prepared.feeds.rate(tangent, cos_alpha, 1.0);
            let squared = family.squared_spacing(prepared, tangent);
            let rise = tangent.sin * tangent.per_cos;
            seen.push(Seen { along, across, tip: station.tip, rise, squared, is_level: tangent.sin < NEARLY_LEVEL, length, time });
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
    /// What each bin's squared spacing can be widened to.
    most: Vec<f64>,
}

/// Bins narrower than this share of the widest spacing do not change where lines are.
const BINS_A_SPACING: f64 = 16.0;
const MOST_BINS: f64 = 8192.0;

/// The halvings in the search of the factor of all spacings, for a thousandth of it.
const FACTOR_HALVINGS: u32 = 10;

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
        let mut most = squared.clone();
        // Over the whole direction, the stations of the least share of the area are left out.
        let mut by_spacing: Vec<&Seen> = spread.seen.iter().collect();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss, reason = "a share of a count")]
        let omitted = (left_out * by_spacing.len() as f64) as usize;
        if (1..by_spacing.len()).contains(&omitted) {
            by_spacing.select_nth_unstable_by(omitted, |a, b| a.squared.total_cmp(&b.squared));
        }
        for seen in &by_spacing[omitted.min(by_spacing.len())..] {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the bins")]
            let bin = (((seen.across - first) / width) as usize).min(count - 1);
            squared[bin] = f64::min(squared[bin], seen.squared);
            if seen.is_level {
                most[bin] = f64::min(most[bin], seen.squared);
            }
        }
        Self { first, width, squared, most }
    }

    /// The largest spacing of neighbouring lines from `from` on that everything between them allows; 0 if there is none.
    pub(super) fn next(&self, from: f64) -> f64 {
        let mut least = f64::INFINITY;
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
            self.squared[bin] = (self.squared[bin] * factor * factor).min(self.most[bin]);
        }
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the bins")]
    fn bin(&self, across: f64) -> usize {
        ((((across - self.first) / self.width).max(0.0)) as usize).min(self.squared.len() - 1)
    }

    /// The distances across of all lines: the first half a spacing from the border, the last half a spacing from the other
    /// border. `None` if some spacing is 0 or there are more than `most`.
    ///
    /// As few lines as the spacings allow would overshoot the other border. So all spacings are reduced by one factor, with which
    /// the lines just reach it: moved lines would leave the places whose spacings they have.
    pub(super) fn lines(&self, range: [f64; 2], most: usize) -> Option<Vec<f64>> {
        let mut fewest = self.lines_at(range, 1.0, most)?;
        let [mut too_small, mut factor] = [0.0, 1.0];
        for _ in 0..FACTOR_HALVINGS {
            let middle = f64::midpoint(too_small, factor);
            match self.lines_at(range, middle, fewest.len()) {
                Some(lines) => (fewest, factor) = (lines, middle),
                None => too_small = middle,
            }
        }
        Some(fewest)
    }

    /// The lines with all spacings multiplied by `factor`, from the first border until half a spacing reaches the other one.
    fn lines_at(&self, [first, last]: [f64; 2], factor: f64, most: usize) -> Option<Vec<f64>> {
        let begin = factor * self.next(first);
        if begin <= 0.0 {
            return None;
        }
        if last - first <= begin {
            return Some(vec![f64::midpoint(first, last)]);
        }
        let mut lines = vec![first + begin / 2.0];
        loop {
            let at = lines[lines.len() - 1];
            let spacing = factor * self.next(at);
            if at + spacing / 2.0 >= last && spacing > 0.0 {
                return Some(lines);
            }
            if spacing <= 0.0 || lines.len() >= most {
                return None;
            }
            lines.push((at + spacing).min(last - 1e-9 * (last - first)));
        }
    }
}
