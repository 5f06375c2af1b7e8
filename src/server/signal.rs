//! The signals that stop the server.

use std::io;

/// Ready at the first SIGTERM, SIGHUP or Ctrl-C. Later signals are ignored, because the grace limits the time to stop.
///
/// # Errors
/// The system cannot install the signal handlers.
#[cfg(unix)]
pub fn stop_signal() -> io::Result<impl Future<Output = &'static str>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut terminate, mut interrupt) = (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
    let mut hangup = signal(SignalKind::hangup())?;
    Ok(async move {
        tokio::select! {
            _ = terminate.recv() => "SIGTERM",
            _ = interrupt.recv() => "SIGINT",
            _ = hangup.recv() => "SIGHUP",
        }
    })
}

/// Ready at the first Ctrl-C.
///
/// # Errors
/// Never fails on this system; the type is that of Unix.
#[cfg(not(unix))]
pub fn stop_signal() -> io::Result<impl Future<Output = &'static str>> {
    Ok(async {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
        "Ctrl-C"
    })
}
