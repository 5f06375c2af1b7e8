//! Which cutter finishes a surface soonest, by simulating zigzag passes on the surface itself.
//!
//! Passes lie in parallel vertical planes. For each candidate cutter and direction, [`rank`] spaces the planes by the worst point of each strip
//! between them, cuts the facets with them, and adds up the times of the runs and links; the fastest direction's plan is then checked
//! by model `envelope` with the surface's own curvature. All lengths are in mm, all times in s.
//!
//! The files, in the order in which they are used: `workpiece` prepares facets, `slopes` and `spacing` hold what a cutter allows, `sweep` orders facets
//! across a direction, `march` places the planes, `runs` cuts the facets, `tour` adds up times, `simulate` joins these three, `search` tries
//! directions, `contacts` and `check` judge a plan, `least_time` bounds it, `ranking` is the entry, `confidence` says how far to trust it,
//! `passes` gives a plan point by point, `heights` its scallops facet by facet.

mod candidate;
mod check;
mod confidence;
mod contacts;
mod heights;
mod least_time;
mod march;
mod passes;
mod ranking;
mod runs;
mod search;
mod settings;
mod simulate;
mod slopes;
mod spacing;
mod sweep;
mod tour;
mod workpiece;

pub use candidate::{CandidateCutter, Drive, ReachFigures};
pub use check::ScallopFigures;
pub use confidence::{SurfaceConfidence, SurfaceEvidence, SurfaceReason, SurfaceWeakness};
pub use heights::heights;
pub use passes::{PassPoint, Passes, TooManyPoints, bytes_of_passes, passes};
pub use ranking::{NotRanked, NotRankedReason, Ranking, SpacingFigures, SurfaceFigures, ZigzagPlan, rank};
pub use settings::{Directions, ZigzagSettings};
pub use tour::{Pattern, TourFigures};
