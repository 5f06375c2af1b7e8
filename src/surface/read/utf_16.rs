//! A decoder of UTF-16 with a byte-order mark to UTF-8.

use std::io::{self, Read};

/// The decoder.
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
