//! NaN and Infinity in JSON texts. They are not JSON, but Python and other languages write them. A text that cannot be
//! parsed is scanned for them, and each is replaced by a string that readers of numbers recognize, so that the fault
//! has a location and affects only one value.

use crate::cancellation::CancelFlag;
use crate::memory_budget::{BudgetExceeded, MemoryBudget, Reserved};

/// The tokens and the JSON strings that replace them. A control character distinguishes the strings from those of
/// callers.
const MARKS: [(&str, &str); 3] = [("NaN", r#""\u0000NaN""#), ("-Infinity", r#""\u0000-Infinity""#), ("Infinity", r#""\u0000Infinity""#)];

/// The token that the JSON value `value` replaced.
pub(crate) fn token(value: &str) -> Option<&'static str> {
    MARKS.iter().find(|(_, mark)| *mark == value).map(|(token, _)| *token)
}

/// The JSON value that replaces a token.
pub(crate) fn mark(token: &str) -> Option<&'static str> {
    MARKS.iter().find(|(known, _)| *known == token).map(|(_, mark)| *mark)
}

/// Replaces the tokens outside strings; `None` if there are none. A cancelled scan ends early, and its result is
/// discarded.
pub(crate) fn mark_not_finite(
    json: &[u8],
    budget: &MemoryBudget,
    cancel: &CancelFlag,
) -> Result<Option<Reserved<Vec<u8>>>, BudgetExceeded> {
    let growth: usize = Tokens::new(json, cancel).map(|(_, token, mark)| mark.len() - token.len()).sum();
    if growth == 0 {
        return Ok(None);
    }
    let length = json.len() + growth;
    let reservation = budget.reserve(length as u64)?;
    let (mut text, mut copied) = (Vec::with_capacity(length), 0);
    for (at, token, mark) in Tokens::new(json, cancel) {
        text.extend_from_slice(&json[copied..at]);
        text.extend_from_slice(mark.as_bytes());
        copied = at + token.len();
    }
    text.extend_from_slice(&json[copied..]);
    Ok(Some(Reserved { bytes: text, reservation }))
}

/// An iterator over the tokens outside strings, each with its position and its mark. It ends when the scan is
/// cancelled.
struct Tokens<'a> {
    json: &'a [u8],
    cancel: &'a CancelFlag,
    at: usize,
    in_string: bool,
    next_check: usize,
}

impl<'a> Tokens<'a> {
    /// The number of bytes between two checks of the flag, which take some tenths of a millisecond.
    const TURN: usize = 1 << 18;

    fn new(json: &'a [u8], cancel: &'a CancelFlag) -> Self {
        Self { json, cancel, at: 0, in_string: false, next_check: 0 }
    }
}

impl Iterator for Tokens<'_> {
    type Item = (usize, &'static str, &'static str);

    fn next(&mut self) -> Option<Self::Item> {
        while let Some(byte) = self.json.get(self.at) {
            if self.at >= self.next_check {
                if self.cancel.is_cancelled() {
                    return None;
                }
                self.next_check = self.at + Self::TURN;
            }
            match byte {
                b'\\' if self.in_string => self.at += 1,
                b'"' => self.in_string = !self.in_string,
                b'N' | b'I' | b'-' if !self.in_string => {
                    let rest = &self.json[self.at..];
                    if let Some(&(token, mark)) = MARKS.iter().find(|(token, _)| rest.starts_with(token.as_bytes())) {
                        let at = self.at;
                        self.at += token.len();
                        return Some((at, token, mark));
                    }
                }
                _ => {}
            }
            self.at += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marked(json: &[u8]) -> Option<Reserved<Vec<u8>>> {
        mark_not_finite(json, &MemoryBudget::new(1000), &CancelFlag::default()).unwrap()
    }

    #[test]
    fn tokens_are_marked_outside_strings_only() {
        let text = marked(br#"{"NaN": [NaN, -Infinity, 1], "b": "a\"NaN", "c":Infinity}"#).unwrap();
        let value: serde_json::Value = serde_json::from_slice(text.as_ref()).unwrap();
        assert_eq!(value, serde_json::json!({"NaN": ["\0NaN", "\0-Infinity", 1], "b": "a\"NaN", "c": "\0Infinity"}));
        assert_eq!(token(r#""\u0000-Infinity""#), Some("-Infinity"));
        assert_eq!(token("\"NaN\""), None);
        assert!(marked(br#"{"a": "NaN", "b": -1"#).is_none());
    }

    #[test]
    fn the_copy_is_reserved_as_long_as_it_is_held() {
        let (budget, cancel) = (MemoryBudget::new(100), CancelFlag::default());
        // 9 bytes, of which 3 become 11.
        let held = mark_not_finite(br#"{"a":NaN}"#, &budget, &cancel).unwrap();
        assert_eq!(budget.reserved(), 17);
        drop(held);
        assert_eq!(budget.reserved(), 0);
        let flood = format!("[{}]", "NaN,".repeat(10));
        assert_eq!(mark_not_finite(flood.as_bytes(), &budget, &cancel).map(|_| ()), Err(BudgetExceeded::Always));
    }

    #[test]
    fn a_cancelled_scan_ends() {
        let cancel = CancelFlag::default();
        cancel.cancel();
        assert!(mark_not_finite(b"[NaN]", &MemoryBudget::new(100), &cancel).unwrap().is_none());
    }
}
