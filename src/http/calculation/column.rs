//! The answer for many contacts as it is written: each column is JSON text from the start, so that its parts are written on all cores
//! and no column of numbers is held beside its text.

use crate::http::body::WrittenJson;
use serde::Serialize;

/// A column of figures: the JSON of its rows, in pieces between which a comma is missing.
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
    pub(crate) fn push(&mut self, figure: Option<impl Serialize>) {
        let Some(rows) = self.pieces.last_mut() else { unreachable!("an open column has a piece that grows") };
        if !rows.is_empty() {
            rows.push(b',');
        }
        self.says_something |= figure.is_some();
        write(rows, &figure);
    }

    /// Adds the rows of `next` below these.
    pub(crate) fn append(&mut self, next: Self) {
        self.pieces.extend(next.pieces.into_iter().filter(|rows| !rows.is_empty()));
        self.says_something |= next.says_something;
    }
}

/// An object of columns and a few other members.
#[derive(Debug, Default)]
pub(crate) struct Table<'a> {
    members: Vec<(&'static str, Member<'a>)>,
}

#[derive(Debug)]
enum Member<'a> {
    Column(&'a Column),
    Value(Vec<u8>),
}

impl<'a> Table<'a> {
    /// Adds a member that is no column.
    pub(crate) fn value(&mut self, name: &'static str, value: &impl Serialize) {
        let mut text = Vec::new();
        write(&mut text, value);
        self.members.push((name, Member::Value(text)));
    }

    /// Adds a column.
    pub(crate) fn column(&mut self, name: &'static str, column: &'a Column) {
        self.members.push((name, Member::Column(column)));
    }

    /// Adds a column unless no row of it says anything.
    pub(crate) fn optional_column(&mut self, name: &'static str, column: &'a Column) {
        if column.says_something {
            self.column(name, column);
        }
    }

    /// The whole as text.
    pub(crate) fn written(&self) -> WrittenJson {
        // Four more than a name are "":, and a column's two brackets; a comma goes with each piece.
        let room = |(name, member): &(&str, Member)| {
            name.len()
                + 6
                + match member {
                    Member::Column(column) => column.pieces.iter().map(|rows| rows.len() + 1).sum(),
                    Member::Value(text) => text.len(),
                }
        };
        let mut text = Vec::with_capacity(2 + self.members.iter().map(room).sum::<usize>());
        text.push(b'{');
        for (index, (name, member)) in self.members.iter().enumerate() {
            if index > 0 {
                text.push(b',');
            }
            write(&mut text, name);
            text.push(b':');
            match member {
                Member::Value(value) => text.extend_from_slice(value),
                Member::Column(column) => write_column(&mut text, column),
            }
        }
        text.push(b'}');
        WrittenJson(text)
    }
}

fn write_column(text: &mut Vec<u8>, column: &Column) {
    text.push(b'[');
    for (index, rows) in column.pieces.iter().enumerate() {
        if index > 0 {
            text.push(b',');
        }
        text.extend_from_slice(rows);
    }
    text.push(b']');
}

fn write(text: &mut Vec<u8>, value: &impl Serialize) {
    serde_json::to_writer(text, value).unwrap_or_else(|_| unreachable!("memory takes all, and answers have nothing that JSON lacks"));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(table: &Table<'_>) -> String {
        String::from_utf8(table.written().0).unwrap()
    }

    #[test]
    fn parts_make_one_array_however_they_are_cut() {
        let rows = [Some(0.5), None, Some(1e-7)];
        for cut in 0..=rows.len() {
            let mut whole = Column::default();
            for rows in [&rows[..cut], &rows[cut..]] {
                let mut part = Column::open(2);
                rows.iter().for_each(|row| part.push(*row));
                whole.append(part);
            }
            let mut table = Table::default();
            table.value("model", &"analytic");
            table.column("height_mm", &whole);
            assert_eq!(text(&table), r#"{"model":"analytic","height_mm":[0.5,null,1e-7]}"#, "cut at {cut}");
        }
    }

    #[test]
    fn an_optional_column_that_says_nothing_is_absent() {
        let (empty, mut silent) = (Column::default(), Column::open(1));
        silent.push(None::<f64>);
        let mut table = Table::default();
        table.optional_column("feed_rate_mm_min", &silent);
        table.column("heights", &empty);
        assert_eq!(text(&table), r#"{"heights":[]}"#);
        silent.push(Some(2.0));
        table = Table::default();
        table.optional_column("feed_rate_mm_min", &silent);
        assert_eq!(text(&table), r#"{"feed_rate_mm_min":[null,2.0]}"#);
    }
}
