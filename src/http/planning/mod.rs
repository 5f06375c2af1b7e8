//! Which cutter finishes a surface sooner: critical slope of a rectangle, recommendation for a surface sent as JSON or as a file, and the
//! machines to name. One file per endpoint holds what is particular to it; the rest is what they share.

mod answer;
mod bounded;
mod candidates;
pub(crate) mod critical_slope;
mod job;
mod machine;
pub(crate) mod machines;
mod multipart;
mod points;
pub(crate) mod recommendation;
mod source;
mod stated_surface;
pub(crate) mod upload;
