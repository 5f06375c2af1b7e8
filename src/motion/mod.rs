//! Machine limits, machine presets, and the time of a straight move with limited jerk. Independent of cutters and surfaces.
//!
//! Source: Herraz et al. 2020, doi:10.1007/s00170-020-06087-y, section 2.2. The paper omits the fourth case, which is
//! added here.

mod limits;
mod machine;
mod presets;
mod travel_time;

pub use limits::MachineLimits;
pub use machine::Machine;
pub use presets::{PRESETS, Preset};
pub use travel_time::{TravelCase, travel_time};
