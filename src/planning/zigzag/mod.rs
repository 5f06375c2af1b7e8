//! Method `surface`: simulates zigzag passes on the surface itself, to find the cutter that finishes it soonest.
//!
//! Passes lie in parallel vertical planes. For each candidate cutter and direction, [`rank`] spaces the planes by the
//! worst point of each strip between them, intersects them with the facets, and adds up the times of the runs and
//! links. The plan of the fastest direction is then checked by model `envelope` with the surface's own curvature. All
//! lengths are in mm, all times in s.
//!
//! The files in the order of use: `workpiece` prepares facets; `slopes` and `spacing` compute the spacings that a
//! cutter allows; `heading` is a direction; `sweep` sorts facets across it; `footprint`
//! shows where runs on sampled facets end; `spaced` adds their spacings; `march` places the planes;
//! `runs` intersects planes and facets; `regions` and `links` order the runs; `tour` adds up times; `simulate` combines
//! these steps. `room` limits the size of a plan; `prepared` is a candidate with its spacings; `search` tries
//! directions; `contacts`, `imprint` and `inspector` evaluate facets; `check` evaluates a plan; `refine` refines the
//! spacings that bind strips, and `fit` fits strips to wide facets; `least_time` is a lower bound of its time; `plan`
//! is the result; `ranking` is the entry point; `confidence` rates the ranking. `passes` lists the points of a plan:
//! `cuts` intersects its planes with the facets, and `tip_path` moves the cutter's tip over the cuts. `heights` computes a
//! plan's scallop heights at facets.

mod candidate;
mod check;
mod confidence;
mod contacts;
mod cuts;
mod fit;
mod footprint;
mod heading;
mod heights;
mod imprint;
mod inspector;
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
mod slivers;
mod slopes;
mod spaced;
mod spacing;
mod sweep;
mod tip_path;
mod tour;
mod workpiece;

pub use candidate::{CandidateCutter, Drive, ReachFigures};
pub use check::ScallopFigures;
pub use confidence::{SurfaceEvidence, SurfaceWeakness};
pub use heights::heights;
pub use passes::{PassPoint, Passes, TooManyPoints, bytes_of_passes, passes, passes_until};
pub use plan::{NotRanked, NotRankedReason, SpacingFigures, ZigzagPlan};
pub use ranking::{NoRanking, Ranking, rank, rank_within};
pub use room::PlanRoom;
pub use settings::{Directions, Pattern, ZigzagSettings};
pub use tour::TourFigures;
pub use workpiece::SurfaceFigures;
