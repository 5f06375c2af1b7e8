//! The fault of a tool library: file, tool and member, what is expected there and what was found.

use super::shortened;
use std::borrow::Cow;
use std::fmt;

/// The kinds of faults of a library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LibraryFaultKind {
    /// Not one of the formats that are read.
    UnknownFormat,
    /// A violation of the format, or a member that a cutter needs is missing.
    Malformed,
    /// A number outside its bounds, or a corner radius that does not fit the diameter.
    OutOfRange,
    /// Larger than a limit: tools, files of a zip, bytes after inflation.
    TooLarge,
    /// Holds no tool.
    Empty,
}

/// The reason why a library was refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LibraryFault {
    file: String,
    tool: Option<String>,
    flaw: Box<Flaw>,
}

impl LibraryFault {
    /// The kind of the fault.
    #[must_use]
    pub fn kind(&self) -> LibraryFaultKind {
        self.flaw.kind
    }

    /// The file with the fault; for a file of a zip `archive.zip/folder/file.json`.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The tool with the fault: its position in the file, counted from 1, and its name in quotation marks.
    #[must_use]
    pub fn tool(&self) -> Option<&str> {
        self.tool.as_deref()
    }

    /// The member with the fault, as the format names it.
    #[must_use]
    pub fn member(&self) -> Option<&str> {
        self.flaw.member.as_deref()
    }

    /// The expected value.
    #[must_use]
    pub fn expected(&self) -> &str {
        &self.flaw.expected
    }

    /// What was found: a description, or a short quotation with its special characters escaped.
    #[must_use]
    pub fn found(&self) -> &str {
        &self.flaw.found
    }
}

impl fmt::Display for LibraryFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        for part in [&self.tool, &self.flaw.member.as_ref().map(ToString::to_string)].into_iter().flatten() {
            write!(f, ", {part}")?;
        }
        write!(f, ": expected {}, found {}", self.flaw.expected, self.flaw.found)
    }
}

impl std::error::Error for LibraryFault {}

/// A fault without its file and tool, which the caller adds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Flaw {
    kind: LibraryFaultKind,
    member: Option<Cow<'static, str>>,
    expected: Cow<'static, str>,
    found: Cow<'static, str>,
}

impl Flaw {
    pub(super) fn new(kind: LibraryFaultKind, expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self { kind, member: None, expected: expected.into(), found: found.into() }
    }

    pub(super) fn malformed(expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self::new(LibraryFaultKind::Malformed, expected, found)
    }

    pub(super) fn out_of_range(expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self::new(LibraryFaultKind::OutOfRange, expected, found)
    }

    /// A text that is not JSON, or not the expected JSON. The parser's message quotes the text at any length, so it is
    /// shortened.
    pub(super) fn json(expected: impl Into<Cow<'static, str>>, error: &serde_json::Error) -> Self {
        let message = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let message = message.strip_suffix(&place).unwrap_or(&message);
        Self::malformed(expected, format!("{}{place}", shortened(message)))
    }

    pub(super) fn too_large(expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self::new(LibraryFaultKind::TooLarge, expected, found)
    }

    /// A member that a cutter needs is missing.
    pub(super) fn missing(expected: impl Into<Cow<'static, str>>) -> Self {
        Self::malformed(expected, "nothing")
    }

    pub(super) fn of_member(self, member: impl Into<Cow<'static, str>>) -> Self {
        Self { member: Some(member.into()), ..self }
    }

    pub(super) fn in_file(self, file: &str) -> LibraryFault {
        LibraryFault { file: shortened(file), tool: None, flaw: Box::new(self) }
    }

    /// The fault of a tool, where `position` counts the tools of the file from 1.
    pub(super) fn of_tool(self, file: &str, position: usize, name: Option<&str>) -> LibraryFault {
        let tool = match name.map(str::trim) {
            Some(name) if !name.is_empty() => format!("tool {position} {}", quoted(name)),
            _ => format!("tool {position}"),
        };
        LibraryFault { tool: Some(tool), ..self.in_file(file) }
    }
}

/// `text` in quotation marks, shortened, with its control characters escaped.
pub(super) fn quoted(text: &str) -> String {
    format!("\"{}\"", shortened(text))
}
