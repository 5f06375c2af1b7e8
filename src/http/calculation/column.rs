//! The answer for many contacts as it is written: each column is JSON text from the start, so that its parts are written on all cores
//! and no column of numbers is held beside its text.

use crate::http::body::WrittenJson;
use serde::Serialize;

/// A column of figures: the JSON of its rows, in pieces that follow each other.
#[derive(Debug, Default)]
pub(crate) struct Column {
    pieces: Vec<Vec<u8>>,
    says_something: bool,
}

impl Column {
    /// A column without a row, to which rows can be added one by one, about so many.
    pub(crate) fn open(rows: usize) -> Self {
        // 17 digits, a point, a digit before it and a comma.
        Self { pieces: vec![Vec::with_capacity(20 * rows)], says_something: false }
    }

    /// Adds a row to an open column; `None` is null.
    pub(crate) fn push(&mut self, figure: Option<impl Serialize + Copy>) {
        let Some(rows) = self.pieces.last_mut() else { unreachable!("an open column has a piece that grows") };
        if !rows.is_empty() {
            rows.push(b',');
        }
        self.says_something |= figure.is_some();
        write(rows, &figure);
    }

    /// Adds the rows of `next` below these.
    pub(crate) fn append(&mut self, next: Self) {
        for rows in next.pieces.into_iter().filter(|rows| !rows.is_empty()) {
            if let Some(above) = self.pieces.last_mut() {
                above.push(b',');
            }
            self.pieces.push(rows);
        }
        self.says_something |= next.says_something;
    }
}

/// An object of columns and a few other members, as it is being put together.
#[derive(Debug, Default)]
pub(crate) struct Table {
    pieces: Vec<Vec<u8>>,
    /// What comes after the pieces.
    text: Vec<u8>,
}

impl Table {
    /// Adds a member that is no column.
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

    /// Adds a column unless no row of it says anything.
    pub(crate) fn optional_column(&mut self, name: &'static str, column: Column) {
        if column.says_something {
            self.column(name, column);
        }
    }

    /// The whole.
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
    serde_json::to_writer(text, value).unwrap_or_else(|_| unreachable!("memory takes all, and answers have nothing that JSON lacks"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use http_body_util::BodyExt;

    async fn text(table: Table) -> String {
        String::from_utf8(table.written().collect().await.unwrap().to_bytes().into()).unwrap()
    }

    #[tokio::test]
    async fn parts_make_one_array_however_they_are_cut() {
        let rows = [Some(0.5), None, Some(1e-7)];
        for cut in 0..=rows.len() {
            let mut whole = Column::default();
            for rows in [&rows[..cut], &rows[cut..]] {
                let mut part = Column::open(2);
                for row in rows {
                    part.push(*row);
                }
                whole.append(part);
            }
            let mut table = Table::default();
            table.value("model", &"analytic");
            table.column("height_mm", whole);
            assert_eq!(text(table).await, r#"{"model":"analytic","height_mm":[0.5,null,1e-7]}"#, "cut at {cut}");
        }
    }

    #[tokio::test]
    async fn an_optional_column_that_says_nothing_is_absent() {
        let (empty, mut silent) = (Column::default(), Column::open(1));
        silent.push(None::<f64>);
        let mut table = Table::default();
        table.optional_column("feed_rate_mm_min", silent);
        table.column("heights", empty);
        assert_eq!(text(table).await, r#"{"heights":[]}"#);
        let mut speaking = Column::open(2);
        speaking.push(None::<f64>);
        speaking.push(Some(2.0));
        table = Table::default();
        table.optional_column("feed_rate_mm_min", speaking);
        assert_eq!(text(table).await, r#"{"feed_rate_mm_min":[null,2.0]}"#);
    }
}
