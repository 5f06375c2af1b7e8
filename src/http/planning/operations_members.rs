//! How many operations a plan may have, and the cutter whose rest it machines.

use crate::http::reading::{Faulted, Faults, JsonPath, Whole, members};
use crate::http::wire::AnyCutter;
use crate::milling::Cutter;

/// The most operations that a request can allow.
const MOST_OPERATIONS: u32 = 3;

members! {
    /// The members of the settings of operations.
    pub(super) struct OperationsMembers for OperationsKind ("Operations", "How many operations a plan may have, in method surface") -> usize {
        most: required MOST: Whole = ("max", Whole { minimum: 1, maximum: MOST_OPERATIONS, example: 3 },
            "the most operations: the surface divided by slope, each part with its cutter and lines, and a smaller cutter for what they cannot reach"),
    }
}

impl OperationsMembers {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<usize, Faulted> {
        self.most.map(|most| most as usize)
    }
}

members! {
    /// The members of a rest.
    pub(super) struct RestOfMembers for RestOfKind ("RestOf", "A cutter that has machined everything before") -> Cutter {
        cutter: required REST_CUTTER: AnyCutter = ("cutter", AnyCutter, "the cutter"),
    }
}

impl RestOfMembers {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<Cutter, Faulted> {
        self.cutter.map(|stated| stated.cutter)
    }
}
