//! Programs of machine tools, read into points of the tip and written from moves.

mod apt;
mod arc;
mod block;
mod columns;
mod gcode;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use read::{Dialect, FaultKind, Program, ProgramFault, ProgramPoint, Reached, ReadSettings, read};
pub use write::{Gap, Operation, WriteSettings, write_iso};
