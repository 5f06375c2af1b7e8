//! Faults of the files that clients send, surfaces and tool libraries: where, what is expected there, and what was found.

use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

/// The kinds of faults of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileFaultKind {
    /// The file has a format or encoding that is not read. The fault names it if it is known.
    UnknownFormat,
    /// A violation of the format; in a tool library also a missing member that a cutter needs.
    Malformed,
    /// A number that is not finite, out of its bounds, or the index of a missing vertex; a corner that does not fit its cutter.
    OutOfRange,
    /// The file ends before the size that it states.
    Truncated,
    /// The file exceeds a limit of its reader: length of a line, corners of a face, number of vertices or tools, size of an archive.
    TooLarge,
    /// The file can be read in two ways with different surfaces. The fault names both.
    Ambiguous,
    /// The file has no point, no facet or no tool.
    Empty,
}

/// A place in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FilePlace {
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
    /// A file of a tool library, or a tool in it.
    Tool {
        /// The name of the file; for a file of an archive `archive.zip/folder/file.json`.
        file: Arc<str>,
        /// The tool: its position in the file, counted from 1, and its name in quotation marks. `None` for the whole file.
        tool: Option<Arc<str>>,
    },
}

impl fmt::Display for FilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
            Self::Entry { path, byte } => write!(f, "{path}, byte {byte}"),
            Self::Tool { file, tool: None } => f.write_str(file),
            Self::Tool { file, tool: Some(tool) } => write!(f, "{file}, {tool}"),
        }
    }
}

/// A fault of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileFault {
    place: FilePlace,
    flaw: Flaw,
}

impl FileFault {
    /// The kind of the fault.
    #[must_use]
    pub fn kind(&self) -> FileFaultKind {
        self.flaw.kind
    }

    /// The place in the file.
    #[must_use]
    pub fn place(&self) -> &FilePlace {
        &self.place
    }

    /// The member of a tool with the fault, as the format names it.
    #[must_use]
    pub fn member(&self) -> Option<&str> {
        self.flaw.member.as_deref()
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

    /// The fault without its place.
    pub(crate) fn flaw(&self) -> &Flaw {
        &self.flaw
    }
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", self.place, if self.flaw.member.is_some() { ", " } else { ": " }, self.flaw)
    }
}

impl std::error::Error for FileFault {}

/// A fault without its place, which the caller adds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Flaw {
    kind: FileFaultKind,
    member: Option<Cow<'static, str>>,
    expected: Cow<'static, str>,
    found: Cow<'static, str>,
}

impl Flaw {
    #[cold]
    pub(crate) fn new(kind: FileFaultKind, expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self { kind, member: None, expected: expected.into(), found: found.into() }
    }

    pub(crate) fn kind(&self) -> FileFaultKind {
        self.kind
    }

    #[cold]
    pub(crate) fn malformed(expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self::new(FileFaultKind::Malformed, expected, found)
    }

    /// A violation of the format's grammar, with a quotation of the text found.
    #[cold]
    pub(crate) fn quoting(expected: impl Into<Cow<'static, str>>, found: &[u8]) -> Self {
        Self::malformed(expected, quoted(found))
    }

    pub(crate) fn out_of_range(expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self::new(FileFaultKind::OutOfRange, expected, found)
    }

    pub(crate) fn too_large(expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self::new(FileFaultKind::TooLarge, expected, found)
    }

    /// A member of a tool that a cutter needs is missing.
    pub(crate) fn missing(expected: impl Into<Cow<'static, str>>) -> Self {
        Self::malformed(expected, "nothing")
    }

    pub(crate) fn of_member(self, member: impl Into<Cow<'static, str>>) -> Self {
        Self { member: Some(member.into()), ..self }
    }

    #[cold]
    pub(crate) fn at(self, place: FilePlace) -> FileFault {
        FileFault { place, flaw: self }
    }

    #[cold]
    pub(crate) fn at_line(self, number: u64) -> FileFault {
        self.at(FilePlace::Line(number))
    }

    /// The fault of a file in an archive; its path is cut to 200 characters, with control characters escaped.
    #[cold]
    pub(crate) fn in_entry(self, path: &str, byte: u64) -> FileFault {
        self.at(FilePlace::Entry { path: shortened(path, 200).into(), byte })
    }

    /// The fault of a file of a tool library; its name is cut to 100 characters, with control characters escaped.
    #[cold]
    pub(crate) fn in_file(self, file: &str) -> FileFault {
        self.at(FilePlace::Tool { file: shortened(file, 100).into(), tool: None })
    }

    #[cold]
    pub(crate) fn at_byte(self, offset: u64) -> FileFault {
        self.at(FilePlace::Byte(offset))
    }
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(member) = &self.member {
            write!(f, "{member}: ")?;
        }
        write!(f, "expected {}, found {}", self.expected, self.found)
    }
}

/// `text` in quotation marks, cut to 40 characters, with its special characters escaped.
pub(crate) fn quoted(text: impl AsRef<[u8]>) -> String {
    const LONGEST: usize = 40;
    let text = text.as_ref();
    if text.is_empty() {
        return "nothing".into();
    }
    // A character takes at most 4 bytes.
    let head = String::from_utf8_lossy(&text[..text.len().min(4 * (LONGEST + 1))]);
    let shown: String = head.chars().flat_map(char::escape_debug).take(LONGEST).collect();
    let whole = text.len() <= 4 * (LONGEST + 1) && head.chars().flat_map(char::escape_debug).count() <= LONGEST;
    format!("\"{shown}{}\"", if whole { "" } else { "..." })
}

/// `text` without blanks around it, with its control characters escaped, cut to `longest` characters.
pub(crate) fn shortened(text: &str, longest: usize) -> String {
    let text = text.trim();
    let mut escaped = text.chars().flat_map(|c| {
        let (plain, escaped) = if c.is_control() { (None, Some(c.escape_default())) } else { (Some(c), None) };
        plain.into_iter().chain(escaped.into_iter().flatten())
    });
    let mut short: String = escaped.by_ref().take(longest).collect();
    if escaped.next().is_some() {
        short.push_str("...");
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_reads_as_a_sentence() {
        let flaw = Flaw::malformed("three numbers", "\"1,2\"");
        assert_eq!(flaw.clone().at_line(7).to_string(), "line 7: expected three numbers, found \"1,2\"");
        let place = FilePlace::Tool { file: "a.csv".into(), tool: Some("tool 2 \"B6\"".into()) };
        assert_eq!(flaw.clone().at(place.clone()).to_string(), "a.csv, tool 2 \"B6\": expected three numbers, found \"1,2\"");
        let of_member = flaw.of_member("diameter").at(place);
        assert_eq!(of_member.to_string(), "a.csv, tool 2 \"B6\", diameter: expected three numbers, found \"1,2\"");
    }

    #[test]
    fn quotations_are_short_and_escaped() {
        assert_eq!(quoted(b"a\x00\x1b[31m\"\n"), "\"a\\0\\u{1b}[31m\\\"\\n\"");
        assert_eq!(quoted([b'x'; 40]), format!("\"{}\"", "x".repeat(40)));
        assert_eq!(quoted([b'x'; 41]), format!("\"{}...\"", "x".repeat(40)));
        assert_eq!(quoted([0xff; 1000]).chars().count(), 40 + 5);
        assert_eq!(quoted(""), "nothing");
    }
}
