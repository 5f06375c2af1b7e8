//! Columns of coordinates: x, y, z in mm and, if there is a fourth, the feed rate in mm/min.

use super::collected::Collected;
use super::program_faults::ProgramFaultKind;
use super::program_points::{ProgramPoint, Reached};

pub(super) fn read(text: &str, collected: &mut Collected) {
    let mut is_first = true;
    for (line, number) in text.lines().zip(1_u32..) {
        if collected.is_full() {
            break;
        }
        let line = line.trim();
        if line.is_empty() || line.starts_with(['#', '/']) {
            continue;
        }
        let columns: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
        if is_first && columns.iter().take(3).map(|name| name.to_ascii_lowercase()).eq(["x", "y", "z"]) {
            continue;
        }
        let values: Vec<f64> = columns.iter().filter_map(|column| column.parse::<f64>().ok()).filter(|value| value.abs() <= 1e9).collect();
        if values.len() != columns.len() || !(3..=4).contains(&values.len()) {
            collected.fault(number, ProgramFaultKind::Number, line);
            continue;
        }
        let reached = if is_first { Reached::FromUnknown } else { Reached::Feed };
        let feed_rate = values.get(3).copied().filter(|feed| *feed > 0.0 && !is_first);
        let point = [values[0], values[1], values[2]];
        collected.push(ProgramPoint { point, reached, feed_rate, line: number, tool: 0, spindle_speed: None, feed_unit: 1.0 });
        is_first = false;
    }
}
