//! Readers of the JSON of requests, which collect all faults with their locations. The schemas of the OpenAPI document
//! come from the same declarations.

mod array;
mod columns;
mod components;
mod faults;
mod kinds;
mod list;
mod member;
mod members;
mod not_finite;
mod object;
mod path;
mod schema;

pub(crate) use array::{each_raw, items};
pub(crate) use columns::Columns;
pub(crate) use components::Components;
pub(crate) use faults::{Fault, Faulted, Faults, describe, nearest};
pub(crate) use kinds::{Choice, Flag, Number, NumberPair, Quantity, Renamed, Vector, Whole, number, text};
pub(crate) use list::List;
pub(crate) use member::{AnyMember, Declared, Kind, Member};
pub(crate) use members::{Form, Members, at_most_one, members};
pub(crate) use not_finite::{mark, mark_not_finite};
pub(crate) use object::Object;
pub(crate) use path::JsonPath;
pub(crate) use schema::{AddMembers, ObjectSchema};
