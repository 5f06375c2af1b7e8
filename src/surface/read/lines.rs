//! Splitting of chunks, which may end anywhere, into lines, and of lines into words.

use super::fault::{Fault, FaultKind, Flaw};

/// The longest line that is accepted, in bytes: far longer than any point, facet or polygon needs. It bounds the memory
/// of a reader of text.
pub(super) const LONGEST_LINE: usize = 1 << 16;

/// The splitter of chunks into lines. A line ends with LF, CR LF, or CR alone.
#[derive(Debug)]
pub(super) struct Lines {
    /// The incomplete line at the end of the last chunk.
    begun: Vec<u8>,
    /// The number of complete lines.
    ended: u64,
    /// Whether the last chunk ended with a CR, so that a LF at the start of the next belongs to the same line end.
    after_cr: bool,
}

impl Lines {
    /// A splitter that numbers the lines as if `before` lines preceded them.
    pub(super) fn after(before: u64) -> Self {
        Self { begun: Vec::new(), ended: before, after_cr: false }
    }

    /// Adds lines that were read in blocks to the count.
    pub(super) fn skip(&mut self, lines: u64) {
        self.ended += lines;
        // A LF after a CR belongs to those lines.
        self.after_cr = false;
    }

    /// The number of lines before the current one.
    pub(super) fn ended(&self) -> u64 {
        self.ended
    }

    /// The number of the current line, counted from 1.
    pub(super) fn number(&self) -> u64 {
        self.ended + 1
    }

    /// Passes every line that ends in `chunk` to `each`, without its line end.
    pub(super) fn push(&mut self, mut chunk: &[u8], mut each: impl FnMut(&[u8], u64) -> Result<(), Flaw>) -> Result<(), Fault> {
        if self.after_cr
            && let Some((&first, rest)) = chunk.split_first()
        {
            self.after_cr = false;
            chunk = if first == b'\n' { rest } else { chunk };
        }
        while let Some(end) = line_end(chunk) {
            let number = self.number();
            if self.begun.is_empty() {
                if end > LONGEST_LINE {
                    return Err(too_long().at_line(number));
                }
                each(&chunk[..end], number).map_err(|flaw| flaw.at_line(number))?;
            } else {
                self.begin(&chunk[..end])?;
                each(&self.begun, number).map_err(|flaw| flaw.at_line(number))?;
                self.begun.clear();
            }
            self.ended += 1;
            let ending = match (chunk[end], chunk.get(end + 1)) {
                (b'\r', Some(b'\n')) => 2,
                (b'\r', None) => {
                    self.after_cr = true;
                    1
                }
                _ => 1,
            };
            chunk = &chunk[end + ending..];
        }
        self.begin(chunk)
    }

    /// Passes the last line to `each` if it has no line end.
    pub(super) fn finish(&mut self, mut each: impl FnMut(&[u8], u64) -> Result<(), Flaw>) -> Result<(), Fault> {
        let number = self.number();
        let mut last = std::mem::take(&mut self.begun);
        // Old systems mark the end of a text with null bytes or Ctrl-Z.
        while last.pop_if(|byte| matches!(*byte, 0 | 0x1a)).is_some() {}
        if last.is_empty() { Ok(()) } else { each(&last, number).map_err(|flaw| flaw.at_line(number)) }
    }

    fn begin(&mut self, part: &[u8]) -> Result<(), Fault> {
        if self.begun.len() + part.len() > LONGEST_LINE {
            return Err(too_long().at_line(self.number()));
        }
        self.begun.extend_from_slice(part);
        Ok(())
    }
}

#[cold]
pub(super) fn too_long() -> Flaw {
    Flaw::new(FaultKind::TooLarge, format!("at most {LONGEST_LINE} bytes in a line"), "a longer one")
}

/// The position of the first CR or LF.
pub(super) fn line_end(bytes: &[u8]) -> Option<usize> {
    memchr::memchr2(b'\n', b'\r', bytes)
}

/// Whether `byte` separates words inside a line.
pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c)
}

/// `line` without the blanks before it.
pub(super) fn trimmed_start(mut line: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = line
        && is_blank(*first)
    {
        line = rest;
    }
    line
}

/// `line` without the blanks on both sides.
pub(super) fn trimmed(line: &[u8]) -> &[u8] {
    let mut line = trimmed_start(line);
    while let [rest @ .., last] = line
        && is_blank(*last)
    {
        line = rest;
    }
    line
}

/// The words of a line.
#[derive(Debug, Clone)]
pub(super) struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    pub(super) fn of(line: &'a [u8]) -> Self {
        Self(line)
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let line = trimmed_start(self.0);
        let end = line.iter().position(|byte| is_blank(*byte)).unwrap_or(line.len());
        let (word, rest) = line.split_at(end);
        self.0 = rest;
        (!word.is_empty()).then_some(word)
    }
}

/// Whether `text` starts with a number.
pub(super) fn starts_number(text: &[u8]) -> bool {
    matches!(text, [b'0'..=b'9', ..] | [b'+' | b'-' | b'.', b'0'..=b'9' | b'.', ..])
}

/// The lines that are not blank, trimmed.
pub(super) fn statements(mut text: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        while !text.is_empty() {
            let end = line_end(text).unwrap_or(text.len());
            let line = trimmed(&text[..end]);
            text = text.get(end + 1..).unwrap_or_default();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    })
}

/// Whether the first word of the line is `word`, in either case.
pub(super) fn is_word(line: &[u8], word: &[u8]) -> bool {
    Words::of(line).next().is_some_and(|first| first.eq_ignore_ascii_case(word))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lines_of(chunks: &[&[u8]]) -> Result<Vec<(Vec<u8>, u64)>, Fault> {
        let mut all = Vec::new();
        let mut lines = Lines::after(0);
        let mut each = |line: &[u8], number| {
            all.push((line.to_vec(), number));
            Ok(())
        };
        for chunk in chunks {
            lines.push(chunk, &mut each)?;
        }
        lines.finish(&mut each)?;
        Ok(all)
    }

    #[test]
    fn all_three_line_ends_count_once() {
        let found = lines_of(&[b"a\nb\r\nc\r\rd\n\re"]).unwrap();
        let expected: Vec<(Vec<u8>, u64)> =
            ["a", "b", "c", "", "d", "", "e"].iter().zip(1..).map(|(line, number)| (line.as_bytes().to_vec(), number)).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn a_line_of_the_limit_passes_and_one_byte_more_does_not() {
        let longest = vec![b'x'; LONGEST_LINE];
        let longer = vec![b'x'; LONGEST_LINE + 1];
        assert_eq!(lines_of(&[&longest, b"\n"]).unwrap().len(), 1);
        for chunks in [vec![&longer[..]], vec![&longer[..], b"\n"], vec![&longest[..], b"x", b"\n"]] {
            assert_eq!(lines_of(&chunks).unwrap_err(), too_long().at_line(1));
        }
        let with_end: Vec<u8> = [&b"\n"[..], &longer, b"\n"].concat();
        assert_eq!(lines_of(&[&with_end]).unwrap_err(), too_long().at_line(2));
    }

    #[test]
    fn words_are_separated_by_blanks() {
        let words: Vec<&[u8]> = Words::of(b" \t one  two\x0cthree ").collect();
        assert_eq!(words, [&b"one"[..], b"two", b"three"]);
        assert_eq!(trimmed(b" \t a b \t"), b"a b");
    }

    proptest! {
        #[test]
        fn lines_do_not_depend_on_the_chunks(text in "[a\r\n]{0,40}", cuts in proptest::collection::vec(0_usize..40, 0..6)) {
            let mut cuts: Vec<usize> = cuts.into_iter().map(|cut| cut.min(text.len())).collect();
            cuts.sort_unstable();
            let edges: Vec<usize> = std::iter::once(0).chain(cuts).chain([text.len()]).collect();
            let chunks: Vec<&[u8]> = edges.windows(2).map(|pair| &text.as_bytes()[pair[0]..pair[1]]).collect();
            prop_assert_eq!(lines_of(&chunks), lines_of(&[text.as_bytes()]));
        }
    }
}
