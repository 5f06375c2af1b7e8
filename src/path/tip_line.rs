//! The path of the tip over a line that is straight seen from above, with the corners and edges of facets that the cutter
//! passes between two samples of the line, seen by neither.

use super::bottom::{Bottom, Touching};
use super::drop_cutter::{DropCutter, Touch};
use crate::milling::Profile;
use crate::numerics::vector::{difference, length};
use nalgebra::Vector3;

/// The share of a distance from the axis within which a corner is surely under the cutter.
const ROUNDING: f64 = 1e-9;

/// How often the range in which a corner's distance from the axis lies is halved.
const HALVINGS: u32 = 8;

/// What a cutter passes between two samples of a line. Points are given by their places along the line and across it, and their
/// heights.
pub(super) struct Unseen {
    bottom: Bottom,
    /// Where the profile is as steep as the chord: the distance from the axis, and the height over the tip. What is highest over the
    /// chord touches the profile there or further out.
    least: [f64; 2],
    /// The places of both samples along the line.
    ends: [f64; 2],
    /// The height of the chord at the first sample, and its slope.
    chord: [f64; 2],
    /// Facets up to this height are under the chord.
    pub(super) lowest: f64,
    /// The largest height over the chord so far.
    highest: f64,
    /// Where the cutter touches what is highest over the chord.
    pub(super) place: Option<f64>,
}

impl Unseen {
    /// Between samples at two places, with two heights of the tip; what is over the chord by up to `tolerance` is left out.
    pub(super) fn new(profile: &Profile, ends: [f64; 2], [from, to]: [f64; 2], tolerance: f64) -> Self {
        let slope = (to - from) / (ends[1] - ends[0]);
        let bottom = Bottom::of(profile);
        let least = rim(&bottom, [slope, 1.0]);
        Self { bottom, least, ends, chord: [from, slope], lowest: from.min(to) + tolerance, highest: tolerance, place: None }
    }

    /// Looks at the corners and edges of a facet.
    pub(super) fn look_at(&mut self, corners: [[f64; 3]; 3]) {
        for (index, corner) in corners.into_iter().enumerate() {
            self.look_at_corner(corner);
            self.look_at_edge(corner, difference(corners[(index + 1) % 3], corner));
        }
    }

    /// A corner is highest over the chord where the cutter leaves it as steeply as the chord.
    fn look_at_corner(&mut self, [along, across, height]: [f64; 3]) {
        let (outer, [_, slope], [first, last]) = (self.bottom.radius(), self.chord, self.ends);
        let ahead = |rho: f64| ((rho - across) * (rho + across)).max(0.0).sqrt().copysign(slope);
        let [least, low] = self.least;
        let [near, far] = [least, outer].map(|rho| along - ahead(rho));
        if height - low <= self.lowest || across.abs() >= outer || near.min(far) >= last || near.max(far) <= first {
            return;
        }
        let passed = length([(first - along).max(along - last).max(0.0), across]);
        if height - self.bottom.low(passed) <= self.lowest {
            return;
        }
        // The cutter is steeper there, as it passes the corner at an angle.
        let (mut least, mut most) = (least.max(across.abs()), outer);
        for _ in 0..HALVINGS {
            let rho = 0.5 * (least + most);
            if rim(&self.bottom, [slope * rho, ahead(rho)])[0] > rho { least = rho } else { most = rho }
        }
        // A cone is as steep everywhere: there the bracket alone tells where.
        let rho = rim(&self.bottom, [slope * most, ahead(most)])[0].clamp(least, most);
        self.touch(along - ahead(rho), height - self.bottom.low(rho));
    }

    /// An edge is highest over the chord where the cutter is as steep along the edge as the edge, and along the chord as the chord.
    fn look_at_edge(&mut self, [along, across, height]: [f64; 3], edge: [f64; 3]) {
        let [least, low] = self.least;
        if height.max(height + edge[2]) - low <= self.lowest {
            return;
        }
        let [_, slope] = self.chord;
        let abeam = (edge[2] - slope * edge[0]) / edge[1];
        let steepness = (slope * slope + abeam * abeam).sqrt();
        let [ahead, aside] = [slope / steepness, abeam / steepness];
        // Whether a value that changes with the distance from the axis can lie between two others.
        let passes = |value: &dyn Fn(f64) -> f64, [first, last]: [f64; 2]| {
            let (near, far) = (value(least), value(self.bottom.radius()));
            near.min(far) <= first.max(last) && near.max(far) >= first.min(last)
        };
        if !passes(&|rho| rho * aside, [across, across + edge[1]]) {
            return;
        }
        let share = |rho: f64| (rho * aside - across) / edge[1];
        let place = |rho: f64| along + share(rho) * edge[0] - rho * ahead;
        if passes(&place, self.ends) {
            let [rho, low] = rim(&self.bottom, [steepness, 1.0]);
            if (0.0..=1.0).contains(&share(rho)) {
                self.touch(place(rho), height + share(rho) * edge[2] - low);
            }
        }
    }

    /// The tip stands at this height at a place along the line.
    fn touch(&mut self, place: f64, height: f64) {
        let [from, slope] = self.chord;
        let over = height - from - slope * (place - self.ends[0]);
        if self.ends[0] < place && place < self.ends[1] && over > self.highest {
            (self.highest, self.place) = (over, Some(place));
        }
    }
}

/// The distance from the axis at which the profile rises so far over a run, and its height over the tip there.
fn rim(bottom: &Bottom, [rise, run]: [f64; 2]) -> [f64; 2] {
    let across = length([rise, run]);
    let Touching { distance, height, .. } = bottom.touching(rise.abs() / across, run.abs() / across);
    [distance * (1.0 - ROUNDING), height]
}

/// The shortest distance between two samples in mm. A part of the line this short over which the height changes by more
/// than the tolerance is a vertical step.
const SHORTEST: f64 = 1e-4;

/// The share of the chord tolerance for what chords between samples miss; the other half is for leaving samples out.
const SAMPLING_SHARE: f64 = 0.5;

/// The depth in chord tolerances to which a chord may cut into what both its ends miss.
const MOST_MISSED: f64 = 3.0;

/// Where a chord may cut deeper than so many times that depth, what the cutter passes is sought; up to there, some more samples cost
/// less.
const MOST_SAMPLED: f64 = 16.0;

/// A position of the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tip {
    /// x, y, z in mm.
    pub position: [f64; 3],
    /// What the cutter touches there; `None` where it stands on the floor that the caller gave, and at the height of a
    /// step's upper end on the place of its lower.
    pub touch: Option<Touch>,
}

impl Tip {
    /// The position as a vector.
    #[must_use]
    pub fn vector(&self) -> Vector3<f64> {
        Vector3::from(self.position)
    }
}

/// The tips along the straight line `from` to `to`, both ends included. With fine sampling, the chords between consecutive tips
/// are at most the chord tolerance under T, the height on which the tip stands, where they would cut into the part, and
/// at most that much over T.
///
/// A vertical step becomes two tips at its lower, free side, so that no chord crosses the part: the line rises before the
/// step or falls behind it, by less than 1e-4 mm. Where no facet is in reach the tip is at `floor`; without a floor there
/// are no tips, and consecutive ones may be far apart.
///
/// **Samples.** Whatever the cutter touches, T bends downwards over it no more sharply than the cutter's own profile. Between two
/// samples at the distance l in space, the chord therefore cuts at most l^2/(8 r) into a feature that neither touches, with r the
/// smallest radius of the profile. Where that is too much, as on steep lines, there are more samples; where it is far too much, as
/// for a flat end, which has no such radius, the corners and edges of facets that the cutter passes between the samples are sought
/// one by one. Between samples T is compared with its tangents at both, which the contacts' normals give: where it bends one way it
/// is between chord and tangents.
#[must_use]
pub fn tips_between(
    drop: &DropCutter,
    profile: &Profile,
    from: [f64; 2],
    to: [f64; 2],
    sampling: &Sampling,
    floor: Option<f64>,
) -> Vec<Tip> {
    let line = Line::new(drop, profile, [from, to], floor);
    simplified(line.samples(sampling), (1.0 - SAMPLING_SHARE) * sampling.chord_tolerance)
}

/// How a line is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// What chords may miss in mm, over 0.
    pub chord_tolerance: f64,
    /// The distance in mm between samples from which refinement starts.
    pub step: f64,
    /// The largest curvature of the profile in 1/mm, infinite for a corner: it bounds how deep a chord may cut into what both its
    /// ends miss. With 0 nothing is looked for there.
    pub curvature: f64,
}

impl Sampling {
    /// So fine that level chords miss no more than the tolerance: sqrt(8 r tolerance) apart, at least R/25; R/20 for a profile of
    /// corners, whose chords are searched.
    #[must_use]
    pub fn fine(profile: &Profile, chord_tolerance: f64) -> Self {
        let radius = profile.outer_radius();
        let radii = profile.arcs().iter().map(|arc| arc.radius).filter(|r| *r > 0.0);
        let (step, curvature) = match radii.min_by(f64::total_cmp) {
            Some(r) => ((8.0 * r * chord_tolerance).sqrt().clamp(radius / 25.0, radius / 5.0), 1.0 / r),
            None => (radius / 20.0, f64::INFINITY),
        };
        Self { chord_tolerance, step, curvature }
    }

    /// A tenth of the radius apart, for a first look: edges of the part between two samples can be missed.
    #[must_use]
    pub fn coarse(profile: &Profile, chord_tolerance: f64) -> Self {
        let step = (profile.outer_radius() / 10.0).max(Self::fine(profile, chord_tolerance).step);
        Self { chord_tolerance, step, curvature: 0.0 }
    }
}

/// A place on the line.
#[derive(Debug, Clone, Copy)]
struct Sample {
    /// The distance from the line's start.
    s: f64,
    /// Height and slope of T along the line; `None` if no facet is in reach and there is no floor.
    height: Option<[f64; 2]>,
    touch: Option<Touch>,
}

struct Line<'a> {
    drop: &'a DropCutter,
    profile: &'a Profile,
    start: [f64; 2],
    direction: [f64; 2],
    length: f64,
    floor: Option<f64>,
}

impl<'a> Line<'a> {
    fn new(drop: &'a DropCutter, profile: &'a Profile, [from, to]: [[f64; 2]; 2], floor: Option<f64>) -> Self {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = along[0].hypot(along[1]);
        let direction = if length > 0.0 { along.map(|part| part / length) } else { [1.0, 0.0] };
        Self { drop, profile, start: from, direction, length, floor }
    }

    fn place(&self, s: f64) -> [f64; 2] {
        [self.start[0] + s * self.direction[0], self.start[1] + s * self.direction[1]]
    }

    fn sample(&self, s: f64, near: Option<&Sample>) -> Sample {
        let [x, y] = self.place(s);
        let guess = near.and_then(|near| near.touch).map(|touch| touch.facet);
        let touch = self.drop.drop(self.profile, x, y, guess);
        let height = match touch {
            Some(touch) => {
                let uphill = -(touch.normal.x * self.direction[0] + touch.normal.y * self.direction[1]);
                // At a vertical contact a slope of 1e9 is as good as infinite, and can be multiplied by 0.
                Some([touch.height, (uphill / touch.normal.z.max(1e-9)).clamp(-1e9, 1e9)])
            }
            None => self.floor.map(|floor| [floor, 0.0]),
        };
        Sample { s, height, touch }
    }

    /// The tips, close enough for chords to keep their share of the tolerance.
    fn samples(&self, sampling: &Sampling) -> Vec<Tip> {
        let tolerance = sampling.chord_tolerance;
        let parts = (self.length / sampling.step).ceil().max(1.0);
        let step = self.length / parts;
        let mut last = self.sample(0.0, None);
        let mut tips = Vec::new();
        tips.extend(self.tip(&last));
        let mut ahead = Vec::new();
        let mut part = 0.0;
        while part < parts && self.length > 0.0 {
            part += 1.0;
            ahead.push(self.sample(if part < parts { part * step } else { self.length }, Some(&last)));
            // `last` and the end of `ahead` bound the next part of the line; the others wait in reverse order.
            while let Some(next) = ahead.last().copied() {
                let is_fine = Self::keeps(&last, &next, SAMPLING_SHARE * tolerance);
                let between = if is_fine {
                    self.missed_between(&last, &next, sampling)
                } else {
                    (next.s - last.s > SHORTEST).then_some(0.5 * (last.s + next.s))
                };
                if let Some(s) = between {
                    ahead.push(self.sample(s, Some(&last)));
                    continue;
                }
                if let (false, Some([low, _]), Some([high, _])) = (is_fine, last.height, next.height)
                    && (high - low).abs() > SAMPLING_SHARE * tolerance
                {
                    let lower = if low < high { last.s } else { next.s };
                    let [x, y] = self.place(lower);
                    tips.push(Tip { position: [x, y, low.max(high)], touch: None });
                }
                tips.extend(self.tip(&next));
                last = next;
                ahead.pop();
            }
        }
        tips
    }

    /// Where a sample is to be taken between two whose chord may cut too deep into what neither sees: halfway, or where the cutter
    /// touches the corner or edge of a facet that is highest over the chord.
    fn missed_between(&self, a: &Sample, b: &Sample, sampling: &Sampling) -> Option<f64> {
        let (Some([from, _]), Some([to, _])) = (a.height, b.height) else { return None };
        let (run, rise) = (b.s - a.s, to - from);
        let (tolerance, most) = (SAMPLING_SHARE * sampling.chord_tolerance, MOST_MISSED * sampling.chord_tolerance);
        let missed = sampling.curvature * (run * run + rise * rise) / 8.0;
        if missed <= most || rise.abs() <= tolerance {
            return None;
        }
        if missed <= MOST_SAMPLED * most {
            return Some(0.5 * (a.s + b.s));
        }
        let mut unseen = Unseen::new(self.profile, [a.s, b.s], [from, to], tolerance);
        let [x, y] = self.place(0.5 * (a.s + b.s));
        let widened = self.profile.widened(0.5 * (b.s - a.s));
        self.drop.each_over(&widened, [x, y, unseen.lowest], |corners| {
            unseen.look_at(corners.map(|[x, y, height]| {
                let out = [x - self.start[0], y - self.start[1]];
                let along = out[0] * self.direction[0] + out[1] * self.direction[1];
                [along, out[1] * self.direction[0] - out[0] * self.direction[1], height]
            }));
            true
        });
        unseen.place
    }

    fn tip(&self, sample: &Sample) -> Option<Tip> {
        let [x, y] = self.place(sample.s);
        sample.height.map(|[height, _]| Tip { position: [x, y, height], touch: sample.touch })
    }

    /// Whether T is within the tolerance of the chord between two samples, as far as its tangents there tell.
    fn keeps(a: &Sample, b: &Sample, tolerance: f64) -> bool {
        let (Some([low, first]), Some([high, last])) = (a.height, b.height) else { return a.height.is_none() && b.height.is_none() };
        let distance = b.s - a.s;
        if a.touch.is_some() != b.touch.is_some() && (high - low).abs() > tolerance {
            return false;
        }
        let chord = (high - low) / distance;
        // The tangents leave the chord at these slopes. If T bends one way it is between the chord and the tangents, which
        // meet on one side; else it may follow a tangent for half of the distance. Twice the tolerance is left for a T that
        // seems to bend one way and does not, as where it rises beside one sample and is straight from there.
        let (leaving, arriving) = (first - chord, chord - last);
        let astray = 0.5 * distance * leaving.abs().max(arriving.abs());
        let deviation =
            if leaving * arriving > 0.0 { (distance * leaving * arriving / (leaving + arriving)).abs().max(0.5 * astray) } else { astray };
        deviation <= tolerance
    }
}

/// Leaves out tips as long as the chords keep within `tolerance` of those left out. Both tips of a vertical step stay.
fn simplified(tips: Vec<Tip>, tolerance: f64) -> Vec<Tip> {
    const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    let mut kept: Vec<Tip> = Vec::with_capacity(tips.len());
    let mut waiting: Option<Tip> = None;
    // The slopes of lines from the last tip kept that pass all since within the tolerance.
    let mut slopes = ANY;
    for tip in tips {
        if let (Some(anchor), Some(skipped)) = (kept.last(), waiting) {
            let (run, rise) = run_and_rise(anchor, &tip);
            let is_step = run_and_rise(&skipped, &tip).0 <= 0.0;
            if is_step || !(slopes[0]..=slopes[1]).contains(&(rise / run)) {
                kept.push(skipped);
                slopes = ANY;
            }
        }
        let (run, rise) = kept.last().map_or((0.0, 0.0), |anchor| run_and_rise(anchor, &tip));
        if run > 0.0 {
            slopes = [slopes[0].max((rise - tolerance) / run), slopes[1].min((rise + tolerance) / run)];
            waiting = Some(tip);
        } else {
            kept.push(tip);
            (waiting, slopes) = (None, ANY);
        }
    }
    kept.extend(waiting);
    kept
}

fn run_and_rise(from: &Tip, to: &Tip) -> (f64, f64) {
    let [x, y, z] = [0, 1, 2].map(|axis| to.position[axis] - from.position[axis]);
    (x.hypot(y), z)
}

#[cfg(test)]
mod tests;
