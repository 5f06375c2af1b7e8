//! Tool paths: where the tip of a cutter can stand on a part, and lines along which it runs.

mod bottom;
mod drop_cutter;
mod facet_tree;
mod tip_line;

pub use drop_cutter::{DropCutter, Feature, Touch};
pub use tip_line::{Tip, tips_between, tips_of_lines};
