//! A streaming decoder of UTF-16 with a byte-order mark to UTF-8.

/// The decoder. Chunks may end anywhere.
#[derive(Debug)]
pub(super) struct Utf16 {
    is_big: bool,
    /// The first byte of a unit whose second byte has not arrived.
    half: Option<u8>,
    /// The first unit of a surrogate pair whose second unit has not arrived.
    high: Option<u16>,
}

impl Utf16 {
    /// A decoder for a file that begins with `start`, if that begins with a byte-order mark of UTF-16.
    pub(super) fn by_mark(start: &[u8]) -> Option<Self> {
        let is_big = match start {
            [0xff, 0xfe, ..] => false,
            [0xfe, 0xff, ..] => true,
            _ => return None,
        };
        Some(Self { is_big, half: None, high: None })
    }

    /// The next bytes of the file as UTF-8. The byte-order mark becomes that of UTF-8; invalid units become U+FFFD.
    pub(super) fn decode(&mut self, chunk: &[u8]) -> Vec<u8> {
        let mut text = String::with_capacity(chunk.len());
        for &byte in chunk {
            match self.half.take() {
                None => self.half = Some(byte),
                Some(first) if self.is_big => self.unit(u16::from_be_bytes([first, byte]), &mut text),
                Some(first) => self.unit(u16::from_le_bytes([first, byte]), &mut text),
            }
        }
        text.into_bytes()
    }

    fn unit(&mut self, unit: u16, text: &mut String) {
        let mut decode = |units: &[u16]| {
            text.extend(char::decode_utf16(units.iter().copied()).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)));
        };
        let is_high = (0xd800..0xdc00).contains(&unit);
        match self.high.take() {
            // Two high surrogates in a row: the first has no low surrogate.
            Some(high) if is_high => decode(&[high]),
            Some(high) => return decode(&[high, unit]),
            None if !is_high => return decode(&[unit]),
            None => {}
        }
        self.high = Some(unit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn chunks_that_end_anywhere_give_the_same_text(text in "\\PC{0,20}", is_big: bool, size in 1_usize..5) {
            let units = format!("\u{feff}{text}").encode_utf16().collect::<Vec<_>>();
            let bytes: Vec<u8> = units.iter().flat_map(|unit| if is_big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect();
            let mut decoder = Utf16::by_mark(&bytes).unwrap();
            let decoded: Vec<u8> = bytes.chunks(size).flat_map(|chunk| decoder.decode(chunk)).collect();
            prop_assert_eq!(String::from_utf8(decoded).unwrap(), format!("\u{feff}{text}"));
        }
    }

    #[test]
    fn invalid_units_are_replaced() {
        let mut decoder = Utf16::by_mark(b"\xff\xfe").unwrap();
        assert_eq!(decoder.decode(b"\x00\xd8\x00\xd8\x31\x00\x00\xdc\x32\x00"), "\u{fffd}\u{fffd}1\u{fffd}2".as_bytes());
    }
}
