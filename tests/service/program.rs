//! The program: its settings, its health check and its shutdown.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::app::PATIENCE;
use crate::service::launch::{Program, scallopd, text};

/// The answer to one request on a new connection; `None` if the server no longer accepts connections or requests.
fn ask(address: SocketAddr) -> Option<String> {
    let mut stream = TcpStream::connect(address).ok()?;
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.write_all(b"GET /metrics HTTP/1.1\r\nhost: test\r\nconnection: close\r\n\r\n").ok()?;
    let mut answer = String::new();
    match stream.read_to_string(&mut answer) {
        Ok(_) => Some(answer),
        Err(error) => {
            assert!(answer.is_empty(), "an answer was cut off ({error}): {answer}");
            None
        }
    }
}

#[test]
fn all_faults_of_flags_and_variables_are_reported_at_once_with_both_names() {
    let output = scallopd().args(["--listen", "nowhere", "--max-json", "0"]).env("SCALLOPD_LOG_LEVEL", "loud").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let text = text(&output);
    for part in ["--listen or SCALLOPD_LISTEN: \"nowhere\"", "--max-json or SCALLOPD_MAX_JSON: \"0\"", "SCALLOPD_LOG_LEVEL: \"loud\""] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn a_variable_that_no_setting_has_is_warned_of() {
    let program = Program::run(scallopd().env("SCALLOPD_MAX_CONECTIONS", "7"));
    program.signal("TERM");
    let (_, log) = program.wait();
    assert!(log.iter().any(|line| line["level"] == "WARN" && line["variable"] == "SCALLOPD_MAX_CONECTIONS"), "{log:?}");
}

#[test]
fn help_names_every_variable_with_its_default() {
    let help = text(&scallopd().arg("--help").output().unwrap());
    for part in ["[env: SCALLOPD_LISTEN=]", "[default: 127.0.0.1:8080]", "[env: SCALLOPD_OTLP_ENDPOINT=]", "healthcheck", "openapi"] {
        assert!(help.contains(part), "{part} is not in\n{help}");
    }
}

#[test]
fn a_health_check_succeeds_only_with_a_ready_server() {
    let program = Program::start(&[]);
    let port = program.address.port();
    // A server on all addresses is reached on loopback.
    let check = || scallopd().arg("healthcheck").env("SCALLOPD_LISTEN", format!("0.0.0.0:{port}")).status().unwrap().code();
    assert_eq!(check(), Some(0));
    program.signal("INT");
    assert_eq!(program.wait().0, Some(0));
    assert_eq!(check(), Some(1));
}

#[test]
fn an_address_in_use_ends_the_program_with_a_reason() {
    let program = Program::start(&[]);
    let second = scallopd().args(["--listen", &program.address.to_string()]).output().unwrap();
    assert_eq!(second.status.code(), Some(1));
    let address = program.address.to_string();
    for part in ["in use", "--listen", &address] {
        assert!(text(&second).contains(part), "{part} is not in {}", text(&second));
    }
    program.signal("TERM");
    assert_eq!(program.wait().0, Some(0));
}

#[test]
fn a_hangup_drains_like_a_termination() {
    let program = Program::start(&[]);
    program.signal("HUP");
    let (code, log) = program.wait();
    assert_eq!(code, Some(0));
    assert!(log.iter().any(|line| line["message"] == "draining" && line["signal"] == "SIGHUP"), "{log:?}");
}

#[test]
fn probes_and_metrics_are_served_on_their_own_address_if_one_is_set() {
    // A port that was free just before.
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let program = Program::start(&["--health-listen", &free.to_string()]);
    assert!(ask(program.address).expect("an answer").starts_with("HTTP/1.1 404"));
    assert!(ask(free).expect("an answer").starts_with("HTTP/1.1 200"));
    let check = scallopd().args(["healthcheck", "--health-listen", &free.to_string(), "--listen", "127.0.0.1:1"]).status().unwrap();
    assert_eq!(check.code(), Some(0));
    program.signal("TERM");
    assert_eq!(program.wait().0, Some(0));
}

#[test]
fn a_draining_program_still_answers_and_a_health_check_fails() {
    let program = Program::start(&["--drain-delay-s", "3"]);
    program.signal("TERM");
    let deadline = std::time::Instant::now() + PATIENCE;
    loop {
        let answer = scallopd().args(["healthcheck", "--listen", &program.address.to_string()]).output().unwrap();
        if answer.status.code() == Some(1) {
            // The server answered; a refused connection would be `None`.
            assert_eq!(text(&answer), "");
            break;
        }
        assert!(std::time::Instant::now() < deadline, "the server stays ready");
    }
    assert_eq!(program.wait().0, Some(0));
}

#[test]
fn a_termination_under_load_loses_no_accepted_request() {
    let program = Program::start(&["--log-level", "debug"]);
    let address = program.address;
    let over = Arc::new(AtomicBool::new(false));
    let clients: Vec<_> = (0..16)
        .map(|_| {
            let over = Arc::clone(&over);
            std::thread::spawn(move || {
                let mut answered = 0;
                while !over.load(Ordering::Relaxed) {
                    let Some(answer) = ask(address) else { continue };
                    assert!(answer.starts_with("HTTP/1.1 200") && answer.ends_with("# EOF\n"), "an answer was cut off: {answer:?}");
                    answered += 1;
                }
                answered
            })
        })
        .collect();
    std::thread::sleep(Duration::from_millis(700));
    program.signal("TERM");
    let (code, log) = program.wait();
    over.store(true, Ordering::Relaxed);
    let answered: usize = clients.into_iter().map(|client| client.join().unwrap()).sum();
    assert_eq!(code, Some(0));
    // Each request that the server accepted has a line in its log, and a client must have read the whole answer of
    // each.
    let begun: Vec<_> = log.iter().filter(|line| line["message"] == "request").collect();
    assert!(begun.iter().all(|line| line["status"] == 200), "a request was given up");
    assert!(answered > 100, "that was no load: {answered}");
    assert_eq!(answered, begun.len());
}

#[test]
fn a_request_that_is_cut_off_at_the_end_of_the_grace_is_logged_with_its_id() {
    let program = Program::start(&["--shutdown-grace-s", "1"]);
    let mut stream = TcpStream::connect(program.address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let head = "POST /v1/max-feed HTTP/1.1\r\nhost: test\r\ncontent-type: application/json\r\nx-request-id: order-66\r\ncontent-length: 9\r\nexpect: 100-continue\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    // The request has begun when the server asks for its body.
    stream.read_exact(&mut [0; 25]).unwrap();
    program.signal("TERM");
    let (code, log) = program.wait();
    assert_eq!(code, Some(0));
    let of_request = log.iter().find(|line| line["request_id"] == "order-66").expect("a line");
    assert_eq!((of_request["level"].as_str(), of_request["route"].as_str()), (Some("WARN"), Some("/v1/max-feed")));
    assert!(of_request["message"].as_str().unwrap().contains("cut off"), "{of_request}");
}

#[test]
fn a_request_is_one_line_with_its_id_route_status_duration_and_bytes() {
    let program = Program::start(&["--log-level", "debug"]);
    let mut stream = TcpStream::connect(program.address).unwrap();
    stream.write_all(b"GET /livez HTTP/1.1\r\nhost: test\r\nx-request-id: order-66\r\nconnection: close\r\n\r\n").unwrap();
    stream.read_to_string(&mut String::new()).unwrap();
    program.signal("TERM");
    let (_, log) = program.wait();
    let of_request: Vec<_> = log.iter().filter(|line| line["request_id"] == "order-66").collect();
    assert_eq!(of_request.len(), 1);
    let line = of_request[0];
    assert_eq!((line["route"].as_str(), line["method"].as_str(), line["status"].as_u64()), (Some("/livez"), Some("GET"), Some(200)));
    assert_eq!((line["request_bytes"].as_u64(), line["response_bytes"].as_u64()), (Some(0), Some(6)));
    assert!(line["duration_ms"].as_f64().unwrap() >= 0.0);
}

#[test]
fn a_line_of_a_refusal_has_the_problem_its_first_fault_and_the_path_of_a_404() {
    let program = Program::start(&[]);
    let mut stream = TcpStream::connect(program.address).unwrap();
    let body = r#"{"cutter":{"type":"ball_end","diameter_mm":-1}}"#;
    let head = format!(
        "POST /v1/scallop-height HTTP/1.1\r\nhost: test\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\r\n",
        body.len()
    );
    stream.write_all((head + body).as_bytes()).unwrap();
    stream.write_all(b"GET /nowhere HTTP/1.1\r\nhost: test\r\nconnection: close\r\n\r\n").unwrap();
    stream.read_to_string(&mut String::new()).unwrap();
    program.signal("TERM");
    let (_, log) = program.wait();
    let of_status = |status: u16| log.iter().find(|line| line["status"] == status).unwrap_or_else(|| panic!("no {status} in {log:?}"));
    let refused = of_status(422);
    assert_eq!((refused["problem"].as_str(), refused["pointer"].as_str()), (Some("invalid-request"), Some("/cutter/diameter_mm")));
    assert!(refused["fault"].is_string(), "{refused}");
    let unknown = of_status(404);
    assert_eq!((unknown["problem"].as_str(), unknown["path"].as_str()), (Some("not-found"), Some("/nowhere")));
    assert!(unknown.get("fault").is_none(), "{unknown}");
}

#[test]
fn a_head_that_is_no_request_is_one_line_with_its_id_and_status() {
    let program = Program::start(&["--log-level", "debug"]);
    let mut stream = TcpStream::connect(program.address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.write_all(b"no request at all\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let id = answer.lines().find_map(|line| line.strip_prefix("x-request-id: ")).unwrap_or_else(|| panic!("no id in {answer}")).to_owned();
    program.signal("TERM");
    let (_, log) = program.wait();
    let of_request: Vec<_> = log.iter().filter(|line| line["request_id"] == id.as_str()).collect();
    assert_eq!(of_request.len(), 1, "{log:?}");
    assert_eq!(of_request[0]["status"], 400);
}

#[test]
fn a_program_without_free_file_descriptors_continues_when_connections_end() {
    // The program itself opens about ten files.
    let program = Program::run(Command::new("sh").args(["-c", "ulimit -n 40 && exec \"$0\"", env!("CARGO_BIN_EXE_scallopd")]));
    let idle: Vec<_> = (0..60).map(|_| TcpStream::connect(program.address).unwrap()).collect();
    // Longer than the pause after a failure to accept.
    std::thread::sleep(Duration::from_millis(500));
    drop(idle);
    assert!(ask(program.address).expect("an answer").starts_with("HTTP/1.1 200"));
    program.signal("TERM");
    let (code, log) = program.wait();
    assert_eq!(code, Some(0));
    assert!(log.iter().any(|line| line["message"] == "no connection can be accepted"), "the files were enough: the test tests nothing");
}
