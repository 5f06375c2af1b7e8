//! What a program is read into, whatever its dialect: points of the tip, and faults, each with its line.

use crate::path::{Move, MoveKind};
use std::fmt;

/// The dialects that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// G-code of LinuxCNC, Fanuc, Haas, GRBL and Siemens.
    GCode,
    /// Heidenhain's own language.
    Klartext,
    /// APT and cutter location files: GOTO, RAPID, FEDRAT.
    Apt,
    /// Columns x, y, z and, if there is a fourth, the feed rate in mm/min.
    Columns,
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
    /// The feed rate in mm/min of a feed word of 1 there: 25.4 in inches, the spindle's speed in feeds per revolution.
    pub feed_unit: f64,
}

/// A program as points in the order in which the tool gets to them.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// The dialect that was found.
    pub dialect: Dialect,
    /// The points.
    pub points: Vec<ProgramPoint>,
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

/// Why a program is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProgramFaultKind {
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
    /// Feeds in inches where no unit of the coordinates is stated.
    UnknownUnit,
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
    pub kind: ProgramFaultKind,
    /// The word or statement.
    pub word: String,
}

impl fmt::Display for ProgramFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self.kind {
            ProgramFaultKind::UnknownWord => "is not known",
            ProgramFaultKind::Number => "has no number that can be read",
            ProgramFaultKind::Macro => "is part of a macro or subprogram; expand the program first",
            ProgramFaultKind::Transformation => "changes the geometry and is not followed",
            ProgramFaultKind::Cycle => "is a fixed cycle, which is not followed",
            ProgramFaultKind::Spline => "is a spline, which is not followed",
            ProgramFaultKind::InverseTimeFeed => "asks for inverse time feed, which is not read",
            ProgramFaultKind::FeedPerRevolution => "states a feed per revolution, but no spindle speed is known",
            ProgramFaultKind::UnknownUnit => "is in inches, and no UNITS statement before it says what the coordinates are in",
            ProgramFaultKind::Axis => "moves an axis other than X, Y and Z",
            ProgramFaultKind::Arc => "is an arc whose centre or radius does not fit its ends",
            ProgramFaultKind::UnknownPosition => "cuts before X, Y and Z are all known",
            ProgramFaultKind::Conflict => "excludes another word of the block",
            ProgramFaultKind::Comment => "opens a comment that is not closed",
            ProgramFaultKind::TooManyPoints => "exceeds the number of points",
            ProgramFaultKind::Empty => "has no point of a path",
        };
        write!(f, "line {}: {} {reason}", self.line, self.word)
    }
}

/// The most faults that are kept.
const MOST_FAULTS: usize = 100;

/// The points and faults that a reader collects.
pub(super) struct Collected {
    pub(super) points: Vec<ProgramPoint>,
    pub(super) faults: Vec<ProgramFault>,
    pub(super) most_points: usize,
    is_full: bool,
}

impl Collected {
    /// Nothing yet; at most so many points.
    pub(super) fn new(most_points: usize) -> Self {
        Self { points: Vec::new(), faults: Vec::new(), most_points, is_full: false }
    }

    pub(super) fn fault(&mut self, line: u32, kind: ProgramFaultKind, word: impl Into<String>) {
        if self.faults.len() < MOST_FAULTS {
            let word: String = word.into().chars().take(40).collect();
            self.faults.push(ProgramFault { line, kind, word });
        }
    }

    /// Adds a point; past the limit it is a fault, once.
    pub(super) fn push(&mut self, point: ProgramPoint) {
        if self.points.len() < self.most_points {
            self.points.push(point);
        } else if !self.is_full {
            self.is_full = true;
            self.fault(point.line, ProgramFaultKind::TooManyPoints, "the path");
        }
    }

    /// Whether a point was refused: the rest need not be read. An arc in chords may have 10^5.
    pub(super) fn is_full(&self) -> bool {
        self.is_full
    }
}
