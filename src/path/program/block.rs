//! A block of G-code as words.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use super::collected::Collected;
use super::program_faults::ProgramFaultKind;

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

/// The words of a line without comments, block skip and numbers of blocks and programs. A fault ends the line.
pub(super) fn words(line: &str, number: u32, collected: &mut Collected, words: &mut Vec<Word>) {
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
            '#' | '[' => {
                collected.fault(number, ProgramFaultKind::Macro, rest);
                return;
            }
            letter if letter.is_ascii_alphabetic() => {
                let letter = letter.to_ascii_uppercase();
                let after = rest[1..].trim_start();
                if after.starts_with(['#', '[', '<']) {
                    collected.fault(number, ProgramFaultKind::Macro, rest);
                    return;
                }
                let (value, length) = number_at_start(after);
                let Some(value) = value else {
                    collected.fault(number, kind_of_text(rest), rest);
                    return;
                };
                rest = &after[length..];
                if letter != 'N' && letter != 'O' {
                    words.push(Word { letter, value });
                }
            }
            _ => {
                collected.fault(number, ProgramFaultKind::UnknownWord, rest);
                return;
            }
        }
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
        "BEGIN" | "TOOL" | "BLK" | "FMAX" | "CC" | "CYCL" | "LBL" | "L" => ProgramFaultKind::Heidenhain,
        "TRANS" | "ROT" | "AROT" | "SCALE" | "MIRROR" | "ATRANS" => ProgramFaultKind::Transformation,
        _ if word.starts_with("CYCLE") => ProgramFaultKind::Cycle,
        _ if word.len() > 1 => ProgramFaultKind::UnknownWord,
        _ => ProgramFaultKind::Number,
    }
}
