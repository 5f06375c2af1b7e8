//! Which cutter finishes a surface sooner: critical slope of a rectangle, recommendation for a surface sent as JSON or as a file, and the
//! machine presets. One file for each endpoint holds what is particular to it; the rest is what they share.

mod answer;
mod candidates;
pub(crate) mod critical_slope;
mod job;
pub(crate) mod machines;
mod multipart;
pub(crate) mod recommendation;
pub(crate) mod upload;
