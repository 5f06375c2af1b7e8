//! The table of all codes, `docs/codes.md`, checked against the enumerations.

use super::{Code, ConfidenceCode, Entry, FileFault, NoAnswerCode, NotRankedCode, RequestFault, ServiceProblem, WarningCode};
use axum::http::StatusCode;
use std::collections::BTreeSet;
use std::fmt::Write;

const INTRODUCTION: &str = "# Codes

Programs can rely on these names: they never change. Texts (`title`, `detail`) are for people and may change. The table is generated
from the enumerations in `src/http/codes`: `SCALLOPD_WRITE_DOCS=1 cargo test --lib codes::table` writes it.
";

/// The table of a family. `status` is that of problems with a code that has none of its own; `None` for a family without
/// problems.
fn table<C: Code>(heading: &str, about: &str, status: Option<&str>) -> String {
    let mut text = format!("\n## {heading}\n\n{about}\n\n");
    text += if status.is_some() {
        "| code | status | meaning | remedy |\n|---|---|---|---|\n"
    } else {
        "| code | meaning | remedy |\n|---|---|---|\n"
    };
    for code in C::ALL {
        let Entry { name, meaning, remedy, status: own } = code.entry();
        let status = status.map_or(String::new(), |status| format!(" {} |", own.as_ref().map_or(status, StatusCode::as_str)));
        let _ = writeln!(text, "| `{name}` |{status} {meaning} | {remedy} |");
    }
    text
}

fn all_tables() -> String {
    [
        INTRODUCTION.to_owned(),
        table::<ServiceProblem>("Problems", "The `type` of a problem (RFC 9457) that concerns a request as a whole.", Some("any")),
        table::<FileFault>(
            "Files",
            "Faults of an uploaded file: the `code` in `errors`, and the `type` of the problem if it is the only fault.",
            Some("any"),
        ),
        table::<NoAnswerCode>(
            "Reasons without an answer",
            "The `code` in `errors` or, in a batch, in `failures`; the `type` of the problem if it is the only fault.",
            Some("422"),
        ),
        table::<RequestFault>("Faults", "The `code` in `errors` of a problem, and in `failures` of a batch.", None),
        table::<WarningCode>("Warnings", "The `code` in `warnings` of an answer.", None),
        table::<NotRankedCode>(
            "Cutters that are not ranked",
            "The `code` in `not_ranked` of a recommendation, and of the problem `no-cutter-fits`.",
            None,
        ),
        table::<ConfidenceCode>("Confidence", "The `code` in `confidence.reasons` of a recommendation.", None),
    ]
    .concat()
}

#[test]
fn the_committed_table_lists_every_code() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/codes.md");
    if std::env::var_os("SCALLOPD_WRITE_DOCS").is_some() {
        std::fs::write(path, all_tables()).unwrap();
    }
    let committed = std::fs::read_to_string(path).unwrap();
    assert!(committed == all_tables(), "docs/codes.md is stale: SCALLOPD_WRITE_DOCS=1 cargo test --lib codes::table");
}

#[test]
fn every_name_is_in_kebab_case_and_stands_once_in_its_family() {
    for names in [
        RequestFault::names(),
        FileFault::names(),
        NoAnswerCode::names(),
        NotRankedCode::names(),
        ServiceProblem::names(),
        WarningCode::names(),
        ConfidenceCode::names(),
    ] {
        for name in &names {
            assert!(name.split('-').all(|word| !word.is_empty() && word.bytes().all(|letter| letter.is_ascii_lowercase())), "{name}");
        }
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{names:?}");
    }
}
