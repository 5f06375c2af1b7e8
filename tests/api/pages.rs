//! The examples of README.md, docs/tour.md and docs/papers.md: each `curl` command gives the JSON that follows it.
//!
//! After an intended change, `docs/renew-examples` updates the answers.

use crate::app::TestApp;
use reqwest::multipart::{Form, Part};
use serde_json::Value;

const PAGES: [&str; 3] = [include_str!("../../README.md"), include_str!("../../docs/tour.md"), include_str!("../../docs/papers.md")];
const BASE: &str = "http://127.0.0.1:8080";

/// A command and the answer that a page shows for it.
struct Example<'a> {
    command: &'a str,
    answer: Value,
}

fn examples(page: &'static str) -> Vec<Example<'static>> {
    let mut blocks = page.split("```").skip(1).step_by(2).filter_map(|block| block.split_once('\n')).peekable();
    let mut examples = Vec::new();
    while let Some((language, text)) = blocks.next() {
        if language != "sh" || !text.starts_with("curl") {
            continue;
        }
        let answer = blocks.next_if(|(language, _)| *language == "json").unwrap_or_else(|| panic!("no answer follows {text}"));
        examples.push(Example { command: text, answer: serde_json::from_str(answer.1).unwrap() });
    }
    examples
}

/// The arguments of `flag` in a command: texts in quotation marks, or up to the next blank.
fn arguments<'a>(command: &'a str, flag: &str) -> Vec<&'a str> {
    let values = command.match_indices(flag).map(|(at, _)| command[at + flag.len()..].trim_start());
    values
        .map(|rest| rest.strip_prefix('\'').map_or_else(|| rest.split_whitespace().next(), |rest| rest.split('\'').next()).unwrap())
        .collect()
}

fn file(name: &str) -> Vec<u8> {
    std::fs::read(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

async fn run(app: &TestApp, command: &str) -> Value {
    let path = command.split(BASE).nth(1).unwrap().split_whitespace().next().unwrap().trim_end_matches('\'');
    let request = app.client.post(app.url(path));
    let request = if let Some(body) = arguments(command, " -d").first() {
        let body = body.strip_prefix('@').map_or_else(|| body.as_bytes().to_vec(), file);
        request.header("content-type", "application/json").body(body)
    } else {
        let parts = arguments(command, " -F");
        if parts.is_empty() {
            app.client.get(app.url(path))
        } else {
            let form = parts.iter().map(|part| part.split_once('=').unwrap()).fold(Form::new(), |form, (name, value)| {
                let part = match value.strip_prefix('@') {
                    Some(path) => Part::bytes(file(path)).file_name(path.to_owned()),
                    None => Part::text(value.to_owned()),
                };
                form.part(name.to_owned(), part)
            });
            request.multipart(form)
        }
    };
    let answer = request.send().await.unwrap().json().await.unwrap();
    selected(command, answer)
}

/// The members of `answer` that a command selects with `| jq '{name, ...}'`, those of one of its members that it selects with
/// `| jq '.member | {name, ...}'`, or the whole answer.
fn selected(command: &str, answer: Value) -> Value {
    let Some((_, filter)) = command.split_once("| jq '") else { return answer };
    let (member, names) = filter.split_once('{').unwrap();
    let of = member.trim().strip_prefix('.').map_or(&answer, |member| &answer[member.trim_end_matches([' ', '|'])]);
    let names = names.split_once("}'").unwrap().0.split(',').map(str::trim);
    names.map(|name| (name.to_owned(), of[name].clone())).collect()
}

/// Whether `found` is the answer shown, whose numbers are rounded to six digits.
fn is_shown(shown: &Value, found: &Value) -> bool {
    match (shown, found) {
        (Value::Number(shown), Value::Number(found)) => {
            let (shown, found) = (shown.as_f64().unwrap(), found.as_f64().unwrap());
            // Half of the sixth digit is at most 5e-6 of the number.
            (shown - found).abs() <= 5.001e-6 * found.abs()
        }
        (Value::Array(shown), Value::Array(found)) => shown.len() == found.len() && shown.iter().zip(found).all(|(a, b)| is_shown(a, b)),
        (Value::Object(shown), Value::Object(found)) => {
            let found: Vec<_> = found.iter().filter(|(name, _)| *name != "request_id").collect();
            shown.len() == found.len() && found.iter().all(|(name, value)| shown.get(*name).is_some_and(|shown| is_shown(shown, value)))
        }
        (shown, found) => shown == found,
    }
}

#[tokio::test]
async fn every_command_gives_the_answer_shown_below_it() {
    let app = TestApp::start().await;
    let examples: Vec<_> = PAGES.into_iter().flat_map(examples).collect();
    for Example { command, answer } in &examples {
        let found = run(&app, command).await;
        assert!(is_shown(answer, &found), "{command}\nshown: {answer:#}\nfound: {found:#}");
    }
    let document: Value = serde_json::from_str(&scallopd::http::openapi_json()).unwrap();
    let posts = document["paths"].as_object().unwrap().iter().filter(|(_, operations)| operations.get("post").is_some());
    for (path, _) in posts {
        let command = format!("{BASE}{path} ");
        assert!(examples.iter().any(|example| example.command.contains(&command)), "no page shows how to call {path}");
    }
}
