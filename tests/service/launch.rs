//! The compiled program, started on a free port.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::process::{Child, Command, Output, Stdio};
use std::thread::JoinHandle;

pub(crate) fn scallopd() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scallopd"));
    for (name, _) in std::env::vars().filter(|(name, _)| name.starts_with("SCALLOPD_")) {
        command.env_remove(name);
    }
    command
}

pub(crate) fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// A running program and its log lines.
pub(crate) struct Program {
    child: Child,
    pub(crate) address: SocketAddr,
    log: Option<JoinHandle<Vec<serde_json::Value>>>,
}

impl Program {
    pub(crate) fn start(arguments: &[&str]) -> Self {
        Self::run(scallopd().args(arguments))
    }

    /// Starts `command`, which must end with the program.
    pub(crate) fn run(command: &mut Command) -> Self {
        let mut child = command.env("SCALLOPD_LISTEN", "127.0.0.1:0").stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(|line| serde_json::from_str(&line.unwrap()).unwrap());
        let first: serde_json::Value = lines.next().expect("a line with the address");
        let address = first["address"].as_str().expect("an address").parse().unwrap();
        Self { child, address, log: Some(std::thread::spawn(move || lines.collect())) }
    }

    pub(crate) fn signal(&self, name: &str) {
        let killed = Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status().unwrap();
        assert!(killed.success());
    }

    /// The program's peak memory so far, in kB.
    #[cfg(target_os = "linux")]
    pub(crate) fn peak_memory_kb(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a peak");
        line.trim().trim_end_matches(" kB").parse().unwrap()
    }

    /// The processor time of all its threads so far, in s, to a hundredth.
    #[cfg(target_os = "linux")]
    pub(crate) fn processor_time_s(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.child.id())).unwrap();
        // The name of the program, in brackets, may have blanks. User and system time are the 14th and 15th fields of
        // the line.
        let figures = stat.rsplit_once(')').expect("a name").1.split_whitespace();
        let ticks: f64 = figures.skip(11).take(2).map(|ticks| ticks.parse::<f64>().unwrap()).sum();
        // Linux states 100 ticks a second to programs on all its architectures.
        ticks / 100.0
    }

    /// The exit code and the log.
    pub(crate) fn wait(mut self) -> (Option<i32>, Vec<serde_json::Value>) {
        let code = self.child.wait().unwrap().code();
        (code, self.log.take().expect("a log").join().unwrap())
    }
}

/// Ends the program when a test fails.
impl Drop for Program {
    fn drop(&mut self) {
        // The program has usually ended.
        let _ = self.child.kill();
    }
}
