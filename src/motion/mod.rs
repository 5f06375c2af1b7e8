//! Machine limits, machine presets, and the time of a straight move and of a path with limited jerk. Independent of cutters and
//! surfaces.
//!
//! Source: Herraz et al. 2020, doi:10.1007/s00170-020-06087-y, section 2.2. The paper omits the fourth case, which is added
//! here.

mod machine;
mod path_time;
mod travel_time;

pub use machine::{Machine, PRESETS, Preset, TimedMove};
pub use path_time::path_time;
pub use travel_time::{MachineLimits, TravelCase, speed_after, travel_time};
