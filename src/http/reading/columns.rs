//! Objects of columns, from which batches take contacts row by row. A column is an array with an item for each contact,
//! null for a contact without a value.

use super::array::items;
use super::{Faulted, Faults, Object, PlainColumns};
use crate::http::codes::RequestFault;
use crate::json_text::{JsonPath, JsonText, PlainJson, PlainValue, Unusual, read_numbers};

/// The columns that an object may have, by their names.
pub(crate) type KnownColumns = Vec<(&'static str, ColumnKind)>;

/// The kind of a column's values.
pub(crate) enum ColumnKind {
    /// Numbers, which are parsed on all cores when the column is read.
    Numbers,
    /// Arrays, each parsed when its row is read.
    Arrays,
    /// An object of columns in place of a column of objects.
    Object(KnownColumns),
}

/// An object of columns.
#[derive(Debug)]
pub(crate) struct Columns<'a>(pub(super) Vec<(&'static str, Column<'a>)>);

#[derive(Debug)]
pub(crate) enum Column<'a> {
    /// Numbers, NaN for null.
    Numbers(Vec<f64>),
    /// The unparsed items of another array.
    Items(Vec<JsonText<'a>>),
    Object(Columns<'a>),
}

/// The name of the first column and its number of rows, with which the others are compared.
type FirstColumn = Option<(&'static str, usize)>;

impl<'a> Columns<'a> {
    /// Takes the columns `known` of at most `most` rows from `object`. An item of another type is a fault of its row,
    /// which is reported when the row is read.
    pub(crate) fn take(object: &mut Object<'a, '_>, known: &KnownColumns, most: usize, faults: &mut Faults) -> Self {
        let path = object.path();
        let take = |(name, kind): &(&'static str, ColumnKind)| {
            let raw = object.take(name, faults)?;
            Some((*name, Column::read(raw, kind, most, path.member(name), faults).ok()?))
        };
        Self(known.iter().filter_map(take).collect())
    }

    /// The same for columns whose syntax has not been checked. `None` if there are others than columns of numbers.
    pub(crate) fn of_plain(mut given: PlainColumns<'_>, known: &KnownColumns, most: usize) -> Option<Self> {
        let mut columns = Vec::new();
        for (name, _) in known.iter().filter(|(_, kind)| matches!(kind, ColumnKind::Numbers)) {
            if let Some(items) = given.take(name) {
                columns.push((*name, Column::Numbers(read_numbers(items, most)?)));
            }
        }
        given.is_empty().then_some(Self(columns))
    }

    /// Compares the number of rows of all columns of the object at `path`.
    pub(crate) fn check_rows(&self, first: &mut FirstColumn, path: &JsonPath<'_>, faults: &mut Faults) {
        for (name, column) in &self.0 {
            let path = path.member(name);
            let count = match column {
                Column::Numbers(numbers) => numbers.len(),
                Column::Items(items) => items.len(),
                Column::Object(columns) => {
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

    /// A row as the JSON text of an object, whether its values are valid or not.
    pub(crate) fn text(&self, index: usize) -> String {
        let members = self.0.iter().filter_map(|(name, column)| Some(format!("{name:?}:{}", column.text(index)?)));
        format!("{{{}}}", members.collect::<Vec<_>>().join(","))
    }
}

impl<'a> Column<'a> {
    fn read(raw: JsonText<'a>, kind: &ColumnKind, most: usize, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self, Faulted> {
        if let ColumnKind::Object(known) = kind {
            let read = |object: &mut Object<'a, '_>, faults: &mut Faults| Ok(Self::Object(Columns::take(object, known, most, faults)));
            return Object::open(raw, path, faults)?.read(faults, read);
        }
        let inside = raw.get().strip_prefix('[').and_then(|items| items.strip_suffix(']'));
        match inside.filter(|_| matches!(kind, ColumnKind::Numbers)).and_then(|items| read_numbers(items.as_bytes(), most)) {
            Some(numbers) => Ok(Self::Numbers(numbers)),
            None => items(raw, "an array with an item for each contact", most, path, faults).map(Self::Items),
        }
    }

    /// The JSON text of the value of a row, if it has one.
    fn text(&self, index: usize) -> Option<String> {
        match self {
            Self::Numbers(numbers) => {
                numbers.get(index).filter(|number| !number.is_nan()).and_then(|number| serde_json::to_string(number).ok())
            }
            Self::Items(items) => items.get(index).map(|item| item.get()).filter(|item| *item != "null").map(str::to_owned),
            Self::Object(columns) => Some(columns.text(index)).filter(|object| object != "{}"),
        }
    }

    /// The value of a row of unparsed items.
    pub(super) fn item<P: PlainValue>(&self, index: usize) -> Result<Option<P>, Unusual> {
        let Self::Items(items) = self else { return Err(Unusual) };
        let mut json = PlainJson::new(items.get(index).ok_or(Unusual)?.get().as_bytes());
        if json.takes_null() { Ok(None) } else { P::read(&mut json).map(Some) }
    }
}
