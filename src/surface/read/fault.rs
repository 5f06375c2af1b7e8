//! The fault of a surface file: its location, the content expected there, and the content found.

use std::borrow::Cow;
use std::fmt;
use std::io;
use std::sync::Arc;

/// A location in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileLocation {
    /// A line of a text file, counted from 1.
    Line(u64),
    /// A byte of a binary file, counted from 0.
    Byte(u64),
    /// A byte of a file in an archive, counted from 0 after inflation.
    Entry {
        /// The path of the file in the archive.
        path: Arc<str>,
        /// The byte.
        byte: u64,
    },
}

impl fmt::Display for FileLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
            Self::Entry { path, byte } => write!(f, "{path}, byte {byte}"),
        }
    }
}

/// The kinds of faults of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileFaultKind {
    /// The file has a format or encoding that is not read. The fault names it if it is known.
    UnknownFormat,
    /// A violation of the format.
    Malformed,
    /// A number that is not finite, beyond [`LARGEST_COORDINATE`](super::LARGEST_COORDINATE), or the index of a missing
    /// vertex.
    OutOfRange,
    /// The file ends before the size that it states.
    Truncated,
    /// The file exceeds a limit of the reader: length of a line, corners of a face, number of vertices, size of an
    /// archive.
    TooLarge,
    /// The file can be read in two ways with different surfaces. The fault names both.
    Ambiguous,
    /// The file has neither a point nor a facet.
    Empty,
}

/// The reason why a file was refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileFault {
    location: FileLocation,
    flaw: Flaw,
}

impl FileFault {
    /// The kind of the fault.
    #[must_use]
    pub fn kind(&self) -> FileFaultKind {
        self.flaw.kind
    }

    /// The location in the file.
    #[must_use]
    pub fn location(&self) -> FileLocation {
        self.location.clone()
    }

    /// The expected content.
    #[must_use]
    pub fn expected(&self) -> &str {
        &self.flaw.expected
    }

    /// The content found: a description, or a short quotation with special characters escaped.
    #[must_use]
    pub fn found(&self) -> &str {
        &self.flaw.found
    }
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}, found {}", self.location, self.flaw.expected, self.flaw.found)
    }
}

impl std::error::Error for FileFault {}

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

/// A fault without its location, which the caller adds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Flaw {
    kind: FileFaultKind,
    expected: Cow<'static, str>,
    found: Cow<'static, str>,
}

impl Flaw {
    #[cold]
    pub(super) fn new(kind: FileFaultKind, expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self { kind, expected: expected.into(), found: found.into() }
    }

    pub(super) fn kind(&self) -> FileFaultKind {
        self.kind
    }

    /// A violation of the format's grammar, with a quotation of the text found.
    #[cold]
    pub(super) fn malformed(expected: impl Into<Cow<'static, str>>, found: &[u8]) -> Self {
        Self::new(FileFaultKind::Malformed, expected, quoted(found))
    }

    #[cold]
    pub(super) fn at_line(self, number: u64) -> FileFault {
        FileFault { location: FileLocation::Line(number), flaw: self }
    }

    /// The fault of a file in an archive; its path is cut to 200 characters, with control characters escaped.
    #[cold]
    pub(super) fn in_entry(self, path: &str, byte: u64) -> FileFault {
        let path: String =
            path.chars().take(200).flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] }).collect();
        FileFault { location: FileLocation::Entry { path: path.into(), byte }, flaw: self }
    }

    #[cold]
    pub(super) fn at_byte(self, offset: u64) -> FileFault {
        FileFault { location: FileLocation::Byte(offset), flaw: self }
    }
}

/// `text` in quotation marks, cut to 40 characters, with its control characters escaped.
pub(super) fn quoted(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    if text.is_empty() {
        return "nothing".into();
    }
    // A character takes at most 4 bytes.
    let head = String::from_utf8_lossy(&text[..text.len().min(4 * (LONGEST + 1))]);
    let shown: String = head.chars().flat_map(char::escape_debug).take(LONGEST).collect();
    let whole = text.len() <= 4 * (LONGEST + 1) && head.chars().flat_map(char::escape_debug).count() <= LONGEST;
    format!("\"{shown}{}\"", if whole { "" } else { "..." })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_reads_as_a_sentence() {
        let fault = Flaw::malformed("three numbers", b"1,2").at_line(7);
        assert_eq!(fault.to_string(), "line 7: expected three numbers, found \"1,2\"");
        assert_eq!(Flaw::malformed("a byte", b"").at_byte(0).to_string(), "byte 0: expected a byte, found nothing");
    }

    #[test]
    fn quotations_are_short_and_escaped() {
        assert_eq!(quoted(b"a\x00\x1b[31m\"\n"), "\"a\\0\\u{1b}[31m\\\"\\n\"");
        assert_eq!(quoted(&[b'x'; 40]), format!("\"{}\"", "x".repeat(40)));
        assert_eq!(quoted(&[b'x'; 41]), format!("\"{}...\"", "x".repeat(40)));
        assert_eq!(quoted(&[0xff; 1000]).chars().count(), 40 + 5);
    }
}
