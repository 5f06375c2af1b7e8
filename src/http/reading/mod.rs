//! Reads the JSON of requests. Every fault of a request is found and placed in one go, so nothing here stops at the first; and
//! what is read is described to the API document by the same constants.

mod fault;
pub(crate) mod member;
mod object;
mod schema;

pub(crate) use fault::{Fault, Faulted, Faults, Place};
pub(crate) use member::{Kind, Member};
pub(crate) use object::{Object, describe};
pub(crate) use schema::ObjectSchema;
