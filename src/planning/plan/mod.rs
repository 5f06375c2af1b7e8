//! Method `surface`: plans the tips of a zigzag on the part itself, mills them, and ranks the cutters by their times.
//!
//! A plan is made of tips, not of contacts: the drop-cutter of [`crate::path`] tells the height at which the cutter can
//! stand. Lines are vertical planes, straight seen from above. For each candidate cutter, `stations` draws places over the
//! surface with the tips that finish them, and `estimate` finds the time of each direction from them. The best directions are
//! planned: `family` spaces the lines by what the stations allow, `runs` finds the tips along them, `missed` adds runs over what
//! the lines miss, `link` and `tour` make them one path, and `judged` states what it leaves; `milled_plan` moves the lines
//! until the scallop height is kept and used, and `thinned` leaves out the stretches of lines without which the others suffice.
//! `ranking` is the entry point, `plan_confidence` rates it, and `passes` lists the points of the path. All lengths are in mm,
//! all times in s.

mod candidate_plan;
mod cut_lines;
mod estimate;
mod estimated_candidate;
mod family;
mod judged;
mod left;
mod levels;
mod link;
mod milled_plan;
mod missed;
mod operations;
mod passes;
mod plan_confidence;
mod ranking;
mod runs;
mod settings;
mod spacing;
mod stations;
mod tangent;
mod thinned;
mod tour;
mod travel;
mod workpiece;

pub use candidate_plan::{CandidatePlan, MilledFigures, NotRankedReason, SpacingFigures, UnrankedCandidate};
pub use estimated_candidate::estimated_times;
pub use judged::FinishFigures;
pub use left::{LeftAt, left_at, left_at_by_all, lifts_at};
pub use operations::{Lines, OperationPlan, OperationsPlan};
pub use passes::{CutPoint, PassPoint, Passes, passes, passes_of_all};
pub use ranking::{Ranking, rank};
pub(in crate::planning) use settings::FeedRange;
pub use settings::{CandidateCutter, Directions, Drive, Pattern, PlanSettings};
pub use tour::TourFigures;
pub use travel::APPROACH_HEIGHT;
pub use workpiece::{SurfaceFigures, Workpiece};
