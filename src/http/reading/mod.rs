//! Readers of the JSON of requests, which collect all faults with their locations. The schemas of the OpenAPI document
//! come from the same declarations.

mod array;
mod columns;
mod faults;
mod kinds;
mod not_finite;
mod object;

pub(crate) use array::{List, each_raw, items};
pub(crate) use columns::Columns;
pub(crate) use faults::{Fault, Faulted, Faults, JsonPath, describe, meant};
pub(crate) use kinds::{Choice, Flag, Number, NumberPair, Quantity, Renamed, Vector, Whole, number, text};
pub(crate) use not_finite::{mark, mark_not_finite};
pub(crate) use object::{
    AddMembers, AnyMember, Components, Declared, Form, Kind, Member, Members, Object, ObjectSchema, at_most_one, members,
};
