//! The fast reader of plain values in JSON text whose syntax has not been checked: objects of known members, numbers
//! and arrays of numbers. It refuses everything else, valid or not, so that the general reader can find the faults.

use super::JsonText;

/// A JSON text and the position up to which it has been read.
#[derive(Debug, Clone)]
pub(crate) struct PlainJson<'a> {
    text: &'a [u8],
    at: usize,
}

/// The text has something that the fast reader does not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Unusual;

/// A value that the fast reader reads.
pub(crate) trait PlainValue: Copy {
    /// Reads the next value, after blanks.
    fn read(json: &mut PlainJson<'_>) -> Result<Self, Unusual>;
}

impl PlainValue for f64 {
    #[inline]
    fn read(json: &mut PlainJson<'_>) -> Result<Self, Unusual> {
        json.number()
    }
}

impl PlainValue for u32 {
    #[inline]
    fn read(json: &mut PlainJson<'_>) -> Result<Self, Unusual> {
        json.whole_number()
    }
}

impl<T: PlainValue + Default, const N: usize> PlainValue for [T; N] {
    #[inline]
    fn read(json: &mut PlainJson<'_>) -> Result<Self, Unusual> {
        let mut items = [T::default(); N];
        json.expect(b'[')?;
        for (index, item) in items.iter_mut().enumerate() {
            if index > 0 {
                json.expect(b',')?;
            }
            *item = T::read(json)?;
        }
        json.expect(b']')?;
        Ok(items)
    }
}

/// 10^0 to 10^22, the powers of ten that are doubles without rounding.
const EXACT_POWERS: [f64; 23] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22];

/// No name that is read is longer.
const LONGEST_NAME: usize = 64;

/// The most decimal digits of which every number fits into 64 bits.
const MOST_DIGITS: usize = 19;

impl<'a> PlainJson<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0 }
    }

    /// The position of the next byte.
    pub(crate) fn position(&self) -> usize {
        self.at
    }

    /// Continues at `position`, which is in the text or at its end.
    pub(crate) fn seek(&mut self, position: usize) {
        self.at = position;
    }

    fn next(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    #[inline]
    pub(crate) fn skip_blank(&mut self) {
        while let Some(b' ' | b'\n' | b'\t' | b'\r') = self.next() {
            self.at += 1;
        }
    }

    /// Reads `byte`, after blanks.
    #[inline]
    pub(crate) fn expect(&mut self, byte: u8) -> Result<(), Unusual> {
        if self.takes(byte) { Ok(()) } else { Err(Unusual) }
    }

    /// Reads `byte`, after blanks, if it comes next.
    #[inline]
    pub(crate) fn takes(&mut self, byte: u8) -> bool {
        self.skip_blank();
        let found = self.next() == Some(byte);
        self.at += usize::from(found);
        found
    }

    /// Whether the text ends here, blanks aside.
    pub(crate) fn is_at_end(&mut self) -> bool {
        self.skip_blank();
        self.at == self.text.len()
    }

    /// Reads a string without escapes, of printable ASCII characters.
    #[inline]
    pub(crate) fn name(&mut self) -> Result<&'a str, Unusual> {
        self.expect(b'"')?;
        let start = self.at;
        while let Some(byte) = self.next() {
            match byte {
                _ if self.at - start > LONGEST_NAME => return Err(Unusual),
                b'"' => {
                    let name = std::str::from_utf8(&self.text[start..self.at]).map_err(|_| Unusual);
                    self.at += 1;
                    return name;
                }
                b'\\' => return Err(Unusual),
                b' '..=b'~' => self.at += 1,
                _ => return Err(Unusual),
            }
        }
        Err(Unusual)
    }

    /// Reads a number of finite double precision, the nearest double to its decimal.
    #[inline]
    pub(crate) fn number(&mut self) -> Result<f64, Unusual> {
        self.skip_blank();
        let start = self.at;
        let is_negative = self.next() == Some(b'-');
        self.at += usize::from(is_negative);
        let mut number = 0_u64;
        let whole = self.digits(&mut number);
        // A number begins with 0 only if that is all before the point.
        if whole == 0 || (whole > 1 && self.text[self.at - whole] == b'0') {
            return Err(Unusual);
        }
        let mut decimals = 0;
        if self.next() == Some(b'.') {
            self.at += 1;
            decimals = self.digits(&mut number);
            if decimals == 0 {
                return Err(Unusual);
            }
        }
        let has_exponent = matches!(self.next(), Some(b'e' | b'E'));
        if has_exponent {
            self.at += 1;
            self.at += usize::from(matches!(self.next(), Some(b'+' | b'-')));
            if self.digits(&mut 0) == 0 {
                return Err(Unusual);
            }
        } else if whole + decimals <= MOST_DIGITS && number <= 1 << f64::MANTISSA_DIGITS && decimals < EXACT_POWERS.len() {
            // Both are doubles without rounding, so that the quotient has the only one.
            #[expect(clippy::cast_precision_loss, reason = "at most 2^53")]
            let magnitude = number as f64 / EXACT_POWERS[decimals];
            return Ok(if is_negative { -magnitude } else { magnitude });
        }
        let text = std::str::from_utf8(&self.text[start..self.at]).map_err(|_| Unusual)?;
        text.parse().ok().filter(|number: &f64| number.is_finite()).ok_or(Unusual)
    }

    /// Reads a whole number of 32 bits in digits alone.
    #[inline]
    pub(crate) fn whole_number(&mut self) -> Result<u32, Unusual> {
        /// No number of 32 bits has more digits.
        const MOST: usize = 10;
        self.skip_blank();
        let mut number = 0;
        match (self.digits(&mut number), self.next()) {
            (1..=MOST, Some(b',' | b']' | b' ' | b'\n' | b'\t' | b'\r')) => u32::try_from(number).map_err(|_| Unusual),
            _ => Err(Unusual),
        }
    }

    /// Reads digits, appends them to `number` modulo 2^64, and returns their count.
    #[inline]
    fn digits(&mut self, number: &mut u64) -> usize {
        let start = self.at;
        while let Some(byte @ b'0'..=b'9') = self.next() {
            *number = number.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
            self.at += 1;
        }
        self.at - start
    }

    /// Reads null if it comes next, after blanks.
    #[inline]
    pub(crate) fn takes_null(&mut self) -> bool {
        self.skip_blank();
        let found = self.text[self.at..].starts_with(b"null");
        self.at += if found { 4 } else { 0 };
        found
    }

    /// Reads a value of any kind, unparsed. Once `stop` returns true, it ends early with an error.
    pub(crate) fn value(&mut self, stop: &dyn Fn() -> bool) -> Result<JsonText<'a>, Unusual> {
        self.skip_blank();
        let value = JsonText::first(&self.text[self.at..], stop).ok_or(Unusual)?;
        self.at += value.get().len();
        Ok(value)
    }

    /// Reads an object. `take` reads the value of a member, and returns false if it does not know the name.
    #[inline]
    pub(crate) fn object(&mut self, mut take: impl FnMut(&str, &mut Self) -> Result<bool, Unusual>) -> Result<(), Unusual> {
        let mut is_first = true;
        self.expect(b'{')?;
        while !self.takes(b'}') {
            if !std::mem::take(&mut is_first) {
                self.expect(b',')?;
            }
            let name = self.name()?;
            self.expect(b':')?;
            if !take(name, self)? {
                return Err(Unusual);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The number that makes up the whole text.
    fn number(text: &str) -> Option<f64> {
        let mut json = PlainJson::new(text.as_bytes());
        json.number().ok().filter(|_| json.is_at_end())
    }

    #[test]
    fn only_numbers_of_json_are_numbers() {
        for text in ["0", "-0", "0.1", "-12.50", "1e5", "1E-7", "1e+2", "40.123456", "5e-324", "1.7976931348623157e308", " 7\n", "-0.0"] {
            assert_eq!(number(text).map(f64::to_bits), serde_json::from_str(text).ok().map(f64::to_bits), "{text}");
        }
        let long =
            ["9007199254740993", "0.30000000000000004", "18446744073709551615", "100000000000000000000000", "0.00000000000000000000001"];
        for text in long {
            assert_eq!(number(text), Some(text.parse().unwrap()), "{text}");
        }
        for text in
            ["", "-", "+1", ".5", "1.", "01", "-01", "00", "1e", "1e+", "1.e5", "0x1", "1_0", "NaN", "-Infinity", "inf", "1 2", "1e999"]
        {
            assert_eq!(number(text), None, "{text}");
        }
    }

    #[test]
    fn arrays_have_their_length() {
        let triple = |text: &str| <[f64; 3]>::read(&mut PlainJson::new(text.as_bytes())).ok();
        assert_eq!(triple("[1, -2.5 ,3e1]"), Some([1.0, -2.5, 30.0]));
        for text in ["[1,2]", "[1,2,3,4]", "[1,2,3", "[1,2,]", "[1,,2]", "[,1,2,3]", "1", "[]", "{}", "[1,2,\"3\"]", "[1,2,null]"] {
            assert_eq!(triple(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn every_number_is_the_nearest_double(number_written in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL, digits in 0..20_usize) {
            for text in [format!("{number_written:?}"), format!("{:.digits$}", number_written % 1e6), format!("{number_written:.digits$e}")] {
                prop_assert_eq!(number(&text).map(f64::to_bits), Some(text.parse::<f64>().unwrap().to_bits()), "{}", text);
            }
        }
    }
}
