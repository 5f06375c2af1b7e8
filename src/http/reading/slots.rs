//! The values of several members in one pass, without collecting faults. Two sets of members of one object are a pair.

use super::{KnownColumns, ObjectSchema, ValueSource};
use crate::json_text::{PlainJson, PlainValue, Unusual};

/// The values of members, each absent until it is read.
pub(crate) trait Slots: Default + Copy + PartialEq {
    /// Reads the value of `name` into its slot. Returns false if no member has this name, and an error for a value of
    /// another type or a repeated name.
    fn fill(&mut self, name: &str, source: &mut impl ValueSource) -> Result<bool, Unusual>;

    /// The columns of the members.
    fn columns() -> KnownColumns;

    /// Adds columns of at most `most` rows to a schema; none is required.
    fn describe_columns(schema: ObjectSchema<'_>, most: usize) -> ObjectSchema<'_>;

    /// Whether no slot is filled.
    #[inline]
    fn are_absent(&self) -> bool {
        *self == Self::default()
    }
}

impl<A: Slots, B: Slots> Slots for (A, B) {
    #[inline]
    fn fill(&mut self, name: &str, source: &mut impl ValueSource) -> Result<bool, Unusual> {
        Ok(self.0.fill(name, source)? || self.1.fill(name, source)?)
    }

    fn columns() -> KnownColumns {
        A::columns().into_iter().chain(B::columns()).collect()
    }

    fn describe_columns(schema: ObjectSchema<'_>, most: usize) -> ObjectSchema<'_> {
        B::describe_columns(A::describe_columns(schema, most), most)
    }
}

/// The values of an object that has no other members.
impl<S: Slots> PlainValue for S {
    #[inline]
    fn read(json: &mut PlainJson<'_>) -> Result<Self, Unusual> {
        let mut slots = Self::default();
        json.object(|name, json| slots.fill(name, json))?;
        Ok(slots)
    }
}
