//! The contacts of a batch as rows or as columns, in a body whose syntax has been checked.

use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, describe, items};
use crate::http::wire::{BatchContact, ContactColumns, ContactParameters, StatedParameters};
use crate::json_text::{JsonPath, JsonText};

/// The largest number of contacts in a request. Without this limit, a body of the largest size could hold some ten
/// million. With it, an answer stays below about 100 MB.
pub(super) const MOST_CONTACTS: usize = 250_000;

/// Contacts that are not read yet.
pub(super) enum Contacts<'a> {
    /// An array of objects.
    Rows(Vec<JsonText<'a>>),
    /// An object of arrays.
    Columns(ContactColumns<'a>),
}

impl<'a> Contacts<'a> {
    /// Opens an array or an object of columns. Faults of a contact are found when it is read.
    pub(super) fn open(raw: JsonText<'a>, stated: StatedParameters, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self, Faulted> {
        match raw.get().as_bytes().first() {
            Some(b'[') => items(raw, "an array", MOST_CONTACTS, path, faults).map(Self::Rows),
            Some(b'{') => ContactColumns::read(raw, stated, MOST_CONTACTS, path, faults).map(Self::Columns),
            _ => {
                let detail = format_args!("expected an array of contacts or an object of columns, found {}", describe(raw));
                Err(faults.add(&path, RequestFault::WrongType, detail))
            }
        }
    }

    pub(super) fn count(&self) -> usize {
        match self {
            Self::Rows(rows) => rows.len(),
            Self::Columns(columns) => columns.count,
        }
    }

    /// The path of a contact. `path` is that of all contacts.
    pub(super) fn path<'p>(&self, index: usize, path: &'p JsonPath<'p>) -> JsonPath<'p> {
        match self {
            Self::Rows(_) => path.item(index),
            Self::Columns(columns) => columns.path(index, path),
        }
    }

    /// Reads a contact, whose own parameters override `defaults`.
    #[inline]
    pub(super) fn read(
        &self,
        index: usize,
        defaults: &ContactParameters,
        path: JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<BatchContact, Faulted> {
        match self {
            Self::Rows(rows) => BatchContact::read(rows[index], defaults, path, faults),
            Self::Columns(columns) => columns.contact(index, defaults, path, faults),
        }
    }
}
