//! G-code: the words that people's controls have in common. What changes the geometry and is not followed is a fault.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use super::arc::{Arc, Centre};
use super::program_points::{Collected, ProgramFaultKind, ProgramPoint, Reached};
use std::collections::HashMap;

/// How axis words without another code move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Motion {
    Rapid,
    Straight,
    Clockwise,
    CounterClockwise,
}

/// G words, times ten, that leave the geometry as it is: look-ahead, polar coordinates off, compensation off, length
/// compensation, scaling, mirroring and shifts off, exact stop, corners and path control, rotation off, cycle off, return levels; Haas'
/// look-ahead, offsets and smoothness; Siemens' own language, offsets off, corners.
const SETTING_G: [i32; 27] = [
    80, 90, 150, 400, 430, 490, 500, 501, 610, 611, 620, 640, 690, 800, 921, 922, 970, 980, 990, 1030, 1540, 1870, 2900, 4500, 4510, 5000,
    6210,
];

/// M words, times ten, for spindle, coolant, stops, clamps, gears, overrides, pallets, chips and air; M17 ends a part program of
/// Siemens.
pub(super) const AUXILIARY_M: [i32; 37] = [
    0, 10, 30, 40, 50, 70, 80, 90, 100, 110, 120, 130, 140, 170, 190, 310, 330, 340, 350, 360, 400, 410, 420, 430, 440, 450, 480, 490, 500,
    510, 520, 530, 600, 830, 840, 880, 890,
];

/// What holds from block to block.
#[allow(clippy::struct_excessive_bools, reason = "each is a modal state of its own")]
pub(super) struct State {
    pub(super) motion: Option<Motion>,
    /// First, second and third axis of the arcs' plane.
    plane: [usize; 3],
    pub(super) millimetres: f64,
    absolute: bool,
    pub(super) absolute_centres: bool,
    pub(super) per_revolution: bool,
    pub(super) feed: Option<f64>,
    pub(super) spindle: Option<f64>,
    pub(super) tool: u32,
    next_tool: u32,
    /// Unknown axes are those that have not been moved to yet, or that a reference point moved away.
    pub(super) position: [Option<f64>; 3],
    pub(super) is_new: bool,
}

/// What one block asks for.
#[allow(clippy::struct_excessive_bools, reason = "each is a word of its own")]
#[derive(Default)]
pub(super) struct Block {
    pub(super) axes: [Option<f64>; 3],
    pub(super) centre: [Option<f64>; 3],
    pub(super) radius: Option<f64>,
    motion: Option<Motion>,
    /// Its axis words are for a reference point or machine coordinates.
    pub(super) reference: bool,
    /// Its axis words are parameters of a dwell or of the control's smoothing: nothing moves.
    parameters: bool,
    tool_change: bool,
    /// A word of it is refused: its other words may belong to that one.
    pub(super) refused: bool,
    first_of_arc: Option<Word>,
    /// LinuxCNC's number of turns of an arc.
    turns: Option<Word>,
}

pub(super) fn read(text: &str, sagitta: f64, collected: &mut Collected) {
    let mut state = State::new();
    let mut block = Vec::new();
    let mut variables = Variables::new();
    for (line, number) in text.lines().zip(1..) {
        words(line, number, &mut variables, collected, &mut block);
        if state.run(&block, number, sagitta, collected) || collected.is_full() {
            break;
        }
    }
}

impl State {
    /// Before the first block.
    pub(super) fn new() -> Self {
        Self {
            motion: None,
            plane: [0, 1, 2],
            millimetres: 1.0,
            absolute: true,
            absolute_centres: false,
            per_revolution: false,
            feed: None,
            spindle: None,
            tool: 0,
            next_tool: 0,
            position: [None; 3],
            is_new: true,
        }
    }

    /// Runs a block; true at the end of the program.
    fn run(&mut self, words: &[Word], line: u32, sagitta: f64, collected: &mut Collected) -> bool {
        let mut block = Block::default();
        let mut ends = false;
        let has = |letter: char| words.iter().any(|word| word.letter == letter);
        for word in words.iter().filter(|word| word.letter == 'G') {
            match word.tenths() {
                // Fanuc's smoothing, where LinuxCNC has splines: G5 P10000 and G5.1 Q1, there with axes as parameters.
                Some(50) if has('P') && !has('Q') => {}
                Some(51) if has('Q') => block.parameters = true,
                // A shift by zero ends an earlier one; others are refused, so that there is none.
                Some(520) if words.iter().all(|word| word.letter == 'G' || word.value == 0.0) => block.parameters = true,
                _ => self.g(*word, &mut block, line, collected),
            }
        }
        for word in words {
            match word.letter {
                _ if word.value.is_nan() && !block.reference => collected.fault(line, ProgramFaultKind::Macro, word.letter),
                'M' => ends |= Self::m(*word, &mut block, line, collected),
                'X' | 'Y' | 'Z' if !block.parameters => {
                    block.axes["XYZ".find(word.letter).unwrap_or(0)] = Some(word.value * self.millimetres);
                }
                'I' | 'J' | 'K' => {
                    block.first_of_arc.get_or_insert(*word);
                    block.centre["IJK".find(word.letter).unwrap_or(0)] = Some(word.value * self.millimetres);
                }
                'R' if !block.parameters => {
                    block.first_of_arc.get_or_insert(*word);
                    block.radius = Some(word.value * self.millimetres);
                }
                'F' => self.feed = Some(word.value * self.millimetres),
                'S' if !block.parameters => self.spindle = (word.value > 0.0).then_some(word.value),
                'T' if word.value >= 0.0 && word.value <= 1e6 => self.next_tool = word.value as u32,
                // Offset numbers, and the parameters of a dwell and of path control.
                'G' | 'H' | 'D' | 'Q' | 'R' | 'S' | 'E' => {}
                'P' => block.turns = Some(*word),
                'X' | 'Y' | 'Z' | 'U' if block.parameters => {}
                // A rotary axis that stays at zero, or goes home, turns nothing.
                'A' | 'B' | 'C' if word.value == 0.0 || word.value.is_nan() => {}
                'A' | 'B' | 'C' | 'U' | 'V' | 'W' => collected.fault(line, ProgramFaultKind::Axis, word.to_string()),
                // The parameters of a refused word need no fault of their own.
                _ if block.refused => {}
                _ => collected.fault(line, ProgramFaultKind::UnknownWord, word.to_string()),
            }
        }
        if block.tool_change {
            self.tool = self.next_tool;
            // Where the tool is changed is not told.
            self.is_new = true;
        }
        self.move_to(&block, line, sagitta, collected);
        ends
    }

    fn g(&mut self, word: Word, block: &mut Block, line: u32, collected: &mut Collected) {
        let motion = match word.tenths() {
            Some(0) => Some(Motion::Rapid),
            Some(10) => Some(Motion::Straight),
            Some(20) => Some(Motion::Clockwise),
            Some(30) => Some(Motion::CounterClockwise),
            _ => None,
        };
        if motion.is_some() {
            if block.motion.is_some() && block.motion != motion {
                collected.fault(line, ProgramFaultKind::Conflict, word.to_string());
            }
            (block.motion, self.motion) = (motion, motion);
            return;
        }
        let refused = match word.tenths() {
            Some(930) => ProgramFaultKind::InverseTimeFeed,
            Some(50..=53 | 60..=63) => ProgramFaultKind::Spline,
            Some(730 | 740 | 760 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890) => ProgramFaultKind::Cycle,
            Some(650 | 660 | 670) => ProgramFaultKind::Macro,
            Some(100 | 160 | 410..=421 | 431 | 432 | 434 | 440 | 510 | 511 | 520 | 680..=682 | 920 | 923) => {
                ProgramFaultKind::Transformation
            }
            known => {
                if self.set(known, block) {
                    return;
                }
                ProgramFaultKind::UnknownWord
            }
        };
        block.refused = true;
        collected.fault(line, refused, word.to_string());
    }

    /// Sets what a G word sets that is followed or leaves the geometry as it is; false if it is not known.
    fn set(&mut self, tenths: Option<i32>, block: &mut Block) -> bool {
        match tenths {
            Some(40) => block.parameters = true,
            Some(170) => self.plane = [0, 1, 2],
            Some(180) => self.plane = [2, 0, 1],
            Some(190) => self.plane = [1, 2, 0],
            Some(200 | 7000) => self.millimetres = 25.4,
            // Alone it says nothing about feeds: Siemens leaves them in the unit of the machine.
            Some(700) if self.millimetres > 1.0 => {}
            Some(210 | 710 | 7100) => self.millimetres = 1.0,
            Some(280 | 300 | 530 | 750 | 1530) => block.reference = true,
            Some(900) => self.absolute = true,
            Some(910) => self.absolute = false,
            Some(901) => self.absolute_centres = true,
            Some(911) => self.absolute_centres = false,
            Some(940) => self.per_revolution = false,
            Some(950) => self.per_revolution = true,
            // Work offsets; Siemens' offsets, exact stop and smoothing.
            Some(540..=593 | 5050..=5990 | 6010..=6030 | 6410..=6450) => {}
            known => return known.is_some_and(|tenths| SETTING_G.contains(&tenths)),
        }
        true
    }

    /// True at the end of the program.
    fn m(word: Word, block: &mut Block, line: u32, collected: &mut Collected) -> bool {
        match word.tenths() {
            Some(20 | 300) => return true,
            Some(60) => block.tool_change = true,
            Some(tenths) if AUXILIARY_M.contains(&tenths) => {}
            Some(970..=990) => collected.fault(line, ProgramFaultKind::Macro, word.to_string()),
            _ => collected.fault(line, ProgramFaultKind::UnknownWord, word.to_string()),
        }
        false
    }

    /// Moves as the block asks for.
    pub(super) fn move_to(&mut self, block: &Block, line: u32, sagitta: f64, collected: &mut Collected) {
        if block.parameters {
            return;
        }
        let moved = |axis: usize| block.axes[axis].is_some();
        if block.reference {
            // Without axis words all axes leave; the way over the stated point is a rapid to it, which is not followed.
            let all = !(0..3).any(moved);
            (0..3).filter(|axis| all || moved(*axis)).for_each(|axis| self.position[axis] = None);
            self.is_new = true;
            return;
        }
        let is_arc = matches!(self.motion, Some(Motion::Clockwise | Motion::CounterClockwise));
        if !((0..3).any(moved) || is_arc && block.first_of_arc.is_some()) {
            return;
        }
        if self.motion.is_none() && !block.refused {
            collected.fault(line, ProgramFaultKind::UnknownWord, "axes without G0, G1, G2 or G3,");
            return;
        }
        let before = self.position;
        for axis in 0..3 {
            if let Some(value) = block.axes[axis] {
                self.position[axis] = if self.absolute { Some(value) } else { self.position[axis].map(|at| at + value) };
            }
        }
        let Some(motion) = self.motion.filter(|_| !block.refused) else { return };
        let [Some(x), Some(y), Some(z)] = self.position else {
            if motion != Motion::Rapid {
                collected.fault(line, ProgramFaultKind::UnknownPosition, "the block");
            }
            return;
        };
        let end = [x, y, z];
        let start = match before {
            [Some(x), Some(y), Some(z)] if !self.is_new => Some([x, y, z]),
            _ => None,
        };
        let is_rapid = motion == Motion::Rapid;
        let Some(start) = start else {
            // The way to the first known point is not known, whatever moves there.
            if is_arc {
                collected.fault(line, ProgramFaultKind::UnknownPosition, "the block");
            }
            self.is_new = false;
            self.push(end, Reached::FromUnknown, line, collected);
            return;
        };
        if !is_arc {
            if let Some(word) = block.first_of_arc {
                collected.fault(line, ProgramFaultKind::Arc, word.to_string());
            }
            self.push(end, if is_rapid { Reached::Rapid } else { Reached::Feed }, line, collected);
            return;
        }
        if let Some(turns) = block.turns.filter(|turns| turns.value > 1.0) {
            collected.fault(line, ProgramFaultKind::Arc, turns.to_string());
            return;
        }
        let arc = Arc { axes: self.plane, start, end, clockwise: motion == Motion::Clockwise };
        let chords = self.centre(block, start).and_then(|centre| arc.chords(centre, sagitta));
        let Some(points) = chords else {
            collected.fault(
                line,
                ProgramFaultKind::Arc,
                block.first_of_arc.map_or_else(|| "the block".to_owned(), |word| word.to_string()),
            );
            return;
        };
        for point in points {
            self.push(point, Reached::Feed, line, collected);
        }
    }

    /// The arc's centre, if the block has one and words of the plane alone.
    fn centre(&self, block: &Block, start: [f64; 3]) -> Option<Centre> {
        let [first, second, third] = self.plane;
        if let Some(radius) = block.radius {
            return block.centre.iter().all(Option::is_none).then_some(Centre::Radius(radius));
        }
        let stated = block.centre[first].is_some() || block.centre[second].is_some();
        if !stated || block.centre[third].is_some_and(|value| value != 0.0) {
            return None;
        }
        let along = |axis: usize| {
            let value = block.centre[axis].unwrap_or(0.0);
            if self.absolute_centres { block.centre[axis] } else { Some(start[axis] + value) }
        };
        Some(Centre::At([along(first)?, along(second)?]))
    }

    fn push(&self, point: [f64; 3], reached: Reached, line: u32, collected: &mut Collected) {
        let mut feed_rate = self.feed.filter(|feed| *feed > 0.0);
        if self.per_revolution && reached == Reached::Feed {
            if self.spindle.is_none() && feed_rate.is_some() {
                collected.fault(line, ProgramFaultKind::FeedPerRevolution, "the block");
            }
            feed_rate = feed_rate.zip(self.spindle).map(|(feed, speed)| feed * speed);
        }
        let feed_rate = if reached == Reached::Feed { feed_rate } else { None };
        let feed_unit = self.millimetres * if self.per_revolution { self.spindle.unwrap_or(1.0) } else { 1.0 };
        collected.push(ProgramPoint { point, reached, feed_rate, line, tool: self.tool, spindle_speed: self.spindle, feed_unit });
    }
}

/// A letter with its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Word {
    pub(super) letter: char,
    pub(super) value: f64,
}

impl Word {
    /// The number times ten, for G and M words such as G90.1.
    pub(super) fn tenths(self) -> Option<i32> {
        let tenths = self.value * 10.0;
        ((tenths - tenths.round()).abs() < 1e-6 && (0.0..10_000.0).contains(&tenths)).then(|| tenths.round() as i32)
    }
}

impl std::fmt::Display for Word {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.letter, self.value)
    }
}

/// Siemens' variables that have a constant value, by their names in capitals: those that begin with `_`, and R parameters.
type Variables = HashMap<String, f64>;

/// The words of a line without comments, block skip and numbers of blocks and programs. A fault ends the line.
fn words(line: &str, number: u32, variables: &mut Variables, collected: &mut Collected, words: &mut Vec<Word>) {
    words.clear();
    let mut rest = line.trim();
    if rest.starts_with('%') {
        return;
    }
    rest = rest.strip_prefix('/').map_or(rest, |skip| skip.trim_start_matches(|c: char| c.is_ascii_digit()));
    loop {
        rest = rest.trim_start();
        let Some(first) = rest.chars().next() else { return };
        match first {
            ';' => return,
            '(' => {
                let Some(end) = rest.find(')') else {
                    collected.fault(number, ProgramFaultKind::Comment, rest);
                    return;
                };
                rest = &rest[end + 1..];
            }
            '#' | '[' | '=' => {
                collected.fault(number, ProgramFaultKind::Macro, rest);
                return;
            }
            letter if letter.is_ascii_alphabetic() || letter == '_' => match word_at_start(rest, variables) {
                Ok((word, length)) => {
                    words.extend(word.filter(|word| !matches!(word.letter, 'N' | 'O')));
                    rest = &rest[length..];
                }
                Err(kind) => {
                    collected.fault(number, kind, rest);
                    return;
                }
            },
            _ => {
                collected.fault(number, ProgramFaultKind::UnknownWord, rest);
                return;
            }
        }
    }
}

/// The word at the start of a text that begins with a letter, if it says something about the path, and its length.
fn word_at_start(text: &str, variables: &mut Variables) -> Result<(Option<Word>, usize), ProgramFaultKind> {
    let letter = text.as_bytes()[0].to_ascii_uppercase() as char;
    let after = text[1..].trim_start();
    // A program may have a name: O<PART>. With more behind it, it is LinuxCNC's call of a subprogram.
    if letter == 'O' && after.starts_with('<') && after.trim_end().ends_with('>') {
        return Ok((None, text.len()));
    }
    if after.starts_with(['#', '[', '<']) {
        return Err(ProgramFaultKind::Macro);
    }
    // Siemens has S1=8000 and M1=3 for its first spindle, and allows X=40 for X40.
    let after = if matches!(letter, 'S' | 'M') { after.strip_prefix("1=").unwrap_or(after) } else { after };
    let after = after.strip_prefix('=').map_or(after, str::trim_start);
    match number_at_start(after) {
        (Some(_), length) if letter == 'R' && after[length..].trim_start().starts_with('=') => {
            named(text, variables).ok_or(ProgramFaultKind::Macro)
        }
        (Some(value), length) => Ok((Some(Word { letter, value }), text.len() - after.len() + length)),
        (None, _) => named(text, variables).ok_or_else(|| kind_of_text(text)),
    }
}

/// Siemens' names of what sets how exactly the control follows the path, defines a variable, or is for the operator.
const NAMES: &str = "ACTBLOCNO ADIS ADISPOS BRISK CDOF CFC CFIN CFTCP COMPCAD COMPCURV COMPOF COMPON COMPSURF CP CTOL CUT2D CUTCONOF CYCLE832 \
    DIAMOF DISPLOF DISPLON DYNFINISH DYNNORM DYNPOS DYNPREC DYNROUGH DYNSEMIFIN FFWOF FFWON FGROUP FIFOCTRL FLIN FNORM \
    GROUP_BEGIN GROUP_END KONT LIMS MSG NORM ORIAXES ORIMKS ORISOF ORIVECT ORIWKS OTOL RET SBLOF SBLON SETMS SOFT SPATH SPOS \
    STARTFIFO STOPFIFO STOPRE TRAFOOF UPATH WALIMOF WALIMON WORKPIECE";

/// The word that a name at the start stands for, if any, and the length of the name with what belongs to it: arguments in
/// parentheses, or a value after `=`. `None` for other names.
fn named(text: &str, variables: &mut Variables) -> Option<(Option<Word>, usize)> {
    let variable_at_start =
        |text: &str| text.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect::<String>().to_ascii_uppercase();
    let name = variable_at_start(text).len();
    let behind = text[name..].trim_start();
    let code = behind.split(';').next().unwrap_or_default();
    let is_zero = |word: &str| word.get(1..).is_some_and(|value| value.trim_start_matches('=').parse() == Ok(0.0));
    let value = behind.strip_prefix('=').map(str::trim_start);
    let is_name = |known: &str| NAMES.split(' ').any(|name| name == known);
    let is_variable = |known: &str| known.starts_with('_') || known.starts_with('R') && known[1..].parse::<u32>().is_ok();
    let with = |behind: &str, length: usize| text.len() - behind.len() + length;
    match (text[..name].to_ascii_uppercase().as_str(), value) {
        // A tool by its name has no number.
        ("T", Some(value)) if value.starts_with('"') => {
            Some((Some(Word { letter: 'T', value: 0.0 }), with(value, value[1..].find('"')? + 2)))
        }
        ("CR", Some(value)) => {
            let (radius, length) = number_at_start(value);
            Some((Some(Word { letter: 'R', value: radius? }), with(value, length)))
        }
        ("SUPA", None) => Some((Some(Word { letter: 'G', value: 53.0 }), name)),
        ("DEF", None) => Some((None, text.len())),
        // Without arguments, or by zero, they end what they began.
        ("SCALE" | "MIRROR", None) if code.is_empty() => Some((None, text.len())),
        ("TRANS" | "ROT", None) if code.split_whitespace().all(is_zero) => Some((None, text.len())),
        ("CYCLE800", None) => {
            let (arguments, _) = behind.strip_prefix('(')?.split_once(')')?;
            // Shift, angles, and shift after the turn.
            let neutral = arguments.split(',').skip(4).take(9).all(|value| value.trim().is_empty() || value.trim().parse() == Ok(0.0));
            neutral.then_some((None, with(behind, arguments.len() + 2)))
        }
        // NaN if the value is unknown. For rotary axes too: a variable moves them home in machine coordinates, and is a fault elsewhere.
        (letter, Some(value)) if letter.len() == 1 && is_variable(&variable_at_start(value)) => {
            let name = variable_at_start(value);
            let constant = variables.get(&name).copied().filter(|_| !matches!(letter, "A" | "B" | "C")).unwrap_or(f64::NAN);
            Some((Some(Word { letter: letter.chars().next()?, value: constant }), with(value, name.len())))
        }
        (known, Some(value)) if is_variable(known) => {
            let (constant, length) = number_at_start(value);
            variables.insert(known.to_owned(), constant?);
            Some((None, with(value, length)))
        }
        (known, Some(value)) if is_name(known) => Some((None, with(value, number_at_start(value).1))),
        (known, None) if is_name(known) => {
            let arguments = behind.starts_with('(').then(|| behind.find(')')).flatten();
            Some((None, arguments.map_or(name, |end| with(behind, end + 1))))
        }
        _ => None,
    }
}

/// The number at the start, and its length. Blanks between sign and digits are none.
fn number_at_start(text: &str) -> (Option<f64>, usize) {
    let bytes = text.as_bytes();
    let mut end = usize::from(bytes.first().is_some_and(|byte| matches!(byte, b'+' | b'-')));
    while bytes.get(end).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.') {
        end += 1;
    }
    let value = text[..end].parse::<f64>().ok().filter(|value| value.is_finite() && value.abs() <= 1e9);
    (value, end)
}

/// What a word without a number is.
fn kind_of_text(text: &str) -> ProgramFaultKind {
    let word: String = text.chars().take_while(char::is_ascii_alphabetic).collect::<String>().to_ascii_uppercase();
    match word.as_str() {
        "IF" | "WHILE" | "DO" | "GOTO" | "END" | "SUB" | "ENDSUB" | "CALL" | "REPEAT" | "FOR" | "DEF" | "PROC" => ProgramFaultKind::Macro,
        "TRANS" | "ROT" | "AROT" | "SCALE" | "MIRROR" | "ATRANS" => ProgramFaultKind::Transformation,
        _ if word.starts_with("CYCLE") => ProgramFaultKind::Cycle,
        _ if word.len() > 1 => ProgramFaultKind::UnknownWord,
        _ => ProgramFaultKind::Number,
    }
}
