//! The tool libraries of an upload: their cutters, faults and warnings.

use crate::http::codes::{FileFault, WarningCode};
use crate::http::reading::{Faulted, Faults, JsonPath};
use crate::http::wire::{NamedCandidate, Warning};
use crate::tooling::{LibraryFault, LibraryFaultKind, ToolLibrary};
use std::collections::BTreeMap;

/// The name of the form's parts that hold libraries.
pub(super) const LIBRARY: &str = "library";

/// The most bytes of a library file. Fusion writes 2 kB for a tool.
pub(super) const LARGEST_LIBRARY: usize = 16 << 20;

/// The result of reading each part `library`.
#[derive(Debug, Default)]
pub(super) struct Libraries(Vec<Result<ToolLibrary, LibraryFault>>);

impl Libraries {
    pub(super) fn push(&mut self, read: Result<ToolLibrary, LibraryFault>) {
        self.0.push(read);
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Records the faults of refused libraries, each with file, tool and member.
    pub(super) fn check(&self, faults: &mut Faults) -> Result<(), Faulted> {
        let root = JsonPath::Root;
        let path = root.member(LIBRARY);
        let mut result = Ok(());
        for (index, library) in self.0.iter().enumerate() {
            if let Err(fault) = library {
                result = Err(faults.add(&path.item(index), FileFault::from(fault.kind()), fault));
            }
        }
        result
    }

    /// The warning that lists the tools that are no finishing cutters, counted by type.
    pub(super) fn warning(&self) -> Option<Warning> {
        self.left_out().map(|detail| Warning::new(WarningCode::OtherTools, detail))
    }

    /// The tools that are no finishing cutters, counted by type.
    pub(super) fn left_out(&self) -> Option<String> {
        const MOST_LISTED: usize = 20;
        let mut others = BTreeMap::<&str, u64>::new();
        for (kind, count) in self.0.iter().flatten().flat_map(ToolLibrary::others) {
            *others.entry(kind).or_default() += count;
        }
        if others.is_empty() {
            return None;
        }
        let mut listed: Vec<String> = others.iter().take(MOST_LISTED).map(|(kind, count)| format!("{count} {kind}")).collect();
        if others.len() > MOST_LISTED {
            listed.push(format!("and {} further types", others.len() - MOST_LISTED));
        }
        Some(format!("tools that are no ball-end, bull-nose or flat end mill were left out: {}", listed.join(", ")))
    }

    /// The finishing cutters of all libraries, in their order.
    pub(super) fn into_candidates(self) -> impl Iterator<Item = NamedCandidate> {
        self.0.into_iter().flatten().flat_map(ToolLibrary::into_tools).map(NamedCandidate::from)
    }
}

impl From<LibraryFaultKind> for FileFault {
    fn from(kind: LibraryFaultKind) -> Self {
        match kind {
            LibraryFaultKind::UnknownFormat => Self::UnknownFormat,
            LibraryFaultKind::Malformed => Self::MalformedFile,
            LibraryFaultKind::OutOfRange => Self::OutOfRange,
            LibraryFaultKind::TooLarge => Self::FileTooLarge,
            LibraryFaultKind::Empty => Self::EmptyFile,
        }
    }
}
