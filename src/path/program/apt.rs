//! APT and cutter location files: the statements that place the tool.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use super::collected::Collected;
use super::faults::FaultKind;
use super::points::{ProgramPoint, Reached};

/// The statements by which such a file is known.
pub(super) const STATEMENTS: [&str; 9] = ["PARTNO", "GOTO", "FEDRAT", "LOADTL", "UNITS", "MULTAX", "MACHIN", "CUTTER", "SPINDL"];

/// Statements that say nothing about the path.
const SKIPPED: [&str; 18] = [
    "PARTNO", "PPRINT", "MACHIN", "CUTTER", "MULTAX", "COOLNT", "CUTCOM", "OUTTOL", "INTOL", "TOLER", "END", "FINI", "REMARK", "INSERT",
    "STOP", "OPSTOP", "TLON", "MODE",
];

pub(super) fn read(text: &str, collected: &mut Collected) {
    let (mut millimetres, mut feed, mut spindle, mut tool, mut rapid, mut is_new) = (1.0, None, None, 0, false, true);
    let mut lines = text.lines().zip(1_u32..);
    while let Some((line, number)) = lines.next() {
        // A statement goes on in the next line after a single $.
        let mut statement = without_comment(line).to_owned();
        while statement.trim_end().ends_with('$') {
            statement.truncate(statement.trim_end().len() - 1);
            let Some((next, _)) = lines.next() else { break };
            statement.push_str(without_comment(next));
        }
        let statement = statement.trim().to_ascii_uppercase();
        if statement.is_empty() {
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
                    collected.fault(number, FaultKind::Number, statement.clone());
                    continue;
                };
                if values.len() != arguments.len() {
                    collected.fault(number, FaultKind::Number, statement.clone());
                    continue;
                }
                if axis.len() == 3 && (axis[0].abs() > 1e-6 || axis[1].abs() > 1e-6 || axis[2] <= 0.0) {
                    collected.fault(number, FaultKind::Axis, statement.clone());
                    continue;
                }
                let reached = match (is_new || word == "FROM", rapid) {
                    (true, _) => Reached::FromUnknown,
                    (false, true) => Reached::Rapid,
                    (false, false) => Reached::Feed,
                };
                let feed_rate = if reached == Reached::Feed { feed } else { None };
                let point = [x, y, z].map(|value| value * millimetres);
                collected.push(ProgramPoint { point, reached, feed_rate, line: number, tool, spindle_speed: spindle });
                // RAPID holds for one motion.
                (rapid, is_new) = (false, false);
            }
            "RAPID" => rapid = true,
            "FEDRAT" => match numbers().find(|value| *value > 0.0) {
                Some(value) if arguments.iter().any(|argument| matches!(*argument, "MMPR" | "IPR" | "PERREV")) => match spindle {
                    Some(speed) => feed = Some(value * millimetres * speed),
                    None => collected.fault(number, FaultKind::FeedPerRevolution, statement.clone()),
                },
                Some(value) => feed = Some(value * if arguments.contains(&"IPM") { 25.4 } else { millimetres }),
                None => collected.fault(number, FaultKind::Number, statement.clone()),
            },
            "SPINDL" => spindle = numbers().find(|value| *value > 0.0).or(spindle),
            "UNITS" if rest.contains("INCH") => millimetres = 25.4,
            "UNITS" if rest.contains("MM") => millimetres = 1.0,
            "LOADTL" | "TURRET" => {
                tool = numbers().next().filter(|value| (0.0..=1e6).contains(value)).map_or(0, |value| value as u32);
                is_new = true;
            }
            "GOHOME" => is_new = true,
            "CIRCLE" | "CYCLE" => collected.fault(number, FaultKind::Cycle, statement.clone()),
            "TRANS" | "ORIGIN" | "TRACUT" | "COPY" => collected.fault(number, FaultKind::Transformation, statement.clone()),
            word if SKIPPED.contains(&word) => {}
            _ => collected.fault(number, FaultKind::UnknownWord, statement.clone()),
        }
    }
}

fn without_comment(line: &str) -> &str {
    line.split("$$").next().unwrap_or(line)
}
