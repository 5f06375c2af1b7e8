//! Measures batches of 100 000 contacts through the service's routes and middleware, compared with reading and writing
//! the same JSON without a computation, and the same contacts as columns with one column of the answer:
//! `cargo bench --bench batches [contacts]`. Writes `target/benches/batches.json`.
//!
//! The comparison reads the request into numbers with serde's derived code and writes the same columns from numbers, on
//! one core. Calls that are compared alternate in each round. Processor time is that of all threads of this process: the
//! service uses all cores and the comparison one, and other work on the machine makes processor time longer by less
//! than time.

use axum::Router;
use axum::body::{Body, Bytes};
use axum::http::{Request, header};
use http_body_util::BodyExt;
use scallopd::http::{self, AppState};
use scallopd::settings::Command;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::hint::black_box;
use std::time::{Duration, Instant};
use tower::ServiceExt;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const ROUNDS: usize = 5;
const LEAST_ROUND: Duration = Duration::from_millis(300);

/// Each calculation with its parameters and its result.
const CALCULATIONS: [(&str, &str, &str); 3] = [
    ("scallop-height", r#""step_over_mm": 0.687, "feed_per_tooth_mm": 0.3"#, "scallop_height_mm"),
    ("max-feed", r#""step_over_mm": 0.687, "scallop_tolerance_mm": 0.03"#, "feed_per_tooth_mm"),
    ("step-over", r#""scallop_tolerance_mm": 0.03, "feed_per_tooth_mm": 0.15"#, "step_over_mm"),
];

/// The columns of analytic answers that are written only if a request names them.
const BY_NAME_ONLY: [&str; 2] = ["envelope_scallop_height_mm", "deviation"];

/// The request of the comparison: the contacts only.
#[derive(Deserialize)]
struct Contacts {
    contacts: Vec<Contact>,
}

/// The same as columns.
#[derive(Deserialize)]
struct ContactsInColumns {
    contacts: ContactColumns,
}

#[derive(Deserialize)]
struct ContactColumns {
    slope_deg: Vec<f64>,
    feed_angle_deg: Vec<f64>,
}

#[derive(Deserialize)]
struct Contact {
    slope_deg: f64,
    feed_angle_deg: f64,
}

/// An answer's columns by their names.
#[derive(Serialize)]
struct Columns(std::collections::BTreeMap<String, Column>);

#[derive(Deserialize, Serialize)]
#[serde(untagged)]
enum Column {
    Numbers(Vec<Option<f64>>),
    Words(Vec<Option<String>>),
}

impl Columns {
    fn of(answer: &[u8]) -> Self {
        let answer: serde_json::Map<String, serde_json::Value> = serde_json::from_slice(answer).expect("an object");
        let columns = answer.into_iter().filter(|(name, _)| name != "failures" && name != "warnings");
        Self(columns.filter_map(|(name, column)| serde_json::from_value(column).ok().map(|column| (name, column))).collect())
    }
}

/// Contacts spread over slopes and directions, with as many digits as a CAM system writes.
fn request(contacts: u32, terms: &str, model: &str) -> Bytes {
    let mut json = format!(
        r#"{{"cutter": {{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4}}, {terms}, "model": "{model}", "contacts": ["#
    );
    for index in 0..contacts {
        let turn = f64::from(index) * 0.618_033_988_749;
        let (slope, feed) = (5.0 + 80.0 * turn.fract(), 360.0 * (turn * 7.0).fract());
        let separator = if index == 0 { "" } else { "," };
        let _ = write!(json, r#"{separator}{{"slope_deg":{slope:.6},"feed_angle_deg":{feed:.6}}}"#);
    }
    (json + "]}").into()
}

/// The same contacts as columns, answered with the column `named` only.
fn request_of_columns(contacts: u32, terms: &str, model: &str, named: &str) -> Bytes {
    let (mut slopes, mut feeds) = (String::new(), String::new());
    for index in 0..contacts {
        let turn = f64::from(index) * 0.618_033_988_749;
        let (slope, feed) = (5.0 + 80.0 * turn.fract(), 360.0 * (turn * 7.0).fract());
        let separator = if index == 0 { "" } else { "," };
        let _ = write!(slopes, "{separator}{slope:.6}");
        let _ = write!(feeds, "{separator}{feed:.6}");
    }
    let cutter = r#"{"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4}"#;
    format!(
        r#"{{"cutter": {cutter}, {terms}, "model": "{model}", "columns": ["{named}"], "contacts": {{"slope_deg": [{slopes}], "feed_angle_deg": [{feeds}]}}}}"#
    )
    .into()
}

/// Wall and processor time of one call, in s.
#[derive(Clone, Copy)]
struct Cost {
    wall: f64,
    cpu: f64,
}

impl Cost {
    fn of(mut run: impl FnMut()) -> Self {
        let (start, cpu) = (Instant::now(), cpu_s());
        let mut calls = 0.0;
        while start.elapsed() < LEAST_ROUND {
            run();
            calls += 1.0;
        }
        Self { wall: start.elapsed().as_secs_f64() / calls, cpu: (cpu_s() - cpu) / calls }
    }
}

/// Processor time of this process so far, in s.
#[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
fn cpu_s() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Medians over rounds, in each of which all calls are measured in turn.
fn medians<const N: usize>(mut calls: [&mut dyn FnMut(); N]) -> [Cost; N] {
    let rounds: Vec<[Cost; N]> = (0..ROUNDS).map(|_| std::array::from_fn(|call| Cost::of(&mut *calls[call]))).collect();
    std::array::from_fn(|call| Cost {
        wall: median(rounds.iter().map(|round| round[call].wall).collect()),
        cpu: median(rounds.iter().map(|round| round[call].cpu).collect()),
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

struct Bench {
    runtime: tokio::runtime::Runtime,
    app: Router,
}

impl Bench {
    fn new() -> Self {
        let Ok(Command::Serve(settings)) = Command::read(["scallopd"]) else { panic!("the defaults serve") };
        let state = AppState::start(&settings).expect("threads");
        let app = http::service(http::routes(), &settings, &state);
        Self { runtime: tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime"), app }
    }

    /// The answer, in the pieces in which it is sent.
    fn answer(&self, path: &str, body: &Bytes) -> Vec<Bytes> {
        let request = Request::post(path).header(header::HOST, "localhost").header(header::CONTENT_TYPE, "application/json");
        let request = request.body(Body::from(body.clone()));
        self.runtime.block_on(async {
            let response = self.app.clone().oneshot(request.expect("a request")).await.expect("an answer");
            assert!(response.status().is_success(), "{path}: {}", response.status());
            let (mut body, mut pieces) = (response.into_body(), Vec::new());
            while let Some(frame) = body.frame().await {
                pieces.extend(frame.expect("a body").into_data());
            }
            pieces
        })
    }

    /// The same rows, which ask for every column that the answer can have.
    fn every_column(&self, contacts: u32, path: &str, terms: &str, model: &str) -> Bytes {
        let Columns(unasked) = Columns::of(&self.answer(path, &request(1, terms, model)).concat());
        let by_name: &[&str] = if model == "analytic" { &BY_NAME_ONLY } else { &[] };
        let names: Vec<&str> = unasked.keys().map(String::as_str).chain(by_name.iter().copied()).collect();
        request(contacts, &format!("{terms}, \"columns\": {}", serde_json::json!(names)), model)
    }

    /// Columns with one column of the answer against rows with all columns, and with every one that can be asked for.
    fn columns(&self, contacts: u32, calculation: &str, terms: &str, named: &str, model: &'static str) -> ColumnsRow {
        let path = format!("/v1/{calculation}/batch");
        let (rows, columns) = (request(contacts, terms, model), request_of_columns(contacts, terms, model, named));
        let every = self.every_column(contacts, &path, terms, model);
        let answer = Columns::of(&self.answer(&path, &columns).concat());
        let [of_rows, of_every, of_columns, json] = medians([
            &mut || drop(black_box(self.answer(&path, &rows))),
            &mut || drop(black_box(self.answer(&path, &every))),
            &mut || drop(black_box(self.answer(&path, &columns))),
            &mut || {
                let read: ContactsInColumns = serde_json::from_slice(&columns).expect("JSON");
                black_box(read.contacts.slope_deg.iter().chain(&read.contacts.feed_angle_deg).sum::<f64>());
                black_box(serde_json::to_vec(&answer).expect("JSON"));
            },
        ]);
        ColumnsRow {
            calculation: calculation.to_owned(),
            model,
            rows_wall_ms: of_rows.wall * 1e3,
            columns_wall_ms: of_columns.wall * 1e3,
            wall_ratio: of_columns.wall / of_rows.wall,
            wall_ratio_to_every: of_columns.wall / of_every.wall,
            cpu_ratio: of_columns.cpu / of_rows.cpu,
            cpu_ratio_to_json: of_columns.cpu / json.cpu,
            ns_a_contact: of_columns.wall * 1e9 / f64::from(contacts),
            cpu_ns_a_contact: of_columns.cpu * 1e9 / f64::from(contacts),
        }
    }

    fn row(&self, contacts: u32, calculation: &str, terms: &str, model: &'static str) -> Row {
        let body = request(contacts, terms, model);
        let path = format!("/v1/{calculation}/batch");
        let answer = Bytes::from(self.answer(&path, &body).concat());
        let columns = Columns::of(&answer);
        let read_and_write = || {
            let read: Contacts = serde_json::from_slice(&body).expect("JSON");
            black_box(read.contacts.iter().map(|contact| contact.slope_deg + contact.feed_angle_deg).sum::<f64>());
            black_box(serde_json::to_vec(&columns).expect("JSON"));
        };
        let [ours, json] = medians([&mut || drop(black_box(self.answer(&path, &body))), &mut || read_and_write()]);
        Row {
            calculation: calculation.to_owned(),
            model,
            request_mb: megabytes(&body),
            answer_mb: megabytes(&answer),
            wall_ms: ours.wall * 1e3,
            cpu_ratio: ours.cpu / json.cpu,
            wall_ratio: ours.wall / json.wall,
            us_a_contact_and_core: ours.cpu * 1e6 / f64::from(contacts),
            cores_used: ours.cpu / ours.wall,
        }
    }
}

#[derive(Serialize)]
struct Row {
    calculation: String,
    model: &'static str,
    request_mb: f64,
    answer_mb: f64,
    wall_ms: f64,
    cpu_ratio: f64,
    wall_ratio: f64,
    us_a_contact_and_core: f64,
    cores_used: f64,
}

/// Columns with one column of the answer against rows with all columns.
#[derive(Serialize)]
struct ColumnsRow {
    calculation: String,
    model: &'static str,
    rows_wall_ms: f64,
    columns_wall_ms: f64,
    wall_ratio: f64,
    /// Against rows with every column that can be asked for.
    wall_ratio_to_every: f64,
    cpu_ratio: f64,
    /// Processor time against reading and writing the same JSON.
    cpu_ratio_to_json: f64,
    ns_a_contact: f64,
    cpu_ns_a_contact: f64,
}

#[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
fn megabytes(bytes: &Bytes) -> f64 {
    bytes.len() as f64 / 1e6
}

fn main() {
    let contacts = std::env::args().find_map(|argument| argument.parse().ok()).unwrap_or(100_000);
    let bench = Bench::new();
    println!("{contacts} contacts; ratios against reading and writing the same JSON");
    println!("calculation     model     MB in  MB out    ms  cpu ratio  wall ratio  us/contact, core  cores used");
    let mut rows = Vec::new();
    for model in ["analytic", "envelope"] {
        for (calculation, terms, _) in CALCULATIONS {
            let row = bench.row(contacts, calculation, terms, model);
            println!(
                "{calculation:15} {model:8} {:6.1} {:7.1} {:5.0} {:10.2} {:11.2} {:17.2} {:11.2}",
                row.request_mb, row.answer_mb, row.wall_ms, row.cpu_ratio, row.wall_ratio, row.us_a_contact_and_core, row.cores_used
            );
            rows.push(row);
        }
    }
    println!("\ncolumns with one column of the answer against rows with all columns");
    println!("calculation     model     rows ms  columns ms  wall ratio  to every one  cpu ratio  cpu/JSON  ns/contact  cpu ns/contact");
    let mut columns = Vec::new();
    for model in ["analytic", "envelope"] {
        for (calculation, terms, named) in CALCULATIONS {
            let row = bench.columns(contacts, calculation, terms, named, model);
            println!(
                "{calculation:15} {model:8} {:8.0} {:11.0} {:11.2} {:13.2} {:10.2} {:9.2} {:11.0} {:15.0}",
                row.rows_wall_ms,
                row.columns_wall_ms,
                row.wall_ratio,
                row.wall_ratio_to_every,
                row.cpu_ratio,
                row.cpu_ratio_to_json,
                row.ns_a_contact,
                row.cpu_ns_a_contact
            );
            columns.push(row);
        }
    }
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/target/benches");
    std::fs::create_dir_all(folder).expect("a folder");
    let figures = serde_json::json!({"rows": rows, "columns": columns});
    std::fs::write(format!("{folder}/batches.json"), serde_json::to_vec_pretty(&figures).expect("JSON")).expect("a file");
}
