//! Programs of machine tools, read into points of the tip and written from moves.

mod apt;
mod arc;
mod block;
mod collected;
mod columns;
mod faults;
mod gcode;
mod points;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use faults::{FaultKind, ProgramFault};
pub use points::{Dialect, Program, ProgramPoint, Reached};
pub use read::{ReadSettings, read};
pub use write::{Gap, Operation, WriteSettings, write_iso};
