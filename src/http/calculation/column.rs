//! The columns of a batch's answer: which the request selects, with how many significant digits, and their text. Each thread
//! writes its rows directly as JSON text, so that no column is in memory both as numbers and as text.

use super::Calculation;
use crate::http::codes::RequestFault;
use crate::http::json_body::WrittenJson;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, Member, Object, ObjectSchema, Whole, items, text};
use crate::http::wire::{CHECK_FIGURES, Extreme, Extremes, Figure, Heights};
use crate::numerics::scalar::to_digits;
use serde::Serialize;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// A column of figures: the JSON of its rows in consecutive pieces, and the extremes of its numbers.
#[derive(Debug, Default)]
pub(crate) struct Column {
    /// The pieces before the last one, each with the comma after it.
    pieces: Vec<Vec<u8>>,
    rows: Vec<u8>,
    /// Whether a row is not null.
    pub(crate) has_value: bool,
    minimum: Option<Extreme>,
    maximum: Option<Extreme>,
    /// The number of contacts that have an answer, but not this figure, and the first of them.
    pub(crate) absent: usize,
    pub(crate) first_absent: Option<usize>,
}

impl Column {
    /// An empty column with room for about this many rows.
    pub(crate) fn with_capacity(rows: usize) -> Self {
        // 17 digits, a point, a digit before it and a comma.
        Self { rows: Vec::with_capacity(20 * rows), ..Self::default() }
    }

    /// Adds the row of a contact without an answer.
    pub(crate) fn push_failed(&mut self) {
        self.next_row().extend_from_slice(b"null");
    }

    /// Adds the row of contact `index`; `None` is written as null.
    #[inline]
    pub(crate) fn push_number(&mut self, index: usize, number: Option<f64>) {
        let Some(value) = number.filter(|value| value.is_finite()) else {
            self.absent += 1;
            self.first_absent = self.first_absent.or(Some(index));
            self.push_failed();
            return;
        };
        let rows = self.next_row();
        // As the serializer writes numbers.
        rows.extend_from_slice(zmij::Buffer::new().format_finite(value).as_bytes());
        self.has_value = true;
        if self.minimum.is_none_or(|minimum| value < minimum.value) {
            self.minimum = Some(Extreme { index, value });
        }
        if self.maximum.is_none_or(|maximum| value > maximum.value) {
            self.maximum = Some(Extreme { index, value });
        }
    }

    /// Adds a row that is no number; `None` is written as null.
    pub(crate) fn push(&mut self, value: Option<&impl Serialize>) {
        self.has_value |= value.is_some();
        write(self.next_row(), &value);
    }

    /// The text of the rows, after the comma before the next one.
    #[inline]
    fn next_row(&mut self) -> &mut Vec<u8> {
        if !self.rows.is_empty() {
            self.rows.push(b',');
        }
        &mut self.rows
    }

    /// Moves the rows to contacts with indices larger by `first`.
    pub(crate) fn shift(&mut self, first: usize) {
        for extreme in self.minimum.iter_mut().chain(&mut self.maximum) {
            extreme.index += first;
        }
        self.first_absent = self.first_absent.map(|index| index + first);
    }

    /// The contacts with the smallest and the largest number; `None` if the column has no number.
    pub(crate) fn extremes(&self) -> Option<Extremes> {
        Some(Extremes { minimum: self.minimum?, maximum: self.maximum? })
    }

    /// Appends the rows of `next`.
    pub(crate) fn append(&mut self, mut next: Self) {
        if next.rows.is_empty() {
            return;
        }
        if !self.rows.is_empty() {
            self.rows.push(b',');
            self.pieces.push(std::mem::take(&mut self.rows));
        }
        self.pieces.append(&mut next.pieces);
        self.rows = next.rows;
        self.has_value |= next.has_value;
        self.absent += next.absent;
        self.first_absent = self.first_absent.or(next.first_absent);
        self.minimum = further(self.minimum, next.minimum, f64::lt);
        self.maximum = further(self.maximum, next.maximum, f64::gt);
    }
}

/// The second extreme if it exceeds the first, otherwise the first.
fn further(first: Option<Extreme>, second: Option<Extreme>, exceeds: impl FnOnce(&f64, &f64) -> bool) -> Option<Extreme> {
    match (first, second) {
        (Some(a), Some(b)) => Some(if exceeds(&b.value, &a.value) { b } else { a }),
        (one, other) => one.or(other),
    }
}

/// A JSON object of columns and some other members, written member by member.
#[derive(Debug, Default)]
pub(crate) struct Table {
    pieces: Vec<Vec<u8>>,
    /// The text after the pieces.
    text: Vec<u8>,
}

impl Table {
    /// Adds a member that is not a column.
    pub(crate) fn value(&mut self, name: &'static str, value: &impl Serialize) {
        self.name(name);
        write(&mut self.text, value);
    }

    /// Adds a column.
    pub(crate) fn column(&mut self, name: &'static str, column: Column) {
        self.name(name);
        self.text.push(b'[');
        self.pieces.push(std::mem::take(&mut self.text));
        self.pieces.extend(column.pieces);
        self.pieces.push(column.rows);
        self.text.push(b']');
    }

    /// The whole object.
    pub(crate) fn written(mut self) -> WrittenJson {
        self.text.push(b'}');
        self.pieces.push(self.text);
        WrittenJson::in_pieces(self.pieces)
    }

    /// The whole object as one text.
    pub(crate) fn joined(mut self) -> Vec<u8> {
        self.text.push(b'}');
        self.pieces.push(self.text);
        self.pieces.concat()
    }

    fn name(&mut self, name: &'static str) {
        let first = self.pieces.is_empty() && self.text.is_empty();
        self.text.push(if first { b'{' } else { b',' });
        write(&mut self.text, &name);
        self.text.push(b':');
    }
}

fn write(text: &mut Vec<u8>, value: &impl Serialize) {
    serde_json::to_writer(text, value)
        .unwrap_or_else(|_| unreachable!("writing to memory does not fail, and every value of an answer has a JSON form"));
}

const SIGNIFICANT_DIGITS: Member<Whole> = Member::new(
    "significant_digits",
    "the significant digits to which numbers are rounded; absent = all",
    Whole { minimum: 3, maximum: 17, example: 6 },
);

/// The names of figures, each at most once.
struct ColumnNames {
    known: Vec<&'static Figure>,
}

fn columns<C: Calculation>() -> Member<ColumnNames> {
    let known = C::figures().chain(CHECK_FIGURES).collect();
    let about = "the columns of the answer; absent = all except envelope_scallop_height_mm and deviation, which must be named";
    Member::new("columns", about, ColumnNames { known })
}

impl ColumnNames {
    fn names(&self) -> Vec<&'static str> {
        self.known.iter().map(|figure| figure.name).collect()
    }
}

impl Kind for ColumnNames {
    type Value = Vec<&'static Figure>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted> {
        // A list without repetitions has at most as many items as there are names. Further items are read only to
        // report their faults.
        let names = items(raw, "an array", 2 * self.known.len(), path, faults)?;
        if names.is_empty() {
            return Err(faults.add(&path, RequestFault::WrongCount, "name at least one column, or leave the field out"));
        }
        let (mut selected, mut result) = (Vec::<&'static Figure>::new(), Ok(()));
        for (index, raw) in names.into_iter().enumerate() {
            let path = path.item(index);
            let Ok(name) = text(raw, path, faults) else {
                result = Err(Faulted);
                continue;
            };
            match self.known.iter().find(|figure| figure.name == name) {
                None => {
                    let detail = format_args!("expected one of {}, found {name:?}", self.names().join(", "));
                    result = Err(faults.add(&path, RequestFault::UnknownValue, detail));
                }
                Some(figure) if selected.iter().any(|known| known.name == figure.name) => {
                    result = Err(faults.add(&path, RequestFault::RepeatedField, format_args!("the column {name} is named more than once")));
                }
                Some(figure) => selected.push(figure),
            }
        }
        result.map(|()| selected)
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let name = ObjectBuilder::new().schema_type(Type::String).enum_values(Some(self.names()));
        let schema = ArrayBuilder::new().items(name).unique_items(true).min_items(Some(1));
        schema.description(Some(about)).examples([serde_json::json!(["step_over_mm"])]).into()
    }
}

/// The columns of an answer.
pub(super) struct ColumnSelection {
    pub(super) figures: Vec<&'static Figure>,
    /// Whether the request names the columns.
    pub(super) is_stated: bool,
    significant_digits: Option<u32>,
    /// The heights that the columns need.
    pub(super) heights: Heights,
    /// Whether a selected column needs the comparison with the cutter's exact shape.
    pub(super) is_compared: bool,
}

impl ColumnSelection {
    /// Reads the selection from `object`.
    pub(super) fn read<C: Calculation>(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Self, Faulted> {
        let stated = object.optional(&columns::<C>(), faults);
        let significant_digits = object.optional(&SIGNIFICANT_DIGITS, faults);
        let (stated, significant_digits) = (stated?, significant_digits?);
        let is_stated = stated.is_some();
        let figures = stated.unwrap_or_else(|| C::figures().collect());
        let heights = figures.iter().map(|figure| figure.heights).max().unwrap_or(Heights::Unused);
        let is_compared = figures.iter().any(|figure| CHECK_FIGURES.iter().any(|check| check.name == figure.name));
        Ok(Self { figures, is_stated, significant_digits, heights, is_compared })
    }

    pub(super) fn describe<C: Calculation>(schema: ObjectSchema<'_>) -> ObjectSchema<'_> {
        schema.optional(&columns::<C>()).optional(&SIGNIFICANT_DIGITS)
    }

    /// Whether the answer has the column of a figure.
    pub(super) fn shows(&self, figure: &Figure, column: &Column) -> bool {
        self.is_stated || figure.is_required_column() || column.has_value
    }

    /// The number, rounded to the significant digits.
    pub(super) fn rounded(&self, number: f64) -> f64 {
        self.significant_digits.map_or(number, |digits| to_digits(number, digits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use http_body_util::BodyExt;

    async fn text(table: Table) -> String {
        String::from_utf8(table.written().collect().await.unwrap().to_bytes().into()).unwrap()
    }

    fn column(first: usize, rows: &[Option<f64>]) -> Column {
        let mut column = Column::with_capacity(rows.len());
        for (index, row) in (first..).zip(rows) {
            column.push_number(index, *row);
        }
        column
    }

    #[tokio::test]
    async fn parts_make_one_array_however_they_are_cut() {
        let rows = [Some(0.5), None, Some(1e-7), Some(0.5)];
        for cut in 0..=rows.len() {
            let mut whole = Column::default();
            whole.append(column(0, &rows[..cut]));
            whole.append(column(cut, &rows[cut..]));
            let extremes = whole.extremes().unwrap();
            assert_eq!((extremes.minimum.index, extremes.maximum.index), (2, 0), "cut at {cut}");
            let mut table = Table::default();
            table.value("model", &"analytic");
            table.column("height_mm", whole);
            assert_eq!(text(table).await, r#"{"model":"analytic","height_mm":[0.5,null,1e-7,0.5]}"#, "cut at {cut}");
        }
    }

    #[test]
    fn contacts_without_the_figure_are_counted_but_not_failed_ones() {
        let mut whole = Column::default();
        whole.push_failed();
        whole.push_number(1, Some(2.0));
        let mut next = column(0, &[None, None]);
        next.shift(2);
        whole.append(next);
        assert_eq!((whole.absent, whole.first_absent), (2, Some(2)));
    }

    #[tokio::test]
    async fn a_column_of_nulls_has_no_value() {
        assert!(!column(0, &[None]).has_value && column(0, &[None, Some(2.0)]).has_value);
        let mut table = Table::default();
        table.column("heights", Column::default());
        assert_eq!(text(table).await, r#"{"heights":[]}"#);
    }
}
