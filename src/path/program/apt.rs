//! APT and cutter location files: the statements that place the tool.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use super::arc::{Arc, Centre};
use super::program_points::{Collected, ProgramFaultKind, ProgramPoint, Reached};

/// The statements by which such a file is known.
pub(super) const STATEMENTS: [&str; 10] = ["PARTNO", "GOTO", "FEDRAT", "LOADTL", "UNITS", "MULTAX", "MACHIN", "CUTTER", "SPINDL", "TLDATA"];

/// Statements that say nothing about the path.
const SKIPPED: &str = "PARTNO PPRINT MACHIN CUTTER MULTAX COOLNT OUTTOL INTOL TOLER END FINI REMARK INSERT STOP OPSTOP TLON MODE \
    AUTOPS AUXFUN DELAY DISPLY END-OF-PATH OPSKIP PAINT REWIND SELECTL SEQNO TDATA TLDATA TOOL TOOLNO TPRINT";

/// A circle about a line along an axis, on which the next GOTO ends.
struct Circle {
    axes: [usize; 3],
    clockwise: bool,
    centre: [f64; 2],
    radius: f64,
    line: u32,
}

pub(super) fn read(text: &str, sagitta: f64, collected: &mut Collected) {
    let mut circle: Option<Circle> = None;
    let mut last: Option<[f64; 3]> = None;
    let mut system: Option<String> = None;
    let mut unit_is_stated = false;
    let (mut millimetres, mut feed, mut spindle, mut tool, mut rapid, mut is_new) = (1.0, None, None, 0, false, true);
    let mut lines = text.lines().zip(1_u32..);
    while let Some((line, number)) = lines.next().filter(|_| !collected.is_full()) {
        // A statement goes on in the next line after a single $, and so does a comment.
        let is_comment = line.trim_start().starts_with("$$");
        let part = |line| if is_comment { line } else { without_comment(line) };
        let mut statement = part(line).trim_end().to_owned();
        while statement.ends_with('$') && !statement.ends_with("$$") {
            statement.pop();
            let Some((next, _)) = lines.next() else { break };
            statement.push_str(part(next).trim_end());
        }
        let statement = statement.trim().to_ascii_uppercase();
        if statement.is_empty() || is_comment {
            continue;
        }
        let (word, rest) = statement.split_once('/').unwrap_or((&statement, ""));
        let word = word.split_whitespace().next().unwrap_or("");
        let arguments: Vec<&str> = rest.split(',').map(str::trim).collect();
        let numbers = || arguments.iter().filter_map(|argument| argument.parse::<f64>().ok()).filter(|value| value.abs() <= 1e9);
        match word {
            "GOTO" | "FROM" => {
                let values: Vec<f64> = numbers().collect();
                let [x, y, z, axis @ ..] = &values[..] else {
                    collected.fault(number, ProgramFaultKind::Number, statement.clone());
                    continue;
                };
                if values.len() != arguments.len() {
                    collected.fault(number, ProgramFaultKind::Number, statement.clone());
                    continue;
                }
                if axis.len() == 3 && (axis[0].abs() > 1e-6 || axis[1].abs() > 1e-6 || axis[2] <= 0.0) {
                    collected.fault(number, ProgramFaultKind::Axis, statement.clone());
                    continue;
                }
                let reached = match (is_new || word == "FROM", rapid) {
                    (true, _) => Reached::FromUnknown,
                    (false, true) => Reached::Rapid,
                    (false, false) => Reached::Feed,
                };
                let feed_rate = if reached == Reached::Feed { feed } else { None };
                let point = [x, y, z].map(|value| value * millimetres);
                let stated = ProgramPoint { point, reached, feed_rate, line: number, tool, spindle_speed: spindle, feed_unit: millimetres };
                if let Some(circle) = circle.take() {
                    match last.filter(|_| reached == Reached::Feed).and_then(|start| circle.chords(start, point, sagitta)) {
                        Some(points) => points.into_iter().for_each(|point| collected.push(ProgramPoint { point, ..stated })),
                        None => collected.fault(circle.line, ProgramFaultKind::Arc, "CIRCLE"),
                    }
                } else {
                    collected.push(stated);
                }
                last = Some(point);
                // RAPID holds for one motion.
                (rapid, is_new) = (false, false);
            }
            "RAPID" => rapid = true,
            "FEDRAT" => match numbers().find(|value| *value > 0.0) {
                Some(value) if arguments.iter().any(|argument| matches!(*argument, "MMPR" | "IPR" | "PERREV")) => match spindle {
                    Some(speed) => feed = Some(value * millimetres * speed),
                    None => collected.fault(number, ProgramFaultKind::FeedPerRevolution, statement.clone()),
                },
                Some(_) if arguments.contains(&"IPM") && !unit_is_stated => {
                    collected.fault(number, ProgramFaultKind::UnknownUnit, statement.clone());
                }
                Some(value) => feed = Some(value * if arguments.contains(&"IPM") { 25.4 } else { millimetres }),
                None => collected.fault(number, ProgramFaultKind::Number, statement.clone()),
            },
            "SPINDL" => spindle = numbers().find(|value| *value > 0.0).or(spindle),
            "UNITS" if rest.contains("INCH") => (millimetres, unit_is_stated) = (25.4, true),
            "UNITS" if rest.contains("MM") => (millimetres, unit_is_stated) = (1.0, true),
            // The coordinates are those of NX's machine coordinate system, as in the program of the control. A second one would
            // shift them.
            "MSYS" if system.as_ref().is_none_or(|first| first == rest) => system = Some(rest.to_owned()),
            "CUTCOM" if rest.trim() == "OFF" => {}
            "LOADTL" | "LOAD" | "TURRET" => {
                tool = numbers().next().filter(|value| (0.0..=1e6).contains(value)).map_or(0, |value| value as u32);
                is_new = true;
            }
            "GOHOME" => is_new = true,
            "CIRCLE" => {
                let values: Vec<f64> = numbers().collect();
                circle = Circle::new(&values, millimetres, number);
                if circle.is_none() {
                    collected.fault(number, ProgramFaultKind::Arc, statement.clone());
                }
            }
            "CYCLE" => collected.fault(number, ProgramFaultKind::Cycle, statement.clone()),
            "TRANS" | "ORIGIN" | "TRACUT" | "COPY" | "CUTCOM" | "MSYS" => {
                collected.fault(number, ProgramFaultKind::Transformation, statement.clone());
            }
            word if SKIPPED.split(' ').any(|skipped| skipped == word) => {}
            _ => collected.fault(number, ProgramFaultKind::UnknownWord, statement.clone()),
        }
    }
    if let Some(circle) = circle {
        collected.fault(circle.line, ProgramFaultKind::Arc, "CIRCLE");
    }
}

impl Circle {
    /// CIRCLE/x, y, z, i, j, k, r: centre, axis and radius; the tool turns counter-clockwise about the axis. `None` if the axis
    /// is not along X, Y or Z, or if numbers are missing.
    fn new(values: &[f64], millimetres: f64, line: u32) -> Option<Self> {
        let [x, y, z, i, j, k, radius, ..] = *values else { return None };
        let along = [i, j, k];
        let third = (0..3).find(|axis| (along[*axis].abs() - 1.0).abs() < 1e-6)?;
        let axes = [(third + 1) % 3, (third + 2) % 3, third];
        let centre = [x, y, z].map(|value| value * millimetres);
        (radius > 0.0).then_some(Self {
            axes,
            clockwise: along[third] < 0.0,
            centre: [centre[axes[0]], centre[axes[1]]],
            radius: radius * millimetres,
            line,
        })
    }

    /// The chords' ends; `None` if the ends are not on the circle.
    fn chords(&self, start: [f64; 3], end: [f64; 3], sagitta: f64) -> Option<Vec<[f64; 3]>> {
        let [first, second, _] = self.axes;
        let radius = (start[first] - self.centre[0]).hypot(start[second] - self.centre[1]);
        if (radius - self.radius).abs() > 0.005 + 1e-3 * self.radius {
            return None;
        }
        Arc { axes: self.axes, start, end, clockwise: self.clockwise }.chords(Centre::At(self.centre), sagitta)
    }
}

fn without_comment(line: &str) -> &str {
    line.split("$$").next().unwrap_or(line)
}
