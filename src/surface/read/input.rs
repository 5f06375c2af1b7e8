//! The input of a reader: the file's next bytes or next line, with the count of both for the places of faults; and why a file
//! could not be read.

use super::words::{is_blank, line_end, trimmed_start};
use crate::file_fault::{FileFault, FileFaultKind, Flaw};
use std::fmt;
use std::io::{self, Read};
use std::ops::Range;

/// The reason why a file could not be read.
#[derive(Debug)]
pub enum ReadError {
    /// The file has a fault.
    Fault(FileFault),
    /// The source of the file failed: it was cut off, or nobody waits for the surface any longer.
    Source(io::Error),
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) => fault.fmt(f),
            Self::Source(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ReadError {}

impl From<FileFault> for ReadError {
    fn from(fault: FileFault) -> Self {
        Self::Fault(fault)
    }
}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> Self {
        Self::Source(error)
    }
}

/// The longest line that is accepted, in bytes: far longer than any point, facet or polygon needs.
pub(super) const LONGEST_LINE: usize = 1 << 16;

/// The buffer holds the head by which the format is detected, and any line with its end.
const BUFFER: usize = 1 << 18;

/// A file that is being read. A line ends with LF, CR LF, or CR alone.
pub(super) struct Input<'a> {
    source: &'a mut dyn Read,
    buffer: Vec<u8>,
    /// The bytes in the buffer that have not been taken.
    held: Range<usize>,
    is_over: bool,
    /// Bytes taken.
    offset: u64,
    /// Lines taken with their ends.
    ended: u64,
    /// The number of the last line taken, counted from 1.
    number: u64,
    /// The rest of that line, for [`Input::word`].
    rest: Range<usize>,
}

impl<'a> Input<'a> {
    pub(super) fn new(source: &'a mut dyn Read) -> Self {
        Self { source, buffer: vec![0; BUFFER], held: 0..0, is_over: false, offset: 0, ended: 0, number: 0, rest: 0..0 }
    }

    /// The bytes taken.
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// The number of the last line taken.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// The number of the line that would follow the last line's end: where a file is cut off.
    pub(super) fn number_at_end(&self) -> u64 {
        self.ended + 1
    }

    /// The next bytes, not taken: at least `count` of them, at most the buffer's size, unless the file ends before.
    pub(super) fn peek(&mut self, count: usize) -> io::Result<&[u8]> {
        while self.held.len() < count && !self.is_over {
            self.fill()?;
        }
        Ok(&self.buffer[self.held.clone()])
    }

    /// Takes bytes that were peeked.
    pub(super) fn consume(&mut self, count: usize) {
        self.held.start += count;
        self.offset += count as u64;
    }

    /// Takes `count` bytes; `None` if fewer are left.
    #[inline]
    pub(super) fn block(&mut self, count: usize) -> io::Result<Option<&[u8]>> {
        if self.held.len() < count && self.peek(count)?.len() < count {
            return Ok(None);
        }
        let start = self.held.start;
        self.consume(count);
        Ok(Some(&self.buffer[start..start + count]))
    }

    /// Takes up to `count` bytes without looking at them, and returns how many there were.
    pub(super) fn skip(&mut self, count: u64) -> io::Result<u64> {
        let mut skipped = 0;
        while skipped < count {
            let held = self.peek(1)?.len();
            if held == 0 {
                break;
            }
            let some = held.min(usize::try_from(count - skipped).unwrap_or(usize::MAX));
            self.consume(some);
            skipped += some as u64;
        }
        Ok(skipped)
    }

    /// Takes the rest of the file; `None` if it has more than `limit` bytes.
    pub(super) fn rest_within(&mut self, limit: usize) -> io::Result<Option<Vec<u8>>> {
        let mut rest = Vec::new();
        loop {
            let held = self.peek(1)?;
            if rest.len() + held.len() > limit {
                return Ok(None);
            }
            if held.is_empty() {
                return Ok(Some(rest));
            }
            rest.extend_from_slice(held);
            let length = held.len();
            self.consume(length);
        }
    }

    /// Asks the source whether reading may go on after the end of the file; it answers with an error if nobody waits for
    /// the result.
    pub(super) fn check(&mut self) -> io::Result<()> {
        self.source.read(&mut [0]).map(|_| ())
    }

    /// Takes the next line, without its end; `None` at the end of the file. Old systems mark the end of a text with null
    /// bytes or Ctrl-Z, which are left out.
    pub(super) fn line(&mut self) -> Result<Option<&[u8]>, ReadError> {
        Ok(self.next_line()?.map(|line| &self.buffer[line]))
    }

    /// Passes every line to `each`, whose flaws get the line's number.
    pub(super) fn each_line(&mut self, mut each: impl FnMut(&[u8], u64) -> Result<(), Flaw>) -> Result<(), ReadError> {
        while let Some(line) = self.next_line()? {
            each(&self.buffer[line], self.number).map_err(|flaw| flaw.at_line(self.number))?;
        }
        Ok(())
    }

    /// Takes the next word, on the current line or a later one.
    #[inline]
    pub(super) fn word(&mut self) -> Result<Option<&[u8]>, ReadError> {
        loop {
            let rest = trimmed_start(&self.buffer[self.rest.clone()]);
            if !rest.is_empty() {
                let start = self.rest.end - rest.len();
                let length = rest.iter().position(|byte| is_blank(*byte)).unwrap_or(rest.len());
                self.rest.start = start + length;
                return Ok(Some(&self.buffer[start..start + length]));
            }
            match self.next_line()? {
                Some(line) => self.rest = line,
                None => return Ok(None),
            }
        }
    }

    /// Leaves out the words that follow on the current line.
    pub(super) fn skip_words(&mut self) {
        self.rest = 0..0;
    }

    /// Takes the bytes before the next `end`, and `end` itself; `None` if the file has no more.
    pub(super) fn line_until(&mut self, end: u8) -> Result<Option<&[u8]>, ReadError> {
        let length = loop {
            let held = &self.buffer[self.held.clone()];
            match memchr::memchr(end, held) {
                Some(length) => break length,
                None if held.len() > LONGEST_LINE => return Err(too_long().at_line(self.number_at_end()).into()),
                None if self.is_over => return Ok(None),
                None => self.fill()?,
            }
        };
        let start = self.held.start;
        self.consume(length + 1);
        self.ended += 1;
        self.number = self.ended;
        Ok(Some(&self.buffer[start..start + length]))
    }

    fn next_line(&mut self) -> Result<Option<Range<usize>>, ReadError> {
        self.rest = 0..0;
        let mut searched = 0;
        loop {
            let held = &self.buffer[self.held.clone()];
            let end = line_end(&held[searched..]).map(|at| searched + at);
            if end.unwrap_or(held.len()) > LONGEST_LINE {
                return Err(too_long().at_line(self.number_at_end()).into());
            }
            match end {
                // A LF may follow a CR.
                Some(end) if held[end] == b'\n' || end + 1 < held.len() || self.is_over => {
                    let line = self.held.start..self.held.start + end;
                    let ending = if held[end..].starts_with(b"\r\n") { 2 } else { 1 };
                    self.consume(end + ending);
                    self.ended += 1;
                    self.number = self.ended;
                    return Ok(Some(line));
                }
                None if self.is_over => return Ok(self.last_line()),
                _ => {
                    searched = end.unwrap_or(held.len());
                    self.fill()?;
                }
            }
        }
    }

    /// The last line, which has no end.
    fn last_line(&mut self) -> Option<Range<usize>> {
        let held = &self.buffer[self.held.clone()];
        let length = held.iter().rposition(|byte| !matches!(byte, 0 | 0x1a)).map_or(0, |last| last + 1);
        let line = self.held.start..self.held.start + length;
        self.consume(held.len());
        self.number = self.ended + 1;
        (length > 0).then_some(line)
    }

    /// Reads more bytes into the buffer.
    fn fill(&mut self) -> io::Result<()> {
        if self.held.end == self.buffer.len() {
            self.buffer.copy_within(self.held.clone(), 0);
            self.held = 0..self.held.len();
        }
        let read = loop {
            match self.source.read(&mut self.buffer[self.held.end..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                result => break result?,
            }
        };
        self.held.end += read;
        self.is_over = read == 0;
        Ok(())
    }
}

impl Read for Input<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let held = self.peek(1)?;
        let length = held.len().min(buffer.len());
        buffer[..length].copy_from_slice(&held[..length]);
        self.consume(length);
        Ok(length)
    }
}

#[cold]
pub(super) fn too_long() -> Flaw {
    Flaw::new(FileFaultKind::TooLarge, format!("at most {LONGEST_LINE} bytes in a line"), "a longer one")
}

/// A decoder of UTF-16 with a byte-order mark to UTF-8.
#[derive(Debug)]
pub(super) struct Utf16 {
    is_big: bool,
}

impl Utf16 {
    /// A decoder for a file that begins with `start`, if that begins with a byte-order mark of UTF-16.
    pub(super) fn by_mark(start: &[u8]) -> Option<Self> {
        match start {
            [0xff, 0xfe, ..] => Some(Self { is_big: false }),
            [0xfe, 0xff, ..] => Some(Self { is_big: true }),
            _ => None,
        }
    }

    /// The file of `source` in UTF-8. The byte-order mark becomes that of UTF-8; invalid units become U+FFFD.
    pub(super) fn of<R: Read>(self, source: R) -> Decoded<R> {
        Decoded { decoder: self, source, raw: Vec::new(), text: Vec::new(), used: 0 }
    }

    /// Decodes whole characters from the start of `raw` and removes their bytes. `is_last` states that none follow.
    fn decode(&self, raw: &mut Vec<u8>, is_last: bool) -> Vec<u8> {
        let unit = |pair: &[u8; 2]| if self.is_big { u16::from_be_bytes(*pair) } else { u16::from_le_bytes(*pair) };
        let (pairs, _) = raw.as_chunks::<2>();
        // The second unit of a surrogate pair may not have arrived.
        let is_half = |pair: &[u8; 2]| (0xd800..0xdc00).contains(&unit(pair));
        let whole = if !is_last && pairs.last().is_some_and(is_half) { &pairs[..pairs.len() - 1] } else { pairs };
        let characters = char::decode_utf16(whole.iter().map(unit)).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        let text: String = characters.collect();
        let used = 2 * whole.len();
        raw.drain(..used);
        text.into_bytes()
    }
}

/// A file in UTF-16 that is read as UTF-8.
#[derive(Debug)]
pub(super) struct Decoded<R> {
    decoder: Utf16,
    source: R,
    /// Bytes that are not decoded yet.
    raw: Vec<u8>,
    text: Vec<u8>,
    /// The bytes of `text` that were passed on.
    used: usize,
}

impl<R: Read> Read for Decoded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.used == self.text.len() {
            let mut piece = [0; 1 << 14];
            let read = self.source.read(&mut piece)?;
            self.raw.extend_from_slice(&piece[..read]);
            self.text = self.decoder.decode(&mut self.raw, read == 0);
            self.used = 0;
            if read == 0 && self.text.is_empty() {
                return Ok(0);
            }
        }
        let read = (&self.text[self.used..]).read(buffer)?;
        self.used += read;
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A source that delivers at most `1` bytes at a time.
    struct Pieces<'a>(&'a [u8], usize);

    impl Read for Pieces<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let length = buffer.len().min(self.1);
            self.0.read(&mut buffer[..length])
        }
    }

    /// The lines with their numbers, or the fault.
    fn lines_of(text: &[u8], piece: usize) -> Result<Vec<(Vec<u8>, u64)>, String> {
        let (mut source, mut all) = (Pieces(text, piece), Vec::new());
        let each = |line: &[u8], number| {
            all.push((line.to_vec(), number));
            Ok(())
        };
        Input::new(&mut source).each_line(each).map_err(|error| error.to_string())?;
        Ok(all)
    }

    #[test]
    fn all_three_line_ends_count_once() {
        let expected: Vec<(Vec<u8>, u64)> =
            ["a", "b", "c", "", "d", "", "e"].iter().zip(1..).map(|(line, number)| (line.as_bytes().to_vec(), number)).collect();
        assert_eq!(lines_of(b"a\nb\r\nc\r\rd\n\re", 1), Ok(expected));
    }

    #[test]
    fn a_line_of_the_limit_passes_and_one_byte_more_does_not() {
        let longest = vec![b'x'; LONGEST_LINE];
        assert_eq!(lines_of(&[&longest[..], b"\r\n"].concat(), 1000).unwrap().len(), 1);
        for (before, after, line) in [("", "", 1), ("", "\n", 1), ("\n", "\n", 2)] {
            let text = [before.as_bytes(), &longest, b"x", after.as_bytes()].concat();
            for piece in [1000, usize::MAX] {
                assert_eq!(lines_of(&text, piece), Err(too_long().at_line(line).to_string()));
            }
        }
    }

    #[test]
    fn words_may_stand_on_any_line() {
        let mut source = Pieces(b" one\t\n\n two three left out\nfour", 3);
        let mut input = Input::new(&mut source);
        let mut word = |expected: Option<&[u8]>, number| {
            assert_eq!(input.word().unwrap(), expected);
            assert_eq!(input.number(), number);
            if expected == Some(b"three") {
                input.skip_words();
            }
        };
        word(Some(b"one"), 1);
        word(Some(b"two"), 3);
        word(Some(b"three"), 3);
        word(Some(b"four"), 4);
        word(None, 4);
    }

    #[test]
    fn bytes_are_taken_or_skipped_up_to_the_end() {
        let bytes: Vec<u8> = (0..=250).cycle().take(2 * BUFFER).collect();
        let mut source = Pieces(&bytes, 777);
        let mut input = Input::new(&mut source);
        assert_eq!(input.block(1000).unwrap(), Some(&bytes[..1000]));
        assert_eq!(input.skip(BUFFER as u64).unwrap(), BUFFER as u64);
        assert_eq!(input.block(2).unwrap(), Some(&bytes[BUFFER + 1000..BUFFER + 1002]));
        assert_eq!(input.offset(), BUFFER as u64 + 1002);
        assert_eq!(input.skip(u64::MAX).unwrap(), BUFFER as u64 - 1002);
        assert_eq!(input.block(1).unwrap(), None);
    }

    proptest! {
        #[test]
        fn lines_do_not_depend_on_the_pieces(text in "[a\r\n]{0,40}", piece in 1_usize..8) {
            prop_assert_eq!(lines_of(text.as_bytes(), piece), lines_of(text.as_bytes(), usize::MAX));
        }
    }

    fn decoded(bytes: &[u8]) -> String {
        let mut text = String::new();
        Utf16::by_mark(bytes).unwrap().of(bytes).read_to_string(&mut text).unwrap();
        text
    }

    proptest! {
        #[test]
        fn text_is_decoded_in_either_order(text in "\\PC{0,20}", is_big: bool, count in 1_usize..3000) {
            let text = format!("\u{feff}{}", text.repeat(count));
            let units = text.encode_utf16();
            let bytes: Vec<u8> = units.flat_map(|unit| if is_big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect();
            prop_assert_eq!(decoded(&bytes), text);
        }
    }

    #[test]
    fn invalid_units_are_replaced() {
        let bytes = b"\xff\xfe\x00\xd8\x00\xd8\x31\x00\x00\xdc\x32\x00\x00\xd8";
        assert_eq!(decoded(bytes), "\u{feff}\u{fffd}\u{fffd}1\u{fffd}2\u{fffd}");
    }
}
