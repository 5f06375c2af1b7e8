//! JSON texts. Their syntax is checked in steps, so that the check of a long text can be cancelled. Plain values and
//! arrays of numbers have fast readers, which need no check before or use all cores.

mod error;
pub(crate) mod not_finite;
mod number_array;
mod path;
mod plain;
mod scanner;
#[cfg(test)]
mod tests;
mod triples;

pub(crate) use error::JsonError;
pub(crate) use number_array::read_numbers;
pub(crate) use path::JsonPath;
pub(crate) use plain::{PlainJson, PlainValue, Unusual};
pub(crate) use triples::read_triples;

use memchr::memchr;
use scanner::Scanner;
use std::borrow::Cow;

/// The number of bytes between two checks for cancellation, which take at most some tenths of a millisecond.
const STEP: usize = 1 << 16;

/// The text of a JSON value whose syntax has been checked, without blanks around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct JsonText<'a>(&'a str);

/// The members of an object in the order sent, each with its name and its unparsed value.
#[derive(Debug)]
pub(crate) struct JsonMembers<'a> {
    /// The first members.
    pub(crate) kept: Vec<(Cow<'a, str>, JsonText<'a>)>,
    /// The number of members beyond those that are kept.
    pub(crate) unkept: usize,
}

/// A text, and its members if it is an object.
pub(crate) type CheckedObject<'a> = (JsonText<'a>, Result<JsonMembers<'a>, Unread>);

/// The reason why the items of an array or the members of an object were not all read.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Unread {
    /// The value is of another type.
    OtherType,
    /// The reading was cancelled; its result must be discarded.
    Cancelled,
    /// The name of a member cannot be decoded.
    Name(JsonError),
}

impl<'a> JsonText<'a> {
    /// Checks the syntax of a whole text. Once `stop` returns true, the check ends with an error that must be
    /// discarded.
    pub(crate) fn check(json: &'a [u8], stop: &dyn Fn() -> bool) -> Result<Self, JsonError> {
        let mut scanner = Scanner::new(json, stop);
        let value = scanner.value().map_err(|_| scanner.error())?;
        let first = scanner.position() - value.len();
        let text = std::str::from_utf8(value).map_err(|error| JsonError::not_utf_8(json, first + error.valid_up_to()))?;
        scanner.end().map_err(|_| scanner.error())?;
        Ok(Self(text))
    }

    /// Checks the syntax of a whole text, and returns its members too, as [`JsonText::members`], in the same pass.
    pub(crate) fn check_object(json: &'a [u8], most: usize, stop: &dyn Fn() -> bool) -> Result<CheckedObject<'a>, JsonError> {
        let mut scanner = Scanner::new(json, stop);
        let blanks = scanner.blanks();
        let is_object = blanks.is_ok() && scanner.next() == Some(b'{');
        let Some(text) = std::str::from_utf8(json).ok().filter(|_| is_object) else {
            return Self::check(json, stop).map(|text| (text, Err(Unread::OtherType)));
        };
        let first = scanner.position();
        let members = scanner.members(text, most).map_err(|_| scanner.error())?;
        let object = Self(&text[first..scanner.position()]);
        scanner.end().map_err(|_| scanner.error())?;
        Ok((object, members.map_err(|name| Unread::Name(object.name_error(&name)))))
    }

    /// The value at the beginning of `json`, after blanks. `None` if there is none, or once `stop` returns true.
    pub(crate) fn first(json: &'a [u8], stop: &dyn Fn() -> bool) -> Option<Self> {
        let value = Scanner::new(json, stop).value().ok()?;
        std::str::from_utf8(value).ok().map(Self)
    }

    /// A text that is known to be a JSON value without blanks around it.
    pub(crate) fn known(json: &'a str) -> Self {
        Self(json)
    }

    /// The text.
    pub(crate) fn get(self) -> &'a str {
        self.0
    }

    /// The members of an object, of which the first `most` are kept.
    pub(crate) fn members(self, most: usize, stop: &dyn Fn() -> bool) -> Result<JsonMembers<'a>, Unread> {
        if !self.0.starts_with('{') {
            return Err(Unread::OtherType);
        }
        // The syntax has been checked, so the scan can only be cancelled.
        let members = Scanner::new(self.0.as_bytes(), stop).members(self.0, most).map_err(|_| Unread::Cancelled)?;
        members.map_err(|name| Unread::Name(self.name_error(&name)))
    }

    /// Passes the items of an array to `take`, in order.
    pub(crate) fn items(self, stop: &dyn Fn() -> bool, mut take: impl FnMut(Self)) -> Result<(), Unread> {
        let mut scanner = Scanner::new(self.0.as_bytes(), stop);
        if !scanner.takes(b'[') {
            return Err(Unread::OtherType);
        }
        let mut until_check = ITEMS;
        while scanner.has_more_items().map_err(|_| Unread::Cancelled)? {
            take(self.part(scanner.value().map_err(|_| Unread::Cancelled)?));
            // What is done with an item may take longer than its scan.
            until_check -= 1;
            if until_check == 0 {
                until_check = ITEMS;
                if stop() {
                    return Err(Unread::Cancelled);
                }
            }
        }
        Ok(())
    }

    /// The content of a string; `None` for another value, for a string that cannot be decoded, or once `stop` returns
    /// true.
    pub(crate) fn string(self, stop: &dyn Fn() -> bool) -> Option<String> {
        let content = self.0.strip_prefix('"')?.strip_suffix('"')?;
        if content.len() <= STEP {
            return serde_json::from_str(self.0).ok();
        }
        let mut decoded = String::with_capacity(content.len());
        let mut rest = content;
        while !rest.is_empty() && !stop() {
            let (piece, after) = rest.split_at(end_of_piece(rest));
            decoded += &serde_json::from_str::<String>(&format!("\"{piece}\"")).ok()?;
            rest = after;
        }
        rest.is_empty().then_some(decoded)
    }

    /// The part of this text with these bytes, which are a value.
    fn part(self, value: &[u8]) -> Self {
        let first = value.as_ptr().addr() - self.0.as_ptr().addr();
        Self(&self.0[first..first + value.len()])
    }

    /// The error of a name in this text that cannot be decoded.
    fn name_error(self, name: &BadName<'_>) -> JsonError {
        let from = name.quoted.as_ptr().addr() - self.0.as_ptr().addr();
        JsonError::of(&name.error, name.quoted.as_bytes(), 0, self.0.as_bytes(), from)
    }
}

/// A name that cannot be decoded, with its quotation marks.
struct BadName<'a> {
    quoted: &'a str,
    error: serde_json::Error,
}

/// A member's name, given with its quotation marks. It is borrowed unless it is written with escapes.
fn decoded(quoted: &str) -> Result<Cow<'_, str>, BadName<'_>> {
    let name = &quoted[1..quoted.len() - 1];
    if memchr(b'\\', name.as_bytes()).is_none() {
        return Ok(Cow::Borrowed(name));
    }
    // The longest name that is read, and the longest part of another one that is shown, are much shorter.
    let decoded = if name.len() <= STEP {
        serde_json::from_str(quoted)
    } else {
        serde_json::from_str(&format!("\"{}\"", &name[..end_of_piece(name)]))
    };
    decoded.map(Cow::Owned).map_err(|error| BadName { quoted, error })
}

/// The number of items between two checks for cancellation.
const ITEMS: usize = 256;

/// The end of a piece of about [`STEP`] bytes of a string's content. No escape and no pair of surrogates is divided.
fn end_of_piece(content: &str) -> usize {
    let bytes = content.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let unit = if bytes[at] != b'\\' {
            1
        } else if bytes.get(at + 1) != Some(&b'u') {
            2
        } else if matches!(bytes.get(at + 2..at + 4), Some([b'd' | b'D', b'8'..=b'9' | b'a' | b'b' | b'A' | b'B'])) {
            12
        } else {
            6
        };
        at = bytes.len().min(at + unit);
        if at >= STEP && content.is_char_boundary(at) {
            return at;
        }
    }
    at
}
