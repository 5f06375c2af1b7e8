//! Moves written as an ISO program: G17 G21 G90 G94, G0 and G1 alone, modal words not repeated.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use crate::path::{Move, MoveKind};
use std::fmt::{self, Write};

/// One tool's moves.
#[derive(Debug, Clone, Copy)]
pub struct Operation<'a> {
    /// The number for the tool call.
    pub tool: u32,
    /// A name for the comment at the tool call.
    pub name: Option<&'a str>,
    /// The spindle's speed in rpm, > 0.
    pub spindle_speed: Option<f64>,
    /// The moves, each from where the one before ended.
    pub moves: &'a [Move],
    /// The feed rate of each move in mm/min; those of rapids do not count.
    pub feed_rates: &'a [f64],
}

/// How a program is written.
#[derive(Debug, Clone)]
pub struct WriteSettings<'a> {
    /// G20 and inches in place of G21 and mm.
    pub inches: bool,
    /// Numbers the blocks in steps of 10.
    pub number_lines: bool,
    /// The decimals of coordinates, up to 8.
    pub decimals: usize,
    /// Lines after the first.
    pub header: &'a [String],
    /// Lines before M30.
    pub footer: &'a [String],
    /// M8 after each tool call.
    pub coolant: bool,
}

impl Default for WriteSettings<'_> {
    fn default() -> Self {
        Self { inches: false, number_lines: false, decimals: 4, header: &[], footer: &[], coolant: false }
    }
}

/// A move does not begin where the one before it ended, or has no feed rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// The operation.
    pub operation: usize,
    /// The move.
    pub index: usize,
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "move {} of operation {} does not begin where the one before ends, or has no feed rate", self.index, self.operation)
    }
}

impl std::error::Error for Gap {}

/// The text being written, and the words that hold.
struct Writer<'a> {
    text: String,
    settings: &'a WriteSettings<'a>,
    number: u32,
    motion: &'static str,
    axes: [String; 3],
    feed: String,
}

/// The program of the operations, in their order. Each begins with a rapid to its first point: X and Y at the height where
/// the tool is, then Z.
///
/// # Errors
/// [`Gap`] if the moves do not join, or if there are fewer feed rates than moves.
pub fn write_iso(operations: &[Operation<'_>], settings: &WriteSettings<'_>) -> Result<String, Gap> {
    let none = || [const { String::new() }; 3];
    let mut writer = Writer { text: "%\n".to_owned(), settings, number: 0, motion: "", axes: none(), feed: String::new() };
    settings.header.iter().for_each(|line| writer.block(line));
    writer.block(if settings.inches { "G17 G20 G90 G94" } else { "G17 G21 G90 G94" });
    for (number, operation) in operations.iter().enumerate() {
        let Some(first) = operation.moves.first() else { continue };
        if let Some(name) = operation.name {
            let name: String = name.chars().filter(|c| c.is_ascii_graphic() && !matches!(c, '(' | ')') || *c == ' ').take(60).collect();
            writer.block(&format!("({name})"));
        }
        writer.block(&format!("T{} M6", operation.tool));
        if let Some(speed) = operation.spindle_speed {
            writer.block(&format!("S{speed:.0} M3"));
        }
        if settings.coolant {
            writer.block("M8");
        }
        (writer.motion, writer.axes, writer.feed) = ("", none(), String::new());
        let [x, y, z] = first.from.map(|value| writer.coordinate(value));
        writer.block(&format!("G0 X{x} Y{y}"));
        writer.block(&format!("Z{z}"));
        (writer.motion, writer.axes) = ("G0", [x, y, z]);
        let mut at = first.from;
        for (index, each) in operation.moves.iter().enumerate() {
            let feed = operation.feed_rates.get(index).copied();
            let is_rapid = each.kind == MoveKind::Rapid;
            let joins = (0..3).all(|axis| (each.from[axis] - at[axis]).abs() <= 1e-9 * (1.0 + at[axis].abs()));
            if !joins || !is_rapid && !feed.is_some_and(|feed| feed.is_finite() && feed > 0.0) {
                return Err(Gap { operation: number, index });
            }
            writer.line_to(each.to, is_rapid, feed.unwrap_or_default());
            at = each.to;
        }
    }
    settings.footer.iter().for_each(|line| writer.block(line));
    writer.block("M5");
    if settings.coolant {
        writer.block("M9");
    }
    writer.block("M30");
    writer.text.push_str("%\n");
    Ok(writer.text)
}

impl Writer<'_> {
    fn block(&mut self, text: &str) {
        if self.settings.number_lines {
            self.number += 10;
            let _ = write!(self.text, "N{} ", self.number);
        }
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn scale(&self) -> f64 {
        if self.settings.inches { 25.4 } else { 1.0 }
    }

    fn coordinate(&self, mm: f64) -> String {
        number(mm / self.scale(), self.settings.decimals.min(8))
    }

    fn line_to(&mut self, to: [f64; 3], is_rapid: bool, feed_rate: f64) {
        let mut words = String::new();
        let motion = if is_rapid { "G0" } else { "G1" };
        for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            let value = self.coordinate(to[axis]);
            if value != self.axes[axis] {
                words.push_str(if words.is_empty() { "" } else { " " });
                words.push_str(letter);
                words.push_str(&value);
                self.axes[axis] = value;
            }
        }
        if words.is_empty() {
            return;
        }
        if !is_rapid {
            // Rounded down, so that no feed exceeds what keeps the tolerance.
            let decimals = if self.settings.inches { 3 } else { 1 };
            let unit = 10.0_f64.powi(decimals);
            let feed = (feed_rate / self.scale() * unit).floor().max(1.0) / unit;
            let feed = number(feed, decimals as usize);
            if feed != self.feed {
                words.push_str(" F");
                words.push_str(&feed);
                self.feed = feed;
            }
        }
        if motion != self.motion {
            self.motion = motion;
            words = format!("{motion} {words}");
        }
        self.block(&words);
    }
}

/// The number with up to these decimals, without zeros at its end, and without a sign at zero.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
