//! NaN and Infinity in JSON texts. They are not JSON, but Python and other languages write them. In a text that cannot
//! be parsed, each is replaced by a string of the same length that the readers of numbers recognise, so that the fault
//! has its location and affects only one value, and so that all other places stay as they are.

/// The tokens and the JSON strings that replace them. A delete character distinguishes the strings from those of
/// callers. No token is the beginning of another.
const MARKS: [(&str, &str); 3] = [("NaN", "\"\u{7f}\""), ("Infinity", "\"\u{7f}finit\""), ("-Infinity", "\"\u{7f}nfinit\"")];

/// The token that the JSON value `value` replaced.
pub(crate) fn token(value: &str) -> Option<&'static str> {
    MARKS.iter().find(|(_, mark)| *mark == value).map(|(token, _)| *token)
}

/// The JSON value that replaces a token.
pub(crate) fn mark(token: &str) -> Option<&'static str> {
    MARKS.iter().find(|(known, _)| *known == token).map(|(_, mark)| *mark)
}

/// The text with the tokens outside strings replaced; `None` if there are none.
pub(crate) fn mark_not_finite(json: &[u8]) -> Option<Vec<u8>> {
    let (mut marked, mut in_string, mut at) = (None, false, 0);
    while let Some(byte) = json.get(at) {
        match byte {
            b'\\' if in_string => at += 1,
            b'"' => in_string = !in_string,
            b'N' | b'I' | b'-' if !in_string => {
                if let Some((token, mark)) = MARKS.iter().find(|(token, _)| json[at..].starts_with(token.as_bytes())) {
                    marked.get_or_insert_with(|| json.to_vec())[at..at + token.len()].copy_from_slice(mark.as_bytes());
                    at += token.len() - 1;
                }
            }
            _ => {}
        }
        at += 1;
    }
    marked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_marked_outside_strings_only() {
        let text = mark_not_finite(br#"{"NaN": [NaN, -Infinity, 1], "b": "a\"NaN", "c":Infinity}"#).unwrap();
        let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let [nan, negative, positive] = ["NaN", "-Infinity", "Infinity"].map(|token| {
            let mark = mark(token).unwrap();
            assert_eq!(mark.len(), token.len());
            assert_eq!(super::token(mark), Some(token));
            serde_json::from_str::<String>(mark).unwrap()
        });
        assert_eq!(value, serde_json::json!({"NaN": [nan, negative, 1], "b": "a\"NaN", "c": positive}));
        assert_eq!(token("\"NaN\""), None);
        assert_eq!(mark_not_finite(br#"{"a": "NaN", "b": -1"#), None);
    }
}
