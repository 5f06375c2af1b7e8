//! The least that a JSON service on this framework can do: one route that reads a body and answers a constant. What scallopd's own
//! layers and calculations cost is measured against it by `benches/requests`.
//!
//! `baseline LENGTH` listens on a free port of 127.0.0.1, prints its address, and answers every POST of `/` with LENGTH bytes, once the
//! whole body is in memory. It has the program's allocator and runtime, and the framework's own accept loop: time-outs and the like are
//! part of what is measured.

use axum::Router;
use axum::body::Bytes;
use axum::http::header;
use axum::routing::post;
use axum::serve::ListenerExt;
use std::io::{Error, Write};

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const JSON: [(header::HeaderName, &str); 1] = [(header::CONTENT_TYPE, "application/json")];

fn main() -> std::io::Result<()> {
    let length = std::env::args().nth(1).and_then(|length| length.parse().ok());
    let length = length.ok_or_else(|| Error::other("the answer's length is missing"))?;
    tokio::runtime::Builder::new_multi_thread().enable_all().build()?.block_on(serve(length))
}

async fn serve(length: usize) -> std::io::Result<()> {
    let answer = Bytes::from(vec![b'0'; length]);
    let read = async move |body: Bytes| {
        std::hint::black_box(body);
        (JSON, answer)
    };
    let app = Router::new().route("/", post(read));
    let listener = tokio::net::TcpListener::bind(("127.0.0.1", 0)).await?;
    let address = listener.local_addr()?;
    writeln!(std::io::stdout(), "listening on {address}")?;
    let listener = listener.tap_io(|stream| _ = stream.set_nodelay(true));
    axum::serve(listener, app).await
}
