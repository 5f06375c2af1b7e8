//! What a path leaves at the stations of a cutter, as figures and by strip between lines, and how deep it cuts into the part.

use super::family::{Allowed, Family};
use super::spacing::Prepared;
use super::stations::{AT_ONCE, Station};
use super::workpiece::Workpiece;
use crate::path::{self, Milled, Place};
use crate::quantity::Length;
use rayon::prelude::*;

/// What a path leaves at one station.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged {
    /// The height in mm left along the normal, negative for a cut into the part; `None` if no cutting move reaches the place.
    pub(super) left: Option<f64>,
    /// The height in mm that tooth marks add; 0 for a cutter without a drive.
    pub(super) marks: f64,
}

impl Judged {
    /// What two operations leave together: less material, and the deeper cut.
    pub(super) fn together(&self, other: &Self) -> Self {
        match (self.left, other.left) {
            (Some(a), Some(b)) if a.min(b) < 0.0 => Self { left: Some(a.min(b)), marks: if a < b { self.marks } else { other.marks } },
            _ if other.material() < self.material() => *other,
            _ => *self,
        }
    }

    /// The height left, longer by the factor by which tooth marks leave less than the scallop height to ridges, infinite where no move
    /// reaches the place.
    fn ridge(self, height: f64) -> f64 {
        self.left.unwrap_or(f64::INFINITY).max(0.0) * height / (height - self.marks).max(1e-3 * height)
    }

    /// The height left, tooth marks included, infinite where no move reaches the place.
    pub(super) fn material(self) -> f64 {
        self.left.map_or(f64::INFINITY, |left| left.max(0.0) + self.marks)
    }
}

/// What a path of a candidate, with lines of a family, leaves at each station. `None` once `stop` returns true.
pub(super) fn judged(
    workpiece: &Workpiece,
    stations: &[Station],
    prepared: &Prepared,
    family: &Family,
    milled: &Milled,
    height: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Judged>> {
    let of_station = |station: &Station| {
        if stop() {
            return None;
        }
        let left = milled.left_at(station.place.point, workpiece.targets[station.place.target].normal);
        let tangent = &workpiece.tangents[station.place.target];
        let (cos_alpha, _) = tangent.alpha(family.along(tangent));
        let marks = height * (1.0 - prepared.feeds.step_over_share(tangent, cos_alpha));
        Some(Judged { left: left.map(|left| left.height), marks })
    };
    stations.par_iter().with_max_len(AT_ONCE).map(of_station).collect()
}

/// From this many scallop heights on, a place is missed by planes: it is no ridge between them.
const MISSED_BY_PLANES: f64 = 1.1;

/// The same for level curves. Slopes differ along one of them, and with them the heights of ridges, until lines have moved a few times.
const MISSED_BY_LEVELS: f64 = 1.5;

/// The height in scallop heights from which on a place is missed.
fn missed_from(family: &Family) -> f64 {
    match family {
        Family::Planes(_) => MISSED_BY_PLANES,
        Family::Levels => MISSED_BY_LEVELS,
    }
}

/// Where more than this share of a strip's places is missed, its lines are too far apart. Fewer are beside walls, on narrow tops or
/// in narrow bands: closer lines would finish them late or not at all, runs of their own do.
const TOO_FAR_APART: f64 = 0.05;

/// A station that the cutter can reach and a path misses.
#[derive(Debug, Clone, Copy)]
pub(super) struct MissedStation<'a> {
    pub(super) station: &'a Station,
    /// What the path leaves there.
    pub(super) judged: Judged,
    /// Its share of the area of all stations.
    pub(super) share: f64,
}

/// Whether more is left at a station that the cutter can reach than a ridge between lines.
fn is_missed(judged: Judged, family: &Family, height: f64) -> bool {
    judged.ridge(height) > missed_from(family) * height
}

impl MissedStation<'_> {
    /// The station, if it is still missed after a further path, which leaves `path` there.
    pub(super) fn after(self, path: &Judged, family: &Family, height: f64) -> Option<Self> {
        let judged = self.judged.together(path);
        is_missed(judged, family, height).then_some(Self { judged, ..self })
    }
}

/// The missed stations; the scallop height in mm.
pub(super) fn missed<'a>(stations: &'a [Station], judged: &'a [Judged], family: &Family, height: f64) -> Vec<MissedStation<'a>> {
    let whole = stations.iter().map(|station| station.place.area).sum::<f64>().max(f64::MIN_POSITIVE);
    let of_station = |(station, &judged): (&'a Station, &Judged)| {
        let is_missed = station.lift <= height && is_missed(judged, family, height);
        is_missed.then_some(MissedStation { station, judged, share: station.place.area / whole })
    };
    stations.iter().zip(judged).filter_map(of_station).collect()
}

/// Heights left over the area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinishFigures {
    /// The median over what the cutter can reach.
    pub p50: Length,
    /// The 90th percentile.
    pub p90: Length,
    /// The 99th percentile.
    pub p99: Length,
    /// The largest.
    pub max: Length,
    /// The share of the area that the cutter can reach and that is left higher than the scallop height.
    pub over_tolerance_share: f64,
    /// The part of that share where the excess is over 2 %.
    pub far_over_share: f64,
    /// The share of the area that the cutter cannot reach within the scallop height.
    pub uncut_share: f64,
    /// The largest height left there.
    pub uncut_height: Length,
    /// The share of the area with at least half of the scallop height.
    pub used_share: f64,
    /// The deepest cut into the part, links and lifts included.
    pub gouge: Length,
}

/// The share of the area that a path may leave more than 2 % over the scallop height and still keep it.
pub(super) const KEPT: f64 = 0.005;

/// An excess over the scallop height that counts as far over: the chord tolerance and the places' own error.
const FAR: f64 = 1.02;

impl FinishFigures {
    /// The figures of judged stations; `height` is the scallop height to keep, and the lift in mm up to which a station counts
    /// as reached.
    pub(super) fn of(stations: &[Station], judged: &[Judged], height: f64) -> Self {
        let whole: f64 = stations.iter().map(|station| station.place.area).sum();
        let mut heights = Vec::with_capacity(stations.len());
        let (mut over, mut far, mut uncut, mut used, mut uncut_height) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
        for (station, judged) in stations.iter().zip(judged) {
            let material = judged.material();
            let area = station.place.area;
            used += if material >= height / 2.0 { area } else { 0.0 };
            if station.lift > height && material > height {
                uncut += area;
                uncut_height = uncut_height.max(if material.is_finite() { material } else { station.lift });
                continue;
            }
            over += if material > height { area } else { 0.0 };
            far += if material > FAR * height { area } else { 0.0 };
            heights.push(if material.is_finite() { material } else { station.lift.max(height) });
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "a place among the heights"
        )]
        let mut at = |share: f64| {
            let place = (share * heights.len() as f64) as usize;
            Length::computed(at_rank(&mut heights, place, f64::total_cmp).unwrap_or(0.0))
        };
        let gouge = judged.iter().filter_map(|judged| judged.left).fold(0.0, |deepest: f64, left| deepest.max(-left));
        let of = |area: f64| if whole > 0.0 { area / whole } else { 0.0 };
        Self {
            p50: at(0.5),
            p90: at(0.9),
            p99: at(0.99),
            max: at(1.0),
            over_tolerance_share: of(over),
            far_over_share: of(far),
            uncut_share: of(uncut),
            uncut_height: Length::computed(uncut_height),
            used_share: of(used),
            gouge: Length::computed(gouge),
        }
    }
}

/// The value that would be at this index, or the last one, if the values were in order; `None` if there are none.
fn at_rank<T: Copy>(values: &mut [T], index: usize, order: impl FnMut(&T, &T) -> std::cmp::Ordering) -> Option<T> {
    let index = index.min(values.len().checked_sub(1)?);
    Some(*values.select_nth_unstable_by(index, order).1)
}

/// The largest changes of a strip's spacing in one round.
const MOST_NARROWED: f64 = 0.5;
const MOST_WIDENED: f64 = 1.35;

/// Stations at least this share of the way from a line to the middle of its strip tell the height of the ridge there.
const NEAR_THE_RIDGE: f64 = 0.85;

/// Of n random places across a parabolic ridge, the one nearest to it misses it by 1/n of its distance on average, and by less than
/// twice that in all but a seventh of the strips.
const OFF_THE_RIDGE: f64 = 2.0;

/// Changes the spacings that lines may have so that the height left between them becomes the scallop height: the height
/// grows with the square of the spacing. Stations that the cutter cannot reach do not count, nor do missed ones if few of a strip are.
/// A station beside the ridge counts for the ridge, whose height is larger by the square of the distances from the line, up to
/// what n places can have missed: the highest of a few random places alone is too low, by chance more or less, but on coarse
/// facets ridges are not parabolas. `margin` multiplies all spacings.
pub(super) fn respace(
    allowed: &mut Allowed,
    lines: &[f64],
    family: &Family,
    stations: &[Station],
    judged: &[Judged],
    height: f64,
    margin: f64,
) {
    if lines.len() < 2 {
        return;
    }
    let missed_from = missed_from(family) * height;
    // The height of each station of a strip, and that of the ridge beside it.
    let mut heights: Vec<Vec<[f64; 2]>> = vec![Vec::new(); lines.len() - 1];
    for (station, judged) in stations.iter().zip(judged) {
        let [_, across] = family.of_station(station);
        let strip = lines.partition_point(|line| *line <= across);
        if strip == 0 || strip == lines.len() || station.lift > height {
            continue;
        }
        let [before, after] = [lines[strip - 1], lines[strip]];
        let share = 2.0 * (across - before).min(after - across) / (after - before);
        let here = judged.ridge(height);
        heights[strip - 1].push([here, if share >= NEAR_THE_RIDGE { here / (share * share) } else { here }]);
    }
    let factors: Vec<f64> = heights
        .iter_mut()
        .map(|heights| {
            let missed = heights.iter().filter(|[here, _]| *here > missed_from).count();
            #[expect(clippy::cast_precision_loss, reason = "thousands")]
            if missed as f64 <= TOO_FAR_APART * heights.len() as f64 {
                heights.retain(|[here, _]| *here <= missed_from);
            }
            // A thousandth of a strip's area may be over.
            let place = heights.len().saturating_sub(1 + heights.len() / 1000);
            let [highest, ridge] = [0, 1].map(|of| at_rank(heights, place, |a, b| a[of].total_cmp(&b[of])).map(|heights| heights[of]));
            #[expect(clippy::cast_precision_loss, reason = "thousands")]
            let off_the_ridge = 1.0 + OFF_THE_RIDGE / heights.len().max(1) as f64;
            let factor = |(highest, ridge): (f64, f64)| {
                let ridge = ridge.min(highest * off_the_ridge * off_the_ridge);
                (margin * (height / ridge.max(1e-3 * height)).sqrt()).clamp(MOST_NARROWED, MOST_WIDENED)
            };
            highest.zip(ridge).map_or(1.0, factor)
        })
        .collect();
    for (strip, pair) in lines.windows(2).enumerate() {
        // A strip widens only as far as its neighbours let the lines move: a line that moves changes both of its strips.
        let around = [strip.saturating_sub(1), strip, (strip + 1).min(factors.len() - 1)];
        let least = around.into_iter().map(|strip| factors[strip]).fold(f64::INFINITY, f64::min);
        let factor = if factors[strip] < 1.0 { factors[strip] } else { least.max(1.0) };
        allowed.scale(pair[0], pair[1], factor);
    }
}

/// The deepest cut in mm of a path into the part: at the stations, at places for cuts on all facets, and where these lead to on their facets.
pub(super) fn deepest_cut(workpiece: &Workpiece, stations: &[Station], milled: &Milled) -> f64 {
    let places: Vec<Place> = stations.iter().map(|station| station.place.on(workpiece)).chain(workpiece.places_for_cuts()).collect();
    let cut = |place: Place| milled.left_at(place.point, place.normal).map(|left| (place, left.height));
    let cuts: Vec<(Place, f64)> = places.into_par_iter().with_max_len(AT_ONCE).filter_map(cut).collect();
    let corners_of = |facet: u32| workpiece.corners_of(facet).map(Into::into);
    path::deepest_cut(milled, &corners_of, cuts.into_iter()).map_or(0.0, |spot| -spot.left.height)
}
