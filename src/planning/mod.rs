//! Planning: the choice of the cutter that finishes a surface soonest. Heights and step-overs come from `milling`,
//! times from `motion`, shapes and facets from `surface`.
//!
//! There are two methods. [`rectangle`], the published one, replaces the surface by an inclined rectangle. [`mod@plan`] plans
//! the tips of the cutter on the part itself, and mills them.

mod confidence;
pub(crate) mod machined_surface;

pub mod plan;
pub mod rectangle;

pub use confidence::{Confidence, Level, PathEvidence, Reason, SurfaceEvidence, SurfaceWeakness};
pub use rectangle::{
    Candidate, CriticalFormFactor, CriticalSlope, CutterChoice, CutterComparison, Evidence, HeightExceedsWidth, InclinedRectangle,
    JobError, Plan, PlanError, Recommendation, RectanglePlan, Weakness, Zigzag, critical_form_factor, critical_slope, plan,
    plan_on_rectangle, recommend,
};
