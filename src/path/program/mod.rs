//! Programs of machine tools, read into points of the tip and written from moves.

mod apt;
mod arc;
mod gcode;
mod klartext;
mod program_points;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use program_points::{Dialect, Program, ProgramFault, ProgramFaultKind, ProgramPoint, Reached};
pub use read::{ReadSettings, read};
pub use write::{Gap, Operation, WriteSettings, with_feeds, write};
