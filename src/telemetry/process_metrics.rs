//! Metrics of the process, under the names of Prometheus' client libraries, read by the crate `procfs` at each scrape.
//! Metrics that the system does not provide are left out.

use procfs::process::{LimitValue, Process};
use procfs::{ProcResult, WithCurrentSystemInfo};
use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, EncodeMetric};
use prometheus_client::metrics::MetricType;
use prometheus_client::metrics::counter::ConstCounter;
use prometheus_client::metrics::gauge::ConstGauge;
use prometheus_client::registry::Unit;

/// The collector of this process's metrics.
#[derive(Debug)]
pub(crate) struct ProcessMetrics;

/// The values that Linux reports for the process.
#[derive(Debug)]
struct Figures {
    cpu_s: f64,
    resident_bytes: u64,
    virtual_bytes: u64,
    open_fds: u64,
    max_fds: Option<u64>,
    start_time_s: f64,
}

#[expect(clippy::cast_precision_loss, reason = "2^53 clock ticks are three million years")]
fn seconds(ticks: u64) -> f64 {
    ticks as f64 / procfs::ticks_per_second() as f64
}

impl Figures {
    fn read() -> ProcResult<Self> {
        let process = Process::myself()?;
        let stat = process.stat()?;
        let max_fds = match process.limits()?.max_open_files.soft_limit {
            LimitValue::Value(limit) => Some(limit),
            LimitValue::Unlimited => None,
        };
        #[expect(clippy::cast_precision_loss, reason = "seconds since 1970 need 31 bits")]
        let boot_time = procfs::boot_time_secs()? as f64;
        Ok(Self {
            cpu_s: seconds(stat.utime + stat.stime),
            resident_bytes: stat.rss_bytes().get(),
            virtual_bytes: stat.vsize,
            open_fds: process.fd_count()? as u64,
            max_fds,
            start_time_s: boot_time + seconds(stat.starttime),
        })
    }
}

impl Collector for ProcessMetrics {
    fn encode(&self, mut encoder: DescriptorEncoder) -> Result<(), std::fmt::Error> {
        let figures = match Figures::read() {
            Ok(figures) => figures,
            Err(error) => {
                tracing::debug!(%error, "the process metrics cannot be read");
                return Ok(());
            }
        };
        let cpu = encoder.encode_descriptor("process_cpu", "Processor time used", Some(&Unit::Seconds), MetricType::Counter)?;
        ConstCounter::new(figures.cpu_s).encode(cpu)?;
        let start = encoder.encode_descriptor("process_start_time", "Start, since 1970", Some(&Unit::Seconds), MetricType::Gauge)?;
        ConstGauge::new(figures.start_time_s).encode(start)?;
        let gauges = [
            ("process_resident_memory", "Memory in RAM", Some(Unit::Bytes), Some(figures.resident_bytes)),
            ("process_virtual_memory", "Address space", Some(Unit::Bytes), Some(figures.virtual_bytes)),
            ("process_open_fds", "Open files and sockets", None, Some(figures.open_fds)),
            ("process_max_fds", "Limit of open files and sockets", None, figures.max_fds),
        ];
        for (name, help, unit, figure) in gauges {
            if let Some(figure) = figure {
                ConstGauge::new(figure).encode(encoder.encode_descriptor(name, help, unit.as_ref(), MetricType::Gauge)?)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figures_are_those_of_a_running_process() {
        let figures = Figures::read().unwrap();
        assert!(figures.resident_bytes > 1_000_000 && figures.virtual_bytes > figures.resident_bytes);
        assert!(figures.open_fds >= 3 && figures.max_fds.is_none_or(|limit| limit >= figures.open_fds));
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs_f64();
        // The boot time is in whole seconds.
        assert!(figures.start_time_s < now + 1.0 && figures.start_time_s > now - 24.0 * 3600.0);
        // Each core adds a second of processor time in a second.
        let cores = f64::from(u32::try_from(std::thread::available_parallelism().unwrap().get()).unwrap());
        assert!(figures.cpu_s < cores * (now - figures.start_time_s + 1.0));
    }
}
