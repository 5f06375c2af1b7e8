//! The process as Linux describes it: memory and open files, under the names that Prometheus' own libraries use.

use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, EncodeMetric};
use prometheus_client::metrics::MetricType;
use prometheus_client::metrics::gauge::ConstGauge;

/// Read anew at each scrape; what the system does not tell is left out.
#[derive(Debug)]
pub(super) struct Process;

impl Collector for Process {
    fn encode(&self, mut encoder: DescriptorEncoder) -> Result<(), std::fmt::Error> {
        let figures = [
            ("process_resident_memory_bytes", "Memory in RAM", status_kib("VmRSS:").map(|kib| kib * 1024)),
            ("process_peak_memory_bytes", "Most memory in RAM so far", status_kib("VmHWM:").map(|kib| kib * 1024)),
            ("process_open_fds", "Open files and sockets", open_files()),
        ];
        for (name, help, figure) in figures {
            if let Some(figure) = figure {
                ConstGauge::new(figure).encode(encoder.encode_descriptor(name, help, None, MetricType::Gauge)?)?;
            }
        }
        Ok(())
    }
}

/// A line of `/proc/self/status`, in KiB.
fn status_kib(name: &str) -> Option<i64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

fn open_files() -> Option<i64> {
    i64::try_from(std::fs::read_dir("/proc/self/fd").ok()?.count()).ok()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn memory_and_files_are_told() {
        assert!(status_kib("VmRSS:").unwrap() > 1000);
        assert!(status_kib("VmHWM:").unwrap() >= status_kib("VmRSS:").unwrap() / 2);
        assert!(open_files().unwrap() >= 3);
    }
}
