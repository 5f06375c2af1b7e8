//! Which cutter finishes a surface soonest: critical slope of a rectangle, recommendation for a surface sent as JSON or as a file, and the
//! machine presets. One file for each endpoint holds what is particular to it; the rest is what they share.

mod answer;
mod candidates;
mod confidence;
pub(crate) mod critical_slope;
mod job;
mod library;
pub(crate) mod machines;
mod map;
mod memory;
mod multipart;
mod parameters;
mod passes;
mod plan;
pub(crate) mod recommendation;
mod shape;
mod simulation;
pub(crate) mod upload;
