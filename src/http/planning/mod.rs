//! The planning endpoints: critical slope of a rectangle, cutter recommendation for a surface in JSON or in a file, and
//! machine presets. Each endpoint has a file; they share the other files.

mod answer;
mod candidates;
mod confidence;
pub(crate) mod critical_slope;
mod job;
mod library;
pub(crate) mod machines;
mod map;
mod memory;
mod parameters;
mod passes;
mod plan;
pub(crate) mod recommendation;
mod shape;
mod simulation;
pub(crate) mod upload;
