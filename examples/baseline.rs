//! Two servers to which `benches/requests` compares the service. Both use the service's allocator and runtime and the
//! framework's accept loop, without time-outs, limits, logs or metrics.
//!
//! `baseline LENGTH` is the least work for a JSON service on this framework: it reads the body of every POST of `/` and
//! answers with LENGTH bytes. `baseline job` does only the job of `/v1/scallop-height`: it reads the body by serde's
//! derived code, calls the library, and writes the answer by serde's derived code. Each listens on a free port of
//! 127.0.0.1 and prints its address.

use axum::body::Bytes;
use axum::http::{StatusCode, header};
use axum::routing::post;
use axum::serve::ListenerExt;
use axum::{Json, Router};
use scallopd::milling::{Contact, Cutter, Envelope, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::Length;
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::io::Write;
use std::num::NonZeroU32;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const JSON: [(header::HeaderName, &str); 1] = [(header::CONTENT_TYPE, "application/json")];
/// The deviation below which the service warns.
const OUTSIDE_RANGE: f64 = -0.05;

fn main() -> Result<(), Box<dyn Error>> {
    let what = std::env::args().nth(1).ok_or("the answer's length is missing, or the word job")?;
    let app = if what == "job" { Router::new().route("/v1/scallop-height", post(scallop_height)) } else { constant(what.parse()?) };
    Ok(tokio::runtime::Builder::new_multi_thread().enable_all().build()?.block_on(serve(app))?)
}

fn constant(length: usize) -> Router {
    let answer = Bytes::from(vec![b'0'; length]);
    let read = async move |body: Bytes| {
        std::hint::black_box(body);
        (JSON, answer)
    };
    Router::new().route("/", post(read))
}

async fn serve(app: Router) -> std::io::Result<()> {
    let listener = tokio::net::TcpListener::bind(("127.0.0.1", 0)).await?;
    let address = listener.local_addr()?;
    writeln!(std::io::stdout(), "listening on {address}")?;
    let listener = listener.tap_io(|stream| _ = stream.set_nodelay(true));
    axum::serve(listener, app).await
}

#[derive(Deserialize)]
struct Request {
    cutter: ToroidalCutter,
    contact: Angles,
    step_over_mm: f64,
    feed_per_tooth_mm: f64,
}

#[derive(Deserialize)]
struct ToroidalCutter {
    #[serde(rename = "type")]
    shape: Shape,
    diameter_mm: f64,
    corner_radius_mm: f64,
    teeth: Option<NonZeroU32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Shape {
    Toroidal,
}

#[derive(Deserialize)]
struct Angles {
    slope_deg: f64,
    feed_angle_deg: f64,
}

#[derive(Serialize)]
struct Answer {
    model: &'static str,
    scallop_height_mm: f64,
    step_over_height_mm: f64,
    feed_height_mm: f64,
    feed_share: Option<f64>,
    effective_radius_mm: Option<f64>,
    transverse_effective_radius_mm: Option<f64>,
    step_over_mm: f64,
    step_over_xy_mm: f64,
    check: Check,
    warnings: Vec<Warning>,
}

#[derive(Serialize)]
struct Check {
    envelope_scallop_height_mm: f64,
    deviation: f64,
}

#[derive(Serialize)]
struct Warning {
    code: &'static str,
    detail: String,
}

async fn scallop_height(Json(request): Json<Request>) -> Result<Json<Answer>, StatusCode> {
    read(&request).and_then(|pass| compute(&request, pass)).map(Json).map_err(|_| StatusCode::UNPROCESSABLE_ENTITY)
}

fn read(request: &Request) -> Result<Pass, Box<dyn Error>> {
    let ToroidalCutter { shape: Shape::Toroidal, diameter_mm, corner_radius_mm, teeth } = request.cutter;
    Ok(Pass {
        cutter: Cutter::toroidal(Length::from_mm(diameter_mm)?, Length::from_mm(corner_radius_mm)?)?,
        contact: Contact::from_degrees(request.contact.slope_deg, request.contact.feed_angle_deg)?,
        surface: SurfaceCurvature::PLANE,
        runout: Runout::NONE,
        teeth,
    })
}

fn compute(request: &Request, pass: Pass) -> Result<Answer, Box<dyn Error>> {
    let (step_over, feed) = (Length::from_mm(request.step_over_mm)?, Some(Length::from_mm(request.feed_per_tooth_mm)?));
    let evaluated = EvaluatedPass::new(Model::Analytic, pass)?;
    let height = evaluated.scallop_height(step_over, feed)?;
    let envelope = Envelope::new(pass)?.scallop_height(step_over, feed)?.total().mm();
    let deviation = height.total().mm() / envelope - 1.0;
    let detail = || format!("the analytic height is {:.1} % under the {envelope:.6} mm of the cutter's exact shape", -deviation * 100.0);
    let warning = (deviation < OUTSIDE_RANGE).then(|| Warning { code: "outside-analytic-range", detail: detail() });
    Ok(Answer {
        model: "analytic",
        scallop_height_mm: height.total().mm(),
        step_over_height_mm: height.step_over.mm(),
        feed_height_mm: height.feed.mm(),
        feed_share: height.feed_share(),
        effective_radius_mm: evaluated.effective_radius().map(Length::mm),
        transverse_effective_radius_mm: evaluated.transverse_effective_radius().map(Length::mm),
        step_over_mm: step_over.mm(),
        step_over_xy_mm: step_over.mm() * pass.contact.spacing_ratio(),
        check: Check { envelope_scallop_height_mm: envelope, deviation },
        warnings: warning.into_iter().collect(),
    })
}
