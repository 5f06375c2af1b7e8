//! Which cutter finishes a surface sooner. Heights and step-overs come from `milling`, times from `motion`, shapes
//! and facets from `surface`.
//!
//! Two methods: [`rectangle`], the published one, puts an inclined rectangle in place of the surface; [`zigzag`]
//! simulates the passes on the surface itself.

mod confidence;
pub mod memory;
pub mod reach;
pub mod rectangle;
pub mod zigzag;

pub use confidence::Level;
pub use rectangle::{
    Candidate, Confidence, CriticalFormFactor, CriticalSlope, CutterChoice, Evidence, HeightExceedsWidth, InclinedRectangle, Job, JobError,
    Plan, PlanError, Reason, Recommendation, RectanglePlan, Weakness, Zigzag, critical_form_factor, critical_slope, plan,
    plan_on_rectangle, recommend,
};
