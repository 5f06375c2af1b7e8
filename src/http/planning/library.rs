//! The tool libraries of an upload: their cutters, faults and warnings.

use crate::file_fault::FileFault;
use crate::http::codes::{FileFaultCode, WarningCode};
use crate::http::reading::{Faulted, Faults, JsonPath};
use crate::http::wire::{LibraryFilter, NamedCandidate, Warning};
use crate::tooling::{FaultyTool, LibraryFaults, ToolLibrary};
use std::collections::BTreeMap;

/// The name of the form's parts with libraries.
pub(super) const LIBRARY: &str = "library";

/// The most bytes of a library file. Fusion writes 2 kB for a tool.
pub(super) const LARGEST_LIBRARY: usize = 16 << 20;

/// The most faulty tools that an answer lists, over all libraries.
const MOST_FAULTY_LISTED: usize = 100;

/// The result of reading each part `library`.
#[derive(Debug, Default)]
pub(super) struct Libraries(Vec<Result<ToolLibrary, LibraryFaults>>);

impl Libraries {
    pub(super) fn push(&mut self, read: Result<ToolLibrary, LibraryFaults>) {
        self.0.push(read);
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Records the faults of libraries that cannot be read, each with file, tool and member.
    pub(super) fn check(&self, faults: &mut Faults) -> Result<(), Faulted> {
        self.record(faults, |library| library.as_ref().err().into_iter().flat_map(LibraryFaults::all).collect())
    }

    /// Records the faults of faulty tools. This is for a request that has no other cutters.
    pub(super) fn report_faulty(&self, faults: &mut Faults) -> Result<(), Faulted> {
        self.record(faults, |library| library.iter().flat_map(ToolLibrary::faulty).flat_map(FaultyTool::faults).collect())
    }

    /// Records faults of each library, at the place of its part.
    fn record(&self, faults: &mut Faults, of: fn(&Result<ToolLibrary, LibraryFaults>) -> Vec<&FileFault>) -> Result<(), Faulted> {
        let (root, mut result) = (JsonPath::Root, Ok(()));
        for (index, library) in self.0.iter().enumerate() {
            for fault in of(library) {
                result = Err(faults.add(&root.member(LIBRARY).item(index), FileFaultCode::from(fault.kind()), fault));
            }
        }
        result
    }

    /// The warnings about tools that are not candidates: those that are left out on purpose, and faulty ones.
    pub(super) fn warnings(&self) -> impl Iterator<Item = Warning> {
        let left_out = self.left_out().map(|detail| Warning::new(WarningCode::OtherTools, detail));
        left_out.into_iter().chain(self.faulty_warning())
    }

    fn faulty_warning(&self) -> Option<Warning> {
        let (listed, unlisted) = (self.faulty().count(), self.read().map(ToolLibrary::unlisted_faulty).sum::<u64>());
        let count = listed as u64 + unlisted;
        let which = if count > MOST_FAULTY_LISTED as u64 || unlisted > 0 { "the first of them" } else { "they" };
        let detail =
            format!("finishing cutters of the libraries that cannot be used: {count}; {which} are in not_ranked, with their faults");
        (count > 0).then(|| Warning::new(WarningCode::FaultyTools, detail))
    }

    /// Describes the tools that are left out on purpose: those that are not finishing cutters, counted by type, and
    /// those that no list of their zip names.
    pub(super) fn left_out(&self) -> Option<String> {
        const MOST_LISTED: usize = 20;
        let mut others = BTreeMap::<&str, u64>::new();
        for (kind, count) in self.read().flat_map(ToolLibrary::others) {
            *others.entry(kind).or_default() += count;
        }
        let mut sentences = Vec::new();
        if !others.is_empty() {
            let mut listed: Vec<String> = others.iter().take(MOST_LISTED).map(|(kind, count)| format!("{count} {kind}")).collect();
            if others.len() > MOST_LISTED {
                listed.push(format!("and {} further types", others.len() - MOST_LISTED));
            }
            sentences.push(format!("tools that are no finishing cutters were left out: {}", listed.join(", ")));
        }
        let unlisted: u64 = self.read().map(ToolLibrary::unlisted_files).sum();
        if unlisted > 0 {
            sentences.push(format!("tool files that no .fctl list of their zip names were left out: {unlisted}"));
        }
        (!sentences.is_empty()).then(|| sentences.join("; "))
    }

    /// The finishing cutters of all libraries that `filter` admits, in their order, and the faulty ones.
    pub(super) fn into_candidates(self, filter: &LibraryFilter) -> (Vec<NamedCandidate>, Vec<FaultyTool>) {
        let faulty = self.faulty().take(MOST_FAULTY_LISTED).cloned().collect();
        let tools = self.0.into_iter().flatten().flat_map(ToolLibrary::into_tools).filter(|tool| filter.admits(tool));
        (tools.map(NamedCandidate::from).collect(), faulty)
    }

    /// Whether a library has a finishing cutter.
    pub(super) fn have_cutters(&self) -> bool {
        self.read().any(|library| !library.tools().is_empty())
    }

    fn read(&self) -> impl Iterator<Item = &ToolLibrary> {
        self.0.iter().flatten()
    }

    fn faulty(&self) -> impl Iterator<Item = &FaultyTool> {
        self.read().flat_map(ToolLibrary::faulty)
    }
}
