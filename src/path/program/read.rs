//! Reads a program in the dialect that its content shows.

use super::collected::Collected;
use super::program_faults::{ProgramFault, ProgramFaultKind};
use super::program_points::{Dialect, Program};
use super::{apt, csv_columns, gcode};

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
        Dialect::Columns => csv_columns::read(text, &mut collected),
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
