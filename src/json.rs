//! What the readers of JSON share: errors of serde_json in plain words, and arrays that are read item by item.

use serde::Deserialize;
use serde::de::{Deserializer, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::fmt;
use std::marker::PhantomData;

/// The reason why a text is not JSON, or not the expected JSON, with its place.
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
        let mut message = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        message.truncate(message.strip_suffix(&place).unwrap_or(&message).len());
        Self { message, line: error.line(), column: error.column() }
    }
}

/// Passes every item of the array `raw` to `take`, in order, so that the array is not stored.
///
/// # Errors
/// The value is not an array, or an item is not a `T`. `take` may have been called before.
pub(crate) fn each<'a, T: Deserialize<'a>>(raw: &'a RawValue, take: impl FnMut(T)) -> Result<(), serde_json::Error> {
    raw.deserialize_seq(Each { take, items: PhantomData })
}

struct Each<T, F> {
    take: F,
    items: PhantomData<T>,
}

impl<'de, T: Deserialize<'de>, F: FnMut(T)> Visitor<'de> for Each<T, F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut items: A) -> Result<(), A::Error> {
        while let Some(item) = items.next_element()? {
            (self.take)(item);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IgnoredAny;

    #[test]
    fn every_violation_is_explained_at_its_place() {
        for (text, message) in [
            (
                "[1,\n\n2,]",
                "expected an object, an array, a string in double quotes, a number, true, false or null, without a comma before a closing `]` at line 3 column 3",
            ),
            ("{\"a\":1,}", "expected the name of a member in double quotes, without a comma before a closing `}` at line 1 column 8"),
            ("{1:2}", "expected the name of a member in double quotes, without a comma before a closing `}` at line 1 column 2"),
            ("[1", "the text ends inside an array at line 1 column 2"),
            ("{", "the text ends inside an object at line 1 column 1"),
            ("\"a", "the text ends inside a string at line 1 column 2"),
            ("", "the text ends before a value at line 1 column 0"),
            ("1 2", "there is more text after the end of the JSON at line 1 column 3"),
            ("nul", "the text ends before a value at line 1 column 3"),
            ("nulx", "expected true, false or null at line 1 column 4"),
            ("01", "a number that is not as in JSON, such as 030, .5, 5. or +5 at line 1 column 2"),
        ] {
            let error = serde_json::from_str::<IgnoredAny>(text).unwrap_err();
            assert_eq!(JsonError::from(&error).to_string(), message, "{text}");
        }
    }
}
