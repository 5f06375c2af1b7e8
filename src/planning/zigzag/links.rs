//! Links: the moves from the end of one run to the start of the next.

use super::settings::Pattern;
use crate::motion::{Machine, MachineLimits, travel_time};
use crate::quantity::{Length, Speed};

/// The end of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    /// The coordinates along the passes, across them and upwards.
    pub(super) place: [f64; 3],
    /// The interval of the run along the passes.
    pub(super) along: [f64; 2],
    /// The index of the run's plane.
    pub(super) plane: usize,
}

/// The move between two runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    pub(super) length: f64,
    pub(super) seconds: f64,
    /// Whether it goes over the clearance height.
    pub(super) is_lift: bool,
}

/// The rules for links.
#[derive(Debug, Clone, Copy)]
pub(super) struct Links {
    on_surface: MachineLimits,
    rapid: MachineLimits,
    pattern: Pattern,
    /// The longest link on the surface, in mm, except between runs that overlap in neighbouring planes.
    pub(super) longest: f64,
    clearance: f64,
}

impl Links {
    /// `rate` is the feed rate of links on the surface in mm/s, `top` the highest point of the surface.
    pub(super) fn new(machine: &Machine, pattern: Pattern, rate: f64, longest: f64, top: f64) -> Self {
        Self {
            on_surface: MachineLimits { feed_rate: Speed::computed(rate), ..machine.limits },
            rapid: machine.rapid_limits(),
            pattern,
            longest,
            clearance: top + machine.clearance_height.mm(),
        }
    }

    /// A link stays on the surface in two cases. Between overlapping runs of neighbouring planes, the strip between
    /// them connects both ends, however far apart these are. Other links stay on the surface if they are shorter than
    /// the gaps over which runs are joined.
    pub(super) fn between(&self, from: End, to: End) -> Link {
        let (start, end) = (from.place, to.place);
        let across = (end[0] - start[0]).hypot(end[1] - start[1]);
        let is_next = from.plane.abs_diff(to.plane) == 1 && (end[1] - start[1]).abs() <= self.longest;
        let is_beside = is_next && to.along[0] < from.along[1] && from.along[0] < to.along[1];
        if self.pattern == Pattern::Zigzag && (is_beside || across <= self.longest) {
            let length = across.hypot(end[2] - start[2]);
            Link { length, seconds: straight(length, self.on_surface), is_lift: false }
        } else {
            // A run beside a steep sliver, on the extension of its facet, may end above the surface.
            let top = self.clearance.max(start[2]).max(end[2]);
            let parts = [top - start[2], across, top - end[2]];
            let seconds = parts.iter().map(|&length| straight(length, self.rapid)).sum();
            Link { length: parts.iter().sum(), seconds, is_lift: true }
        }
    }
}

pub(super) fn straight(length: f64, limits: MachineLimits) -> f64 {
    travel_time(Length::computed(length), limits).seconds()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Preset;

    #[test]
    fn a_lift_from_above_the_clearance_height_only_goes_down() {
        let machine = Machine::from(Preset::named("five_axis_vmc").unwrap().limits);
        let links = Links::new(&machine, Pattern::Zigzag, 80.0, 2.0, 0.0);
        let end = |x: f64, height: f64| End { place: [x, 0.0, height], along: [x, x + 1.0], plane: 0 };
        let clearance = machine.clearance_height.mm();
        let low = links.between(end(0.0, -3.0), end(100.0, -1.0));
        assert!(low.is_lift && (low.length - (104.0 + 2.0 * clearance)).abs() < 1e-9);
        let high = links.between(end(0.0, clearance + 5.0), end(100.0, -1.0));
        assert!(high.is_lift && (high.length - (106.0 + clearance)).abs() < 1e-9);
    }
}
