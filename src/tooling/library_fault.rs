//! The faults of a tool library: of files that cannot be read, and of tools whose cutters cannot be used.

use super::{ToolPlace, quoted, shortened};
use crate::file_fault::{FileFault, FilePlace, Flaw};
use crate::json::JsonError;
use std::borrow::Cow;
use std::fmt;

/// All faults of a library that cannot be read, at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LibraryFaults(Vec<FileFault>);

impl LibraryFaults {
    /// The faults: first those of files, then those of tools.
    #[must_use]
    pub fn all(&self) -> &[FileFault] {
        &self.0
    }

    /// These faults and those of the tools that were read.
    pub(super) fn and(mut self, tools: Vec<FaultyTool>) -> Self {
        self.0.extend(tools.into_iter().flat_map(|tool| tool.faults));
        self
    }

    /// All faults of several files; `None` if there are none.
    pub(super) fn of_files(faults: Vec<FileFault>) -> Option<Self> {
        (!faults.is_empty()).then_some(Self(faults))
    }

    pub(super) fn into_all(self) -> Vec<FileFault> {
        self.0
    }
}

impl From<FileFault> for LibraryFaults {
    fn from(fault: FileFault) -> Self {
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
    faults: Vec<FileFault>,
}

impl FaultyTool {
    /// The tool's name, or its position in the file if it has none. At most 100 characters.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The faults of its members, at least one.
    #[must_use]
    pub fn faults(&self) -> &[FileFault] {
        &self.faults
    }
}

impl fmt::Display for FaultyTool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some((first, further)) = self.faults.split_first() else { return Ok(()) };
        write!(f, "{first}")?;
        further.iter().try_for_each(|fault| write!(f, "; {}", fault.flaw()))
    }
}

/// The faults of a tool without its place, which the caller adds.
#[derive(Debug, Default)]
pub(super) struct Flaws(Vec<Flaw>);

impl Flaws {
    /// The value. If it has a flaw, records the flaw and returns `None`.
    pub(super) fn take<T>(&mut self, value: Result<T, Flaw>) -> Option<T> {
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
        let place_of_tool = FilePlace::Tool { file: shortened(place.file).into(), tool: Some(tool.into()) };
        FaultyTool { name: place.name(), faults: self.0.into_iter().map(|flaw| flaw.at(place_of_tool.clone())).collect() }
    }
}

impl From<Flaw> for Flaws {
    fn from(flaw: Flaw) -> Self {
        Self(vec![flaw])
    }
}

/// The flaw of a text that is not JSON, or not the expected JSON. The parser's message may quote a long text, so it is
/// shortened.
pub(super) fn json_flaw(expected: impl Into<Cow<'static, str>>, error: &serde_json::Error) -> Flaw {
    let error = JsonError::from(error);
    // The parser names the program's own type after what it found.
    let message = error.message();
    let found = match message.strip_prefix("invalid type: ").and_then(|found| found.split_once(", expected ")) {
        Some((found, _)) => format!("{found}, a value of another type"),
        None => message.to_owned(),
    };
    Flaw::malformed(expected, format!("{} at line {} column {}", shortened(&found), error.line(), error.column()))
}
