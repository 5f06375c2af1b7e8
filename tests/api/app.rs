//! The whole service on a free port, and a client.

use std::net::SocketAddr;
use std::time::Duration;

use scallopd::http::{self, AppState, Routes};
use scallopd::server::{self, App};
use scallopd::settings::{Command, Settings};
use serde_json::Value;
use tokio::net::TcpListener;
use tokio::sync::oneshot;

/// Longer than anything here takes on a slow machine.
pub(crate) const PATIENCE: Duration = Duration::from_mins(1);

pub(crate) struct TestApp {
    pub(crate) address: SocketAddr,
    pub(crate) state: AppState,
    pub(crate) client: reqwest::Client,
    /// Dropped, it stops the server.
    _stop: oneshot::Sender<()>,
}

impl TestApp {
    pub(crate) async fn start() -> Self {
        Self::start_with(|_| {}, http::routes()).await
    }

    /// Serves `routes`, with some settings other than the default.
    pub(crate) async fn start_with(set: impl FnOnce(&mut Settings), routes: Routes) -> Self {
        let Ok(Command::Serve(mut settings)) = Command::read(["scallopd"]) else { panic!("the defaults cannot be used") };
        set(&mut settings);
        let state = AppState::start(&settings.http).unwrap();
        let app =
            App { router: http::service(routes, &settings.http, &state), refuse: http::refusals(&state), budget: state.budget.clone() };
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = oneshot::channel();
        tokio::spawn(async move {
            let stop = async {
                let _ = stopped.await;
            };
            server::serve(listener, app, &settings.server, stop).await
        });
        let client = reqwest::Client::builder().no_gzip().timeout(PATIENCE).build().unwrap();
        Self { address, state, client, _stop: stop }
    }

    pub(crate) fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    pub(crate) async fn get(&self, path: &str) -> reqwest::Response {
        self.client.get(self.url(path)).send().await.unwrap()
    }

    /// Sends `body` as JSON, whether it is or not.
    pub(crate) async fn send(&self, path: &str, body: impl Into<reqwest::Body>) -> reqwest::Response {
        self.client.post(self.url(path)).header("content-type", "application/json").body(body).send().await.unwrap()
    }

    /// The same, with the answer read. An error must be a problem that names itself as the status line does.
    pub(crate) async fn post_text(&self, path: &str, body: impl Into<reqwest::Body>) -> (u16, Value) {
        let answer = self.send(path, body).await;
        let status = answer.status().as_u16();
        let media_type = answer.headers()["content-type"].to_str().unwrap().to_owned();
        let answer: Value = answer.json().await.unwrap();
        if status == 200 {
            assert_eq!(media_type, "application/json");
        } else {
            assert_eq!(media_type, "application/problem+json");
            assert_eq!((&answer["status"], &answer["instance"]), (&status.into(), &path.into()), "{answer}");
        }
        (status, answer)
    }

    pub(crate) async fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        self.post_text(path, body.to_string()).await
    }

    /// The answer to a request that has one.
    pub(crate) async fn answer(&self, path: &str, body: &Value) -> Value {
        let (status, answer) = self.post(path, body).await;
        assert_eq!(status, 200, "{body} gives {answer}");
        answer
    }

    /// The problem of a request that is well-formed and has no answer.
    pub(crate) async fn refusal(&self, path: &str, body: &Value) -> Value {
        self.refusal_of_text(path, body.to_string()).await
    }

    pub(crate) async fn refusal_of_text(&self, path: &str, body: String) -> Value {
        let (status, problem) = self.post_text(path, body.clone()).await;
        assert_eq!(status, 422, "{body} gives {problem}");
        problem
    }
}

/// The faults of a problem, as pointers and codes, in their order.
pub(crate) fn faults(problem: &Value) -> Vec<(&str, &str)> {
    let errors = problem["errors"].as_array().unwrap_or_else(|| panic!("no errors in {problem}"));
    errors.iter().map(|error| (error["pointer"].as_str().unwrap(), error["code"].as_str().unwrap())).collect()
}

/// The codes of an answer's warnings.
pub(crate) fn warnings(answer: &Value) -> Vec<&str> {
    answer["warnings"].as_array().unwrap().iter().map(|warning| warning["code"].as_str().unwrap()).collect()
}

pub(crate) fn figure(object: &Value, name: &str) -> f64 {
    object[name].as_f64().unwrap_or_else(|| panic!("{name} is not a number in {object}"))
}
