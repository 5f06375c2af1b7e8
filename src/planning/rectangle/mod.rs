//! Method `rectangle`, the published one: a rectangle inclined about its long side replaces the surface. It has the
//! critical slope and form factor, the recommendation of one of two cutters, and the confidence in it.
//!
//! Symbols: w and h the rectangle's long and short side, mu = w/h its form factor, chi = w h its characteristic size, s
//! the slope, sh the scallop height, sod the step-over, T the machining time; index 1 is the toroidal cutter up and
//! down the slope, index 2 the ball-end cutter along the long side.
//!
//! Source: Herraz et al. 2020, doi:10.1007/s00170-020-06087-y, with its misprints corrected.

mod critical;
mod cutter_comparison;
mod inclined;
mod published_recommendation;
mod rectangle_plan;

pub use critical::{CriticalFormFactor, CriticalSlope, critical_form_factor, critical_slope};
pub use cutter_comparison::{CutterComparison, JobError};
pub use inclined::{HeightExceedsWidth, InclinedRectangle, Zigzag};
pub use published_recommendation::{Evidence, PlanError, Recommendation, Weakness, recommend};
pub use rectangle_plan::{Candidate, CutterChoice, Plan, RectanglePlan, plan, plan_on_rectangle};
