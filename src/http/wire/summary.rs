//! What a batch answers beside its columns: counts, the extremes of columns, and failures.

use super::answer;
use crate::http::codes::FaultCode;
use crate::http::reading::Fault;
use serde::{Serialize, Serializer};

answer! {
    /// A contact with an extreme figure.
    #[derive(Clone, Copy)]
    pub(crate) struct Extreme {
        /// The index of the contact, from 0; the first of equals.
        pub(crate) index: usize,
        /// Its figure, as in the column.
        pub(crate) value: f64,
    }

    /// The extremes of a column of numbers.
    #[derive(Clone, Copy)]
    pub(crate) struct Extremes {
        /// The contact with the smallest number.
        pub(crate) minimum: Extreme,
        /// The contact with the largest number.
        pub(crate) maximum: Extreme,
    }
}

/// A JSON object whose members have an order that its type does not determine.
#[derive(Debug, Clone)]
pub(crate) struct InOrder<V>(pub(crate) Vec<(&'static str, V)>);

impl<V: Serialize> Serialize for InOrder<V> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

answer! {
    /// The counts and extremes of a batch.
    #[derive(Clone)]
    pub(crate) struct Summary {
        /// The number of contacts sent.
        pub(crate) count: usize,
        /// The number of contacts without an answer. `failures` beside the summary lists the first thousand of them.
        pub(crate) failures: usize,
        /// The number of contacts whose analytic height is more than 5 % below that of the cutter's exact shape, or whose
        /// exact shape leaves no height to compare. Only if `columns` names `envelope_scallop_height_mm` or `deviation`:
        /// the comparison takes longer than the calculation.
        pub(crate) outside_analytic_range?: usize,
        /// For each column with numbers, the contacts with the smallest and the largest one.
        pub(crate) extremes: InOrder<Extremes> [value_type = std::collections::BTreeMap<String, Extremes>],
    }
}

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
