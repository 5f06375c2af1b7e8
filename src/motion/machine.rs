//! A machine tool: the limits of its feed moves, its rapid rate, its spindle speed and its clearance height; and named classes
//! of machines with typical limits and their source.

use super::{MachineLimits, path_time, travel_time};
use crate::numerics::vector::{difference, dot, length};
use crate::quantity::{Acceleration, Jerk, Length, Speed, SpindleSpeed, Time};

/// The cosine of the angle of 45° over which a corner is the end of a run: here a control without path tolerance stops.
const STOP_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A machine tool. Rapid moves have the acceleration and the jerk of feed moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// The limits of moves at the feed rate.
    pub limits: MachineLimits,
    /// The speed of moves that do not cut.
    pub rapid_rate: Speed,
    /// The largest spindle speed; `None` if no limit is known.
    pub max_spindle_speed: Option<SpindleSpeed>,
    /// The height over the highest point of the surface at which rapid moves cross it.
    pub clearance_height: Length,
    /// The tolerance within which the control rounds corners. `None`: it stops at the ends of every run and link.
    pub path_tolerance: Option<Length>,
    /// What multiplies every time: the time that a shop measured over the one that was stated.
    pub time_factor: f64,
    /// The stated time of a tool change, before `time_factor`.
    pub tool_change: Time,
}

/// A straight move to be timed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedMove {
    /// Where the move begins, in mm.
    pub from: [f64; 3],
    /// Where it ends, in mm.
    pub to: [f64; 3],
    /// The feed rate; `None` for a rapid.
    pub feed_rate: Option<Speed>,
}

impl Machine {
    /// The time of moves in their order. Each rapid is from rest to rest. So is each run of moves at the feed rate that
    /// follow each other: by [`path_time`] where the control has a path tolerance, else from one corner of more than 45° to
    /// the next as one straight move at the mean feed rate.
    #[must_use]
    pub fn time_of(&self, moves: impl IntoIterator<Item = TimedMove>) -> Time {
        let mut seconds = 0.0;
        let mut run = (Vec::new(), Vec::new());
        for each in moves {
            if let Some(feed_rate) = each.feed_rate
                && run.0.last().is_none_or(|last| length(difference(each.from, *last)) <= 0.0)
            {
                if run.0.is_empty() {
                    run.0.push(each.from);
                }
                run.0.push(each.to);
                run.1.push(feed_rate);
                continue;
            }
            seconds += self.run_seconds(&run.0, &run.1);
            run.0.clear();
            run.1.clear();
            match each.feed_rate {
                Some(feed_rate) => {
                    run.0.extend([each.from, each.to]);
                    run.1.push(feed_rate);
                }
                None => seconds += travel_time(Length::computed(length(difference(each.to, each.from))), self.rapid_limits()).seconds(),
            }
        }
        seconds += self.run_seconds(&run.0, &run.1);
        Time::computed(self.time_factor * seconds)
    }

    fn run_seconds(&self, points: &[[f64; 3]], feed_rates: &[Speed]) -> f64 {
        if let Some(tolerance) = self.path_tolerance {
            return path_time(points, feed_rates, self.limits, tolerance).seconds();
        }
        let (mut seconds, mut whole, mut at_feed) = (0.0, 0.0, 0.0);
        let mut last: Option<[f64; 3]> = None;
        for (ends, feed_rate) in points.windows(2).zip(feed_rates) {
            let along = difference(ends[1], ends[0]);
            let step = length(along);
            if step <= 0.0 {
                continue;
            }
            if last.is_some_and(|last| dot(last, along) < STOP_COSINE * length(last) * step) {
                seconds += self.straight_seconds(whole, at_feed);
                (whole, at_feed) = (0.0, 0.0);
            }
            whole += step;
            at_feed += step / feed_rate.mm_s();
            last = Some(along);
        }
        seconds + self.straight_seconds(whole, at_feed)
    }

    /// The time of a straight move from rest to rest of a length in mm that takes the second argument in s at its feed rate.
    fn straight_seconds(&self, whole: f64, at_feed: f64) -> f64 {
        if whole <= 0.0 {
            return 0.0;
        }
        let limits = MachineLimits { feed_rate: Speed::computed(whole / at_feed), ..self.limits };
        travel_time(Length::computed(whole), limits).seconds()
    }

    /// The time that a tool change takes.
    #[must_use]
    pub fn change_time(&self) -> Time {
        Time::computed(self.time_factor * self.tool_change.seconds())
    }

    /// The limits of a straight move at the rapid rate.
    #[must_use]
    pub fn rapid_limits(&self) -> MachineLimits {
        MachineLimits { feed_rate: self.rapid_rate, ..self.limits }
    }
}

impl From<MachineLimits> for Machine {
    /// A machine of which only the limits of feed moves are known. Its rapid rate is the feed rate, its spindle speed
    /// has no limit, it crosses the part 5 mm above the highest point,
    /// it stops at the ends of runs, and it changes tools in 10 s.
    fn from(limits: MachineLimits) -> Self {
        Self {
            limits,
            rapid_rate: limits.feed_rate,
            max_spindle_speed: None,
            clearance_height: Length::computed(5.0),
            path_tolerance: None,
            time_factor: 1.0,
            tool_change: Time::computed(10.0),
        }
    }
}

/// A named machine with its limits and their source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// The stable name used in requests.
    pub name: &'static str,
    /// The class of machines.
    pub description: &'static str,
    /// Feed rate of finishing, acceleration and jerk.
    pub limits: MachineLimits,
    /// A path tolerance that is usual for finishing on such machines. It holds only where a request states it.
    pub usual_path_tolerance: Length,
    /// The publication of the values, or "typical" if they are the usual order of magnitude of the class.
    pub source: &'static str,
}

impl Preset {
    /// The preset with this name; `None` if there is none.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }
}

/// All presets, from the slowest drives to the fastest.
pub const PRESETS: [Preset; 5] = [
    Preset {
        name: "hobby_router",
        description: "Belt- or screw-driven hobby router with stepper motors",
        limits: limits(2500.0, 0.4, 8.0),
        usual_path_tolerance: tolerance(0.02),
        source: "typical",
    },
    Preset {
        name: "vmc",
        description: "Three-axis vertical machining centre with ball screws",
        limits: limits(6000.0, 3.0, 25.0),
        usual_path_tolerance: tolerance(0.01),
        source: "typical",
    },
    Preset {
        name: "five_axis_vmc",
        description: "Five-axis machining centre finishing free-form surfaces",
        limits: limits(5000.0, 6.0, 40.0),
        usual_path_tolerance: tolerance(0.01),
        source: "Herraz et al. 2020, doi:10.1007/s00170-020-06087-y, section 4",
    },
    Preset {
        name: "five_axis_gantry",
        description: "Five-axis gantry for large moulds and aircraft parts",
        limits: limits(12_000.0, 2.5, 20.0),
        usual_path_tolerance: tolerance(0.02),
        source: "typical",
    },
    Preset {
        name: "high_speed_mould",
        description: "High-speed mould and die machine with linear motors",
        limits: limits(15_000.0, 15.0, 200.0),
        usual_path_tolerance: tolerance(0.005),
        source: "typical",
    },
];

/// A path tolerance of a preset.
const fn tolerance(mm: f64) -> Length {
    match Length::from_mm(mm) {
        Ok(tolerance) => tolerance,
        Err(_) => panic!("a preset is out of bounds"),
    }
}

/// The limits of a preset. Bounds are checked at compile time.
const fn limits(feed_rate_mm_min: f64, acceleration_m_s2: f64, jerk_m_s3: f64) -> MachineLimits {
    match (Speed::from_mm_min(feed_rate_mm_min), Acceleration::from_m_s2(acceleration_m_s2), Jerk::from_m_s3(jerk_m_s3)) {
        (Ok(feed_rate), Ok(acceleration), Ok(jerk)) => MachineLimits { feed_rate, acceleration, jerk },
        _ => panic!("a preset is out of bounds"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Acceleration, Jerk};
    use approx::assert_relative_eq;
    use std::collections::HashSet;

    #[test]
    fn a_control_without_path_tolerance_stops_in_sharp_corners() {
        let limits = MachineLimits {
            feed_rate: Speed::from_mm_min(3000.0).unwrap(),
            acceleration: Acceleration::from_m_s2(2.0).unwrap(),
            jerk: Jerk::from_m_s3(50.0).unwrap(),
        };
        let machine = Machine::from(limits);
        let time = |corners: &[[f64; 3]]| {
            let moves = corners.windows(2).map(|ends| TimedMove { from: ends[0], to: ends[1], feed_rate: Some(limits.feed_rate) });
            machine.time_of(moves).seconds()
        };
        let straight = |length: f64| travel_time(Length::from_mm(length).unwrap(), limits).seconds();
        let two_squares = 2.0 * 2f64.sqrt();
        assert_relative_eq!(time(&[[0.0; 3], [2.0, 0.0, 0.0], [5.0, 0.0, 0.0]]), straight(5.0));
        // A turn of 44° and one of 46°.
        let after = |turn: f64| [2.0 + 2.0 * turn.to_radians().cos(), 2.0 * turn.to_radians().sin(), 0.0];
        assert_relative_eq!(time(&[[0.0; 3], [2.0, 0.0, 0.0], after(44.0)]), straight(4.0), max_relative = 1e-12);
        assert_relative_eq!(time(&[[0.0; 3], [2.0, 0.0, 0.0], after(46.0)]), 2.0 * straight(2.0), max_relative = 1e-12);
        // A tip that stands twice does not hide the corner.
        let back = [[0.0; 3], [2.0, 2.0, 0.0], [2.0, 2.0, 0.0], [0.0; 3]];
        assert_relative_eq!(time(&back), 2.0 * straight(two_squares), max_relative = 1e-12);
    }

    #[test]
    fn names_are_unique_and_found() {
        let names: HashSet<_> = PRESETS.iter().map(|preset| preset.name).collect();
        assert_eq!(names.len(), PRESETS.len());
        for preset in &PRESETS {
            assert_eq!(Preset::named(preset.name), Some(preset));
        }
        assert_eq!(Preset::named("five-axis"), None);
    }
}
