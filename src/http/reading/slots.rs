//! The values of several members in one pass, and columns of such values. Two sets of members of one object are a pair.

use super::{Faulted, Faults, Object, ObjectSchema, PlainColumn, PlainColumns, RowText, Rows};
use crate::json_text::{JsonPath, JsonText, PlainJson, PlainValue, Unusual};

/// The values of members, each absent until it is read.
pub(crate) trait Slots: Default + Copy + PartialEq {
    /// Reads the value of `name` into its slot. Returns false if no member has this name, and an error for a value of
    /// another type or a repeated name.
    fn fill(&mut self, name: &str, json: &mut PlainJson<'_>) -> Result<bool, Unusual>;

    /// Whether no slot is filled.
    #[inline]
    fn are_absent(&self) -> bool {
        *self == Self::default()
    }
}

/// Columns of the values of members.
pub(crate) trait Columns: Default + PartialEq {
    /// The values of a row.
    type Row: Slots;

    /// Takes columns of at most `most` rows from `object`, which may have other members.
    fn take(object: &mut Object<'_, '_>, most: usize, faults: &mut Faults) -> Self;

    /// Takes columns of at most `most` rows from `columns`, which may have others; `None` if one is unusual.
    fn take_plain(columns: &mut PlainColumns<'_>, most: usize) -> Option<Self>;

    /// Adds columns of at most `most` rows to a schema; none is required.
    fn describe(schema: ObjectSchema<'_>, most: usize) -> ObjectSchema<'_>;

    /// Whether there are no columns.
    fn are_absent(&self) -> bool {
        *self == Self::default()
    }

    /// Compares the number of rows of all columns of the object at `path`.
    fn check_rows(&self, path: &JsonPath<'_>, rows: &mut Rows, faults: &mut Faults);

    /// The values of a row; an error if one is of another type.
    fn row(&self, index: usize) -> Result<Self::Row, Unusual>;

    /// Writes a row as members of an object.
    fn write_row(&self, index: usize, row: &mut RowText);
}

impl<A: Slots, B: Slots> Slots for (A, B) {
    #[inline]
    fn fill(&mut self, name: &str, json: &mut PlainJson<'_>) -> Result<bool, Unusual> {
        Ok(self.0.fill(name, json)? || self.1.fill(name, json)?)
    }
}

impl<A: Columns, B: Columns> Columns for (A, B) {
    type Row = (A::Row, B::Row);

    fn take(object: &mut Object<'_, '_>, most: usize, faults: &mut Faults) -> Self {
        (A::take(object, most, faults), B::take(object, most, faults))
    }

    fn take_plain(columns: &mut PlainColumns<'_>, most: usize) -> Option<Self> {
        Some((A::take_plain(columns, most)?, B::take_plain(columns, most)?))
    }

    fn describe(schema: ObjectSchema<'_>, most: usize) -> ObjectSchema<'_> {
        B::describe(A::describe(schema, most), most)
    }

    fn check_rows(&self, path: &JsonPath<'_>, rows: &mut Rows, faults: &mut Faults) {
        self.0.check_rows(path, rows, faults);
        self.1.check_rows(path, rows, faults);
    }

    #[inline]
    fn row(&self, index: usize) -> Result<Self::Row, Unusual> {
        Ok((self.0.row(index)?, self.1.row(index)?))
    }

    fn write_row(&self, index: usize, row: &mut RowText) {
        self.0.write_row(index, row);
        self.1.write_row(index, row);
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

/// An object of columns as the value of a member.
impl<C: Columns> PlainColumn for C {
    type Plain = C::Row;

    fn read(raw: JsonText<'_>, most: usize, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self, Faulted> {
        Object::open(raw, path, faults)?.read(faults, |object, faults| Ok(Self::take(object, most, faults)))
    }

    fn check_rows(&self, _: &'static str, path: JsonPath<'_>, rows: &mut Rows, faults: &mut Faults) {
        Columns::check_rows(self, &path, rows, faults);
    }

    fn get(&self, index: usize) -> Result<Option<C::Row>, Unusual> {
        let row = self.row(index)?;
        Ok((!row.are_absent()).then_some(row))
    }

    fn write(&self, index: usize, name: &'static str, row: &mut RowText) {
        let mut object = RowText::default();
        self.write_row(index, &mut object);
        row.object(name, object);
    }
}
