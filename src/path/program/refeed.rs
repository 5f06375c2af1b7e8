//! A program with new feeds: the same text, byte for byte, but for its feed words.

use super::program_points::{Dialect, Program, Reached};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A feed word stays if its feed is at most this part below the new one.
const NEARLY: f64 = 0.99;

/// The text of `program` with the feed rates in mm/min of the moves to its points; those of rapids do not count. A block
/// whose moves have different ones gets the least. Words are rounded down; a word is added where the modal feed differs.
/// With `old_in_comments`, G-code has each replaced word in a comment after the new one.
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
    for (line, number) in text.split_inclusive('\n').zip(1_u32..) {
        let block = line.trim_end_matches(['\n', '\r']);
        let wanted = of_lines.get(&number).filter(|(feed, _)| feed.is_finite()).copied();
        match (program.dialect, wanted) {
            (Dialect::GCode, wanted) => block_with_feed(block, wanted, &mut modal, old_in_comments, &mut written),
            (Dialect::Apt, Some((feed, unit))) => {
                if modal.is_none_or(|(modal, _)| !keeps(modal, feed)) {
                    let ending = &line[block.len()..];
                    let (word, value) = (if unit > 1.0 { "IPM" } else { "MMPM" }, word_value(feed, unit));
                    let _ = write!(written, "FEDRAT/{value},{word}{}", if ending.is_empty() { "\n" } else { ending });
                    modal = Some((feed, unit));
                }
                written.push_str(block);
            }
            (Dialect::Columns, Some((feed, unit))) => {
                let separator = block.find([',', ';', '\t']).map_or(",", |at| &block[at..=at]);
                let columns: Vec<&str> = block.split([',', ';', '\t']).collect();
                written.push_str(&columns[..columns.len().min(3)].join(separator));
                let _ = write!(written, "{separator}{}", word_value(feed, unit));
            }
            (_, None) => written.push_str(block),
        }
        written.push_str(&line[block.len()..]);
    }
    written
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
            b'F' | b'f' => {
                let from = at;
                at += 1;
                while bytes.get(at).is_some_and(|byte| matches!(byte, b' ' | b'\t')) {
                    at += 1;
                }
                let first = at;
                while bytes.get(at).is_some_and(|byte| matches!(byte, b'0'..=b'9' | b'.' | b'+' | b'-')) {
                    at += 1;
                }
                if let Ok(value) = block[first..at].parse() {
                    word = Some(FeedWord { from, to: at, value });
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

fn block_with_feed(block: &str, wanted: Option<(f64, f64)>, modal: &mut Option<(f64, f64)>, old_in_comments: bool, written: &mut String) {
    let (word, end) = scan(block);
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
    let value = word_value(feed, unit);
    let comment = |old: f64| if old_in_comments { format!(" (F{old})") } else { String::new() };
    match word {
        Some(word) => {
            let _ = write!(written, "{}F{value}{}{}", &block[..word.from], comment(word.value), &block[word.to..]);
        }
        None => {
            let _ = write!(written, "{} F{value}{}", &block[..end], &block[end..]);
        }
    }
    *modal = value.parse().ok().map(|value| (value, unit));
}
