//! What a program is read into, whatever its dialect.

use super::{apt, columns, gcode};
use crate::path::{Move, MoveKind};
use std::fmt;

/// The most faults that are kept.
const MOST_FAULTS: usize = 100;

/// The dialects that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// G-code of LinuxCNC, Fanuc, Haas, GRBL, and Siemens in ISO mode.
    GCode,
    /// APT and cutter location files: GOTO, RAPID, FEDRAT.
    Apt,
    /// Columns x, y, z and, if there is a fourth, the feed rate in mm/min.
    Columns,
}

/// How a program is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadSettings {
    /// The largest distance in mm between an arc and its chords.
    pub sagitta: f64,
    /// The most points; more are a fault.
    pub most_points: usize,
}

/// How the tool gets to a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reached {
    /// From a place that the program does not tell: the path begins, or begins anew, here.
    FromUnknown,
    /// At the rapid rate.
    Rapid,
    /// At the feed rate.
    Feed,
}

/// A point of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgramPoint {
    /// In mm.
    pub point: [f64; 3],
    /// How the tool gets there.
    pub reached: Reached,
    /// The feed rate in mm/min, if the program states it.
    pub feed_rate: Option<f64>,
    /// The line of the program, from 1.
    pub line: u32,
    /// The number of the tool; 0 before a tool is called.
    pub tool: u32,
    /// The speed of the spindle in rpm, if the program states it.
    pub spindle_speed: Option<f64>,
}

/// A program as points in the order in which the tool gets to them.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// The dialect that was found.
    pub dialect: Dialect,
    /// The points.
    pub points: Vec<ProgramPoint>,
}

/// Why a program is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// A word or statement that is not known.
    UnknownWord,
    /// A number is missing after a letter, or is not a number.
    Number,
    /// Variables, expressions, loops and calls of subprograms.
    Macro,
    /// A word that changes the geometry in a way that is not followed: cutter compensation, rotation, scaling, polar
    /// coordinates, shifts of the origin.
    Transformation,
    /// A drilling or another fixed cycle.
    Cycle,
    /// A spline.
    Spline,
    /// Feed rates as inverse time.
    InverseTimeFeed,
    /// Feed per revolution without a spindle speed.
    FeedPerRevolution,
    /// A motion of the rotary or secondary linear axes A, B, C, U, V, W.
    Axis,
    /// An arc whose centre or radius does not fit its ends, or has none.
    Arc,
    /// A move at the feed rate before all coordinates are known.
    UnknownPosition,
    /// Two words of one block exclude each other.
    Conflict,
    /// A comment that is not closed.
    Comment,
    /// A program in Heidenhain's own language.
    Heidenhain,
    /// More points than allowed.
    TooManyPoints,
    /// There is no point.
    Empty,
}

/// A fault of a program, with its line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramFault {
    /// The line, from 1.
    pub line: u32,
    /// The reason.
    pub kind: FaultKind,
    /// The word or statement.
    pub word: String,
}

impl fmt::Display for ProgramFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self.kind {
            FaultKind::UnknownWord => "is not known",
            FaultKind::Number => "has no number that can be read",
            FaultKind::Macro => "is part of a macro or subprogram; expand the program first",
            FaultKind::Transformation => "changes the geometry and is not followed",
            FaultKind::Cycle => "is a fixed cycle, which is not followed",
            FaultKind::Spline => "is a spline, which is not followed",
            FaultKind::InverseTimeFeed => "asks for inverse time feed, which is not read",
            FaultKind::FeedPerRevolution => "states a feed per revolution, but no spindle speed is known",
            FaultKind::Axis => "moves an axis other than X, Y and Z",
            FaultKind::Arc => "is an arc whose centre or radius does not fit its ends",
            FaultKind::UnknownPosition => "cuts before X, Y and Z are all known",
            FaultKind::Conflict => "excludes another word of the block",
            FaultKind::Comment => "opens a comment that is not closed",
            FaultKind::Heidenhain => "is Heidenhain's own language; only ISO programs are read",
            FaultKind::TooManyPoints => "exceeds the number of points",
            FaultKind::Empty => "has no point of a path",
        };
        write!(f, "line {}: {} {reason}", self.line, self.word)
    }
}

/// The points and faults that a reader collects.
pub(super) struct Collected {
    pub(super) points: Vec<ProgramPoint>,
    faults: Vec<ProgramFault>,
    most_points: usize,
}

impl Collected {
    pub(super) fn fault(&mut self, line: u32, kind: FaultKind, word: impl Into<String>) {
        if self.faults.len() < MOST_FAULTS {
            let word: String = word.into().chars().take(40).collect();
            self.faults.push(ProgramFault { line, kind, word });
        }
    }

    /// Adds a point; past the limit it is a fault, once.
    pub(super) fn push(&mut self, point: ProgramPoint) {
        if self.points.len() < self.most_points {
            self.points.push(point);
        } else if self.faults.last().is_none_or(|fault| fault.kind != FaultKind::TooManyPoints) {
            self.fault(point.line, FaultKind::TooManyPoints, "the path");
        }
    }
}

/// Reads a program. The dialect comes from its content.
///
/// # Errors
/// The first hundred faults, each with its line.
pub fn read(text: &str, settings: &ReadSettings) -> Result<Program, Vec<ProgramFault>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut collected = Collected { points: Vec::new(), faults: Vec::new(), most_points: settings.most_points };
    let dialect = dialect(text);
    match dialect {
        Dialect::GCode => gcode::read(text, settings.sagitta, &mut collected),
        Dialect::Apt => apt::read(text, &mut collected),
        Dialect::Columns => columns::read(text, &mut collected),
    }
    if collected.faults.is_empty() && collected.points.is_empty() {
        collected.fault(1, FaultKind::Empty, "the program");
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

impl Program {
    /// The moves between the points, and for each the index of the point to which it leads.
    #[must_use]
    pub fn moves(&self) -> (Vec<Move>, Vec<usize>) {
        self.points
            .windows(2)
            .enumerate()
            .filter_map(|(at, ends)| {
                let kind = match ends[1].reached {
                    Reached::FromUnknown => return None,
                    Reached::Rapid => MoveKind::Rapid,
                    Reached::Feed => MoveKind::Cut,
                };
                Some((Move { from: ends[0].point, to: ends[1].point, kind }, at + 1))
            })
            .unzip()
    }
}
