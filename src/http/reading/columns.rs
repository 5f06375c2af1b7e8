//! Columns of values, which batches parse directly into numbers. A column is an array with an item for each contact,
//! null for a contact without a value.

use super::object::describe;
use super::{Faulted, Faults};
use crate::http::codes::RequestFault;
use crate::json_text::{JsonPath, JsonText, PlainJson, PlainValue, Unusual, read_numbers};
use serde::Serialize;
use std::fmt::Write;

/// A column of values, or an object of columns.
pub(crate) trait PlainColumn: Default {
    /// The type of a row's value in JSON.
    type Plain;

    /// Reads a column of at most `most` rows. An item of another type is a fault of its row, which is reported when the
    /// row is read.
    fn read(raw: JsonText<'_>, most: usize, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self, Faulted>;

    /// Reads a column of at most `most` rows from the text between the brackets of its array, whose syntax has not been
    /// checked. `None` if the column has no fast reader or the text is unusual.
    fn read_plain(_items: &[u8], _most: usize) -> Option<Self> {
        None
    }

    /// Compares the number of rows of this column, `name`, with that of earlier columns.
    fn check_rows(&self, name: &'static str, path: JsonPath<'_>, rows: &mut Rows, faults: &mut Faults);

    /// The value of a row, if it has one; an error for a value of another type.
    fn get(&self, index: usize) -> Result<Option<Self::Plain>, Unusual>;

    /// Writes the value of a row, valid or not, as the member `name` of an object.
    fn write(&self, index: usize, name: &'static str, row: &mut RowText);
}

/// The number of rows, which is the same for all columns.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    /// The name of the first column and the number of rows; `None` if there are no columns.
    pub(crate) first: Option<(&'static str, usize)>,
}

impl Rows {
    /// Compares `count`, the rows of the column `name`.
    pub(crate) fn check(&mut self, name: &'static str, count: usize, path: &JsonPath<'_>, faults: &mut Faults) {
        match self.first {
            None => self.first = Some((name, count)),
            Some((first, expected)) if expected != count => {
                let detail = format_args!("all columns must have as many items as {first}, {expected}; found {count}");
                faults.add(path, RequestFault::WrongCount, detail);
            }
            Some(_) => {}
        }
    }
}

/// The items of a column.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Cells<P> {
    values: Vec<P>,
    /// The rows with a value of another type in ascending order, the first ones with their text.
    faulty: Vec<(usize, Option<Box<str>>)>,
}

/// An answer lists at most this many failures; the texts of further items are not needed.
const MOST_FAULTY_TEXTS: usize = 1000;

/// A value that a column holds for a row.
pub(crate) trait CellValue: PlainValue + Default + Serialize {
    /// The value that stands for null. No value in JSON equals it.
    const ABSENT: Self;

    fn is_absent(&self) -> bool;

    /// Reads a value or null.
    #[inline]
    fn read_item(json: &mut PlainJson<'_>) -> Result<Self, Unusual> {
        if json.takes_null() { Ok(Self::ABSENT) } else { Self::read(json) }
    }

    /// Reads the items of an array, as [`PlainColumn::read_plain`].
    fn read_all(items: &[u8], most: usize) -> Option<Vec<Self>> {
        let (mut json, mut values) = (PlainJson::new(items), Vec::new());
        while !json.is_at_end() {
            if values.len() == most || !(values.is_empty() || json.takes(b',')) {
                return None;
            }
            values.push(Self::read_item(&mut json).ok()?);
        }
        Some(values)
    }
}

impl CellValue for f64 {
    const ABSENT: Self = Self::NAN;

    fn is_absent(&self) -> bool {
        self.is_nan()
    }

    /// Reads the items on all cores.
    fn read_all(items: &[u8], most: usize) -> Option<Vec<Self>> {
        read_numbers(items, most)
    }
}

impl<const N: usize> CellValue for [f64; N]
where
    Self: Default + Serialize,
{
    const ABSENT: Self = [f64::NAN; N];

    fn is_absent(&self) -> bool {
        self.iter().any(|component| component.is_nan())
    }
}

impl<P: CellValue> Cells<P> {
    /// The value of a row, if it has one of the column's type.
    fn value(&self, index: usize) -> Option<P> {
        self.values.get(index).copied().filter(|value| !value.is_absent())
    }
}

impl<P: CellValue> PlainColumn for Cells<P> {
    type Plain = P;

    fn read(raw: JsonText<'_>, most: usize, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self, Faulted> {
        let items = raw.get().strip_prefix('[').and_then(|items| items.strip_suffix(']'));
        if let Some(cells) = items.and_then(|items| Self::read_plain(items.as_bytes(), most)) {
            return Ok(cells);
        }
        // This pass finds the items of another type.
        let (mut cells, mut count) = (Self::default(), 0);
        let stop = || faults.is_cancelled();
        let read = raw.items(&stop, |item| {
            count += 1;
            if count > most {
                return;
            }
            let value = P::read_item(&mut PlainJson::new(item.get().as_bytes()));
            if value.is_err() {
                let text = (cells.faulty.len() < MOST_FAULTY_TEXTS).then(|| item.get().into());
                cells.faulty.push((count - 1, text));
            }
            cells.values.push(value.unwrap_or(P::ABSENT));
        });
        read.map_err(|_| {
            let detail = format_args!("expected an array with an item for each contact, found {}", describe(raw));
            faults.add(&path, RequestFault::WrongType, detail)
        })?;
        if count > most {
            return Err(faults.add(&path, RequestFault::TooManyItems, format_args!("must have at most {most} items, found {count}")));
        }
        Ok(cells)
    }

    fn read_plain(items: &[u8], most: usize) -> Option<Self> {
        P::read_all(items, most).map(|values| Self { values, faulty: Vec::new() })
    }

    fn check_rows(&self, name: &'static str, path: JsonPath<'_>, rows: &mut Rows, faults: &mut Faults) {
        rows.check(name, self.values.len(), &path, faults);
    }

    fn get(&self, index: usize) -> Result<Option<P>, Unusual> {
        match self.value(index) {
            None if self.faulty.binary_search_by_key(&index, |(row, _)| *row).is_ok() => Err(Unusual),
            value => Ok(value),
        }
    }

    fn write(&self, index: usize, name: &'static str, row: &mut RowText) {
        if let Some(value) = self.value(index) {
            row.member(name, &value);
        } else if let Ok(found) = self.faulty.binary_search_by_key(&index, |(row, _)| *row) {
            match &self.faulty[found].1 {
                Some(text) => row.written_member(name, text),
                // No member of a contact takes a boolean.
                None => row.member(name, &true),
            }
        }
    }
}

/// The JSON text of a row as an object.
#[derive(Debug, Default)]
pub(crate) struct RowText {
    members: String,
}

impl RowText {
    /// Adds a member.
    pub(crate) fn member(&mut self, name: &str, value: &impl Serialize) {
        let text = serde_json::to_string(value).unwrap_or_else(|_| unreachable!("numbers can be written"));
        self.written_member(name, &text);
    }

    /// Adds a member whose value is given as JSON.
    fn written_member(&mut self, name: &str, value: &str) {
        let separator = if self.members.is_empty() { "" } else { "," };
        let _ = write!(self.members, "{separator}{name:?}:{value}");
    }

    /// Adds a member that is an object, unless it has no members.
    pub(crate) fn object(&mut self, name: &str, object: Self) {
        if !object.members.is_empty() {
            self.written_member(name, &object.written());
        }
    }

    /// The whole object.
    pub(crate) fn written(self) -> String {
        format!("{{{}}}", self.members)
    }
}
