//! Klartext, Heidenhain's own language, for three axes: straight lines (L), circles about a pole (CC with C and CP) and of a radius
//! (CR), and parameters with constant values. What changes the geometry and is not followed is a fault.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use super::gcode::{AUXILIARY_M, Block, Motion, State};
use super::program_points::{Collected, ProgramFaultKind};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Beginnings of blocks, after the block number, that only Klartext has.
const BEGINNINGS: [&str; 13] =
    ["BEGIN PGM", "BLK FORM", "TOOL CALL", "TOOL DEF", "CYCL DEF", "L X", "L Y", "L Z", "L IX", "L IY", "L IZ", "CC X", "FN "];

/// M functions besides those of G-code that leave the path as it is: feeds, corners, look-ahead, rotary axes, the tool's point.
const FUNCTIONS: [i32; 32] = [
    6, 94, 97, 98, 101, 102, 103, 107, 108, 109, 110, 111, 114, 115, 116, 117, 118, 120, 124, 126, 127, 128, 129, 134, 135, 138, 141, 143,
    144, 145, 148, 149,
];

/// M functions with parameters: the words after them belong to the function.
const WITH_PARAMETERS: [i32; 6] = [103, 118, 120, 124, 128, 140];

/// The largest angle of CP in degrees, the control's own limit.
const LARGEST_ANGLE: f64 = 5400.0;

/// Whether a line in capitals can only be a block of Klartext.
pub(super) fn is_block(line: &str) -> bool {
    BEGINNINGS.iter().any(|beginning| without_number(line).starts_with(beginning))
}

/// A block without its number and the sign of a block that may be skipped.
fn without_number(block: &str) -> &str {
    block.trim_start_matches(|c: char| c.is_ascii_digit() || c == '/' || c.is_whitespace())
}

pub(super) fn read(text: &str, sagitta: f64, collected: &mut Collected) {
    let mut state = State::new();
    state.absolute_centres = true;
    let mut reader = Reader { state, unit: 1.0, pole: [None; 2], tool_feed: None, variables: HashMap::new(), line: 0, sagitta, collected };
    for (block, number) in text.lines().zip(1..) {
        reader.line = number;
        if reader.run(block) || reader.collected.is_full() {
            break;
        }
    }
}

struct Reader<'c> {
    /// Its unit is that of feeds; coordinates have `unit`.
    state: State,
    /// The unit of coordinates in mm.
    unit: f64,
    /// The centre of circles.
    pole: [Option<f64>; 2],
    /// The feed rate of the tool call.
    tool_feed: Option<f64>,
    /// The Q parameters whose values are known.
    variables: HashMap<u32, f64>,
    line: u32,
    sagitta: f64,
    collected: &'c mut Collected,
}

impl Reader<'_> {
    fn fault(&mut self, kind: ProgramFaultKind, word: &str) {
        self.collected.fault(self.line, kind, word);
    }

    /// Runs a block; true at the end of the program.
    fn run(&mut self, line: &str) -> bool {
        let block = line.split(';').next().unwrap_or_default().to_ascii_uppercase();
        let block = without_number(&block).trim_end_matches(|c: char| c == '~' || c.is_whitespace());
        let words: Vec<&str> = block.split_whitespace().collect();
        let Some((first, rest)) = words.split_first() else { return false };
        match (*first, rest.first().copied().unwrap_or_default()) {
            ("END", "PGM") => return true,
            ("BEGIN", "PGM") if rest.last() == Some(&"INCH") => {
                // Feeds are in tenths of an inch.
                (self.unit, self.state.millimetres) = (25.4, 2.54);
            }
            ("BEGIN" | "BLK" | "LBL" | "PRESET", _) | ("TOOL", "DEF") | ("PLANE" | "FUNCTION", "RESET") => {}
            ("FUNCTION", "TCPM" | "FEED" | "DWELL" | "S-PULSE") | ("TRANS", "DATUM") if rest.get(1) != Some(&"AXIS") => {}
            ("FUNCTION", "MODE") if rest.get(1) == Some(&"MILL") => {}
            ("TRANS", "DATUM") | ("PLANE", "SPATIAL") => self.expect_neutral(&rest[1..], 0.0),
            ("PLANE" | "TRANS", _) => self.fault(ProgramFaultKind::Transformation, block),
            ("TOOL", "CALL") => self.tool_call(block, &rest[1..]),
            // The position after a measuring cycle is unknown.
            ("TCH", "PROBE") => (self.state.position, self.state.is_new) = ([None; 3], true),
            ("CYCL", "DEF") => self.cycle(&rest[1..], block),
            ("CYCL", _) => self.fault(ProgramFaultKind::Cycle, block),
            ("CALL" | "SEL" | "IF", _) => self.fault(ProgramFaultKind::Macro, block),
            ("STOP", _) => return self.path(rest, None),
            ("CC", _) => self.pole(rest),
            ("L", _) => return self.path(rest, Some(Motion::Straight)),
            ("C" | "CR" | "CP", _) => return self.circle(first, rest),
            (word, _) if word.starts_with('*') => {}
            (word, _) if word.starts_with('Q') => self.assign(block),
            (word, _) if word.starts_with("FN") => self.function(&block[2..]),
            (word, _) if word.starts_with('M') => return self.path(&words, None),
            _ => self.fault(ProgramFaultKind::UnknownWord, block),
        }
        false
    }

    /// The number of a word, or the value of its parameter; a fault if there is none.
    fn value(&mut self, word: &str, number: &str) -> Option<f64> {
        let value = self.constant(number);
        if value.is_none() {
            self.fault(if number.contains('Q') { ProgramFaultKind::Macro } else { ProgramFaultKind::Number }, word);
        }
        value
    }

    fn constant(&self, number: &str) -> Option<f64> {
        let (sign, digits) = number.strip_prefix('-').map_or((1.0, number), |digits| (-1.0, digits));
        let digits = digits.strip_prefix('+').unwrap_or(digits);
        let value = match digits.strip_prefix('Q') {
            Some(index) => *self.variables.get(&index.parse().ok()?)?,
            None => digits.replace(',', ".").parse().ok()?,
        };
        (f64::abs(value) <= 1e9).then_some(sign * value)
    }

    /// Sets a parameter, as in `Q5 = +1200`. Its value is unknown if it is not a constant.
    fn assign(&mut self, assignment: &str) {
        let Some((name, value)) = assignment.split_once('=') else { return self.fault(ProgramFaultKind::Macro, assignment) };
        if let Some(index) = name.trim().strip_prefix('Q').and_then(|index| index.parse().ok()) {
            match self.constant(value.trim()) {
                Some(value) => self.variables.insert(index, value),
                None => self.variables.remove(&index),
            };
        }
    }

    /// A function FN: the assignment FN 0; a jump, which is a fault; others may set any parameter.
    fn function(&mut self, text: &str) {
        match text.split_once(':').map(|(number, rest)| (number.trim().parse::<u32>(), rest)) {
            Some((Ok(0), assignment)) => self.assign(assignment.trim()),
            Some((Ok(9..=12) | Err(_), _)) | None => self.fault(ProgramFaultKind::Macro, text),
            Some(_) => self.variables.clear(),
        }
    }

    fn tool_call(&mut self, block: &str, words: &[&str]) {
        // A tool by its name has no number.
        let behind_name = block.split_once('"').and_then(|(_, name)| name.split_once('"')).map(|(_, words)| words);
        let mut tool = behind_name.map(|_| 0);
        for word in behind_name.map_or_else(|| words.to_vec(), |words| words.split_whitespace().collect()) {
            let (name, number) = split(word);
            match name {
                "" => tool = self.value(word, number).filter(|tool| (0.0..1e6).contains(tool)).map(|tool| tool as u32),
                "S" => self.state.spindle = self.value(word, number).filter(|speed| *speed > 0.0),
                "F" => {
                    self.tool_feed = self.value(word, number).map(|feed| feed * self.state.millimetres);
                    self.state.feed = self.tool_feed;
                }
                // The tool's radius serves compensation alone.
                "Z" | "DR" => {}
                "DL" if self.constant(number) == Some(0.0) => {}
                "X" | "Y" | "DL" => self.fault(ProgramFaultKind::Transformation, word),
                _ => self.fault(ProgramFaultKind::UnknownWord, word),
            }
        }
        if let Some(tool) = tool {
            // The position after a tool change is unknown.
            (self.state.tool, self.state.is_new) = (tool, true);
        }
    }

    /// A cycle is a fault, but for those that end a transformation, and those for tolerance, dwell, spindle and preset.
    fn cycle(&mut self, words: &[&str], block: &str) {
        let Some((number, rest)) = words.split_first() else { return self.fault(ProgramFaultKind::Cycle, block) };
        match number.split_once('.').unwrap_or((number, "")) {
            ("9" | "13" | "32" | "247", _) | ("7" | "8" | "10" | "11" | "19" | "26", "0") => {}
            ("7" | "8" | "10" | "19", _) => self.expect_neutral(rest, 0.0),
            ("11" | "26", _) => self.expect_neutral(rest, 1.0),
            _ => self.fault(ProgramFaultKind::Cycle, block),
        }
    }

    /// Each value of a transformation must be the neutral one. A line of the datum table (`#3`) is a work offset, and accepted.
    fn expect_neutral(&mut self, words: &[&str], neutral: f64) {
        for word in words.iter().filter(|word| !word.starts_with('#')) {
            let (name, number) = split(word);
            let is_value = !number.is_empty() && !matches!(name, "F" | "MB" | "DIST" | "SEQ" | "SYM");
            let is_mirrored_axis = number.is_empty() && matches!(name, "X" | "Y" | "Z");
            if is_mirrored_axis || is_value && self.constant(number) != Some(neutral) {
                self.fault(ProgramFaultKind::Transformation, word);
            }
        }
    }

    fn pole(&mut self, words: &[&str]) {
        let at = [self.state.position[0], self.state.position[1]];
        if words.is_empty() {
            self.pole = at;
        }
        for word in words {
            let (name, number) = split(word);
            let Some(value) = self.value(word, number).map(|value| value * self.unit) else { continue };
            match name {
                "X" => self.pole[0] = Some(value),
                "Y" => self.pole[1] = Some(value),
                "IX" => self.pole[0] = at[0].map(|at| at + value),
                "IY" => self.pole[1] = at[1].map(|at| at + value),
                _ => self.fault(ProgramFaultKind::Arc, word),
            }
        }
    }

    /// A block that moves as stated, unless it is a rapid; true at the end of the program.
    fn path(&mut self, words: &[&str], motion: Option<Motion>) -> bool {
        let (block, ends) = self.block(words, motion);
        self.state.move_to(&block, self.line, self.sagitta, self.collected);
        ends
    }

    /// The words of a block, and whether it ends the program.
    fn block(&mut self, words: &[&str], motion: Option<Motion>) -> (Block, bool) {
        let mut block = Block::default();
        let (mut ends, mut of_function) = (false, false);
        self.state.motion = motion.or(self.state.motion);
        for word in words {
            let (name, number) = split(word);
            of_function &= name != "M";
            match (name, number) {
                _ if of_function => {}
                ("X" | "Y" | "Z" | "IX" | "IY" | "IZ", _) => {
                    let axis = "XYZ".find(&name[name.len() - 1..]).unwrap_or(0);
                    let from = if name.len() > 1 { self.state.position[axis] } else { Some(0.0) };
                    let value = self.value(word, number);
                    block.refused |= value.is_none();
                    if from.is_none() {
                        self.fault(ProgramFaultKind::UnknownPosition, word);
                    }
                    block.axes[axis] = from.zip(value).map(|(from, value)| from + value * self.unit);
                }
                ("F" | "M", "") | ("R", "0" | "") => {}
                // The feed rate may be a parameter behind a blank.
                ("F" | "Q", _) => {
                    let number = if name == "Q" { word } else { number };
                    self.state.feed = self.value(word, number).map(|feed| feed * self.state.millimetres);
                }
                ("FAUTO" | "AUTO", "") => self.state.feed = self.tool_feed,
                ("FMAX" | "MAX", "") => self.state.motion = Some(Motion::Rapid),
                ("R", _) if motion.is_some_and(|motion| motion != Motion::Straight) => {
                    block.radius = self.value(word, number).map(|radius| radius * self.unit);
                }
                ("RL" | "RR" | "R", _) => self.fault(ProgramFaultKind::Transformation, word),
                // Read with the circle.
                ("DR" | "IPA" | "PA", _) if motion.is_some_and(|motion| motion != Motion::Straight) => {}
                ("A" | "B" | "C", _) if self.constant(number) == Some(0.0) => {}
                ("A" | "B" | "C" | "IA" | "IB" | "IC" | "U" | "V" | "W", _) => self.fault(ProgramFaultKind::Axis, word),
                ("M", _) => {
                    let function =
                        self.value(word, number).filter(|number| (0.0..1000.0).contains(number)).map_or(-1, |number| number as i32);
                    of_function = WITH_PARAMETERS.contains(&function);
                    match function {
                        2 | 30 => ends = true,
                        89 | 99 => self.fault(ProgramFaultKind::Cycle, word),
                        91 | 92 => block.reference = true,
                        136 => self.state.per_revolution = true,
                        137 => self.state.per_revolution = false,
                        // Retracts along the tool axis to an unknown height.
                        140 => (self.state.position[2], self.state.is_new) = (None, true),
                        known if FUNCTIONS.contains(&known) || AUXILIARY_M.contains(&(10 * known)) => {}
                        _ => self.fault(ProgramFaultKind::UnknownWord, word),
                    }
                }
                _ => self.fault(ProgramFaultKind::UnknownWord, word),
            }
        }
        block.reference &= block.axes.iter().any(Option::is_some);
        (block, ends)
    }

    /// C: about the pole to a point; CP: about the pole by an angle, with any number of turns; CR: of a radius to a point.
    fn circle(&mut self, kind: &str, words: &[&str]) -> bool {
        let number_of = |wanted: &str| words.iter().map(|word| split(word)).find(|(name, _)| *name == wanted).map(|(_, number)| number);
        let sign = match number_of("DR") {
            Some("+") => 1.0,
            Some("-") => -1.0,
            _ => {
                self.fault(ProgramFaultKind::Arc, kind);
                return false;
            }
        };
        let motion = if sign > 0.0 { Motion::CounterClockwise } else { Motion::Clockwise };
        let (mut block, ends) = self.block(words, Some(motion));
        let ([Some(x), Some(y), Some(z)], [pole_x, pole_y]) = (self.state.position, self.pole) else {
            self.fault(ProgramFaultKind::UnknownPosition, kind);
            return ends;
        };
        block.centre = if kind == "CR" { [None; 3] } else { [pole_x, pole_y, None] };
        if kind != "CP" {
            self.state.move_to(&block, self.line, self.sagitta, self.collected);
            return ends;
        }
        let degrees = number_of("IPA").and_then(|angle| self.constant(angle));
        let degrees = degrees.filter(|degrees| degrees * sign > 0.0 && degrees.abs() <= LARGEST_ANGLE);
        let (Some(sweep), [Some(pole_x), Some(pole_y)]) = (degrees.map(f64::to_radians), self.pole) else {
            self.fault(ProgramFaultKind::Arc, kind);
            return ends;
        };
        let (radius, start) = ((x - pole_x).hypot(y - pole_y), (y - pole_y).atan2(x - pole_x));
        let rise = block.axes[2].map_or(0.0, |end| end - z);
        // Arcs of at most half a turn: their ends and their direction define them.
        let parts = (sweep.abs() / PI).ceil();
        for part in 1..=parts as u32 {
            let share = f64::from(part) / parts;
            let (sin, cos) = (start + share * sweep).sin_cos();
            block.axes = [Some(pole_x + radius * cos), Some(pole_y + radius * sin), Some(z + share * rise)];
            self.state.move_to(&block, self.line, self.sagitta, self.collected);
        }
        ends
    }
}

/// The letters and the number of a word; a parameter is a number: `F` and `Q50` of `FQ50`.
fn split(word: &str) -> (&str, &str) {
    let letters = word.bytes().take_while(u8::is_ascii_alphabetic).count();
    let has_parameter = letters > 1 && word[letters - 1..].starts_with('Q') && word[letters..].starts_with(|c: char| c.is_ascii_digit());
    word.split_at(if has_parameter { letters - 1 } else { letters })
}
