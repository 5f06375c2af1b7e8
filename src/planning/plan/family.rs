//! The families of lines: vertical planes in one direction (zigzag), and level curves of the tips' surface (waterlines); and
//! what the stations of a cutter allow in one family: spacings and lengths of lines by their number.
//!
//! A family gives every tip a number, the same along a line: its distance across the planes, or its height. Lines are spaced in
//! that number.

use super::settings::CandidateCutter;
use super::spacing::Prepared;
use super::stations::Station;
use super::tangent::Tangent;
use super::workpiece::Workpiece;
use crate::quantity::Angle;

/// A direction of lines seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
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

    /// The direction, counted from X.
    pub(super) fn angle(&self) -> Angle {
        Angle::from_radians(self.along[1].atan2(self.along[0]))
    }

    /// The position along and across the lines.
    pub(super) fn of_point(&self, point: [f64; 2]) -> [f64; 2] {
        [self.along[0] * point[0] + self.along[1] * point[1], self.across[0] * point[0] + self.across[1] * point[1]]
    }

    pub(super) fn point(&self, [u, c]: [f64; 2]) -> [f64; 2] {
        [u * self.along[0] + c * self.across[0], u * self.along[1] + c * self.across[1]]
    }
}

/// A family of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Family {
    /// Vertical planes.
    Planes(Heading),
    /// Level curves of the tips' surface.
    Levels,
}

impl Family {
    /// Whether both are planes, or both are levels.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }

    /// The distance across the planes, or the height, of a tip in mm.
    pub(super) fn number(&self, [x, y, z]: [f64; 3]) -> f64 {
        match self {
            Self::Planes(heading) => heading.of_point([x, y])[1],
            Self::Levels => z,
        }
    }

    /// The position of a station along the lines, as far as the family has one, and its number.
    pub(super) fn of_station(&self, station: &Station) -> [f64; 2] {
        match self {
            Self::Planes(heading) => heading.of_point(station.axis),
            Self::Levels => [0.0, station.tip],
        }
    }

    /// The direction of the line on a facet, seen from above.
    pub(super) fn along(&self, tangent: &Tangent) -> [f64; 2] {
        match self {
            Self::Planes(heading) => heading.along,
            Self::Levels => [-tangent.down_hill[1], tangent.down_hill[0]],
        }
    }

    /// The spacing of lines in their number for each mm of step-over along a facet.
    pub(super) fn ratio(&self, tangent: &Tangent) -> f64 {
        match self {
            Self::Planes(heading) => tangent.ratio_squared(tangent.alpha(heading.along).0).sqrt(),
            Self::Levels => tangent.sin,
        }
    }

    /// The squared spacing that a facet allows, in mm^2.
    pub(super) fn squared_spacing(&self, prepared: &Prepared, tangent: &Tangent) -> f64 {
        let (cos_alpha, sin_alpha) = tangent.alpha(self.along(tangent));
        let of_planes = prepared.spacing.squared(tangent, cos_alpha, sin_alpha);
        match self {
            Self::Planes(_) => of_planes,
            // Planes along the level line are cos(S) apart for each mm of step-over, levels sin(S).
            Self::Levels => of_planes * (tangent.sin * tangent.per_cos).powi(2),
        }
    }
}

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
