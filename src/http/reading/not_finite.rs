//! NaN and Infinity in requests, as Python and others write them. They are not JSON; a body that cannot be parsed is scanned for
//! them, and each is replaced by a string that the readers of numbers recognize, so that its fault has a location and concerns
//! one contact only.

/// The tokens and the JSON strings that replace them. A control character distinguishes them from texts of callers.
const MARKS: [(&str, &str); 3] = [("NaN", r#""\u0000NaN""#), ("-Infinity", r#""\u0000-Infinity""#), ("Infinity", r#""\u0000Infinity""#)];

/// The token that the JSON value `value` replaced.
pub(super) fn token(value: &str) -> Option<&'static str> {
    MARKS.iter().find(|(_, mark)| *mark == value).map(|(token, _)| *token)
}

/// `json` with its tokens outside strings replaced; `None` where there are none.
pub(crate) fn mark_not_finite(json: &[u8]) -> Option<Vec<u8>> {
    let (mut marked, mut copied, mut at) = (Vec::new(), 0, 0);
    let mut in_string = false;
    while let Some(byte) = json.get(at) {
        match byte {
            b'\\' if in_string => at += 1,
            b'"' => in_string = !in_string,
            b'N' | b'I' | b'-' if !in_string => {
                if let Some((token, mark)) = MARKS.iter().find(|(token, _)| json[at..].starts_with(token.as_bytes())) {
                    marked.extend_from_slice(&json[copied..at]);
                    marked.extend_from_slice(mark.as_bytes());
                    at += token.len();
                    copied = at;
                    continue;
                }
            }
            _ => {}
        }
        at += 1;
    }
    if copied == 0 {
        return None;
    }
    marked.extend_from_slice(&json[copied..]);
    Some(marked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_marked_outside_strings_only() {
        let marked = mark_not_finite(br#"{"NaN": [NaN, -Infinity, 1], "b": "a\"NaN", "c":Infinity}"#).unwrap();
        let value: serde_json::Value = serde_json::from_slice(&marked).unwrap();
        assert_eq!(value, serde_json::json!({"NaN": ["\0NaN", "\0-Infinity", 1], "b": "a\"NaN", "c": "\0Infinity"}));
        assert_eq!(token(r#""\u0000-Infinity""#), Some("-Infinity"));
        assert_eq!(token("\"NaN\""), None);
        assert_eq!(mark_not_finite(br#"{"a": "NaN", "b": -1"#), None);
    }
}
