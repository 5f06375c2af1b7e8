//! Corners and edges of facets that a cutter passes between two samples of a line, seen by neither.

use super::bottom::{Bottom, Touching};
use crate::milling::Profile;
use crate::numerics::vector::{difference, length};

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
