//! Method `surface`: plans the tips of a zigzag on the part itself, mills them, and ranks the cutters by their times.
//!
//! A plan is made of tips, not of contacts: the drop-cutter of [`crate::path`] tells the height at which the cutter can
//! stand. Lines are vertical planes, straight seen from above. For each candidate cutter, `stations` finds the tips that
//! finish places drawn over the surface by `drawn_places`, and `estimate` the time of each direction from them. The best
//! directions are planned: `spread` spaces the lines by what the stations allow, `runs` finds the tips along them,
//! `missed` adds runs over what the lines miss, `order`, `link` and `tour` make them one path, and `judged` mills it and
//! states what it leaves; `milled_plan` moves the lines until the scallop height is kept and used, and `thinned` leaves out the
//! stretches of lines without which the others suffice. `ranking` is the entry point, `plan_confidence` rates it, and `passes`
//! lists the points of the path. All lengths are in mm, all times in s.

mod arrangement;
mod candidate;
mod candidate_plan;
mod cells;
mod chain;
mod cut_lines;
mod deepest_cut;
mod drawn_places;
mod estimate;
mod estimated_candidate;
mod family;
mod hollows;
mod judged;
mod left;
mod levels;
mod link;
mod milled_plan;
mod missed;
mod operations;
mod order;
mod passes;
mod plan_confidence;
mod prepared;
mod ranking;
mod region;
mod rest;
mod runs;
mod settings;
mod slopes;
mod spacing;
mod spread;
mod stations;
mod tangent;
mod thinned;
mod tour;
mod travel;
mod workpiece;

pub(in crate::planning) use candidate::FeedRange;
pub use candidate::{CandidateCutter, Drive};
pub use candidate_plan::{CandidatePlan, MilledFigures, NotRankedReason, SpacingFigures, UnrankedCandidate};
pub use estimated_candidate::estimated_times;
pub use judged::FinishFigures;
pub use left::{LeftAt, left_at, left_at_by_all, lifts_at};
pub use operations::{Lines, OperationPlan, OperationsPlan};
pub use passes::{CutPoint, PassPoint, Passes, passes, passes_of_all};
pub use ranking::{Ranking, rank};
pub use settings::{Directions, Pattern, PlanSettings};
pub use tour::TourFigures;
pub use travel::APPROACH_HEIGHT;
pub use workpiece::{SurfaceFigures, Workpiece};
