//! Method surface: zigzag passes simulated on the surface itself, to find the cutter that finishes it soonest.
//!
//! Passes lie in parallel vertical planes. For each candidate cutter and direction, [`rank`] spaces the planes by the
//! worst point of each strip between them, cuts the facets with them, and adds up the times of the runs and links;
//! the fastest direction's plan is then checked by model `envelope` with the surface's own curvature. All lengths are
//! in mm, all times in s.
//!
//! The files, in the order in which they are used: `workpiece` prepares facets, `slopes` and `spacing` have the
//! spacings that a cutter allows, `sweep` orders facets across a direction, `march` places the planes, `runs` cuts the
//! facets, `regions` and `links` order the runs, `tour` adds up times, `simulate` joins these, `room` bounds the size
//! of a plan, `prepared` holds a candidate, `search` tries directions, `contacts` and `check` evaluate a plan,
//! `least_time` bounds it, `plan` holds it, `ranking` is the entry, `confidence` rates the order of the plans, `passes`
//! gives a plan point by point, `heights` its scallops facet by facet.

mod candidate;
mod check;
mod confidence;
mod contacts;
mod heights;
mod imprint;
mod least_time;
mod links;
mod march;
mod passes;
mod plan;
mod prepared;
mod ranking;
mod refine;
mod regions;
mod room;
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
pub use plan::{NotRanked, NotRankedReason, SpacingFigures, ZigzagPlan};
pub use ranking::{NoRanking, Ranking, rank, rank_within};
pub use room::PlanRoom;
pub use settings::{Directions, Pattern, ZigzagSettings};
pub use tour::TourFigures;
pub use workpiece::SurfaceFigures;
