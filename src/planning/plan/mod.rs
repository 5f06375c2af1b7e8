//! Method `surface`: plans the tips of a zigzag on the part itself, mills them, and ranks the cutters by their times.
//!
//! A plan is made of tips, not of contacts: the drop-cutter of [`crate::path`] tells the height at which the cutter can
//! stand. Lines are vertical planes, straight seen from above. For each candidate cutter, `stations` finds the tips that
//! finish places drawn over the surface by `places`, and `estimate` the time of each direction from them. The best
//! directions are planned: `spread` spaces the lines by what the stations allow, `runs` finds the tips along them,
//! `border` adds passes along the feet of walls, `order` and `tour` link the runs to one path, and `judged` mills it and
//! states what it leaves; `milled_plan` moves the lines until the scallop height is kept and used. `ranking` is the entry
//! point, `weakness` rates it, and `passes` lists the points of the path. All lengths are in mm, all times in s.

mod border;
mod candidate;
mod estimate;
mod judged;
mod left;
mod milled_plan;
mod order;
mod passes;
mod places;
mod prepared;
mod ranking;
mod runs;
mod settings;
mod slopes;
mod spacing;
mod spread;
mod stations;
mod tangent;
mod tour;
mod travel;
mod weakness;
mod workpiece;

pub use candidate::{CandidateCutter, Drive};
pub use judged::FinishFigures;
pub use left::{LeftAt, left_at};
pub use passes::{CutPoint, PassPoint, Passes, passes};
pub use ranking::{CandidatePlan, MilledFigures, NotRanked, NotRankedReason, Ranking, SpacingFigures, estimated_times, rank};
pub use settings::{Directions, Pattern, PlanSettings};
pub use tour::TourFigures;
pub use travel::APPROACH_HEIGHT;
pub use weakness::{SurfaceEvidence, SurfaceWeakness};
pub use workpiece::{SurfaceFigures, Workpiece};
