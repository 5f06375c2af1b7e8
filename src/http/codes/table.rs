//! The table of all codes, `docs/codes.md`, checked against the enumerations.

use super::{
    Code, CodeFamily, ConfidenceCode, Entry, FileFaultCode, NoAnswerCode, NotRankedCode, RequestFault, ServiceProblem, WarningCode,
};
use axum::http::StatusCode;
use std::collections::BTreeSet;
use std::fmt::Write;

const INTRODUCTION: &str = "# Codes

Programs can rely on these names: they never change. Texts (`title`, `detail`) are for people and may change. The table is generated
from the enumerations in `src/http/codes`: `SCALLOPD_WRITE_DOCS=1 cargo test --lib codes::table` writes it.
";

/// The table of a family, with a column of statuses if its codes are types of problems.
fn table<C: CodeFamily>(heading: &str, about: &str) -> String {
    let mut text = format!("\n## {heading}\n\n{about}\n\n");
    let has_statuses = C::ALL.iter().any(|code| code.entry().status.is_some());
    text += if has_statuses {
        "| code | status | meaning | remedy |\n|---|---|---|---|\n"
    } else {
        "| code | meaning | remedy |\n|---|---|---|\n"
    };
    for code in C::ALL {
        let Entry { name, meaning, remedy, status } = code.entry();
        let status = if has_statuses { format!(" {} |", status.as_ref().map_or("any", StatusCode::as_str)) } else { String::new() };
        let _ = writeln!(text, "| `{name}` |{status} {meaning} | {remedy} |");
    }
    text
}

fn all_tables() -> String {
    [
        INTRODUCTION.to_owned(),
        table::<ServiceProblem>("Problems", "The `type` of a problem (RFC 9457) that concerns a request as a whole."),
        table::<FileFaultCode>(
            "Files",
            "Faults of an uploaded file: the `code` in `errors`, and the `type` of the problem if it is the only fault.",
        ),
        table::<NoAnswerCode>(
            "Reasons without an answer",
            "The `code` in `errors` or, in a batch, in `failures`; the `type` of the problem if it is the only fault.",
        ),
        table::<RequestFault>("Faults", "The `code` in `errors` of a problem, and in `failures` of a batch."),
        table::<WarningCode>("Warnings", "The `code` in `warnings` of an answer."),
        table::<NotRankedCode>(
            "Cutters that are not ranked",
            "The `code` in `not_ranked` of a recommendation, and of the problem `no-cutter-fits`.",
        ),
        table::<ConfidenceCode>("Confidence", "The `code` in `confidence.reasons` of a recommendation."),
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
        FileFaultCode::names(),
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
