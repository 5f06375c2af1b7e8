//! Tests of the check against serde_json.

use super::*;
use proptest::prelude::*;
use serde_json::value::RawValue;
use std::cell::Cell;

const NEVER: &dyn Fn() -> bool = &|| false;

/// The outcome of serde_json, with the texts of members or items if there are any.
fn by_serde_json(json: &[u8]) -> Result<&str, JsonError> {
    serde_json::from_slice::<&RawValue>(json).map(RawValue::get).map_err(|error| JsonError::from(&error))
}

fn checked(json: &[u8]) -> Result<&str, JsonError> {
    JsonText::check(json, NEVER).map(JsonText::get)
}

#[test]
fn violations_have_the_texts_and_places_of_serde_json() {
    for json in [
        "",
        " ",
        "\n",
        "1",
        " [] ",
        "{}",
        "[1",
        "[1,",
        "[1,]",
        "[,1]",
        "[1 2]",
        "[",
        "[ ",
        "{",
        "{ ",
        "{,",
        "{1:2}",
        "{\"a\"",
        "{\"a\" ",
        "{\"a\" 1}",
        "{\"a\":",
        "{\"a\":}",
        "{\"a\":1",
        "{\"a\":1,",
        "{\"a\":1,}",
        "{\"a\":1 \"b\":2}",
        "{\"a\":1]",
        "[1}",
        "]",
        "}",
        "1 2",
        "[1] x",
        "tru",
        "truE",
        "t",
        "nul",
        "nulx",
        "falsf",
        "-",
        "-x",
        "01",
        "-01",
        "00",
        "1.",
        "1.x",
        "1e",
        "1e+",
        "1ex",
        "1.5e-",
        "[1.,2]",
        "\"",
        "\"a",
        "\"\\",
        "\"\\x\"",
        "\"\\u12\"",
        "\"\\u12G4\"",
        "\"\\uD800\"",
        "\"\n\"",
        "\"\\\n\"",
        "\"\u{1}\"",
        "[\n1,\n\n x]",
        "{\n\"a\":\n tru}",
        "[1,\n[2,\n{\"k\":[\n}]]]",
        "NaN",
        "[NaN]",
        "-Infinity",
        "\u{feff}{}",
        "/* */ 1",
        "'a'",
        "[1,\"\\u00",
        "[\"a\nb\"]",
    ] {
        assert_eq!(checked(json.as_bytes()), by_serde_json(json.as_bytes()), "{json:?}");
        let object = JsonText::check_object(json.as_bytes(), 3, NEVER);
        assert_eq!(object.map(|(text, _)| text.get()), checked(json.as_bytes()), "{json:?}");
    }
    for json in [&b"\"\xff\""[..], b" [1,\n\"\xc3\"]  ", b"[1,\"\xff\", x]", b"\"\xff\" x", b"\xff", b"[\xff]", b"[\"\xe4\"\n]x"] {
        assert_eq!(checked(json), by_serde_json(json), "{json:?}");
    }
}

/// Values of all kinds, with blanks.
fn value() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("true".to_owned()),
        Just("null".to_owned()),
        any::<f64>().prop_filter("finite", |number| number.is_finite()).prop_map(|number| format!("{number:e}")),
        any::<i32>().prop_map(|number| number.to_string()),
        any::<String>().prop_map(|text| serde_json::to_string(&text).unwrap()),
    ];
    leaf.prop_recursive(6, 40, 5, |inner| {
        let pair =
            (any::<String>(), inner.clone()).prop_map(|(name, value)| format!("{} : {value}", serde_json::to_string(&name).unwrap()));
        prop_oneof![
            proptest::collection::vec(inner, 0..5).prop_map(|items| format!("[ {}\n]", items.join("\n ,"))),
            proptest::collection::vec(pair, 0..5).prop_map(|members| format!("{{{}}}", members.join(","))),
        ]
    })
}

proptest! {
    #[test]
    fn texts_with_a_few_bytes_changed_are_refused_as_by_serde_json(
        text in value(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), prop_oneof![
            Just(None), Just(Some(b'"')), Just(Some(b',')), Just(Some(b']')), Just(Some(b'}')), Just(Some(b'{')), Just(Some(b'[')),
            Just(Some(b':')), Just(Some(b'\\')), Just(Some(b'\n')), Just(Some(b'0')), Just(Some(b'.')), Just(Some(b'e')), any::<u8>().prop_map(Some),
        ]), 0..3),
    ) {
        let mut json = text.into_bytes();
        for (index, change) in changes {
            let at = index.index(json.len().max(1));
            match change {
                None => json.truncate(at),
                Some(byte) if at < json.len() => json[at] = byte,
                Some(byte) => json.push(byte),
            }
        }
        prop_assert_eq!(checked(&json), by_serde_json(&json));
        let object = JsonText::check_object(&json, 3, NEVER).map(|(text, _)| text.get());
        prop_assert_eq!(object, by_serde_json(&json));
    }

    #[test]
    fn members_and_items_are_those_of_serde_json(text in value()) {
        let json = JsonText::check(text.as_bytes(), NEVER).unwrap();
        let mut items = Vec::new();
        match json.items(NEVER, |item| items.push(item.get())) {
            Ok(()) => {
                let known: Vec<&RawValue> = serde_json::from_str(&text).unwrap();
                prop_assert_eq!(items, known.into_iter().map(RawValue::get).collect::<Vec<_>>());
            }
            Err(ended) => {
                prop_assert_eq!(ended, Unread::OtherType);
                prop_assert!(!text.starts_with('['));
            }
        }
        match json.members(3, NEVER) {
            Ok(members) => {
                let count = serde_json::from_str::<std::collections::BTreeMap<String, &RawValue>>(&text).unwrap().len();
                prop_assert!(members.kept.len() + members.unkept >= count);
                prop_assert!(members.kept.len() <= 3);
                for (name, value) in members.kept {
                    let pair = format!("{{{}:{}}}", serde_json::to_string(&name).unwrap(), value.get());
                    prop_assert!(serde_json::from_str::<serde_json::Value>(&pair).is_ok());
                }
            }
            Err(ended) => {
                prop_assert_eq!(ended, Unread::OtherType);
                let is_object = text.starts_with('{');
                prop_assert!(!is_object);
            }
        }
    }
}

#[test]
fn the_check_of_every_kind_of_long_text_stops() {
    const LENGTH: usize = 1 << 21;
    let long = |unit: &str| unit.repeat(LENGTH / unit.len());
    let texts = [
        format!("[{}1]", long("1,")),
        format!("[{}[]]", long("[1.25,2.5e-3,3],")),
        format!("[{}{{}}]", long("{\"a\":\"b\"},")),
        format!("\"{}\"", long("a")),
        format!("\"{}\"", long("\\n")),
        format!("\"{}\"", long("\\u00e4")),
        format!("{{\"{}\":1}}", long("name")),
        format!("1{}", long("0")),
        format!("0.{}1", long("0")),
        format!("{}1", long(" \n")),
        format!("1{}", long(" \n")),
        format!("{}{}", long("["), long("]")),
    ];
    for text in texts {
        let calls = Cell::new(0);
        let stop = || {
            calls.set(calls.get() + 1);
            calls.get() > 5
        };
        let shown = &text[..20];
        assert_eq!(JsonText::check(text.as_bytes(), &stop).unwrap_err().message(), "cancelled", "{shown}");
        assert_eq!(calls.get(), 6, "{shown}");
        calls.set(0);
        assert!(
            JsonText::check(text.as_bytes(), &|| {
                calls.set(calls.get() + 1);
                false
            })
            .is_ok(),
            "{shown}"
        );
        // A check for at most some hundred kB, so that none takes more than a millisecond.
        assert!(calls.get() >= text.len() / (4 * STEP), "{shown}: {} calls", calls.get());
    }
    let long_item = format!("[{}]", format_args!("[{}1]", long("1,")));
    let value = JsonText::check(long_item.as_bytes(), NEVER).unwrap();
    assert_eq!(value.items(&|| true, |_| ()), Err(Unread::Cancelled));
    let member = format!("{{\"a\":{long_item}}}");
    let value = JsonText::check(member.as_bytes(), NEVER).unwrap();
    assert_eq!(value.members(5, &|| true).unwrap_err(), Unread::Cancelled);
    let escaped = format!("\"{}\"", long("\\n"));
    assert_eq!(JsonText::known(&escaped).string(&|| true), None);
}

#[test]
fn long_strings_are_decoded_in_pieces() {
    for unit in ["a", "\\n", "ä", "\\u00e4", "\\ud83d\\ude00", "a\\\\", "\u{1f600}x\\\""] {
        let text = format!("\"x{}\"", unit.repeat(50_000));
        assert_eq!(JsonText::known(&text).string(NEVER), serde_json::from_str(&text).ok(), "{unit}");
        let name = format!("{{{text}:1}}");
        let members = JsonText::known(&name).members(5, NEVER).unwrap();
        let known: String = serde_json::from_str(&text).unwrap();
        assert_eq!(members.kept[0].0.chars().take(1000).collect::<String>(), known.chars().take(1000).collect::<String>());
    }
    assert_eq!(JsonText::known(&format!("\"{}\\ud800\"", "a".repeat(100_000))).string(NEVER), None);
}

#[test]
fn a_name_that_cannot_be_decoded_has_the_place_of_serde_json() {
    let text = "{\n\"a\": 1, \"\\ud800\": 2}";
    let error = serde_json::from_str::<std::collections::BTreeMap<String, &RawValue>>(text).unwrap_err();
    let found = JsonText::check(text.as_bytes(), NEVER).unwrap().members(5, NEVER).unwrap_err();
    let Unread::Name(found) = found else { panic!("{found:?}") };
    assert_eq!(found, JsonError::from(&error));
}

#[test]
fn errors_are_in_plain_words() {
    for (json, expected) in [
        ("{\"a\":1,}", "expected the name of a member in double quotes, without a comma before a closing `}` at line 1 column 8"),
        ("{\"a\":1", "the text ends inside an object at line 1 column 6"),
        ("[nan]", "expected true, false or null at line 1 column 3"),
        ("{} x", "there is more text after the end of the JSON at line 1 column 4"),
        ("030", "a number that is not as in JSON, such as 030, .5, 5. or +5 at line 1 column 2"),
        ("[1 2]", "expected `,` or `]` at line 1 column 4"),
    ] {
        assert_eq!(checked(json.as_bytes()).unwrap_err().to_string(), expected);
    }
}
