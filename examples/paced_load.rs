//! Sends requests at a fixed rate, independent of the answers, and prints the distribution of latencies, for
//! `benches/requests`.
//!
//! `paced_load ADDRESS PATH RATE SECONDS CONNECTIONS`, with the JSON body on standard input. A request is due every
//! 1/RATE seconds and is sent on the first free connection. Its latency counts from the time at which it was due, so
//! that the latencies of a stalled server include the waiting requests. The program polls on one core, because a sleep
//! would be coarser than the latencies.

use std::error::Error;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// A connection and the request on it.
struct Connection {
    stream: TcpStream,
    /// The time at which its request was due; `None` if the connection is free.
    due: Option<Instant>,
    received: Vec<u8>,
}

impl Connection {
    fn open(address: &str) -> std::io::Result<Self> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        stream.set_nonblocking(true)?;
        Ok(Self { stream, due: None, received: Vec::new() })
    }

    /// The latency if the whole answer has arrived.
    fn poll(&mut self) -> Result<Option<Duration>, Box<dyn Error>> {
        let Some(due) = self.due else { return Ok(None) };
        let mut buffer = [0; 16 * 1024];
        match self.stream.read(&mut buffer) {
            Ok(0) => return Err("the server closed a connection".into()),
            Ok(bytes) => self.received.extend_from_slice(&buffer[..bytes]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(None),
            Err(error) => return Err(error.into()),
        }
        let Some(length) = answer_length(&self.received)? else { return Ok(None) };
        if self.received.len() < length {
            return Ok(None);
        }
        self.received.clear();
        self.due = None;
        Ok(Some(due.elapsed()))
    }
}

/// The length of the answer that begins with `received`, head and body, once its head has arrived.
fn answer_length(received: &[u8]) -> Result<Option<usize>, Box<dyn Error>> {
    let Some(end) = received.windows(4).position(|window| window == b"\r\n\r\n") else { return Ok(None) };
    let head = std::str::from_utf8(&received[..end])?.to_ascii_lowercase();
    if !head.starts_with("http/1.1 200") {
        return Err(format!("an answer is not 200: {head}").into());
    }
    let length = head.lines().find_map(|line| line.strip_prefix("content-length:")).ok_or("an answer has no length")?;
    Ok(Some(end + 4 + length.trim().parse::<usize>()?))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [address, path, rate, seconds, connections] = &arguments[..] else {
        return Err("paced_load ADDRESS PATH RATE SECONDS CONNECTIONS".into());
    };
    let (interval, length) = (Duration::from_secs_f64(1.0 / rate.parse::<f64>()?), Duration::from_secs_f64(seconds.parse()?));
    let mut body = String::new();
    std::io::stdin().read_to_string(&mut body)?;
    let head =
        format!("POST {path} HTTP/1.1\r\nhost: {address}\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\r\n", body.len());
    let request = [head.as_bytes(), body.as_bytes()].concat();
    let mut connections = (0..connections.parse()?).map(|_| Connection::open(address)).collect::<Result<Vec<_>, _>>()?;

    let mut latencies = Vec::new();
    let end = Instant::now() + length;
    let mut due = Instant::now();
    while due < end || connections.iter().any(|connection| connection.due.is_some()) {
        for connection in &mut connections {
            if let Some(latency) = connection.poll()? {
                latencies.push(latency);
            }
            if connection.due.is_none() && due < end && Instant::now() >= due {
                // A request fits the system's buffer.
                connection.stream.write_all(&request)?;
                connection.due = Some(due);
                due += interval;
            }
        }
    }
    latencies.sort_unstable();
    let share = |share: usize| latencies[(latencies.len() - 1) * share / 100].as_secs_f64() * 1e6;
    println!("{{\"requests\": {}, \"p50_us\": {:.1}, \"p99_us\": {:.1}}}", latencies.len(), share(50), share(99));
    Ok(())
}
