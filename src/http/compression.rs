//! Compression of answers with gzip. Large answers are compressed by the worker that writes them (see
//! [`WrittenJson`](super::json_body::WrittenJson)), all others by the layer here, in short pieces of work: never on a thread
//! that serves connections, which could answer nobody meanwhile.

use std::io::Write;

use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use http_body_util::{BodyExt, Full};

use crate::worker_pool::WorkerPool;

/// Answers up to this size fit one packet: compressing them costs time and saves nothing.
const MIN_BYTES: u64 = 1024;

/// The number of bytes that are compressed between two checks whether the answer is still needed: a millisecond or two.
const CHUNK: usize = 64 * 1024;

/// The name of the coding.
pub(super) const GZIP: HeaderValue = HeaderValue::from_static("gzip");

/// Whether the client accepts gzip: it names `gzip` or `*` with a weight other than 0 (RFC 9110, section 12.5.3).
pub(super) fn accepts_gzip(headers: &HeaderMap) -> bool {
    let values = || headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    let weight_of = |name: &str| {
        values().flat_map(|value| value.split(',')).find_map(|item| {
            let (coding, parameters) = item.split_once(';').unwrap_or((item, "q=1"));
            let weight = parameters.trim().strip_prefix("q=").and_then(|weight| weight.parse::<f32>().ok());
            coding.trim().eq_ignore_ascii_case(name).then(|| weight.unwrap_or(0.0))
        })
    };
    weight_of("gzip").or_else(|| weight_of("*")).is_some_and(|weight| weight > 0.0)
}

/// Whether an answer of this size is compressed for clients that accept it.
pub(super) fn is_worthwhile(bytes: u64) -> bool {
    bytes > MIN_BYTES
}

/// An answer being compressed.
pub(super) struct Compressor(GzEncoder<Vec<u8>>);

impl Compressor {
    pub(super) fn new() -> Self {
        // Level 1 takes a third of the time of the default level, and its text of numbers is a tenth larger.
        Self(GzEncoder::new(Vec::new(), Compression::fast()))
    }

    /// Adds `bytes`; stops early once `is_cancelled`. Writing to memory does not fail.
    pub(super) fn add(&mut self, bytes: &[u8], is_cancelled: impl Fn() -> bool) {
        for chunk in bytes.chunks(CHUNK).take_while(|_| !is_cancelled()) {
            let _infallible = self.0.write_all(chunk);
        }
    }

    /// The compressed bytes that are ready.
    pub(super) fn take(&mut self) -> Vec<u8> {
        std::mem::take(self.0.get_mut())
    }

    /// The last compressed bytes.
    pub(super) fn finish(self) -> Vec<u8> {
        self.0.finish().unwrap_or_default()
    }
}

/// The layer: compresses answers of the media types for which that helps, unless they are compressed.
pub(super) async fn compress(State(workers): State<WorkerPool>, request: Request, next: Next) -> Response {
    let accepts = accepts_gzip(request.headers());
    let mut response = next.run(request).await;
    let is_whole = response.body().size_hint().exact().is_some_and(is_worthwhile);
    if !is_whole || !is_text(response.headers()) {
        return response;
    }
    response.headers_mut().append(header::VARY, HeaderValue::from_name(header::ACCEPT_ENCODING));
    if !accepts || response.headers().contains_key(header::CONTENT_ENCODING) {
        return response;
    }
    let (mut parts, body) = response.into_parts();
    // Bodies with a known length are in memory.
    let plain = match body.collect().await {
        Ok(plain) => plain.to_bytes(),
        Err(error) => {
            tracing::error!(%error, "an answer could not be read");
            return axum::http::StatusCode::INTERNAL_SERVER_ERROR.into_response();
        }
    };
    let body = compressed(&workers, plain).await;
    parts.headers.insert(header::CONTENT_ENCODING, GZIP);
    parts.headers.remove(header::CONTENT_LENGTH);
    parts.headers.remove(header::ACCEPT_RANGES);
    Response::from_parts(parts, Body::new(Full::new(body)))
}

/// `plain`, compressed in pieces of work. Dropping the future leaves out the pieces that follow.
async fn compressed(workers: &WorkerPool, mut plain: Bytes) -> Bytes {
    let mut compressor = Compressor::new();
    while !plain.is_empty() {
        let chunk = plain.split_to(plain.len().min(CHUNK));
        compressor = workers
            .run_piece(move |_| {
                compressor.add(&chunk, || false);
                compressor
            })
            .await;
    }
    compressor.finish().into()
}

/// Whether an answer is text: images and archives are compressed already.
fn is_text(headers: &HeaderMap) -> bool {
    let media_type = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let essence = media_type.split(';').next().unwrap_or_default().trim();
    essence.starts_with("text/") || ["json", "javascript", "xml", "openmetrics-text"].iter().any(|end| essence.ends_with(end))
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::GzDecoder;

    use super::*;

    #[test]
    fn weights_and_wildcards_of_codings_are_read() {
        let accepts =
            |value: &'static str| accepts_gzip(&HeaderMap::from_iter([(header::ACCEPT_ENCODING, HeaderValue::from_static(value))]));
        assert!(!accepts_gzip(&HeaderMap::new()));
        for value in ["gzip", "GZIP", "br, gzip", "gzip, deflate, br", "gzip;q=0.1", "gzip; q=1", "*", "br;q=1, *;q=0.5"] {
            assert!(accepts(value), "{value}");
        }
        for value in ["", "br", "identity", "gzip;q=0", "*;q=1, gzip;q=0", "gzip;q=x", "*;q=0"] {
            assert!(!accepts(value), "{value}");
        }
    }

    #[test]
    fn bytes_come_back_whole_and_a_cancelled_compression_stops() {
        let plain: Vec<u8> = (0..1_000_000_u32).flat_map(u32::to_le_bytes).collect();
        let mut compressor = Compressor::new();
        let mut file = Vec::new();
        for half in plain.chunks(plain.len() / 2) {
            compressor.add(half, || false);
            file.extend(compressor.take());
        }
        file.extend(compressor.finish());
        let mut back = Vec::new();
        GzDecoder::new(&file[..]).read_to_end(&mut back).unwrap();
        assert!(back == plain);

        let mut cancelled = Compressor::new();
        cancelled.add(&plain, || true);
        assert!(cancelled.finish().len() < 100);
    }

    #[tokio::test]
    async fn pieces_of_work_compress_a_body() {
        let plain = vec![b'7'; 300_000];
        let file = compressed(&WorkerPool::start(1).unwrap(), plain.clone().into()).await;
        let mut back = Vec::new();
        GzDecoder::new(&file[..]).read_to_end(&mut back).unwrap();
        assert!(back == plain);
    }
}
