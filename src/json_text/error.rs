//! Errors of JSON texts, with the places of serde_json, and its messages in plain words.

use memchr::{memchr_iter, memrchr};
use serde_json::value::RawValue;
use std::fmt;

/// The reason why a text is not JSON, with its place. The place is that of serde_json.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct JsonError {
    /// The message of serde_json.
    message: String,
    line: usize,
    column: usize,
}

impl fmt::Display for JsonError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at line {} column {}", self.message(), self.line, self.column)
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

    /// The message without the place, in words for those who do not know parsers where serde_json's are not.
    pub(crate) fn message(&self) -> &str {
        let explained = EXPLAINED.iter().find(|(message, _)| self.message.starts_with(message));
        explained.map_or(&self.message, |(_, explained)| explained)
    }
}

/// The beginnings of serde_json's messages, and what they mean.
const EXPLAINED: &[(&str, &str)] = &[
    ("EOF while parsing an object", "the text ends inside an object"),
    ("EOF while parsing a list", "the text ends inside an array"),
    ("EOF while parsing a string", "the text ends inside a string"),
    ("EOF while parsing a value", "the text ends before a value"),
    ("key must be a string", "expected the name of a member in double quotes, without a comma before a closing `}`"),
    ("trailing comma", "a comma before a closing `}` or `]`"),
    ("trailing characters", "there is more text after the end of the JSON"),
    (
        "expected value",
        "expected an object, an array, a string in double quotes, a number, true, false or null, without a comma before a closing `]`",
    ),
    ("expected ident", "expected true, false or null"),
    ("invalid number", "a number that is not as in JSON, such as 030, .5, 5. or +5"),
    ("control character", "a line break or another control character in a string, which must be escaped"),
    ("unexpected end of hex escape", "an incomplete character in a string: half of a surrogate pair, or fewer than four digits after \\u"),
    ("lone leading surrogate", "an incomplete character in a string: half of a surrogate pair"),
    ("invalid unicode code point", "a string that is not UTF-8"),
    ("recursion limit exceeded", "arrays and objects inside each other more than 127 deep"),
];

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
