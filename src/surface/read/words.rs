//! The words of a line.

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

    #[test]
    fn words_are_separated_by_blanks() {
        let words: Vec<&[u8]> = Words::of(b" \t one  two\x0cthree ").collect();
        assert_eq!(words, [&b"one"[..], b"two", b"three"]);
        assert_eq!(trimmed(b" \t a b \t"), b"a b");
    }
}
