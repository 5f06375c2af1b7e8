//! The test application: the whole service in-process on a free port, with a client.

use std::io::Write;
use std::net::SocketAddr;
use std::time::Duration;

use reqwest::multipart::{Form, Part};
use scallopd::http::{self, AppState, Routes};
use scallopd::server::{self, App};
use scallopd::settings::{Command, Settings};
use serde_json::Value;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// The client's time-out, and the service's for a request unless a test sets it: longer than any takes on a slow and busy machine.
pub(crate) const PATIENCE: Duration = Duration::from_mins(5);

/// The settings of a service that is started without arguments.
pub(crate) fn defaults() -> Settings {
    let Ok(Command::Serve(settings)) = Command::read(["scallopd"]) else { panic!("the defaults cannot be used") };
    *settings
}

/// A running service, which stops when it is dropped.
pub(crate) struct TestApp {
    pub(crate) address: SocketAddr,
    pub(crate) state: AppState,
    pub(crate) client: reqwest::Client,
    stop: Option<oneshot::Sender<()>>,
    served: JoinHandle<()>,
}

/// The status and the JSON of an answer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) body: Value,
}

impl TestApp {
    /// Starts the service with the default settings, and more time for each request.
    pub(crate) async fn start() -> Self {
        Self::start_with(|_| {}).await
    }

    /// Starts the service with some settings other than the default.
    pub(crate) async fn start_with(set: impl FnOnce(&mut Settings)) -> Self {
        let mut settings = defaults();
        settings.request_timeout_s = PATIENCE;
        set(&mut settings);
        Self::serve(settings, http::routes()).await
    }

    /// Serves `routes`.
    pub(crate) async fn serve(settings: Settings, routes: Routes) -> Self {
        let state = AppState::start(&settings).unwrap();
        let app = App { router: http::service(routes, &settings, &state), refuse: http::refusals(&state) };
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let ending = state.readiness.clone();
        let (stop, stopped) = oneshot::channel();
        let served = tokio::spawn(async move {
            let stop = async {
                let _ = stopped.await;
            };
            let remaining = server::serve(listener, app, &settings, stop).await;
            if !remaining.is_empty() {
                ending.end();
            }
            remaining.cut().await;
        });
        let client = reqwest::Client::builder().no_gzip().timeout(PATIENCE).build().unwrap();
        Self { address, state, client, stop: Some(stop), served }
    }

    /// Starts the service's shutdown.
    pub(crate) fn stop(&mut self) {
        self.stop.take().expect("stopped once").send(()).unwrap();
    }

    /// Waits until the service has stopped.
    pub(crate) async fn stopped(self) {
        tokio::time::timeout(PATIENCE, self.served).await.expect("the service stops").unwrap();
    }

    pub(crate) fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    /// A separate TCP connection.
    pub(crate) async fn connect(&self) -> TcpStream {
        TcpStream::connect(self.address).await.unwrap()
    }

    pub(crate) async fn get(&self, path: &str) -> reqwest::Response {
        self.client.get(self.url(path)).send().await.unwrap()
    }

    pub(crate) async fn metrics(&self) -> String {
        self.get("/metrics").await.text().await.unwrap()
    }

    /// Sends `body` with JSON's media type, whether it is JSON or not.
    pub(crate) async fn send(&self, path: &str, body: impl Into<reqwest::Body>) -> reqwest::Response {
        self.client.post(self.url(path)).header("content-type", "application/json").body(body).send().await.unwrap()
    }

    /// Sends `body` with JSON's media type, whether it is JSON or not, and reads the answer.
    pub(crate) async fn post_text(&self, path: &str, body: impl Into<reqwest::Body>) -> Answer {
        Answer::of(self.send(path, body).await).await
    }

    /// Sends `body` under a media type other than JSON's.
    pub(crate) async fn post_as(&self, path: &str, media_type: &str, body: impl Into<reqwest::Body>) -> Answer {
        Answer::of(self.client.post(self.url(path)).header("content-type", media_type).body(body).send().await.unwrap()).await
    }

    pub(crate) async fn post(&self, path: &str, body: &Value) -> Answer {
        self.post_text(path, body.to_string()).await
    }

    /// The answer to a request that has one.
    pub(crate) async fn answer(&self, path: &str, body: &Value) -> Value {
        let answer = self.post(path, body).await;
        assert_eq!(answer.status, 200, "{body} gives {}", answer.body);
        answer.body
    }

    /// The problem of a request that is well-formed and has no answer.
    pub(crate) async fn refusal(&self, path: &str, body: &Value) -> Value {
        self.refusal_of_text(path, body.to_string()).await
    }

    pub(crate) async fn refusal_of_text(&self, path: &str, body: String) -> Value {
        let answer = self.post_text(path, body.clone()).await;
        assert_eq!(answer.status, 422, "{body} gives {}", answer.body);
        answer.body
    }

    pub(crate) async fn recommend(&self, request: &Value) -> Answer {
        self.post("/v1/cutter-recommendation", request).await
    }

    /// Uploads a file without its name or its format.
    pub(crate) async fn upload(&self, file: impl Into<Vec<u8>>, parameters: &Value) -> Answer {
        self.upload_parts([("surface", file.into()), ("parameters", parameters.to_string().into_bytes())]).await
    }

    pub(crate) async fn upload_parts(&self, parts: impl IntoIterator<Item = (&'static str, Vec<u8>)>) -> Answer {
        self.post_parts("/v1/cutter-recommendation/upload", parts).await
    }

    pub(crate) async fn post_parts(&self, path: &str, parts: impl IntoIterator<Item = (&'static str, Vec<u8>)>) -> Answer {
        let form = parts.into_iter().fold(Form::new(), |form, (name, data)| form.part(name, Part::bytes(data)));
        Answer::of(self.client.post(self.url(path)).multipart(form).send().await.unwrap()).await
    }

    pub(crate) async fn upload_form(&self, form: Form) -> Answer {
        let request = self.client.post(self.url("/v1/cutter-recommendation/upload")).multipart(form);
        Answer::of(request.send().await.unwrap()).await
    }

    /// Uploads a complete multipart body with the boundary `edge`.
    pub(crate) async fn upload_raw(&self, body: Vec<u8>, is_gzip: bool) -> Answer {
        let request = self.client.post(self.url("/v1/cutter-recommendation/upload"));
        let request = request.header("content-type", "multipart/form-data; boundary=edge");
        let request = if is_gzip { request.header("content-encoding", "gzip") } else { request };
        Answer::of(request.body(body).send().await.unwrap()).await
    }
}

impl Answer {
    /// Reads an answer. No request may cause a status of 500, and an error must be a problem with the status of the
    /// status line.
    pub(crate) async fn of(response: reqwest::Response) -> Self {
        let status = response.status().as_u16();
        let path = response.url().path().to_owned();
        let media_type = response.headers()["content-type"].to_str().unwrap().to_owned();
        let text = response.text().await.unwrap();
        let body: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{status}, {error}: {text}"));
        assert!(status < 500 || status == 503, "{status}: {body}");
        if status == 200 {
            assert_eq!(media_type, "application/json");
        } else {
            assert_eq!(media_type, "application/problem+json");
            assert_eq!((&body["status"], &body["instance"]), (&status.into(), &path.into()), "{body}");
        }
        Self { status, body }
    }

    /// The body of a success.
    #[track_caller]
    pub(crate) fn ok(self) -> Value {
        assert_eq!(self.status, 200, "{}", self.body);
        self.body
    }

    /// The status, with pointer and code of every fault.
    pub(crate) fn faults(&self) -> (u16, Vec<(&str, &str)>) {
        (self.status, faults(&self.body))
    }

    /// The detail of the first fault.
    pub(crate) fn detail(&self) -> &str {
        self.body["errors"][0]["detail"].as_str().unwrap_or_default()
    }
}

/// The faults of a problem, as pointers and codes, in their order.
#[track_caller]
pub(crate) fn faults(problem: &Value) -> Vec<(&str, &str)> {
    let errors = problem["errors"].as_array().unwrap_or_else(|| panic!("no errors in {problem}"));
    errors.iter().map(|error| (error["pointer"].as_str().unwrap(), error["code"].as_str().unwrap())).collect()
}

/// The codes of an answer's warnings.
#[track_caller]
pub(crate) fn warnings(answer: &Value) -> Vec<&str> {
    answer["warnings"].as_array().unwrap().iter().map(|warning| warning["code"].as_str().unwrap()).collect()
}

/// A number of an answer, by the name of a member or a JSON pointer.
#[track_caller]
pub(crate) fn figure(answer: &Value, place: &str) -> f64 {
    let found = if place.starts_with('/') { answer.pointer(place) } else { answer.get(place) };
    found.and_then(Value::as_f64).unwrap_or_else(|| panic!("{place} is not a number in {answer:#}"))
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}
