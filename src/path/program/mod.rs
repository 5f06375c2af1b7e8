//! Programs of machine tools, read into points of the tip and written from moves.

mod apt;
mod arc;
mod block;
mod collected;
mod csv_columns;
mod gcode;
mod program_faults;
mod program_points;
mod read;
mod refeed;
#[cfg(test)]
mod tests;
mod write;

pub use program_faults::{ProgramFault, ProgramFaultKind};
pub use program_points::{Dialect, Program, ProgramPoint, Reached};
pub use read::{ReadSettings, read};
pub use refeed::with_feeds;
pub use write::{Gap, Operation, WriteSettings, write_iso};
