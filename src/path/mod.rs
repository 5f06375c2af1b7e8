//! Tool paths: where the tip of a cutter can stand on a part, lines along which it runs, moves, and what they leave on a
//! surface.

mod body;
mod bottom;
mod check;
mod climbing;
mod contour;
mod drop_cutter;
mod facet_tree;
mod feeds;
mod finish;
mod idle;
mod milled;
mod move_grid;
mod moves;
mod places;
pub mod program;
mod standing;
#[cfg(test)]
mod tests;
mod tip_line;
mod unseen;
mod valleys;

pub use check::{Finding, FindingKind, PathLengths, findings};
pub use climbing::{Spot, deepest_cut};
pub use contour::{Area, Contour, LevelMap};
pub use drop_cutter::{DropCutter, Feature, Touch};
pub use feeds::{LargestFeeds, WithMarks, smooth};
pub use finish::{Finish, OVER, Residual, Share};
pub use idle::idle_length;
pub use milled::{Left, Milled};
pub use moves::{Move, MoveKind};
pub use places::{EdgedFacet, ON_EDGES, Place, Places, places_on_edges};
pub use standing::{Reach, Standing};
pub use tip_line::{Sampling, Tip, tips_between};
pub use valleys::{Passage, Valley};
