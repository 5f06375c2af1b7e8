//! A pipe from a request's body, which arrives asynchronously, to a reader that waits for data on a thread of its own.
//!
//! The request holds the writer. When the request ends early, for whatever reason (the body timed out, the client has
//! gone, the server stops), the writer is dropped with it, and every further read fails.

use axum::body::Bytes;
use std::io::{self, Read};
use tokio::sync::mpsc;

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

/// An empty pipe.
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
    use std::thread;

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
