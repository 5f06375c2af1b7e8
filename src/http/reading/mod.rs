//! Readers of the JSON of requests, which collect all faults with their locations. The schemas of the OpenAPI document
//! come from the same declarations.

mod array;
mod columns;
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
pub(crate) use columns::{CellValue, Columns, KnownColumns, ValueSource};
pub(crate) use cut_out::{CutOut, Large, PlainColumns};
pub(crate) use faults::{Fault, Faulted, Faults};
pub(crate) use kinds::{Choice, Number, Pair, Quantity, Vector, Whole, number, text};
pub(crate) use list::List;
pub(crate) use member::{Kind, Member, PlainKind};
pub(crate) use members::{Form, Members, at_most_one, members};
pub(crate) use object::{Object, describe};
pub(crate) use schema::{AddMembers, Components, ObjectSchema};
pub(crate) use slots::Slots;
