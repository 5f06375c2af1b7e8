//! Errors of JSON texts, with the messages and places of serde_json.

use memchr::{memchr_iter, memrchr};
use serde_json::value::RawValue;
use std::fmt;

/// The reason why a text is not JSON, with its place. Message and place are those of serde_json.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct JsonError {
    message: String,
    line: usize,
    column: usize,
}

impl fmt::Display for JsonError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at line {} column {}", self.message, self.line, self.column)
    }
}

impl JsonError {
    /// The error of a short text, of which all but the first `added` bytes are the part of `json` that begins at `from`.
    pub(super) fn of(error: &serde_json::Error, short: &[u8], added: usize, json: &[u8], from: usize) -> Self {
        let lines = memchr_iter(b'\n', short).nth(error.line().wrapping_sub(2)).map_or(0, |end| end + 1);
        let at = (lines + error.column()).max(added) - added + from;
        Self { message: without_place(error), ..Self::at(json, at) }
    }

    /// An error at this position, without a message: its line, and the bytes before it in the line.
    fn at(json: &[u8], position: usize) -> Self {
        let before = &json[..position.min(json.len())];
        let start = memrchr(b'\n', before).map_or(0, |end| end + 1);
        Self { message: String::new(), line: 1 + memchr_iter(b'\n', &before[..start]).count(), column: before.len() - start }
    }

    /// The error of the part of `json` that begins at `from` and that serde_json refuses, after `context`, within the
    /// next few bytes.
    pub(super) fn of_violation(context: &str, json: &[u8], from: usize) -> Self {
        /// No violation is found later than within these bytes: `\u` and four digits, `false`.
        const LONGEST: usize = 16;
        let short = [context.as_bytes(), &json[from..json.len().min(from + LONGEST)]].concat();
        match serde_json::from_slice::<&RawValue>(&short) {
            Err(error) => Self::of(&error, &short, context.len(), json, from),
            Ok(_) => unreachable!("serde_json accepts a violation of the syntax"),
        }
    }

    /// The error of a value that is not UTF-8 from this position on.
    pub(super) fn not_utf_8(json: &[u8], from: usize) -> Self {
        Self { message: Self::of_violation("", b"\"\xff\"", 0).message, ..Self::at(json, from + 1) }
    }

    /// The error of a check that was cancelled, which must be discarded.
    pub(super) fn cancelled() -> Self {
        Self { message: "cancelled".to_owned(), line: 0, column: 0 }
    }

    /// The line of the place, from 1.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// The column of the place, in bytes.
    pub(crate) fn column(&self) -> usize {
        self.column
    }

    /// The message without the place.
    pub(crate) fn message(&self) -> &str {
        &self.message
    }
}

impl From<&serde_json::Error> for JsonError {
    fn from(error: &serde_json::Error) -> Self {
        Self { message: without_place(error), line: error.line(), column: error.column() }
    }
}

fn without_place(error: &serde_json::Error) -> String {
    let message = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    message.strip_suffix(&place).map_or(message.clone(), str::to_owned)
}
