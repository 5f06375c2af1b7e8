//! Reads a program in the dialect that its content shows; and columns of coordinates, the simplest of the dialects.

use super::program_points::{Collected, Dialect, Program, ProgramFault, ProgramFaultKind, ProgramPoint, Reached};
use super::{apt, gcode};

/// How a program is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadSettings {
    /// The largest distance in mm between an arc and its chords.
    pub sagitta: f64,
    /// The most points; more are a fault.
    pub most_points: usize,
}

/// Reads a program. The dialect comes from its content.
///
/// # Errors
/// The first hundred faults, each with its line.
pub fn read(text: &str, settings: &ReadSettings) -> Result<Program, Vec<ProgramFault>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut collected = Collected::new(settings.most_points);
    let dialect = dialect(text);
    match dialect {
        Dialect::GCode => gcode::read(text, settings.sagitta, &mut collected),
        Dialect::Apt => apt::read(text, settings.sagitta, &mut collected),
        Dialect::Columns => read_columns(text, &mut collected),
    }
    if collected.faults.is_empty() && collected.points.is_empty() {
        collected.fault(1, ProgramFaultKind::Empty, "the program");
    }
    if collected.faults.is_empty() { Ok(Program { dialect, points: collected.points }) } else { Err(collected.faults) }
}

/// The dialect by the first line that tells.
fn dialect(text: &str) -> Dialect {
    for line in text.lines().map(str::trim).take(1000) {
        let upper: String = line.chars().take(40).collect::<String>().to_ascii_uppercase();
        let word: &str = upper.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or("");
        if apt::STATEMENTS.contains(&word) || upper.starts_with("$$") {
            return Dialect::Apt;
        }
        let columns: Vec<&str> = upper.split([',', ';', '\t']).map(str::trim).collect();
        if columns.len() >= 3 && (columns.iter().all(|column| column.parse::<f64>().is_ok()) || columns[..3] == ["X", "Y", "Z"]) {
            return Dialect::Columns;
        }
    }
    Dialect::GCode
}

/// Reads columns of coordinates: x, y, z in mm and, if there is a fourth, the feed rate in mm/min.
fn read_columns(text: &str, collected: &mut Collected) {
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
