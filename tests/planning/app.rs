//! The whole service in-process, on a free port.

use reqwest::multipart::{Form, Part};
use scallopd::http::{self, AppState};
use scallopd::server::{self, App};
use scallopd::settings::{Command, Settings};
use serde_json::Value;
use std::io::Write;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::TcpListener;

/// Longer than anything here takes on a slow machine.
const PATIENCE: Duration = Duration::from_mins(1);

pub(crate) struct TestApp {
    address: SocketAddr,
    client: reqwest::Client,
}

/// A status with its JSON.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) body: Value,
}

impl TestApp {
    pub(crate) async fn start() -> Self {
        let Ok(Command::Serve(settings)) = Command::read(["scallopd"]) else { panic!("the defaults cannot be used") };
        Self::start_with(*settings).await
    }

    pub(crate) async fn start_with(settings: Settings) -> Self {
        let state = AppState::start(&settings.http).unwrap();
        let app = App {
            router: http::service(http::routes(), &settings.http, &state),
            refuse: http::refusals(&state),
            budget: state.budget.clone(),
        };
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        tokio::spawn(async move { server::serve(listener, app, &settings.server, std::future::pending()).await });
        Self { address, client: reqwest::Client::builder().timeout(PATIENCE).build().unwrap() }
    }

    fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    async fn send(request: reqwest::RequestBuilder) -> Answer {
        let response = request.send().await.unwrap();
        let status = response.status().as_u16();
        let text = response.text().await.unwrap();
        assert!(status < 500, "{status}: {text}");
        let body = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{status}, {error}: {text}"));
        Answer { status, body }
    }

    pub(crate) async fn get(&self, path: &str) -> Answer {
        Self::send(self.client.get(self.url(path))).await
    }

    pub(crate) async fn get_text(&self, path: &str) -> String {
        self.client.get(self.url(path)).send().await.unwrap().text().await.unwrap()
    }

    pub(crate) async fn post(&self, path: &str, body: &Value) -> Answer {
        Self::send(self.client.post(self.url(path)).json(body)).await
    }

    pub(crate) async fn post_text(&self, path: &str, media_type: &str, body: impl Into<reqwest::Body>) -> Answer {
        Self::send(self.client.post(self.url(path)).header("content-type", media_type).body(body)).await
    }

    pub(crate) async fn recommend(&self, request: &Value) -> Answer {
        self.post("/v1/cutter-recommendation", request).await
    }

    /// Uploads a file of which only the content is told.
    pub(crate) async fn upload(&self, file: impl Into<Vec<u8>>, parameters: &Value) -> Answer {
        self.upload_parts([("surface", file.into()), ("parameters", parameters.to_string().into_bytes())]).await
    }

    pub(crate) async fn upload_parts(&self, parts: impl IntoIterator<Item = (&'static str, Vec<u8>)>) -> Answer {
        let form = parts.into_iter().fold(Form::new(), |form, (name, data)| form.part(name, Part::bytes(data)));
        self.upload_form(form).await
    }

    pub(crate) async fn upload_form(&self, form: Form) -> Answer {
        Self::send(self.client.post(self.url("/v1/cutter-recommendation/upload")).multipart(form)).await
    }

    /// Uploads a body of the caller's own with the boundary `edge`.
    pub(crate) async fn upload_raw(&self, body: Vec<u8>, is_gzip: bool) -> Answer {
        let request = self.client.post(self.url("/v1/cutter-recommendation/upload"));
        let request = request.header("content-type", "multipart/form-data; boundary=edge");
        let request = if is_gzip { request.header("content-encoding", "gzip") } else { request };
        Self::send(request.body(body)).await
    }
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

impl Answer {
    /// The body of a success.
    #[track_caller]
    pub(crate) fn ok(self) -> Value {
        assert_eq!(self.status, 200, "{}", self.body);
        self.body
    }

    /// Pointer and code of every fault, with the status.
    pub(crate) fn faults(&self) -> (u16, Vec<(&str, &str)>) {
        let errors = self.body["errors"].as_array().map(Vec::as_slice).unwrap_or_default();
        (self.status, errors.iter().map(|error| (error["pointer"].as_str().unwrap(), error["code"].as_str().unwrap())).collect())
    }

    /// What the first fault says.
    pub(crate) fn detail(&self) -> &str {
        self.body["errors"][0]["detail"].as_str().unwrap_or_default()
    }
}

/// A number of an answer.
#[track_caller]
pub(crate) fn figure(body: &Value, pointer: &str) -> f64 {
    body.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} is no number in {body:#}"))
}

/// The codes of an answer's warnings.
pub(crate) fn warnings(body: &Value) -> Vec<&str> {
    body["warnings"].as_array().unwrap().iter().map(|warning| warning["code"].as_str().unwrap()).collect()
}
