//! What a program is read into, whatever its dialect: points of the tip.

use crate::path::{Move, MoveKind};

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
