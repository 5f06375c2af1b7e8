//! Why a surface file could not be read: a fault of the file, or a failure of its source.

use crate::file_fault::FileFault;
use std::fmt;
use std::io;

/// The reason why a file could not be read.
#[derive(Debug)]
pub enum ReadError {
    /// The file has a fault.
    Fault(FileFault),
    /// The source of the file failed: it was cut off, or nobody waits for the surface any longer.
    Source(io::Error),
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) => fault.fmt(f),
            Self::Source(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ReadError {}

impl From<FileFault> for ReadError {
    fn from(fault: FileFault) -> Self {
        Self::Fault(fault)
    }
}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> Self {
        Self::Source(error)
    }
}
