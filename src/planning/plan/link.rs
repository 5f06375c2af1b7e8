//! Links: how the tool gets to a run, from one to the next, and away from the last, on the surface or over the clearance height.

use super::runs::{RunTip, STEP_IN_RADII, highest_step};
use super::settings::{Pattern, PlanSettings};
use super::spacing::Prepared;
use super::travel::{self, APPROACH_HEIGHT};
use super::workpiece::Workpiece;
use crate::path::{Sampling, tips_between};

/// Links longer than this in radii of the cutter go over the clearance height.
const NEAR_IN_RADII: f64 = 6.0;

/// A link between two runs, the approach to the first, or the retreat from the last.
#[derive(Debug, Default)]
pub(super) struct Link {
    /// The points over the part, at the rapid rate, which come first.
    pub(super) rapid: Vec<[f64; 3]>,
    /// The points at the rate of links; the last is the first tip of the run.
    pub(super) fed: Vec<[f64; 3]>,
    pub(super) length: f64,
    /// The time in s of its straight parts, each from rest to rest.
    pub(super) seconds: f64,
    /// The time in s without acceleration.
    pub(super) moving_seconds: f64,
}

/// Makes the links of a path.
pub(super) struct Linker<'a> {
    workpiece: &'a Workpiece,
    prepared: &'a Prepared,
    settings: &'a PlanSettings,
    chord_tolerance: f64,
    /// The height in mm at which rapid moves cross the part.
    clearance: f64,
    rapid_rate: f64,
}

impl<'a> Linker<'a> {
    pub(super) fn new(workpiece: &'a Workpiece, prepared: &'a Prepared, settings: &'a PlanSettings, chord_tolerance: f64) -> Self {
        let clearance = workpiece.top + settings.machine.clearance_height.mm();
        Self { workpiece, prepared, settings, chord_tolerance, clearance, rapid_rate: settings.machine.rapid_rate.mm_s() }
    }

    /// The longest link on the surface, in mm seen from above.
    pub(super) fn near(&self) -> f64 {
        NEAR_IN_RADII * self.prepared.profile.outer_radius()
    }

    /// From the clearance height straight down to a tip.
    pub(super) fn approach(&self, to: [f64; 3]) -> Link {
        let Self { clearance, rapid_rate, .. } = *self;
        let (machine, link_rate) = (&self.settings.machine, self.prepared.link_rate);
        let near = (to[2] + APPROACH_HEIGHT).min(clearance);
        Link {
            rapid: [clearance, near].map(|height| [to[0], to[1], height]).to_vec(),
            fed: vec![to],
            length: clearance - to[2],
            seconds: travel::straight(clearance - near, rapid_rate, machine) + travel::straight(near - to[2], link_rate, machine),
            moving_seconds: (clearance - near) / rapid_rate + (near - to[2]) / link_rate,
        }
    }

    /// From a tip straight up to the clearance height.
    pub(super) fn retreat(&self, [x, y, z]: [f64; 3]) -> Link {
        let length = self.clearance - z;
        let seconds = travel::straight(length, self.rapid_rate, &self.settings.machine);
        Link { rapid: vec![[x, y, self.clearance]], fed: Vec::new(), length, seconds, moving_seconds: length / self.rapid_rate }
    }

    /// From a run to the next one: on the surface where the way is short, has no step and is sooner than over the clearance height.
    pub(super) fn between(&self, run: &[&RunTip], next: &[&RunTip]) -> Link {
        let [(Some(from), before), (Some(to), after)] = [end_of(run.iter().rev()), end_of(next.iter())] else { return Link::default() };
        let lift = self.lift(from, to);
        let is_near = (to[0] - from[0]).hypot(to[1] - from[1]) <= self.near();
        if !is_near || self.settings.pattern == Pattern::OneWay {
            return lift;
        }
        let surface = self.on_surface(&[from, to]).or_else(|| {
            // Around the corner of a wall: along the run before until the next one is abeam, or the other way round.
            let corners = [before.and_then(|before| abeam(from, before, to)), after.and_then(|after| abeam(to, after, from))];
            let links = corners.into_iter().flatten().filter_map(|[x, y]| {
                let touch = self.workpiece.drop.drop(&self.prepared.profile, x, y, None)?;
                self.on_surface(&[from, [x, y, touch.height], to])
            });
            links.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
        });
        surface.filter(|link| link.seconds <= lift.seconds).unwrap_or(lift)
    }

    /// Up, across, and down.
    fn lift(&self, from: [f64; 3], to: [f64; 3]) -> Link {
        let Self { clearance, rapid_rate, .. } = *self;
        let link_rate = self.prepared.link_rate;
        let rapid =
            vec![[from[0], from[1], clearance], [to[0], to[1], clearance], [to[0], to[1], (to[2] + APPROACH_HEIGHT).min(clearance)]];
        let length = travel::length_of([from].iter().chain(&rapid).chain([to].iter()));
        Link {
            rapid,
            fed: vec![to],
            length,
            seconds: travel::lift(from, to, clearance, link_rate, &self.settings.machine),
            moving_seconds: (length - APPROACH_HEIGHT) / rapid_rate + APPROACH_HEIGHT / link_rate,
        }
    }

    /// On the surface, straight from corner to corner seen from above; `None` over a step that is too high for the feed rate.
    fn on_surface(&self, corners: &[[f64; 3]]) -> Option<Link> {
        let link_rate = self.prepared.link_rate;
        let mut link = Link::default();
        for ends in corners.windows(2) {
            let points = self.straight_on_surface(ends[0], ends[1]);
            if highest_step(&points) > STEP_IN_RADII * self.prepared.profile.outer_radius() {
                return None;
            }
            let length = travel::length_of(points.iter());
            link.length += length;
            link.seconds += travel::straight(length, link_rate, &self.settings.machine);
            link.fed.extend(points.into_iter().skip(1));
        }
        link.fed.dedup_by(|tip, before| travel::distance(*tip, *before) <= travel::NEGLIGIBLE);
        link.moving_seconds = link.length / link_rate;
        Some(link)
    }

    /// A straight link seen from above that is nowhere under the tips' surface: straight in space where it can be.
    fn straight_on_surface(&self, from: [f64; 3], to: [f64; 3]) -> Vec<[f64; 3]> {
        let floor = from[2].min(to[2]);
        let profile = &self.prepared.profile;
        let sampling = Sampling::fine(profile, self.chord_tolerance);
        let tips = tips_between(&self.workpiece.drop, profile, [from[0], from[1]], [to[0], to[1]], &sampling, Some(floor));
        let across = (to[0] - from[0]).hypot(to[1] - from[1]).max(1e-12);
        let straight = |x: f64, y: f64| from[2] + (to[2] - from[2]) * (x - from[0]).hypot(y - from[1]) / across;
        let mut points = vec![from];
        for tip in tips {
            let [x, y, z] = tip.position;
            let height = straight(x, y);
            if z > height + self.chord_tolerance {
                points.push([x, y, z]);
            } else if points.len() > 1 {
                points.push([x, y, height.max(z)]);
            }
        }
        points.push(to);
        points
    }
}

/// The first of some tips, and the first that lies elsewhere.
fn end_of<'a>(mut tips: impl Iterator<Item = &'a &'a RunTip>) -> (Option<[f64; 3]>, Option<[f64; 3]>) {
    let end = tips.next().map(|tip| tip.tip);
    (end, tips.map(|tip| tip.tip).find(|tip| Some(*tip) != end))
}

/// The point on the line from the end of a run through another point of it that is abeam of a third one, seen from above; `None`
/// beyond the end.
fn abeam(end: [f64; 3], through: [f64; 3], of: [f64; 3]) -> Option<[f64; 2]> {
    let along = [through[0] - end[0], through[1] - end[1]];
    let share = (along[0] * (of[0] - end[0]) + along[1] * (of[1] - end[1])) / (along[0] * along[0] + along[1] * along[1]);
    (share > 0.0 && share.is_finite()).then(|| [0, 1].map(|axis| end[axis] + share * along[axis]))
}
