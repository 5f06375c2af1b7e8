//! Faults of a tool library, each with file, tool and member, what is expected there and what was found.

use super::{ToolPlace, shortened};
use crate::json::JsonError;
use std::borrow::Cow;
use std::fmt;

/// The kinds of faults of a library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LibraryFaultKind {
    /// The file has none of the formats that are read.
    UnknownFormat,
    /// A violation of the format, or a member that a cutter needs is missing.
    Malformed,
    /// A number outside its bounds, or a corner radius that does not fit the diameter.
    OutOfRange,
    /// A limit is exceeded: tools, files of a zip, decompressed bytes.
    TooLarge,
    /// The file has no tool.
    Empty,
}

/// A fault of a file or a tool.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LibraryFault {
    file: String,
    tool: Option<String>,
    flaw: Box<LibraryFlaw>,
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

    /// The value found: a description, or a short quotation with special characters escaped.
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

/// All faults of a library that cannot be read, at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LibraryFaults(Vec<LibraryFault>);

impl LibraryFaults {
    /// The faults: first those of files, then those of tools.
    #[must_use]
    pub fn all(&self) -> &[LibraryFault] {
        &self.0
    }

    /// These faults and those of the tools that were read.
    pub(super) fn and(mut self, tools: Vec<FaultyTool>) -> Self {
        self.0.extend(tools.into_iter().flat_map(|tool| tool.faults));
        self
    }

    /// All faults of several files; `None` if there are none.
    pub(super) fn of_files(faults: Vec<LibraryFault>) -> Option<Self> {
        (!faults.is_empty()).then_some(Self(faults))
    }

    pub(super) fn into_all(self) -> Vec<LibraryFault> {
        self.0
    }
}

impl From<LibraryFault> for LibraryFaults {
    fn from(fault: LibraryFault) -> Self {
        Self(vec![fault])
    }
}

impl fmt::Display for LibraryFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.0.iter().enumerate() {
            write!(f, "{}{fault}", if index > 0 { "; " } else { "" })?;
        }
        Ok(())
    }
}

impl std::error::Error for LibraryFaults {}

/// A finishing cutter that cannot be used, with its faults. As text it names file and tool once, and then each fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaultyTool {
    name: String,
    faults: Vec<LibraryFault>,
}

impl FaultyTool {
    /// The tool's name, or its position in the file if it has none. At most 100 characters.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The faults of its members, at least one.
    #[must_use]
    pub fn faults(&self) -> &[LibraryFault] {
        &self.faults
    }
}

impl fmt::Display for FaultyTool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some((first, further)) = self.faults.split_first() else { return Ok(()) };
        write!(f, "{first}")?;
        for fault in further {
            let member = fault.member().map(|member| format!("{member}: ")).unwrap_or_default();
            write!(f, "; {member}expected {}, found {}", fault.expected(), fault.found())?;
        }
        Ok(())
    }
}

/// A fault without its file and tool, which the caller adds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LibraryFlaw {
    kind: LibraryFaultKind,
    member: Option<Cow<'static, str>>,
    expected: Cow<'static, str>,
    found: Cow<'static, str>,
}

impl LibraryFlaw {
    pub(super) fn new(kind: LibraryFaultKind, expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self { kind, member: None, expected: expected.into(), found: found.into() }
    }

    pub(super) fn malformed(expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self::new(LibraryFaultKind::Malformed, expected, found)
    }

    pub(super) fn out_of_range(expected: impl Into<Cow<'static, str>>, found: impl Into<Cow<'static, str>>) -> Self {
        Self::new(LibraryFaultKind::OutOfRange, expected, found)
    }

    /// The flaw of a text that is not JSON, or not the expected JSON. The parser's message may quote a long text, so it
    /// is shortened.
    pub(super) fn json(expected: impl Into<Cow<'static, str>>, error: &serde_json::Error) -> Self {
        let error = JsonError::from(error);
        // The parser names the program's own type after what it found.
        let message = error.message();
        let found = match message.strip_prefix("invalid type: ").and_then(|found| found.split_once(", expected ")) {
            Some((found, _)) => format!("{found}, a value of another type"),
            None => message.to_owned(),
        };
        Self::malformed(expected, format!("{} at line {} column {}", shortened(&found), error.line(), error.column()))
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
}

/// The faults of a tool without its place, which the caller adds.
#[derive(Debug, Default)]
pub(super) struct Flaws(Vec<LibraryFlaw>);

impl Flaws {
    /// The value. If it has a flaw, records the flaw and returns `None`.
    pub(super) fn take<T>(&mut self, value: Result<T, LibraryFlaw>) -> Option<T> {
        value.map_err(|flaw| self.0.push(flaw)).ok()
    }

    /// The value that was read, unless it has flaws.
    pub(super) fn or<T>(self, value: T) -> Result<T, Self> {
        if self.0.is_empty() { Ok(value) } else { Err(self) }
    }

    /// The faulty tool at this place.
    pub(super) fn of_tool(self, place: &ToolPlace) -> FaultyTool {
        let tool = match place.name.map(str::trim) {
            Some(name) if !name.is_empty() => format!("tool {} {}", place.position, quoted(name)),
            _ => format!("tool {}", place.position),
        };
        let of_tool = |flaw: LibraryFlaw| LibraryFault { tool: Some(tool.clone()), ..flaw.in_file(place.file) };
        FaultyTool { name: place.name(), faults: self.0.into_iter().map(of_tool).collect() }
    }
}

impl From<LibraryFlaw> for Flaws {
    fn from(flaw: LibraryFlaw) -> Self {
        Self(vec![flaw])
    }
}

/// `text` in quotation marks, shortened, with its control characters escaped.
pub(super) fn quoted(text: &str) -> String {
    format!("\"{}\"", shortened(text))
}
