//! The queue of log lines, which a separate thread writes to standard output. If the reader of the log is slow, lines
//! are lost, but no answer is delayed. One write has the lines of many requests.

use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tracing_subscriber::fmt::MakeWriter;

use crate::priority;

/// How long lines are gathered before they are written.
const GATHERING: Duration = Duration::from_millis(10);

/// The longest time that `stop` waits for the reader of the log.
const LAST_WRITE: Duration = Duration::from_secs(2);

/// The largest number of bytes in the queue, some thousand lines. Further lines are lost; their number is logged when
/// writing continues.
const MOST_WAITING: usize = 1 << 20;

/// The queue. Clones share it.
#[derive(Debug, Clone, Default)]
pub(super) struct Lines {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<Waiting>,
    news: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    bytes: Vec<u8>,
    lost: usize,
    over: bool,
}

impl Lines {
    /// Starts a thread that writes lines to `output` until [`stop`](Self::stop) is called and the queue is empty.
    ///
    /// # Errors
    /// The system cannot start the thread.
    pub(super) fn write_to(&self, mut output: impl Write + Send + 'static) -> io::Result<JoinHandle<()>> {
        let lines = self.clone();
        let write = move || {
            // Requests take precedence if there are few cores: a write takes as long as several requests.
            priority::lower();
            while lines.write_some(&mut output) {}
        };
        std::thread::Builder::new().name("log".to_owned()).spawn(write)
    }

    /// Marks the queue as complete.
    fn finish(&self) {
        self.waiting().over = true;
        self.shared.news.notify_one();
    }

    /// Waits until `writer` has written all lines, but at most [`LAST_WRITE`].
    pub(super) fn stop(&self, writer: &JoinHandle<()>) {
        self.finish();
        let deadline = Instant::now() + LAST_WRITE;
        while !writer.is_finished() && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Writes the queued lines; false if the queue is finished and empty. Lines that standard output refuses are lost,
    /// because there is no other place to report them.
    fn write_some(&self, output: &mut impl Write) -> bool {
        let idle = |waiting: &mut Waiting| waiting.bytes.is_empty() && waiting.lost == 0 && !waiting.over;
        let waiting = self.shared.news.wait_while(self.waiting(), idle).unwrap_or_else(PoisonError::into_inner);
        let over = waiting.over;
        drop(waiting);
        if !over {
            std::thread::sleep(GATHERING);
        }
        let mut waiting = self.waiting();
        let bytes = std::mem::take(&mut waiting.bytes);
        let lost = std::mem::take(&mut waiting.lost);
        drop(waiting);
        let _ = output.write_all(&bytes).and_then(|()| output.flush());
        if lost > 0 {
            tracing::warn!(lines = lost, "log lines were lost: the reader of the log is too slow");
        }
        !(over && bytes.is_empty() && lost == 0)
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.shared.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Each call of `write` has one whole line.
impl Write for Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let mut waiting = self.waiting();
        if waiting.bytes.len() + line.len() > MOST_WAITING {
            waiting.lost += 1;
            return Ok(line.len());
        }
        let first = waiting.bytes.is_empty();
        waiting.bytes.extend_from_slice(line);
        drop(waiting);
        if first {
            self.shared.news.notify_one();
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl MakeWriter<'_> for Lines {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    /// A writer that forwards its bytes and blocks until the test releases each write.
    struct Slow {
        written: mpsc::Sender<Vec<u8>>,
        go_on: mpsc::Receiver<()>,
    }

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.written.send(bytes.to_vec()).unwrap();
            // The sender is dropped when the test has released all writes.
            let _ = self.go_on.recv();
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn numbered(count: usize) -> Vec<u8> {
        (0..count).flat_map(|number| format!("line {number}\n").into_bytes()).collect()
    }

    #[test]
    fn all_lines_are_written_in_order_before_the_end() {
        let (written, come) = mpsc::channel();
        let (release, go_on) = mpsc::channel::<()>();
        let mut lines = Lines::default();
        let thread = lines.write_to(Slow { written, go_on }).unwrap();
        for number in 0..1000 {
            writeln!(lines, "line {number}").unwrap();
        }
        lines.finish();
        drop(release);
        thread.join().unwrap();
        assert_eq!(come.into_iter().flatten().collect::<Vec<_>>(), numbered(1000));
    }

    #[test]
    fn a_stuck_reader_blocks_no_writer_and_loses_whole_lines() {
        let (written, come) = mpsc::channel();
        let (release, go_on) = mpsc::channel::<()>();
        let mut lines = Lines::default();
        let thread = lines.write_to(Slow { written, go_on }).unwrap();
        lines.write_all(b"first\n").unwrap();
        assert_eq!(come.recv().unwrap(), b"first\n");
        let line = [b'x'; 1000];
        for _ in 0..2 * MOST_WAITING / line.len() {
            lines.write_all(&line).unwrap();
        }
        assert_eq!(lines.waiting().lost, 2 * MOST_WAITING / line.len() - MOST_WAITING / line.len());
        let began = Instant::now();
        lines.stop(&thread);
        assert!(began.elapsed() >= LAST_WRITE && !thread.is_finished());
        drop(release);
        thread.join().unwrap();
        assert_eq!(come.into_iter().map(|bytes| bytes.len()).sum::<usize>(), MOST_WAITING / line.len() * line.len());
    }
}
