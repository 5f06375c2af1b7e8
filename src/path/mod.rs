//! Tool paths: where the tip of a cutter can stand on a part, lines along which it runs, moves, and what they leave on a
//! surface.

mod body;
mod bottom;
mod check;
mod contour;
mod drop_cutter;
mod facet_tree;
mod feeds;
mod finish;
mod milled;
mod places;
pub mod program;
mod standing;
#[cfg(test)]
mod tests;
mod tip_line;

pub use check::{Finding, FindingKind, PathLengths, findings, idle_length};
pub use contour::{Area, Contour, LevelMap};
pub use drop_cutter::{DropCutter, Feature, Touch};
pub use feeds::{LargestFeeds, Passage, Valley, WithMarks, smooth};
pub use finish::{Finish, OVER, Residual, Share, Spot, deepest_cut};
pub use milled::{Left, Milled, Move, MoveKind};
pub use places::{ON_EDGES, Place, Places, places_for_cuts};
pub use standing::{Reach, Standing};
pub use tip_line::{Sampling, Tip, tips_between};
