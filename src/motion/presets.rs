//! Machine presets: named classes of machines with typical limits and their source.

use super::MachineLimits;
use crate::quantity::{Acceleration, Jerk, Length, Speed};

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
    use std::collections::HashSet;

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
