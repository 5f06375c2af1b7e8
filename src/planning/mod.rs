//! Which of two cutters finishes a surface sooner: zigzag over an inclined rectangle, critical slope and form factor, recommendation
//! for a surface, and how far to trust it. Heights and step-overs come from `milling`, times from `motion`, shapes from `surface`.
//!
//! Symbols: w and h the rectangle's long and short side, mu = w/h its form factor, chi = w h its characteristic size, s the slope,
//! sh the scallop height, sod the step-over, T the machining time; 1 marks the toroidal cutter up and down the slope, 2 the
//! ball-end cutter along the long side.
//!
//! Source: Herraz et al. 2020, doi:10.1007/s00170-020-06087-y, with its misprints corrected.

mod confidence;
mod critical;
mod job;
mod recommendation;
mod rectangle;
mod root;
pub mod zigzag;

pub use confidence::{Confidence, Level, Reason, Weakness};
pub use critical::{CriticalFormFactor, CriticalSlope, critical_form_factor, critical_slope};
pub use job::{Job, JobError};
pub use recommendation::{Candidate, CutterChoice, Plan, PlanError, Recommendation, plan, recommend};
pub use rectangle::{HeightExceedsWidth, InclinedRectangle, Zigzag};
