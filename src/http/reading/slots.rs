//! The values of several members in one pass, from an object or a row of columns, without collecting faults. Two sets of
//! members of one object are a pair.

use super::columns::{Column, ColumnKind};
use super::{Columns, Components, Kind, KnownColumns, Member, ObjectSchema};
use crate::json_text::{PlainJson, PlainValue, Unusual};
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

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

/// A source from which the value of a member is read.
pub(crate) trait ValueSource {
    /// The value, if there is one; an error for a value of another type.
    fn value<P: CellValue>(&mut self) -> Result<Option<P>, Unusual>;
}

impl ValueSource for PlainJson<'_> {
    #[inline]
    fn value<P: CellValue>(&mut self) -> Result<Option<P>, Unusual> {
        P::read(self).map(Some)
    }
}

/// The item of a column for a row.
struct Cell<'c> {
    column: &'c Column<'c>,
    index: usize,
}

impl ValueSource for Cell<'_> {
    #[inline]
    fn value<P: CellValue>(&mut self) -> Result<Option<P>, Unusual> {
        P::of_column(self.column, self.index)
    }
}

/// A value that a column has for a row.
pub(crate) trait CellValue: PlainValue {
    /// The kind of a column of such values.
    fn column_kind() -> ColumnKind;

    /// The value of a row, if it has one; an error for a value of another type.
    fn of_column(column: &Column<'_>, index: usize) -> Result<Option<Self>, Unusual>;
}

impl CellValue for f64 {
    fn column_kind() -> ColumnKind {
        ColumnKind::Numbers
    }

    #[inline]
    fn of_column(column: &Column<'_>, index: usize) -> Result<Option<Self>, Unusual> {
        match column {
            Column::Numbers(numbers) => Ok(numbers.get(index).copied().filter(|number| !number.is_nan())),
            _ => column.item(index),
        }
    }
}

impl<const N: usize> CellValue for [f64; N] {
    fn column_kind() -> ColumnKind {
        ColumnKind::Arrays
    }

    fn of_column(column: &Column<'_>, index: usize) -> Result<Option<Self>, Unusual> {
        column.item(index)
    }
}

impl<S: Slots> CellValue for S {
    fn column_kind() -> ColumnKind {
        ColumnKind::Object(S::columns())
    }

    fn of_column(column: &Column<'_>, index: usize) -> Result<Option<Self>, Unusual> {
        let Column::Object(columns) = column else { return Err(Unusual) };
        let mut slots = S::default();
        columns.fill(index, &mut slots)?;
        Ok((!slots.are_absent()).then_some(slots))
    }
}

impl Columns<'_> {
    /// Fills `slots` with the values of a row; an error if one is of another type.
    #[inline]
    pub(crate) fn fill(&self, index: usize, slots: &mut impl Slots) -> Result<(), Unusual> {
        self.0.iter().try_for_each(|(name, column)| slots.fill(name, &mut Cell { column, index }).map(|_| ()))
    }
}

/// A kind of value that batches read without collecting faults.
pub(crate) trait PlainKind: Kind {
    /// The value as in JSON.
    type Plain: CellValue;

    /// The schema of a column: an array of values of the kind, null where a row has none.
    fn column_schema(&self, about: &str, most: usize, components: &mut Components) -> RefOr<Schema> {
        let null = ObjectBuilder::new().schema_type(Type::Null);
        let item = OneOfBuilder::new().item(self.schema("", components)).item(null);
        ArrayBuilder::new().items(item).max_items(Some(most)).description(Some(about)).into()
    }

    /// The checked value; `None` if `plain` is faulty.
    fn accept(&self, plain: Self::Plain) -> Option<Self::Value>;
}

impl ObjectSchema<'_> {
    /// Adds a column of at most `most` values of a member, which may be absent.
    pub(crate) fn column<K: PlainKind>(self, member: &Member<K>, most: usize) -> Self {
        let schema = member.kind.column_schema(member.about, most, self.components);
        self.property(member.name, schema)
    }
}
