//! The columns of a batch's answer. Each thread writes its rows directly as JSON text, so that no column is in memory
//! both as numbers and as text.

use crate::http::body::WrittenJson;
use crate::http::wire::{Extreme, Extremes, FigureValue};
use serde::Serialize;

/// A column of figures: the JSON of its rows in consecutive pieces, and the extremes of its numbers.
#[derive(Debug, Default)]
pub(crate) struct Column {
    pieces: Vec<Vec<u8>>,
    has_value: bool,
    minimum: Option<Extreme>,
    maximum: Option<Extreme>,
}

impl Column {
    /// An empty column with room for about this many rows.
    pub(crate) fn with_capacity(rows: usize) -> Self {
        // 17 digits, a point, a digit before it and a comma.
        Self { pieces: vec![Vec::with_capacity(20 * rows)], ..Self::default() }
    }

    /// Adds the row of contact `index`; `None` is written as null.
    pub(crate) fn push(&mut self, index: usize, figure: Option<FigureValue>) {
        let Some(rows) = self.pieces.last_mut() else { unreachable!("a column with rows has a piece") };
        if !rows.is_empty() {
            rows.push(b',');
        }
        self.has_value |= figure.is_some();
        write(rows, &figure);
        if let Some(FigureValue::Number(value)) = figure {
            let found = Some(Extreme { index, value });
            self.minimum = lower(self.minimum, found);
            self.maximum = higher(self.maximum, found);
        }
    }

    /// The contacts with the smallest and the largest number; `None` if the column has no number.
    pub(crate) fn extremes(&self) -> Option<Extremes> {
        Some(Extremes { minimum: self.minimum?, maximum: self.maximum? })
    }

    /// Appends the rows of `next`.
    pub(crate) fn append(&mut self, next: Self) {
        for rows in next.pieces.into_iter().filter(|rows| !rows.is_empty()) {
            if let Some(above) = self.pieces.last_mut() {
                above.push(b',');
            }
            self.pieces.push(rows);
        }
        self.has_value |= next.has_value;
        self.minimum = lower(self.minimum, next.minimum);
        self.maximum = higher(self.maximum, next.maximum);
    }
}

/// The extreme with the smaller value, the first of equals.
fn lower(first: Option<Extreme>, second: Option<Extreme>) -> Option<Extreme> {
    match (first, second) {
        (Some(a), Some(b)) => Some(if b.value < a.value { b } else { a }),
        (one, other) => one.or(other),
    }
}

/// The extreme with the larger value, the first of equals.
fn higher(first: Option<Extreme>, second: Option<Extreme>) -> Option<Extreme> {
    match (first, second) {
        (Some(a), Some(b)) => Some(if b.value > a.value { b } else { a }),
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
        self.text.push(b']');
    }

    /// Adds a column unless all its rows are null.
    pub(crate) fn optional_column(&mut self, name: &'static str, column: Column) {
        if column.has_value {
            self.column(name, column);
        }
    }

    /// The whole object.
    pub(crate) fn written(mut self) -> WrittenJson {
        self.text.push(b'}');
        self.pieces.push(self.text);
        WrittenJson::in_pieces(self.pieces)
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
            column.push(index, row.map(FigureValue::Number));
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

    #[tokio::test]
    async fn an_optional_column_of_nulls_is_absent() {
        let mut table = Table::default();
        table.optional_column("feed_rate_mm_min", column(0, &[None]));
        table.column("heights", Column::default());
        assert_eq!(text(table).await, r#"{"heights":[]}"#);
        table = Table::default();
        table.optional_column("feed_rate_mm_min", column(0, &[None, Some(2.0)]));
        assert_eq!(text(table).await, r#"{"feed_rate_mm_min":[null,2.0]}"#);
    }
}
