//! Reads a program in the dialect that its content shows; and columns of coordinates, the simplest of the dialects.

use super::program_points::{Collected, Dialect, Program, ProgramFault, ProgramFaultKind, ProgramPoint, Reached};
use super::{apt, gcode, klartext};

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
        Dialect::Klartext => klartext::read(text, settings.sagitta, &mut collected),
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
        if klartext::is_block(&upper) {
            return Dialect::Klartext;
        }
        let columns = fields(line);
        if columns.len() >= 3 && columns.iter().all(|column| column.parse::<f64>().is_ok()) || Columns::named(&columns).is_some() {
            return Dialect::Columns;
        }
    }
    Dialect::GCode
}

/// The column of the feed rate without a header.
pub(super) const UNNAMED_FEED: usize = 3;

/// The most columns of a table.
const MOST_COLUMNS: usize = 100;

/// The columns of a table that hold the path.
pub(super) struct Columns {
    axes: [usize; 3],
    pub(super) feed: Option<usize>,
    kind: Option<usize>,
    /// The most columns of a row.
    most: usize,
}

impl Columns {
    /// Without a header: x, y, z and, if there is a fourth, the feed rate.
    const UNNAMED: Self = Self { axes: [0, 1, 2], feed: Some(UNNAMED_FEED), kind: None, most: 4 };

    /// Those that a header names, with their unit or without; `None` without x, y and z.
    pub(super) fn named(header: &[&str]) -> Option<Self> {
        let find = |is: &dyn Fn(&str) -> bool| header.iter().position(|name| is(&name.to_ascii_lowercase()));
        let axis =
            |axis: char| find(&|name| name.strip_prefix(axis).is_some_and(|unit| ["", "_mm", " (mm)", "(mm)", " [mm]"].contains(&unit)));
        Some(Self {
            axes: [axis('x')?, axis('y')?, axis('z')?],
            feed: find(&|name| ["f", "feed", "feed_rate", "feed_rate_mm_min"].contains(&name)),
            kind: find(&|name| name == "move"),
            most: MOST_COLUMNS,
        })
    }

    /// The point of a row, its feed rate if it states one, and how it is reached; `None` if one of them cannot be read.
    fn read(&self, row: &[&str]) -> Option<([f64; 3], Option<f64>, Reached)> {
        let number = |field: &str| field.parse::<f64>().ok().filter(|value| value.abs() <= 1e9);
        let [x, y, z] = self.axes.map(|at| row.get(at).and_then(|field| number(field)));
        let feed = match self.feed.and_then(|at| row.get(at)) {
            Some(field) if !field.is_empty() => Some(number(field)?),
            _ => None,
        };
        let reached = match self.kind.map(|at| row.get(at).copied().unwrap_or_default()) {
            Some("rapid") => Reached::Rapid,
            None | Some("cut" | "link") => Reached::Feed,
            Some(_) => return None,
        };
        (row.len() <= self.most).then_some(([x?, y?, z?], feed.filter(|feed| *feed > 0.0), reached))
    }
}

/// The fields of a row, without blanks and quotes about them; of too many, one more than allowed.
pub(super) fn fields(row: &str) -> Vec<&str> {
    row.split([',', ';', '\t']).take(MOST_COLUMNS + 1).map(|field| field.trim().trim_matches('"')).collect()
}

/// Reads columns of coordinates in mm, with the feed rate in mm/min and the kind of the move where there are such columns.
fn read_columns(text: &str, collected: &mut Collected) {
    let mut columns = None;
    for (line, number) in text.lines().zip(1_u32..) {
        if collected.is_full() {
            break;
        }
        let line = line.trim();
        if line.is_empty() || line.starts_with(['#', '/']) {
            continue;
        }
        let row = fields(line);
        if columns.is_none() {
            columns = Columns::named(&row);
            if columns.is_some() {
                continue;
            }
        }
        let Some((point, feed_rate, reached)) = columns.get_or_insert(Columns::UNNAMED).read(&row) else {
            collected.fault(number, ProgramFaultKind::Number, line);
            continue;
        };
        let (reached, feed_rate) = match reached {
            _ if collected.points.is_empty() => (Reached::FromUnknown, None),
            Reached::Feed => (reached, feed_rate),
            _ => (reached, None),
        };
        collected.push(ProgramPoint { point, reached, feed_rate, line: number, tool: 0, spindle_speed: None, feed_unit: 1.0 });
    }
}
