//! The member `library_filter`: which cutters of tool libraries join those of the request.

use super::cutter_object::KINDS;
use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Faulted, Faults, JsonPath, List, Quantity, Whole, members};
use crate::milling::CutterKind;
use crate::quantity::Length;
use crate::tooling::LibraryTool;

/// Conditions on cutters of libraries; an absent one holds for all.
#[derive(Debug, Default)]
pub(crate) struct LibraryFilter {
    /// The smallest and the largest diameter.
    diameters: Option<[Length; 2]>,
    types: Option<Vec<CutterKind>>,
    numbers: Option<Vec<u32>>,
}

impl LibraryFilter {
    /// Whether a cutter meets all conditions. One without a number meets no list of numbers.
    pub(crate) fn admits(&self, tool: &LibraryTool) -> bool {
        let diameter = 2.0 * tool.cutter.outer_radius().mm();
        // Diameters in inches are converted, so that the bounds may differ by a rounding.
        let is_between = |[least, most]: [Length; 2]| (least.mm() * (1.0 - 1e-9)..=most.mm() * (1.0 + 1e-9)).contains(&diameter);
        self.diameters.is_none_or(is_between)
            && self.types.as_ref().is_none_or(|types| types.contains(&tool.cutter.kind()))
            && self.numbers.as_ref().is_none_or(|numbers| tool.number.is_some_and(|number| numbers.contains(&number)))
    }
}

members! {
    /// The members of a filter.
    pub(crate) struct FilterMembers for LibraryFilterKind ("LibraryFilter", "Conditions that a cutter of a library must meet, all of them, to join") -> LibraryFilter {
        diameters: optional DIAMETERS: List<Quantity<Length>> = ("diameter_mm",
            List { item: Quantity::length(6.0), about_item: "a diameter", fewest: 2, most: 2 },
            "the smallest and the largest diameter"),
        types: optional TYPES: List<Choice<CutterKind>> = ("types",
            List { item: Choice { name: None, words: KINDS }, about_item: "a kind of cutter", fewest: 1, most: KINDS.len() },
            "the kinds of cutters"),
        numbers: optional NUMBERS: List<Whole> = ("numbers",
            List { item: Whole { minimum: 0, maximum: 4_000_000_000, example: 7 }, about_item: "a tool's number", fewest: 1, most: 1000 },
            "the tools' numbers in the library; a tool without a number does not join"),
    }
}

impl FilterMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<LibraryFilter, Faulted> {
        let diameters = self.diameters.and_then(|diameters| {
            let Some(range) = diameters.and_then(|range| <[Length; 2]>::try_from(range).ok()) else { return Ok(None) };
            if range[0].mm() > range[1].mm() {
                let detail = "the smallest diameter must not be over the largest";
                return Err(faults.add(&path.member(DIAMETERS.name), RequestFault::OutOfRange, detail));
            }
            Ok(Some(range))
        });
        Ok(LibraryFilter { diameters: diameters?, types: self.types?, numbers: self.numbers? })
    }
}
