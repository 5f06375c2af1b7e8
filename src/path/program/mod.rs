//! Programs of machine tools, read into points of the tip and written from moves.

mod apt;
mod arc;
mod gcode;
mod program_points;
mod read;
mod refeed;
#[cfg(test)]
mod tests;
mod write;

pub use program_points::{Dialect, Program, ProgramFault, ProgramFaultKind, ProgramPoint, Reached};
pub use read::{ReadSettings, read};
pub use refeed::with_feeds;
pub use write::{Gap, Operation, WriteSettings, write_iso};
