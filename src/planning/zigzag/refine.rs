//! Refines the spacing of passes at the facets that limit it: estimates of the tables are replaced by computed spacings
//! at which the scallop height is kept.

use super::inspector::Inspector;
use super::march::{NoPlanes, Plane};
use super::room::Room;
use super::simulate::planes_of;
use super::spaced::Spaced;
use super::sweep::Covered;
use super::workpiece::Tangent;
use crate::milling::Cutter;
use rayon::prelude::*;

/// The number of facets that are refined in a round, over all strips.
const REFINED: usize = 1_200;

/// The largest number of facets refined in a strip in each of the two orders.
const MOST_OF_STRIP: usize = 16;

/// The number of facets and strips between two checks for cancellation.
const TURN: usize = 16_384;

/// The largest number of rounds. The planes of a round lie elsewhere than those before, so that other facets limit them; two
/// rounds find nearly all of these.
const ROUNDS: usize = 4;

/// Estimates over this multiple of the strip's width are left as they are, unless their risk is large.
const NEAR: f64 = 1.15;

/// The factor by which an estimate may be too large on a facet on which passes run level.
const LEVEL: f64 = 2.0;

/// The largest ratio of a facet's curvature to that of the cutter's body that counts in its risk.
const LARGEST_CURVATURE: f64 = 10.0;

/// Refines the spacings of the facets that bind the strips, and of those where the estimate errs most, until all
/// that bind are refined. Returns for each facet of the sweep whether its spacing is refined.
///
/// # Errors
/// [`NoPlanes`]
pub(super) fn refine(
    spaced: &mut Spaced,
    risks: &Risks,
    inspector: &Inspector,
    room: &Room,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<bool>, NoPlanes> {
    let mut is_refined = vec![false; spaced.allowed.len()];
    for _ in 0..ROUNDS {
        let planes = planes_of(spaced, room, stop)?;
        let bound = planes.iter().enumerate().filter_map(|(strip, plane)| Some(Tightest { strip, place: plane.binding? }));
        let mut wanted = tightest(spaced, &planes, risks, REFINED, stop);
        wanted.extend(bound);
        wanted.retain(|one| !is_refined[one.place as usize]);
        wanted.sort_unstable_by_key(|one| one.place);
        wanted.dedup_by_key(|one| one.place);
        if wanted.is_empty() {
            break;
        }
        let widest = |one: &Tightest| {
            let facet = spaced.sweep.covered[one.place as usize].facet;
            (!stop()).then(|| inspector.widest(spaced, facet, planes[one.strip].after))
        };
        let widest = wanted.par_iter().with_min_len(16).map(widest).collect::<Option<Vec<_>>>().ok_or(NoPlanes::Cancelled)?;
        for (&Tightest { place, .. }, widest) in wanted.iter().zip(widest) {
            is_refined[place as usize] = true;
            // Where the cutter gouges, the estimate stays.
            if let Some(widest) = widest {
                #[expect(clippy::cast_possible_truncation, reason = "single precision errs by 6e-8, far less than the model")]
                let widest = widest.min(spaced.widest) as f32;
                spaced.allowed[place as usize] = widest;
            }
        }
    }
    Ok(is_refined)
}

/// How far the estimates of one cutter in one direction may be too large.
///
/// Estimates err where the surface's curvature is not small against that of the cutter's body, 1/((R - r)/sin(S) + r),
/// and where the passes run level on the facet. Those of a ball are exact to second order.
#[derive(Debug)]
pub(super) struct Risks {
    /// For each facet of the sweep the factor by which its estimate is lowered, and the lowered spacing of a plane of
    /// its slope; empty for a ball.
    lowered: Vec<[f32; 2]>,
}

impl Risks {
    /// The risks of the estimates in `spaced`. Once `stop` returns true, it returns early, with fewer of them.
    pub(super) fn new(spaced: &Spaced, cutter: Cutter, stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let (core, corner) = (cutter.core_radius().mm(), cutter.corner_radius().mm());
        if core == 0.0 {
            return Self { lowered: Vec::new() };
        }
        let of_facet = |covered: &Covered| {
            let tangent = &spaced.workpiece.tangents[covered.facet as usize];
            let [steepest, twist, level] = tangent.curvature;
            let curvature = steepest.abs().max(level.abs()) + twist.abs();
            let ratio = if curvature > 0.0 { (curvature * (core / tangent.sin + corner)).min(LARGEST_CURVATURE) } else { 0.0 };
            let is_level = runs_level(tangent, spaced.workpiece.areas[covered.facet as usize], spaced.sweep.heading.e);
            let factor = if is_level { LEVEL.recip() } else { (1.0 + ratio).sqrt().recip() };
            let on_plane = spaced.squared_on_plane(covered.facet as usize).sqrt();
            #[expect(clippy::cast_possible_truncation, reason = "a risk needs few digits")]
            let lowered = [factor as f32, (factor * on_plane) as f32];
            lowered
        };
        let mut lowered = Vec::with_capacity(spaced.sweep.covered.len());
        for covered in spaced.sweep.covered.chunks(TURN).take_while(|_| !stop()) {
            lowered.extend(covered.iter().map(of_facet));
        }
        Self { lowered }
    }

    /// The spacing that an estimate may stand for; infinite where it cannot be too large.
    fn lowered(&self, place: usize, estimate: f64) -> f64 {
        let lowered = self.lowered.get(place);
        lowered.map_or(f64::INFINITY, |&[factor, on_plane]| (estimate * f64::from(factor)).min(f64::from(on_plane)))
    }
}

/// A facet that determines a strip.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tightest {
    /// The number of the strip, which is that of the plane before it.
    pub(super) strip: usize,
    /// The facet's place in the sweep.
    pub(super) place: u32,
}

/// About `count` facets that limit the strips, at least two in each strip. Of more strips than `count`, only strips at even
/// distances are considered.
///
/// Half of the facets of a strip are those with the smallest estimates, the other half those whose estimates are
/// smallest once lowered by their risk.
pub(super) fn tightest(spaced: &Spaced, planes: &[Plane], risks: &Risks, count: usize, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Tightest> {
    let stride = planes.len().div_ceil(count).max(1);
    let most = if risks.lowered.is_empty() { 2 } else { MOST_OF_STRIP };
    let of_strip = (count / (2 * planes.len().max(1))).clamp(1, most);
    let mut by_estimate: Vec<Least> = vec![Least::default(); planes.len()];
    let mut by_risk = by_estimate.clone();
    let (mut first, mut examined) = (0, 0);
    for (place, (covered, &allowed)) in (0_u32..).zip(spaced.sweep.covered.iter().zip(&spaced.allowed)) {
        examined += 1;
        if examined >= TURN {
            examined = 0;
            if stop() {
                break;
            }
        }
        while planes.get(first + 1).is_some_and(|next| next.at <= covered.low) {
            first += 1;
        }
        // Steep facets set no spacing.
        let allowed = f64::from(allowed);
        if allowed.is_infinite() {
            continue;
        }
        let at_risk = risks.lowered(place as usize, allowed);
        let reached = planes.iter().enumerate().skip(first).take_while(|(strip, plane)| *strip == first || plane.at < covered.high);
        for (strip, plane) in reached {
            examined += 1;
            if strip % stride != 0 {
                continue;
            }
            if allowed < NEAR * plane.after {
                by_estimate[strip].add(place, allowed, of_strip);
            }
            if at_risk < NEAR * plane.after {
                by_risk[strip].add(place, at_risk, of_strip);
            }
        }
    }
    let lists = by_estimate.into_iter().zip(by_risk).enumerate();
    let places = lists.flat_map(|(strip, (one, mut other))| {
        other.facets.retain(|(place, _)| one.facets.iter().all(|(known, _)| known != place));
        one.facets.into_iter().chain(other.facets).map(move |(place, _)| Tightest { strip, place })
    });
    places.collect()
}

/// Whether passes in the direction `e` run level on a facet: the climb from its middle changes sign within its size.
fn runs_level(tangent: &Tangent, area: f64, e: [f64; 2]) -> bool {
    let (cos_alpha, sin_alpha) = tangent.alpha(e);
    let [steepest, twist, level] = tangent.curvature;
    let up = cos_alpha / tangent.cos;
    // Climb and its change per length, both over cos(S).
    let change = steepest * up * up + 2.0 * twist * up * sin_alpha + level * sin_alpha * sin_alpha;
    (tangent.sin * cos_alpha).abs() <= change.abs() * (2.0 * area).sqrt()
}

/// The facets of a strip with the smallest keys, in rising order of these.
#[derive(Debug, Clone, Default)]
struct Least {
    /// Their places in the sweep, and the keys.
    facets: Vec<(u32, f64)>,
}

impl Least {
    fn add(&mut self, place: u32, key: f64, most: usize) {
        if self.facets.len() == most {
            if self.facets.last().is_some_and(|&(_, largest)| largest <= key) {
                return;
            }
            self.facets.pop();
        }
        let at = self.facets.partition_point(|&(_, other)| other <= key);
        self.facets.insert(at, (place, key));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::zigzag::slopes::place_of;

    #[test]
    fn the_smallest_keys_are_kept_in_rising_order() {
        let keys = [5.0, 3.0, 9.0, 1.0, 3.0, 7.0, 0.5];
        let mut least = Least::default();
        for (place, key) in (0_u32..).zip(keys) {
            least.add(place, key, 4);
        }
        assert_eq!(least.facets, [(6, 0.5), (3, 1.0), (1, 3.0), (4, 3.0)]);
    }

    #[test]
    fn passes_run_level_where_the_climb_changes_sign_within_the_facet() {
        let tangent = |slope: f64, curvature: [f64; 3]| {
            let (sin, cos) = slope.to_radians().sin_cos();
            Tangent { down_hill: [1.0, 0.0], sin, cos, per_cos: cos.recip(), curvature, place: place_of(sin), is_steep: false }
        };
        let along = |degrees: f64| [degrees.to_radians().cos(), degrees.to_radians().sin()];
        // On a curvature of 1/50 mm, 1 deg of climb is 0.87 mm away; facets of 0.5 mm^2 are 1 mm wide.
        let curved = [0.02, 0.0, 0.02];
        assert!(runs_level(&tangent(1.0, curved), 0.5, along(0.0)));
        assert!(!runs_level(&tangent(2.0, curved), 0.5, along(0.0)));
        assert!(!runs_level(&tangent(1.0, curved), 0.25, along(0.0)));
        // Along the level line of any slope, and nowhere on an inclined plane except there.
        assert!(runs_level(&tangent(40.0, curved), 0.5, along(90.0)));
        assert!(!runs_level(&tangent(1.0, [0.0; 3]), 0.5, along(80.0)));
    }
}
