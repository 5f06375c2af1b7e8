//! APT and cutter location files: the statements that place the tool.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use super::arc::{Arc, Centre};
use super::program_points::{Collected, ProgramFaultKind, ProgramPoint, Reached};
use std::f64::consts::{PI, TAU};

/// The statements by which such a file is known.
pub(super) const STATEMENTS: [&str; 10] = ["PARTNO", "GOTO", "FEDRAT", "LOADTL", "UNITS", "MULTAX", "MACHIN", "CUTTER", "SPINDL", "TLDATA"];

/// Statements that say nothing about the path.
const SKIPPED: &str = "PARTNO PPRINT MACHIN CUTTER MULTAX COOLNT OUTTOL OUTOL INTOL TOLER END FINI REMARK INSERT STOP OPSTOP MODE \
    AUTOPS AUXFUN DELAY DISPLY DWELL END-OF-PATH OPSKIP PAINT REWIND SELECTL SELCTL SELECT SEQNO TDATA TLDATA TOOL TOOLNO TPRINT \
    CLAMP CLEARP CLRSRF FLUSH HEAD INTCOD LEADER LPRINT MAXDPM PIVOTZ POWER PREFUN PRINT PSIS SAFETY SET SLOWDN SWITCH";

/// A circle about a line along an axis.
struct Circle {
    axes: [usize; 3],
    clockwise: bool,
    centre: [f64; 2],
    radius: f64,
    /// The angle that is turned, where it is stated.
    sweep: Option<f64>,
    line: u32,
}

/// What holds from the statements so far.
struct Reader<'a> {
    collected: &'a mut Collected,
    sagitta: f64,
    millimetres: f64,
    unit_is_stated: bool,
    system: Option<String>,
    /// The circle on which the next GOTO ends.
    circle: Option<Circle>,
    /// The direction in which the next TLON begins.
    direction: Option<[f64; 3]>,
    last: Option<[f64; 3]>,
    feed: Option<f64>,
    spindle: Option<f64>,
    tool: u32,
    rapid: bool,
    is_new: bool,
}

pub(super) fn read(text: &str, sagitta: f64, collected: &mut Collected) {
    let mut reader = Reader {
        collected,
        sagitta,
        millimetres: 1.0,
        unit_is_stated: false,
        system: None,
        circle: None,
        direction: None,
        last: None,
        feed: None,
        spindle: None,
        tool: 0,
        rapid: false,
        is_new: true,
    };
    let mut lines = text.lines().zip(1_u32..);
    while let Some((line, number)) = lines.next().filter(|_| !reader.collected.is_full()) {
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
        if !statement.is_empty()
            && !is_comment
            && let Err(kind) = reader.statement(&statement, number)
        {
            reader.collected.fault(number, kind, statement);
        }
    }
    if let Some(circle) = reader.circle {
        reader.collected.fault(circle.line, ProgramFaultKind::Arc, "CIRCLE");
    }
}

impl Reader<'_> {
    fn statement(&mut self, statement: &str, line: u32) -> Result<(), ProgramFaultKind> {
        let (word, rest) = statement.split_once('/').unwrap_or((statement, ""));
        let word = word.split_whitespace().next().unwrap_or("");
        let arguments: Vec<&str> = rest.split(',').map(str::trim).collect();
        let numbers: Vec<f64> = arguments.iter().filter_map(|argument| number(argument)).collect();
        match word {
            "GOTO" | "FROM" | "GODLTA" => return self.go_to(word, &arguments, line),
            "RAPID" => self.rapid = true,
            "FEDRAT" => self.feed = Some(self.feed_rate(&arguments, &numbers)?),
            "SPINDL" => self.spindle = numbers.into_iter().find(|value| *value > 0.0).or(self.spindle),
            "UNITS" if rest.contains("INCH") => (self.millimetres, self.unit_is_stated) = (25.4, true),
            "UNITS" if rest.contains("MM") => (self.millimetres, self.unit_is_stated) = (1.0, true),
            // The coordinates are those of NX's machine coordinate system, as in the program of the control. A second one would
            // shift them.
            "MSYS" if self.system.as_ref().is_none_or(|first| first == rest) => self.system = Some(rest.to_owned()),
            "LOADTL" | "LOAD" | "TURRET" => {
                self.tool = numbers.first().filter(|value| (0.0..=1e6).contains(*value)).map_or(0, |value| *value as u32);
                self.is_new = true;
            }
            "GOHOME" => self.is_new = true,
            "TLAXIS" if is_tilted(&numbers) => return Err(ProgramFaultKind::Axis),
            "TLAXIS" => {}
            "CIRCLE" => self.circle = Some(Circle::new(&numbers, self.millimetres, line).ok_or(ProgramFaultKind::Arc)?),
            "MOVARC" => {
                let circle = Circle::new(&numbers, self.millimetres, line).ok_or(ProgramFaultKind::Arc)?;
                self.circle = Some(Circle { sweep: numbers.get(7).map(|sweep| sweep.to_radians()), ..circle });
            }
            "INDIRV" => self.direction = numbers.try_into().ok(),
            "TLON,GOFWD" => return self.along_circle(statement, line).ok_or(ProgramFaultKind::Arc),
            "CUTCOM" | "CYCLE" if rest.trim() == "OFF" => {}
            "CYCLE" => return Err(ProgramFaultKind::Cycle),
            "TRANS" | "ORIGIN" | "TRACUT" | "COPY" | "CUTCOM" | "MSYS" => return Err(ProgramFaultKind::Transformation),
            // Words of APT have no underscore: such a one is an event of the user's own post-processor.
            word if SKIPPED.split_whitespace().any(|skipped| skipped == word) || word.contains('_') => {}
            _ => return Err(ProgramFaultKind::UnknownWord),
        }
        Ok(())
    }

    fn go_to(&mut self, word: &str, arguments: &[&str], line: u32) -> Result<(), ProgramFaultKind> {
        let values: Option<Vec<f64>> = arguments.iter().map(|argument| number(argument)).collect();
        let Some([x, y, z, axis @ ..]) = values.as_deref() else { return Err(ProgramFaultKind::Number) };
        if is_tilted(axis) {
            return Err(ProgramFaultKind::Axis);
        }
        let mut point = [x, y, z].map(|value| value * self.millimetres);
        if word == "GODLTA" {
            let last = self.last.ok_or(ProgramFaultKind::Number)?;
            point = std::array::from_fn(|axis| last[axis] + point[axis]);
        }
        let reached = match (self.is_new || word == "FROM", self.rapid) {
            (true, _) => Reached::FromUnknown,
            (false, true) => Reached::Rapid,
            (false, false) => Reached::Feed,
        };
        match self.circle.take() {
            None => self.push(point, reached, line),
            Some(circle) if reached == Reached::Feed && self.arc(&circle, point).is_some() => {}
            Some(circle) => self.collected.fault(circle.line, ProgramFaultKind::Arc, "CIRCLE"),
        }
        // RAPID holds for one motion.
        (self.last, self.rapid, self.is_new) = (Some(point), false, false);
        Ok(())
    }

    fn push(&mut self, point: [f64; 3], reached: Reached, line: u32) {
        let feed_rate = if reached == Reached::Feed { self.feed } else { None };
        let (tool, spindle_speed, feed_unit) = (self.tool, self.spindle, self.millimetres);
        self.collected.push(ProgramPoint { point, reached, feed_rate, line, tool, spindle_speed, feed_unit });
    }

    /// The chords of the circle to its end. They are of the circle's line, so that a new feed rate is written before it.
    fn arc(&mut self, circle: &Circle, end: [f64; 3]) -> Option<()> {
        let points = circle.chords(self.last?, end, self.sagitta)?;
        for point in points {
            self.push(point, Reached::Feed, circle.line);
        }
        Some(())
    }

    /// CATIA's circles: INDIRV has the direction at the start, and TLON the circle about Z, or a cylinder about an axis, and the line or
    /// the points from the centre to the end.
    fn along_circle(&mut self, statement: &str, line: u32) -> Option<()> {
        let statement: String = statement.split_whitespace().collect();
        let group = |name: &str| -> Option<Vec<f64>> {
            let (_, rest) = statement.rsplit_once(&format!("({name}/"))?;
            rest.split_once(')')?.0.split(',').map(number).collect()
        };
        let (about, end) = match group("CIRCLE") {
            Some(circle) => {
                let [x, y, z, radius]: [f64; 4] = circle.try_into().ok()?;
                let [x_from, y_from, z_from, x_end, y_end, z_end]: [f64; 6] = group("LINE")?.try_into().ok()?;
                let is_from_centre = [x_from - x, y_from - y, z_from - z].iter().all(|off| off.abs() < 1e-3);
                (is_from_centre.then_some([x, y, z, 0.0, 0.0, 1.0, radius])?, [x_end, y_end, z_end])
            }
            None => (group("CYLNDR")?.try_into().ok()?, group("POINT")?.try_into().ok()?),
        };
        let (start, direction) = (self.last.filter(|_| !self.is_new && !self.rapid)?, self.direction.take()?);
        let mut circle = Circle::new(&about, self.millimetres, line)?;
        let [first, second, _] = circle.axes;
        let from = [start[first] - circle.centre[0], start[second] - circle.centre[1]];
        circle.clockwise = from[0] * direction[second] < from[1] * direction[first];
        let end = end.map(|value| value * self.millimetres);
        self.arc(&circle, end)?;
        self.last = Some(end);
        Some(())
    }

    /// In mm/min.
    fn feed_rate(&self, arguments: &[&str], numbers: &[f64]) -> Result<f64, ProgramFaultKind> {
        let value = numbers.iter().find(|value| **value > 0.0).ok_or(ProgramFaultKind::Number)?;
        if arguments.iter().any(|argument| matches!(*argument, "MMPR" | "IPR" | "PERREV")) {
            return self.spindle.map(|speed| value * self.millimetres * speed).ok_or(ProgramFaultKind::FeedPerRevolution);
        }
        match (arguments.contains(&"IPM"), self.unit_is_stated) {
            (false, _) => Ok(value * self.millimetres),
            (true, true) => Ok(value * 25.4),
            (true, false) => Err(ProgramFaultKind::UnknownUnit),
        }
    }
}

fn number(argument: &str) -> Option<f64> {
    argument.parse::<f64>().ok().filter(|value| value.abs() <= 1e9)
}

/// Whether a tool axis is stated that is not along Z, up.
fn is_tilted(axis: &[f64]) -> bool {
    !axis.is_empty() && !matches!(axis, [x, y, z] if x.abs() <= 1e-6 && y.abs() <= 1e-6 && *z > 0.0)
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
            sweep: None,
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
        if let Some(sweep) = self.sweep {
            // Some posts write the axis of a clockwise arc the wrong way round, which would turn the rest of the circle.
            let angle = |point: [f64; 3]| (point[second] - self.centre[1]).atan2(point[first] - self.centre[0]);
            let turned = if self.clockwise { angle(start) - angle(end) } else { angle(end) - angle(start) }.rem_euclid(TAU);
            let off = |turned: f64| ((turned - sweep + PI).rem_euclid(TAU) - PI).abs();
            if off(turned) > off(-turned) + 0.01 {
                return None;
            }
        }
        Arc { axes: self.axes, start, end, clockwise: self.clockwise }.chords(Centre::At(self.centre), sagitta)
    }
}

fn without_comment(line: &str) -> &str {
    line.split("$$").next().unwrap_or(line)
}
