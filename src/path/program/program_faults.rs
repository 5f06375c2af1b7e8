//! Faults of programs, each with its line.

use std::fmt;

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
            ProgramFaultKind::Axis => "moves an axis other than X, Y and Z",
            ProgramFaultKind::Arc => "is an arc whose centre or radius does not fit its ends",
            ProgramFaultKind::UnknownPosition => "cuts before X, Y and Z are all known",
            ProgramFaultKind::Conflict => "excludes another word of the block",
            ProgramFaultKind::Comment => "opens a comment that is not closed",
            ProgramFaultKind::Heidenhain => "is Heidenhain's own language; only ISO programs are read",
            ProgramFaultKind::TooManyPoints => "exceeds the number of points",
            ProgramFaultKind::Empty => "has no point of a path",
        };
        write!(f, "line {}: {} {reason}", self.line, self.word)
    }
}
