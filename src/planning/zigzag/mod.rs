//! Which cutter finishes a surface soonest, by simulating zigzag passes on the surface itself.

mod candidate;
mod march;
mod runs;
mod search;
mod settings;
mod simulate;
mod slopes;
mod spacing;
mod sweep;
mod tour;
mod workpiece;
pub mod ranking;

pub use candidate::{CandidateCutter, Drive, ReachFigures};
pub use settings::{Directions, ZigzagSettings};
pub use tour::{Pattern, TourFigures};
