//! Readers of the JSON of requests, which collect all faults with their locations. The schemas of the OpenAPI document
//! come from the same declarations.

mod array;
mod columns;
mod components;
mod cut_out;
mod faults;
mod kinds;
mod list;
mod member;
mod members;
mod object;
mod schema;
mod slots;

pub(crate) use array::{each_raw, items};
pub(crate) use columns::{Columns, KnownColumns};
pub(crate) use components::Components;
pub(crate) use cut_out::{CutOut, Large, PlainColumns};
pub(crate) use faults::{Fault, Faulted, Faults, describe};
pub(crate) use kinds::{Choice, Number, Pair, Quantity, Vector, Whole, number, text};
pub(crate) use list::List;
pub(crate) use member::{Kind, Member};
pub(crate) use members::{Form, Members, at_most_one, members};
pub(crate) use object::Object;
pub(crate) use schema::{AddMembers, ObjectSchema};
pub(crate) use slots::{CellValue, PlainKind, Slots, ValueSource};
