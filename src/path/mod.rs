//! Tool paths: where the tip of a cutter can stand on a part, lines along which it runs, their moves, and what they leave on a
//! surface.

#![allow(clippy::cast_precision_loss, reason = "counts are below 2^52")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap,
    reason = "cells and moves are fewer than 2^32"
)]

mod body;
mod bottom;
mod climbing;
mod drop_cutter;
mod facet_tree;
mod finish;
mod milled;
mod move_grid;
mod moves;
mod places;
mod random;
mod standing;
#[cfg(test)]
mod tests;
mod tip_line;

pub use drop_cutter::{DropCutter, Feature, Touch};
pub use finish::{Finish, OVER, Residual, Share, Spot};
pub use milled::{Left, Milled};
pub use moves::{Move, MoveKind};
pub use places::{Place, Places};
pub use standing::{Obstacles, Reach};
pub use tip_line::{Tip, tips_between, tips_of_lines};
