//! A failure of a batch.

use super::answer;
use crate::http::codes::FaultCode;
use crate::http::reading::Fault;

answer! {
    /// A contact of a batch that has no answer.
    #[derive(Clone)]
    pub(crate) struct Failure {
        /// The index of the contact, from 0.
        pub(crate) index: usize,
        /// The location of the fault: a JSON pointer (RFC 6901) into the request.
        pub(crate) pointer: String [example = "/contacts/17/slope_deg"],
        pub(crate) code: FaultCode,
        /// What is wrong and what is expected, for people; further faults of the contact follow the first, each after its
        /// pointer.
        pub(crate) detail: String,
    }
}

impl Failure {
    /// The failure of a contact with these faults; `None` without faults.
    pub(crate) fn new(index: usize, faults: &[Fault]) -> Option<Self> {
        let (first, further) = faults.split_first()?;
        let further = further.iter().map(|fault| format!("; {}: {}", fault.pointer, fault.detail));
        let detail = std::iter::once(first.detail.clone()).chain(further).collect();
        Some(Self { index, pointer: first.pointer.clone(), code: first.code, detail })
    }
}
