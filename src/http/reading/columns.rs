//! Objects of columns, from which batches take contacts row by row. A column is an array with an item for each contact,
//! null for a contact without a value.

use super::array::items;
use super::{AnyMember, Faulted, Faults, JsonPath, Object};
use crate::http::codes::RequestFault;
use serde_json::value::RawValue;
use std::borrow::Cow;

/// An object of columns. The values are parsed when their row is read.
#[derive(Debug)]
pub(crate) struct Columns<'a>(Vec<(&'static str, Column<'a>)>);

#[derive(Debug)]
enum Column<'a> {
    Items(Vec<&'a RawValue>),
    /// Columns in place of a column of objects, and the objects of their rows.
    Object(Columns<'a>, Vec<Box<RawValue>>),
}

/// The name of the first column and its number of rows, with which the others are compared.
pub(crate) type FirstColumn = Option<(&'static str, usize)>;

impl<'a> Columns<'a> {
    /// Takes the columns of `members`, each of at most `most` rows, from `object`. An item of another type is a fault of
    /// its row, which is reported when the row is read.
    pub(crate) fn take(
        object: &mut Object<'a, '_>,
        members: impl IntoIterator<Item = &'static dyn AnyMember>,
        most: usize,
        faults: &mut Faults,
    ) -> Self {
        let path = object.path();
        let take = |member: &'static dyn AnyMember| {
            let raw = object.take(member.name(), faults)?;
            Some((member.name(), Column::read(raw, member, most, path.member(member.name()), faults).ok()?))
        };
        Self(members.into_iter().filter_map(take).collect())
    }

    /// Compares the number of rows of all columns of the object at `path`.
    pub(crate) fn check_rows(&self, first: &mut FirstColumn, path: &JsonPath<'_>, faults: &mut Faults) {
        for (name, column) in &self.0 {
            let path = path.member(name);
            let count = match column {
                Column::Items(items) => items.len(),
                Column::Object(columns, _) => {
                    columns.check_rows(first, &path, faults);
                    continue;
                }
            };
            let (first, expected) = *first.get_or_insert((name, count));
            if expected != count {
                let detail = format_args!("all columns must have as many items as {first}, {expected}; found {count}");
                faults.add(&path, RequestFault::WrongCount, detail);
            }
        }
    }

    /// A row as an object.
    pub(crate) fn row<'r, 'p>(&'r self, index: usize, path: JsonPath<'p>) -> Object<'r, 'p> {
        let members = self.0.iter().filter_map(|(name, column)| Some((Cow::Borrowed(*name), column.value(index)?)));
        Object::of_members(members.collect(), path)
    }

    /// The rows as JSON objects, whether their values are valid or not.
    fn objects(&self) -> Vec<Box<RawValue>> {
        let count = self.0.iter().map(|(_, column)| column.count()).max().unwrap_or(0);
        let object = |index| {
            let members = self.0.iter().filter_map(|(name, column)| Some(format!("{name:?}:{}", column.value(index)?)));
            let text = format!("{{{}}}", members.collect::<Vec<_>>().join(","));
            RawValue::from_string(text).unwrap_or_else(|error| unreachable!("a row of values is an object: {error}"))
        };
        (0..count).map(object).collect()
    }
}

impl<'a> Column<'a> {
    fn read(
        raw: &'a RawValue,
        member: &'static dyn AnyMember,
        most: usize,
        path: JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<Self, Faulted> {
        let Some(members) = member.columns() else {
            return items(raw, "an array with an item for each contact", most, path, faults).map(Self::Items);
        };
        Object::open(raw, path, faults)?.read(faults, |object, faults| {
            let columns = Columns::take(object, members, most, faults);
            let objects = columns.objects();
            Ok(Self::Object(columns, objects))
        })
    }

    fn count(&self) -> usize {
        match self {
            Self::Items(items) => items.len(),
            Self::Object(_, objects) => objects.len(),
        }
    }

    /// The value of a row, if it has one.
    fn value(&self, index: usize) -> Option<&RawValue> {
        match self {
            Self::Items(items) => items.get(index).copied().filter(|item| item.get() != "null"),
            Self::Object(_, objects) => objects.get(index).map(|object| &**object).filter(|object| object.get() != "{}"),
        }
    }
}
