//! Moves written as a program: in G-code with G17 G21 G90 G94, G0 and G1 alone, modal words not repeated, coordinates and feeds with a
//! decimal point; in Klartext with straight lines (L) alone. A program that was read is written again with new feeds: the same text, byte
//! for byte, but for its feed words.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use super::program_points::{Dialect, Program, Reached};
use super::read::{Columns, UNNAMED_FEED, fields};
use crate::path::{Move, MoveKind};
use std::collections::BTreeMap;
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
#[expect(clippy::struct_excessive_bools, reason = "each switches words of its own")]
pub struct WriteSettings<'a> {
    /// Inches in place of mm.
    pub inches: bool,
    /// Numbers the blocks: those of G-code in steps of 10, from 10 again after 99990; those of Klartext from 0 on.
    pub number_lines: bool,
    /// The decimals of coordinates, up to 8.
    pub decimals: usize,
    /// Lines after the first.
    pub header: &'a [String],
    /// Lines before M30.
    pub footer: &'a [String],
    /// M8 after each tool call.
    pub coolant: bool,
    /// G43 H with the tool's number at the first Z after each tool call. Tool calls of Klartext set the length.
    pub length_offset: bool,
    /// Klartext in place of G-code.
    pub klartext: bool,
}

impl Default for WriteSettings<'_> {
    fn default() -> Self {
        Self {
            inches: false,
            number_lines: false,
            decimals: 4,
            header: &[],
            footer: &[],
            coolant: false,
            length_offset: false,
            klartext: false,
        }
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

/// The last number of a block with five digits, the most that some controls read.
const LAST_NUMBER: u32 = 99_990;

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
pub fn write(operations: &[Operation<'_>], settings: &WriteSettings<'_>) -> Result<String, Gap> {
    let mut writer = Writer { text: String::new(), settings, number: 0, motion: "", axes: Default::default(), feed: String::new() };
    writer.begin();
    for (number, operation) in operations.iter().enumerate() {
        let Some(first) = operation.moves.first() else { continue };
        writer.call(operation, first.from);
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
    writer.end();
    Ok(writer.text)
}

impl Writer<'_> {
    /// The blocks before the operations.
    fn begin(&mut self) {
        let &WriteSettings { klartext, inches, header, .. } = self.settings;
        if klartext {
            self.block(if inches { "BEGIN PGM FINISH INCH" } else { "BEGIN PGM FINISH MM" });
        } else {
            self.text.push_str("%\n");
        }
        for line in header {
            self.block(line);
        }
        if !klartext {
            self.block(if inches { "G17 G20 G90 G94" } else { "G17 G21 G90 G94" });
        }
    }

    /// The call of an operation's tool, and the rapid to its first point.
    fn call(&mut self, operation: &Operation<'_>, first: [f64; 3]) {
        let &WriteSettings { klartext, coolant, length_offset, .. } = self.settings;
        let tool = operation.tool;
        if let Some(name) = operation.name {
            let name: String = name.chars().filter(|c| c.is_ascii_graphic() && !matches!(c, '(' | ')') || *c == ' ').take(60).collect();
            self.block(&if klartext { format!("; {name}") } else { format!("({name})") });
        }
        let speed = operation.spindle_speed.map(|speed| format!("S{speed:.0}"));
        match (klartext, speed) {
            (true, speed) => {
                self.block(format!("TOOL CALL {tool} Z {}", speed.as_deref().unwrap_or_default()).trim_end());
                if speed.is_some() {
                    self.block("M3");
                }
            }
            (false, speed) => {
                self.block(&format!("T{tool} M6"));
                if let Some(speed) = speed {
                    self.block(&format!("{speed} M3"));
                }
            }
        }
        if coolant {
            self.block("M8");
        }
        let [x, y, z] = first.map(|value| self.coordinate(value));
        if klartext {
            self.block(&format!("L X{x} Y{y} R0 FMAX"));
            self.block(&format!("L Z{z} R0 FMAX"));
        } else {
            self.block(&format!("G0 X{x} Y{y}"));
            let offset = if length_offset { format!("G43 H{tool} ") } else { String::new() };
            self.block(&format!("{offset}Z{z}"));
        }
        (self.motion, self.axes, self.feed) = ("G0", [x, y, z], String::new());
    }

    /// The blocks after the operations.
    fn end(&mut self) {
        let &WriteSettings { klartext, coolant, footer, inches, .. } = self.settings;
        for line in footer {
            self.block(line);
        }
        self.block("M5");
        if coolant {
            self.block("M9");
        }
        self.block("M30");
        if klartext {
            self.block(if inches { "END PGM FINISH INCH" } else { "END PGM FINISH MM" });
        } else {
            self.text.push_str("%\n");
        }
    }

    fn block(&mut self, text: &str) {
        if self.settings.number_lines && self.settings.klartext {
            let _ = write!(self.text, "{} ", self.number);
            self.number += 1;
        } else if self.settings.number_lines {
            self.number = if self.number < LAST_NUMBER { self.number + 10 } else { 10 };
            let _ = write!(self.text, "N{} ", self.number);
        }
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn scale(&self) -> f64 {
        if self.settings.inches { 25.4 } else { 1.0 }
    }

    fn coordinate(&self, mm: f64) -> String {
        let number = number(mm / self.scale(), self.settings.decimals.min(8));
        if !self.settings.klartext {
            return number;
        }
        let sign = if number.starts_with('-') { "" } else { "+" };
        format!("{sign}{}", number.trim_end_matches('.'))
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
            // Klartext has feeds in tenths of an inch.
            let scale = if self.settings.klartext && self.settings.inches { 0.1 * self.scale() } else { self.scale() };
            let feed = (feed_rate / scale * unit).floor().max(1.0) / unit;
            let mut feed = number(feed, decimals as usize);
            if self.settings.klartext {
                feed.truncate(feed.trim_end_matches('.').len());
            }
            if feed != self.feed {
                words.push_str(" F");
                words.push_str(&feed);
                self.feed = feed;
            }
        }
        if self.settings.klartext {
            words = format!("L {words}{}", if is_rapid { " FMAX" } else { "" });
        } else if motion != self.motion {
            self.motion = motion;
            words = format!("{motion} {words}");
        }
        self.block(&words);
    }
}

/// The number with up to these decimals, without zeros at its end, and without a sign at zero. It has a decimal point: some controls
/// read numbers without one in their least increment, 10 as 0.010 mm.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if decimals == 0 { text + "." } else { text.trim_end_matches('0').to_owned() };
    if text == "-0." { "0.".to_owned() } else { text }
}

/// A feed word stays if its feed is at most this part below the new one.
const NEARLY: f64 = 0.99;

/// The text of `program` with the feed rates in mm/min of the moves to its points; those of rapids do not count. A block
/// whose moves have different ones gets the least. Words are rounded down; a word is added where the modal feed differs.
/// With `old_in_comments`, each replaced word of G-code is in a comment in parentheses after the new one, or, as in Klartext, behind a
/// semicolon at the end of the block if the program has lines that are such comments: Siemens' controls have no others. A word of G-code
/// has a decimal point where the replaced one has it, and where its unit is not mm/min: some controls read such numbers without one in
/// their least increment.
///
/// # Panics
/// If there are fewer feed rates than points.
#[must_use]
pub fn with_feeds(text: &str, program: &Program, feed_rates: &[f64], old_in_comments: bool) -> String {
    assert!(feed_rates.len() >= program.points.len(), "a point has no feed rate");
    let mut of_lines: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for (point, feed_rate) in program.points.iter().zip(feed_rates).filter(|(point, _)| point.reached == Reached::Feed) {
        let of_line = of_lines.entry(point.line).or_insert((f64::INFINITY, point.feed_unit));
        of_line.0 = of_line.0.min(*feed_rate);
    }
    let mut written = String::with_capacity(text.len() + 16 * of_lines.len());
    // The modal feed in units of feed words, and the size of the unit.
    let mut modal: Option<(f64, f64)> = None;
    let mut feed_column = None;
    let has_semicolons = || program.dialect == Dialect::Klartext || text.lines().any(|line| line.trim_start().starts_with(';'));
    let comment = old_in_comments.then(|| if has_semicolons() { ';' } else { '(' });
    for (line, number) in text.split_inclusive('\n').zip(1_u32..) {
        let block = line.trim_end_matches(['\n', '\r']);
        let wanted = of_lines.get(&number).filter(|(feed, _)| feed.is_finite()).copied();
        match (program.dialect, wanted) {
            (dialect @ (Dialect::GCode | Dialect::Klartext), wanted) => {
                block_with_feed(dialect, block, wanted, &mut modal, comment, &mut written);
            }
            (Dialect::Apt, Some((feed, unit))) => {
                if modal.is_none_or(|(modal, _)| !keeps(modal, feed)) {
                    let ending = &line[block.len()..];
                    let (word, value) = (if unit > 1.0 { "IPM" } else { "MMPM" }, word_value(feed, unit));
                    let _ = write!(written, "FEDRAT/{value},{word}{}", if ending.is_empty() { "\n" } else { ending });
                    modal = Some((feed, unit));
                }
                written.push_str(block);
            }
            (Dialect::Columns, wanted) => row_with_feed(block, wanted, &mut feed_column, &mut written),
            (Dialect::Apt, None) => {
                if block.trim_start().to_ascii_uppercase().starts_with("FEDRAT") {
                    // The program's own statement holds from here on.
                    modal = None;
                }
                written.push_str(block);
            }
        }
        written.push_str(&line[block.len()..]);
    }
    written
}

/// A row with its feed rate in its column. A header without such a column gets one, the last.
fn row_with_feed(row: &str, wanted: Option<(f64, f64)>, feed_column: &mut Option<usize>, written: &mut String) {
    let separator = row.find([',', ';', '\t']).map_or(",", |at| &row[at..=at]);
    let header = if feed_column.is_none() { Columns::named(&fields(row)) } else { None };
    let Some((feed, unit)) = wanted else {
        written.push_str(row);
        if let Some(header) = header {
            *feed_column = Some(header.feed.unwrap_or(fields(row).len()));
            if header.feed.is_none() {
                let _ = write!(written, "{separator}feed_rate_mm_min");
            }
        }
        return;
    };
    let value = word_value(feed, unit);
    let mut columns: Vec<&str> = row.split([',', ';', '\t']).collect();
    let at = feed_column.unwrap_or(UNNAMED_FEED);
    columns.resize(columns.len().max(at + 1), "");
    columns[at] = &value;
    written.push_str(&columns.join(separator));
}

/// Whether a feed that holds is the wanted one, or hardly less.
fn keeps(feed: f64, wanted: f64) -> bool {
    feed <= wanted && feed >= NEARLY * wanted
}

/// A feed rate in mm/min as the number of a word, rounded down to four digits or a hundredth.
fn word_value(feed_rate: f64, unit: f64) -> String {
    let value = feed_rate / unit;
    let decimals = if value >= 1000.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        4
    };
    let scale = 10.0_f64.powi(decimals);
    let floor = (value * scale * (1.0 + 1e-12)).floor().max(1.0) / scale;
    #[expect(clippy::cast_sign_loss, reason = "0 to 4")]
    let text = format!("{floor:.*}", decimals as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A feed word of a block: where its letter begins and where its number ends.
struct FeedWord {
    from: usize,
    to: usize,
    value: f64,
}

/// The feed word of a block, and where the last word ends.
fn scan(block: &str) -> (Option<FeedWord>, usize) {
    let bytes = block.as_bytes();
    let (mut at, mut end, mut word) = (0, 0, None);
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'(' => at += block[at..].find(')').map_or(block.len() - at, |close| close + 1),
            b';' => break,
            // Siemens' names of tools and variables may look like feeds.
            b'"' | b'_' => {
                let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
                let name = || block[at..].bytes().take_while(is_name).count();
                at += if byte == b'_' { name() } else { block[at + 1..].find('"').map_or(block.len() - at, |close| close + 2) };
                end = at;
            }
            b'F' | b'f' => {
                let from = at;
                at += 1;
                while bytes.get(at).is_some_and(|byte| matches!(byte, b' ' | b'\t' | b'=')) {
                    at += 1;
                }
                let first = at;
                // The name of a variable after `=` is a feed word too, with the value NaN.
                let is_name = |byte: u8| block[from..first].contains('=') && (byte.is_ascii_alphanumeric() || byte == b'_');
                while bytes.get(at).is_some_and(|&byte| matches!(byte, b'0'..=b'9' | b'.' | b'+' | b'-') || is_name(byte)) {
                    at += 1;
                }
                if at > first {
                    word = Some(FeedWord { from, to: at, value: block[first..at].parse().unwrap_or(f64::NAN) });
                }
                end = at;
            }
            byte => {
                at += 1;
                if !byte.is_ascii_whitespace() {
                    end = at;
                }
            }
        }
    }
    (word, end)
}

/// The feed word of a block of Klartext, and where a new one goes: before the first M function. A word that is no number has the value NaN.
fn scan_klartext(block: &str) -> (Option<FeedWord>, usize) {
    let code = block.split(';').next().unwrap_or_default().trim_end();
    let place = |word: &str| word.as_ptr() as usize - block.as_ptr() as usize;
    let is_function = |word: &&str| word.starts_with(['M', 'm']) && word[1..].starts_with(|c: char| c.is_ascii_digit());
    let words: Vec<&str> = code.split_whitespace().take_while(|word| !is_function(word)).collect();
    let end = words.last().map_or(code.len(), |last| place(last) + last.len());
    let feed = words.iter().position(|word| word.starts_with(['F', 'f']) && !word.eq_ignore_ascii_case("FMAX")).map(|at| {
        // `F AUTO` and `F Q50` are two words.
        let last = words[if words[at].len() == 1 { (at + 1).min(words.len() - 1) } else { at }];
        let value = words[at][1..].replace(',', ".").parse().unwrap_or(f64::NAN);
        FeedWord { from: place(words[at]), to: place(last) + last.len(), value }
    });
    (feed, end)
}

fn block_with_feed(
    dialect: Dialect,
    block: &str,
    wanted: Option<(f64, f64)>,
    modal: &mut Option<(f64, f64)>,
    comment: Option<char>,
    written: &mut String,
) {
    let is_klartext = dialect == Dialect::Klartext;
    let (word, end) = if is_klartext { scan_klartext(block) } else { scan(block) };
    let Some((feed, unit)) = wanted else {
        if word.is_some() {
            // The unit of a word in a block without moves is not known.
            *modal = None;
        }
        written.push_str(block);
        return;
    };
    let holds = word.as_ref().map(|word| word.value).or(modal.filter(|(_, of)| of.to_bits() == unit.to_bits()).map(|(value, _)| value));
    if let Some(value) = holds.filter(|value| keeps(value * unit, feed)) {
        *modal = Some((value, unit));
        written.push_str(block);
        return;
    }
    let mut value = word_value(feed, unit);
    let has_point = word.as_ref().is_some_and(|word| block[word.from..word.to].contains('.'));
    if !is_klartext && (has_point || unit > 1.0) && !value.contains('.') {
        value.push('.');
    }
    let [after_word, after_block] = match (comment, word.as_ref().map(|word| &block[word.from..word.to])) {
        (Some('('), Some(old)) => [format!(" ({old})"), String::new()],
        (Some(_), Some(old)) => [String::new(), format!(" ; {old}")],
        _ => [String::new(), String::new()],
    };
    let (before, after) = word.map_or((end, end), |word| (word.from, word.to));
    let blank = if before == after { " " } else { "" };
    let _ = write!(written, "{}{blank}F{value}{after_word}{}{after_block}", &block[..before], &block[after..]);
    *modal = value.parse().ok().map(|value| (value, unit));
}
