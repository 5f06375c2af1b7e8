//! The way of a request's body into the server: how slowly it may come (`pace`), how large it may be once decompressed (`bound`), and
//! how long the answer may take after it. A body that breaks a rule ends with an error, and the answer is the rule's problem
//! whatever the handler made of that error.

mod bound;
mod fault;
mod pace;
mod reception;

use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use tokio::time::{Instant, timeout_at};

use super::weight::Weight;
use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;
use crate::settings::HttpSettings;
use fault::BodyFault;
use reception::Reception;

/// The rules, from the settings.
#[derive(Debug)]
pub(super) struct Limits {
    single: u64,
    json: u64,
    upload: u64,
    request_timeout: Duration,
    pace: pace::Pace,
}

impl Limits {
    pub(super) fn new(settings: &HttpSettings) -> Self {
        Self {
            single: settings.max_json_bytes.min(HttpSettings::LARGEST_SINGLE),
            json: settings.max_json_bytes,
            upload: settings.max_upload_bytes,
            request_timeout: settings.request_timeout,
            pace: pace::Pace { longest_stall: settings.body_idle_timeout, slowest_bytes_s: settings.min_body_rate },
        }
    }

    fn largest(&self, path: &str) -> u64 {
        match Weight::of(path) {
            Weight::Probe | Weight::Single => self.single,
            Weight::Heavy => self.json,
            Weight::Upload => self.upload,
        }
    }
}

/// Outside decompression: refuses what the head already rules out, and minds the pace.
///
/// # Errors
/// The answer to a request whose body is not to be read.
#[expect(clippy::result_large_err, reason = "it is returned as it is, once")]
pub(super) fn receive(limits: &Limits, mut request: Request) -> Result<(Request, Received), Response> {
    let largest = limits.largest(request.uri().path());
    match encoding(request.headers()) {
        Encoding::Gzip => {}
        Encoding::Identity if stated_length(request.headers()).is_none_or(|length| length <= largest) => {}
        Encoding::Identity => return Err(BodyFault::TooLarge { largest }.answer()),
        Encoding::Other => return Err(unsupported_encoding()),
    }
    let reception = Arc::new(Reception::begin());
    request.extensions_mut().insert(Arc::clone(&reception));
    let request = request.map(|body| Body::new(pace::Paced::new(body, limits.pace, Arc::clone(&reception))));
    Ok((request, Received { reception, request_timeout: limits.request_timeout }))
}

/// A request whose body comes under these rules.
pub(super) struct Received {
    reception: Arc<Reception>,
    request_timeout: Duration,
}

impl Received {
    /// `answer`, if it comes in time and no rule was broken.
    pub(super) async fn answer(self, answer: impl Future<Output = Response>) -> Response {
        let answer = answer_within(self.request_timeout, &self.reception, answer).await;
        match (self.reception.fault(), answer) {
            (Some(fault), _) => fault.answer(),
            (None, Some(response)) => response,
            (None, None) => took_too_long(self.request_timeout),
        }
    }
}

/// Inside decompression: ends the body at its limit.
pub(super) fn bound(limits: &Limits, request: Request) -> Request {
    let largest = limits.largest(request.uri().path());
    let reception = request.extensions().get::<Arc<Reception>>().cloned();
    let Some(reception) = reception else { unreachable!("the layer around this one begins the reception") };
    request.map(|body| Body::new(bound::Bound::new(body, largest, reception)))
}

/// What `answer` yields within `longest` of the request's last byte: a long upload over a slow line is not a slow answer.
async fn answer_within(longest: Duration, reception: &Reception, answer: impl Future<Output = Response>) -> Option<Response> {
    let mut answer = std::pin::pin!(answer);
    loop {
        let deadline = reception.last_byte() + longest;
        match timeout_at(deadline, answer.as_mut()).await {
            Ok(response) => return Some(response),
            Err(_) if reception.last_byte() + longest > Instant::now() => {}
            Err(_) => return None,
        }
    }
}

enum Encoding {
    Identity,
    Gzip,
    Other,
}

fn encoding(headers: &HeaderMap) -> Encoding {
    match headers.get(header::CONTENT_ENCODING).map(HeaderValue::as_bytes) {
        None | Some(b"identity") => Encoding::Identity,
        Some(b"gzip") => Encoding::Gzip,
        Some(_) => Encoding::Other,
    }
}

fn stated_length(headers: &HeaderMap) -> Option<u64> {
    headers.get(header::CONTENT_LENGTH)?.to_str().ok()?.parse().ok()
}

fn unsupported_encoding() -> Response {
    let detail = "send the body plain or with the header content-encoding: gzip".to_owned();
    let mut response = Problem::new(ServiceProblem::UnsupportedEncoding, detail).into_response();
    response.headers_mut().insert(header::ACCEPT_ENCODING, HeaderValue::from_static("gzip"));
    response
}

fn took_too_long(longest: Duration) -> Response {
    let detail = format!("no answer within {} s of the request's last byte", longest.as_secs());
    Problem::new(ServiceProblem::Timeout, detail).into_response()
}
