//! The lower bound of an upload's cost: a server with the service's middleware and settings, whose routes for surfaces
//! read and discard the body. `benches/uploads` compares the cost of reading a surface with it.
//!
//! It has the program's settings and logs its address in the same way.

use axum::body::Bytes;
use axum::extract::Request;
use axum::http::header;
use axum::routing::post;
use http_body_util::BodyExt;
use scallopd::http::{self, AppState, RouteClass, Routes};
use scallopd::server::{self, App};
use scallopd::settings::{Command, Settings};
use scallopd::telemetry::Telemetry;
use std::hint::black_box;
use std::io::{Error, Result};

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const JSON: [(header::HeaderName, &str); 1] = [(header::CONTENT_TYPE, "application/json")];

fn main() -> Result<()> {
    let Ok(Command::Serve(settings)) = Command::read(std::env::args_os()) else {
        return Err(Error::other("the arguments are not settings of scallopd"));
    };
    tokio::runtime::Builder::new_multi_thread().enable_all().build()?.block_on(serve(&settings))
}

async fn serve(settings: &Settings) -> Result<()> {
    let telemetry = Telemetry::start(settings)?;
    let state = AppState::start(settings)?;
    let routes = Routes::new().undocumented(RouteClass::Upload, "/v1/cutter-recommendation/upload", post(drain)).undocumented(
        RouteClass::Batch,
        "/v1/cutter-recommendation",
        post(drain),
    );
    let app = App { router: http::service(routes, settings, &state), refuse: http::refusals(&state) };
    let listener = tokio::net::TcpListener::bind(settings.listen).await?;
    // Lines of other programs than scallopd are filtered out.
    tracing::info!(target: "scallopd", address = %listener.local_addr()?, "listening");
    let signal = server::stop_signal()?;
    server::serve(listener, app, settings, async { _ = signal.await }).await.cut().await;
    telemetry.stop();
    Ok(())
}

/// Reads and discards every frame of the body, and answers with the number of bytes.
async fn drain(request: Request) -> ([(header::HeaderName, &'static str); 1], String) {
    let mut body = request.into_body();
    let mut bytes = 0;
    while let Some(Ok(frame)) = body.frame().await {
        bytes += black_box(frame).data_ref().map_or(0, Bytes::len);
    }
    (JSON, format!("{{\"bytes\":{bytes}}}"))
}
