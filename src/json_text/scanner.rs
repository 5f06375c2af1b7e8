//! The scan of a JSON text, which checks its syntax in steps.

use super::{BadName, JsonError, JsonMembers, JsonText, STEP, decoded};

/// The end of a scan before the end of the value, for the reason that [`Scanner::error`] returns. It has no content, so
/// that results are passed in registers.
pub(super) struct Ended;

/// An array or an object that a scan is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Open {
    Array,
    Object,
}

/// A scan of a JSON text.
pub(super) struct Scanner<'a, 's> {
    text: &'a [u8],
    at: usize,
    next_check: usize,
    stop: &'s dyn Fn() -> bool,
    /// After a violation of the syntax, which is within the next few bytes: a text after which the same bytes are refused
    /// for the same reason.
    context: Option<&'static str>,
}

impl<'a, 's> Scanner<'a, 's> {
    pub(super) fn new(text: &'a [u8], stop: &'s dyn Fn() -> bool) -> Self {
        Self { text, at: 0, next_check: STEP, stop, context: None }
    }

    /// The reason why the scan has ended before the end of the value.
    pub(super) fn error(&self) -> JsonError {
        self.context.map_or_else(JsonError::cancelled, |context| JsonError::of_violation(context, self.text, self.at))
    }

    #[inline]
    pub(super) fn next(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    /// The position of the next byte.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// Skips `byte` if it comes next.
    pub(super) fn takes(&mut self, byte: u8) -> bool {
        let found = self.next() == Some(byte);
        self.at += usize::from(found);
        found
    }

    /// Checks for cancellation if a step is complete.
    #[inline]
    fn step(&mut self) -> Result<(), Ended> {
        if self.at < self.next_check { Ok(()) } else { self.check() }
    }

    #[cold]
    fn check(&mut self) -> Result<(), Ended> {
        self.next_check = self.at + STEP;
        if (self.stop)() { Err(Ended) } else { Ok(()) }
    }

    /// Skips the bytes that `is_skipped` accepts.
    fn skip(&mut self, is_skipped: impl Fn(u8) -> bool) -> Result<(), Ended> {
        loop {
            let piece = &self.text[self.at..self.text.len().min(self.at + STEP)];
            if let Some(skipped) = piece.iter().position(|byte| !is_skipped(*byte)) {
                self.at += skipped;
                return Ok(());
            }
            self.at += piece.len();
            if self.at == self.text.len() {
                return Ok(());
            }
            self.check()?;
        }
    }

    #[inline]
    pub(super) fn blanks(&mut self) -> Result<(), Ended> {
        if self.next().is_some_and(|byte| byte > b' ') {
            return Ok(());
        }
        // Most blanks are single.
        self.at += usize::from(matches!(self.next(), Some(b' ' | b'\n' | b'\t' | b'\r')));
        if self.next().is_some_and(|byte| byte > b' ') {
            return Ok(());
        }
        self.skip(|byte| matches!(byte, b' ' | b'\n' | b'\t' | b'\r'))
    }

    #[cold]
    fn violation<T>(&mut self, context: &'static str) -> Result<T, Ended> {
        self.context = Some(context);
        Err(Ended)
    }

    /// Only blanks follow.
    pub(super) fn end(&mut self) -> Result<(), Ended> {
        self.blanks()?;
        if self.at < self.text.len() { self.violation("0 ") } else { Ok(()) }
    }

    /// Whether another item follows in an array whose syntax has been checked. Skips blanks and the comma.
    pub(super) fn has_more_items(&mut self) -> Result<bool, Ended> {
        self.blanks()?;
        if self.next() == Some(b',') {
            self.at += 1;
            self.blanks()?;
        }
        Ok(self.next() != Some(b']'))
    }

    /// Scans the members of an object of `text`, which begins with the next byte. The first `most` are kept. The inner
    /// error is the first name that cannot be decoded.
    pub(super) fn members(&mut self, text: &'a str, most: usize) -> Result<Result<JsonMembers<'a>, BadName<'a>>, Ended> {
        let mut members = JsonMembers { kept: Vec::with_capacity(8), unkept: 0 };
        let mut bad_name = None;
        self.at += 1;
        self.blanks()?;
        let mut is_first = true;
        while !(is_first && self.next() == Some(b'}')) {
            if self.next() != Some(b'"') {
                return self.violation(if is_first { "{" } else { "{\"\":0," });
            }
            let name = self.at;
            self.string()?;
            let name = &text[name..self.at];
            self.blanks()?;
            if self.next() != Some(b':') {
                return self.violation("{\"\" ");
            }
            self.at += 1;
            self.blanks()?;
            let value = self.at;
            self.value()?;
            if members.kept.len() == most {
                members.unkept += 1;
            } else if bad_name.is_none() {
                match decoded(name) {
                    Ok(name) => members.kept.push((name, JsonText(&text[value..self.at]))),
                    Err(name) => bad_name = Some(name),
                }
            }
            is_first = false;
            self.blanks()?;
            match self.next() {
                Some(b',') => self.at += 1,
                Some(b'}') => break,
                _ => return self.violation("{\"\":0 "),
            }
            self.blanks()?;
        }
        self.at += 1;
        Ok(bad_name.map_or(Ok(members), Err))
    }

    /// Scans a value, after blanks, and returns its text.
    pub(super) fn value(&mut self) -> Result<&'a [u8], Ended> {
        self.blanks()?;
        let first = self.at;
        // The arrays and objects around the innermost one, and that one.
        let (mut outer, mut inner) = (Vec::new(), None);
        loop {
            self.step()?;
            self.blanks()?;
            let mut is_complete = true;
            match self.next() {
                Some(b'0'..=b'9' | b'-') => self.number()?,
                Some(b'"') => self.string()?,
                Some(bracket @ (b'[' | b'{')) => {
                    outer.extend(inner.replace(if bracket == b'[' { Open::Array } else { Open::Object }));
                    self.at += 1;
                    is_complete = false;
                }
                Some(b't') => self.word(b"true")?,
                Some(b'f') => self.word(b"false")?,
                Some(b'n') => self.word(b"null")?,
                _ => return self.violation(""),
            }
            // After a value a comma or closing brackets follow, after an opening bracket a closing one or the first item.
            let open = loop {
                let Some(open) = inner else { return Ok(&self.text[first..self.at]) };
                self.blanks()?;
                match (self.next(), open) {
                    (Some(b','), _) if is_complete => {
                        self.at += 1;
                        break open;
                    }
                    (Some(b']'), Open::Array) | (Some(b'}'), Open::Object) => {
                        self.at += 1;
                        inner = outer.pop();
                        is_complete = true;
                        self.step()?;
                    }
                    (Some(_), _) if !is_complete => break open,
                    (_, Open::Array) => return self.violation(if is_complete { "[0 " } else { "[" }),
                    (_, Open::Object) => return self.violation(if is_complete { "{\"\":0 " } else { "{" }),
                }
            };
            if open == Open::Object {
                self.blanks()?;
                if self.next() != Some(b'"') {
                    return self.violation(if is_complete { "{\"\":0," } else { "{" });
                }
                self.string()?;
                self.blanks()?;
                if self.next() != Some(b':') {
                    return self.violation("{\"\" ");
                }
                self.at += 1;
            }
        }
    }

    /// Scans a word that begins with the next byte.
    fn word(&mut self, word: &[u8]) -> Result<(), Ended> {
        if !self.text[self.at..].starts_with(word) {
            return self.violation("");
        }
        self.at += word.len();
        Ok(())
    }

    /// Scans a number that begins with the next byte.
    #[inline]
    fn number(&mut self) -> Result<(), Ended> {
        let first = self.at;
        self.at += usize::from(self.text[first] == b'-');
        match self.next() {
            Some(b'0') => {
                self.at += 1;
                if self.next().is_some_and(|byte| byte.is_ascii_digit()) {
                    self.at = first;
                    return self.violation("");
                }
            }
            Some(b'1'..=b'9') => self.digits()?,
            _ => {
                self.at = first;
                return self.violation("");
            }
        }
        if self.next() == Some(b'.') {
            self.at += 1;
            self.at_least_one_digit(self.at - 1)?;
        }
        if let Some(b'e' | b'E') = self.next() {
            let exponent = self.at;
            self.at += 1;
            self.at += usize::from(matches!(self.next(), Some(b'+' | b'-')));
            self.at_least_one_digit(exponent)?;
        }
        Ok(())
    }

    /// Skips the digits after the sign of a fraction or an exponent, which is at `sign`.
    #[inline]
    fn at_least_one_digit(&mut self, sign: usize) -> Result<(), Ended> {
        if self.next().is_some_and(|byte| byte.is_ascii_digit()) {
            return self.digits();
        }
        self.at = sign;
        self.violation("1")
    }

    /// Skips digits.
    #[inline]
    fn digits(&mut self) -> Result<(), Ended> {
        let end = self.text.len().min(self.at + STEP);
        let mut at = self.at;
        while at < end && self.text[at].is_ascii_digit() {
            at += 1;
        }
        self.at = at;
        if at == end { self.skip(|byte| byte.is_ascii_digit()) } else { Ok(()) }
    }

    /// Scans a string that begins with the next byte.
    #[inline]
    fn string(&mut self) -> Result<(), Ended> {
        /// The number of bytes that are compared at once.
        const LANES: usize = 16;
        let is_plain = |byte: u8| byte >= b' ' && byte != b'"' && byte != b'\\';
        self.at += 1;
        loop {
            while let Some(lanes) = self.text[self.at..].first_chunk::<LANES>()
                && lanes.iter().fold(true, |all, byte| all & is_plain(*byte))
            {
                self.at += LANES;
                self.step()?;
            }
            while self.next().is_some_and(is_plain) {
                self.at += 1;
            }
            match self.next() {
                Some(b'"') => {
                    self.at += 1;
                    return Ok(());
                }
                Some(b'\\') => self.escape()?,
                _ => return self.violation("\""),
            }
        }
    }

    /// Scans an escape that begins with the next byte.
    fn escape(&mut self) -> Result<(), Ended> {
        self.step()?;
        let is_hex = |digits: &[u8]| digits.iter().all(u8::is_ascii_hexdigit);
        self.at += match self.text.get(self.at + 1) {
            Some(b'"' | b'\\' | b'/' | b'b' | b'f' | b'n' | b'r' | b't') => 2,
            Some(b'u') if self.text.get(self.at + 2..self.at + 6).is_some_and(is_hex) => 6,
            _ => return self.violation("\""),
        };
        Ok(())
    }
}
