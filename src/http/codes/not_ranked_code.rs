//! The codes of reasons why a cutter is not ranked.

use super::codes;
use crate::planning::plan::NotRankedReason;

codes! {
    /// Why a cutter is not ranked, as a code for programs; docs/codes.md lists meanings and remedies.
    NotRankedCode: none {
        CannotReach = "cannot-reach": "The cutter leaves too much of the surface uncut", "Use a smaller cutter, select the facets that it reaches, or raise max_uncut_share.";
        NoStepOver = "no-step-over": "No step-over keeps the scallop height", "Allow more height, or use another cutter.";
        FaultyTool = "faulty-tool": "The tool's entry in its library has faults", "Correct the members that the detail names; the other tools of the library are used.";
    }
}

impl From<NotRankedReason> for NotRankedCode {
    fn from(reason: NotRankedReason) -> Self {
        match reason {
            NotRankedReason::CannotReach { .. } => Self::CannotReach,
            NotRankedReason::NoStepOver => Self::NoStepOver,
        }
    }
}
