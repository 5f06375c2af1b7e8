//! A request's body: collected into one buffer within the memory budget, or passed on to a reader that waits for data on a
//! thread of its own.

use super::codes::ServiceProblem;
use super::problem::Problem;
use crate::budget::{Budget, FREE_INPUT, Held, Job, LONGEST_WAIT};
use axum::body::{Body, Bytes};
use http_body_util::BodyExt;
use std::io::{self, Read};
use tokio::sync::mpsc;

/// The number of bytes collected before the task yields: less than a millisecond of decompression.
const TURN: usize = 64 * 1024;

/// A body with its share of the memory.
struct Collected {
    bytes: Vec<u8>,
    held: Held,
}

impl AsRef<[u8]> for Collected {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Collects `body`, of `stated` bytes if the client states its length and does not compress it. The memory is taken
/// before the body is read if its length is known, otherwise as it arrives; it is returned when the last reference to
/// the bytes is dropped.
pub(super) async fn collect(mut body: Body, stated: Option<u64>, budget: &Budget) -> Result<Bytes, Problem> {
    let stated = stated.unwrap_or(0);
    let held = budget.take(Job::Body { bytes: stated }, LONGEST_WAIT).await?;
    let capacity = usize::try_from(stated.min(FREE_INPUT)).unwrap_or(0);
    let mut collected = Collected { bytes: Vec::with_capacity(capacity), held };
    let mut turn = 0;
    while let Some(data) = next_data(&mut body).await? {
        collected.held.grow_input((collected.bytes.len() + data.len()) as u64)?;
        collected.bytes.extend_from_slice(&data);
        turn += data.len();
        drop(data);
        if turn >= TURN {
            // Decompression returns data without waiting, so this yields to other tasks.
            tokio::task::yield_now().await;
            turn = 0;
        }
    }
    Ok(Bytes::from_owner(collected))
}

/// The body's next data; `None` at its end.
pub(super) async fn next_data(body: &mut Body) -> Result<Option<Bytes>, Problem> {
    while let Some(frame) = body.frame().await {
        // If a body is over its limit, too slow or damaged, the middleware replaces the answer; this problem is for
        // other errors.
        let frame = frame.map_err(|error| Problem::new(ServiceProblem::UnreadableBody, error.to_string()))?;
        if let Ok(data) = frame.into_data() {
            return Ok(Some(data));
        }
    }
    Ok(None)
}

/// The largest number of chunks in the pipe. Each keeps its receive buffer in memory.
const CHUNKS: usize = 8;

/// The end of a pipe that the request holds.
#[derive(Debug)]
pub(crate) struct BodyPipe(mpsc::Sender<Bytes>);

/// The end of a pipe that the reader holds.
#[derive(Debug)]
pub(crate) struct PipedBody {
    chunks: mpsc::Receiver<Bytes>,
    /// The rest of the last chunk.
    held: Bytes,
    is_over: bool,
}

/// An empty pipe. When the request ends early, for whatever reason (the body timed out, the client has gone, the server stops), its
/// writer is dropped with it, and every further read fails.
pub(crate) fn body_pipe() -> (BodyPipe, PipedBody) {
    let (sender, chunks) = mpsc::channel(CHUNKS);
    (BodyPipe(sender), PipedBody { chunks, held: Bytes::new(), is_over: false })
}

impl BodyPipe {
    /// Waits until there is room for a chunk, and returns whether the reader still reads.
    pub(crate) async fn send(&self, chunk: Bytes) -> bool {
        chunk.is_empty() || self.0.send(chunk).await.is_ok()
    }

    /// Ends the body. The pipe must be held until the reader has returned its result.
    pub(crate) async fn end(&self) {
        // A reader that has refused the file reads no more.
        let _ = self.0.send(Bytes::new()).await;
    }
}

impl Read for PipedBody {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.held.is_empty() && !self.is_over {
            self.held = self.chunks.blocking_recv().ok_or(io::ErrorKind::BrokenPipe)?;
            self.is_over = self.held.is_empty();
        }
        if self.is_over && self.chunks.is_closed() {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let length = self.held.len().min(buffer.len());
        buffer[..length].copy_from_slice(&self.held.split_to(length));
        Ok(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use http_body_util::channel::Channel;
    use std::thread;

    /// The result for a body of `count` pieces of `size` bytes without a stated length, and the memory held with it.
    async fn collected(count: usize, size: usize, budget: &Budget) -> (Result<usize, Problem>, u64) {
        let (mut sender, channel) = Channel::<Bytes, axum::BoxError>::new(1);
        let sending = tokio::spawn(async move {
            for _ in 0..count {
                if sender.send_data(vec![b'x'; size].into()).await.is_err() {
                    return;
                }
            }
        });
        let whole = collect(Body::new(channel), None, budget).await;
        sending.await.unwrap();
        let held = budget.held();
        (whole.map(|bytes| bytes.len()), held)
    }

    #[tokio::test]
    async fn memory_is_held_as_long_as_the_body() {
        let (length, held) = collected(500, 10_000, &Budget::new(64 << 20)).await;
        assert_eq!((length.unwrap(), held), (5_000_000, 5 << 20));
    }

    #[tokio::test]
    async fn a_body_that_does_not_fit_is_refused_and_its_memory_is_free() {
        let budget = Budget::new(16 << 20);
        let other = budget.take(Job::Body { bytes: 3 << 20 }, LONGEST_WAIT).await.unwrap();
        let (length, held) = collected(500, 10_000, &budget).await;
        assert!(length.is_err());
        assert_eq!(held, 3 << 20);
        drop(other);
        assert_eq!(budget.held(), 0);
    }

    #[tokio::test]
    async fn a_body_arrives_whole_and_ends() {
        let (pipe, mut body) = body_pipe();
        let reading = thread::spawn(move || {
            let mut all = Vec::new();
            body.read_to_end(&mut all).map(|_| all)
        });
        for piece in [&b"one"[..], b"", b" two"] {
            assert!(pipe.send(Bytes::from_static(piece)).await);
        }
        pipe.end().await;
        let all = tokio::task::spawn_blocking(|| reading.join().unwrap()).await.unwrap();
        assert_eq!(all.unwrap(), b"one two");
        assert!(!pipe.send(Bytes::from_static(b"more")).await, "the reader has gone");
    }

    #[tokio::test]
    async fn a_reader_of_a_request_that_has_ended_fails() {
        for ends_first in [false, true] {
            let (pipe, mut body) = body_pipe();
            assert!(pipe.send(Bytes::from_static(b"begun")).await);
            if ends_first {
                pipe.end().await;
            }
            drop(pipe);
            let mut all = Vec::new();
            let read = tokio::task::spawn_blocking(move || body.read_to_end(&mut all).map_err(|error| error.kind())).await.unwrap();
            assert_eq!(read, Err(io::ErrorKind::BrokenPipe));
        }
    }
}
