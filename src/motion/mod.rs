//! How fast a machine moves: the limits of its drives, typical machines, and the time of a straight move between two stops.
//! Cutters and surfaces are outside this module.
//!
//! Source: Herraz et al. 2020, doi:10.1007/s00170-020-06087-y, section 2.2, with the case that it leaves out.

mod limits;
mod machine;
mod presets;
mod travel_time;

pub use limits::MachineLimits;
pub use machine::Machine;
pub use presets::{PRESETS, Preset};
pub use travel_time::{TravelCase, travel_time};
