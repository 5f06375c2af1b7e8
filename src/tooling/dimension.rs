//! Numbers and lengths as tool libraries write them: JSON numbers or text, with a decimal point or comma, with or without a unit.

use super::{HIGHEST_SPINDLE_SPEED, MOST_TEETH, quoted};
use crate::file_fault::Flaw;
use crate::quantity::Length;
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// A unit of length, in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LengthUnit(f64);

impl LengthUnit {
    pub(super) const MILLIMETRE: Self = Self(1.0);
    pub(super) const INCH: Self = Self(25.4);

    /// The unit of this name.
    pub(super) fn named(name: &str) -> Option<Self> {
        let mm = match name.to_lowercase().as_str() {
            "um" | "µm" | "μm" => 1e-3,
            "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => 1.0,
            "cm" => 10.0,
            "m" => 1000.0,
            "in" | "inch" | "inches" | "\"" => 25.4,
            "mil" | "thou" => 0.0254,
            _ => return None,
        };
        Some(Self(mm))
    }

    /// A length of `value` units; zero or less is out of range.
    pub(super) fn length(self, value: f64) -> Result<Length, Flaw> {
        Length::from_mm(value * self.0).map_err(|bounds| {
            let expected = format!("a length from {} mm to {} mm", bounds.minimum, bounds.maximum);
            Flaw::out_of_range(expected, shown(value * self.0))
        })
    }

    /// A length of `value` units; `None` for 0, which means unknown.
    pub(super) fn length_unless_zero(self, value: f64) -> Result<Option<Length>, Flaw> {
        if value == 0.0 { Ok(None) } else { self.length(value).map(Some) }
    }
}

/// Parses `text`, trimmed, as a number with a decimal point or a decimal comma. A text with both is refused, because
/// the comma may separate thousands.
pub(super) fn number(text: &str) -> Result<f64, Flaw> {
    let bare = text.trim();
    let wrong = || Flaw::malformed("a number with a decimal point or a decimal comma", quoted(bare));
    let is_plain = bare.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b',' | b'e' | b'E'));
    let marks = bare.bytes().filter(|byte| matches!(byte, b'.' | b',')).count();
    if !is_plain || marks > 1 {
        return Err(wrong());
    }
    let value: f64 = bare.replace(',', ".").parse().map_err(|_| wrong())?;
    if value.is_finite() { Ok(value) } else { Err(Flaw::out_of_range("a finite number", quoted(bare))) }
}

/// Refuses a spindle speed such as `12,000` or `12.000`, which can mean twelve or twelve thousand.
pub(super) fn unambiguous_thousands(text: &str) -> Result<(), Flaw> {
    let bare = text.trim();
    let is_group = bare.split_once(['.', ',']).is_some_and(|(before, after)| {
        let digits = before.bytes().chain(after.bytes()).all(|byte| byte.is_ascii_digit());
        digits && (1..=3).contains(&before.len()) && !before.starts_with('0') && after.len() == 3
    });
    if !is_group {
        return Ok(());
    }
    let found = format!("{}: either three decimals, or a mark between thousands", quoted(bare));
    Err(Flaw::malformed("a spindle speed without a mark between thousands", found))
}

/// An angle in degrees, with or without its unit: `10.00 °`, `10 deg`, `10`.
pub(super) fn angle_deg(text: &str) -> Result<f64, Flaw> {
    number(text.trim().trim_end_matches(['°', 'd', 'e', 'g']))
}

/// A number and the unit after it, as in `6.0000 mm`, `0,25 in` or `1/4"` without the fraction.
pub(super) fn number_with_unit(text: &str) -> Result<(f64, LengthUnit), Flaw> {
    let bare = text.trim();
    let digits = bare.rfind(|c: char| c.is_ascii_digit() || matches!(c, '.' | ',')).map_or(0, |at| at + 1);
    let (value, unit) = bare.split_at(digits);
    let unit = LengthUnit::named(unit.trim())
        .ok_or_else(|| Flaw::malformed("a length with its unit, such as \"6.0 mm\" or \"0.25 in\"", quoted(bare)))?;
    Ok((number(value)?, unit))
}

/// A length in mm as faults show it, rounded to a nanometre.
pub(super) fn shown(mm: f64) -> String {
    format!("{} mm", (mm * 1e6).round() / 1e6)
}

/// A number of teeth; 0 means unknown.
pub(super) fn teeth(value: f64) -> Result<Option<u32>, Flaw> {
    let whole = whole(value).filter(|teeth| *teeth <= MOST_TEETH);
    let teeth = whole.ok_or_else(|| Flaw::out_of_range(format!("a whole number of teeth up to {MOST_TEETH}"), value.to_string()))?;
    Ok((teeth > 0).then_some(teeth))
}

/// The number of a tool.
pub(super) fn tool_number(value: f64) -> Result<u32, Flaw> {
    whole(value).ok_or_else(|| Flaw::out_of_range("a whole number that is not negative", value.to_string()))
}

/// A spindle speed, in rpm; 0 means unknown.
pub(super) fn spindle_speed(value: f64) -> Result<Option<f64>, Flaw> {
    if value == 0.0 {
        return Ok(None);
    }
    let is_fine = (1.0..=HIGHEST_SPINDLE_SPEED).contains(&value);
    let wrong = || Flaw::out_of_range(format!("a spindle speed from 1 to {HIGHEST_SPINDLE_SPEED} rpm"), value.to_string());
    if is_fine { Ok(Some(value)) } else { Err(wrong()) }
}

fn whole(value: f64) -> Option<u32> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be whole and within 32 bits")]
    let whole = (value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value)).then_some(value as u32);
    whole
}

/// The value of a member that is expected to be a number or a text.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Scalar {
    Number(f64),
    Text(String),
    /// A value of another kind, with its description.
    Other(&'static str),
}

impl Scalar {
    /// The number, or the number that the text contains.
    pub(super) fn number(&self) -> Result<f64, Flaw> {
        match self {
            Self::Number(value) => Ok(*value),
            Self::Text(text) => number(text),
            Self::Other(kind) => Err(Flaw::malformed("a number", *kind)),
        }
    }

    /// The text; for a number, its digits.
    pub(super) fn text(&self) -> Result<String, Flaw> {
        match self {
            Self::Number(value) => Ok(value.to_string()),
            Self::Text(text) => Ok(text.clone()),
            Self::Other(kind) => Err(Flaw::malformed("a text", *kind)),
        }
    }

    /// The value as shown in a fault.
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Number(value) => value.to_string(),
            Self::Text(text) => quoted(text),
            Self::Other(kind) => (*kind).to_owned(),
        }
    }
}

impl<'de> Deserialize<'de> for Scalar {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ScalarVisitor)
    }
}

struct ScalarVisitor;

impl<'de> Visitor<'de> for ScalarVisitor {
    type Value = Scalar;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a text")
    }

    fn visit_f64<E>(self, value: f64) -> Result<Scalar, E> {
        Ok(Scalar::Number(value))
    }

    #[expect(clippy::cast_precision_loss, reason = "as JSON numbers are read everywhere")]
    fn visit_u64<E>(self, value: u64) -> Result<Scalar, E> {
        Ok(Scalar::Number(value as f64))
    }

    #[expect(clippy::cast_precision_loss, reason = "as JSON numbers are read everywhere")]
    fn visit_i64<E>(self, value: i64) -> Result<Scalar, E> {
        Ok(Scalar::Number(value as f64))
    }

    fn visit_str<E>(self, text: &str) -> Result<Scalar, E> {
        Ok(Scalar::Text(text.to_owned()))
    }

    fn visit_bool<E>(self, value: bool) -> Result<Scalar, E> {
        Ok(Scalar::Other(if value { "true" } else { "false" }))
    }

    fn visit_unit<E>(self) -> Result<Scalar, E> {
        Ok(Scalar::Other("null"))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Scalar, A::Error> {
        while items.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Scalar::Other("an array"))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Scalar, A::Error> {
        while members.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Scalar::Other("an object"))
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "decimal fractions are parsed to the nearest double")]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_one_decimal_mark() {
        for (text, value) in [("6", 6.0), (" 0.25 ", 0.25), ("5,00", 5.0), ("-1e-3", -1e-3), ("\u{a0}3,5", 3.5)] {
            assert_eq!(number(text).unwrap(), value, "{text}");
        }
        for text in ["", ",", "1,234.5", "1.2.3", "six", "0x10", "1 2", "nan", "inf", "1e999"] {
            assert!(number(text).is_err(), "{text}");
        }
    }

    #[test]
    fn lengths_carry_their_unit() {
        for (text, mm) in [("6.0000 mm", 6.0), ("5,00 mm", 5.0), ("0.25 in", 6.35), ("0.25\"", 6.35), ("3\u{a0}cm", 30.0), ("500 µm", 0.5)]
        {
            let (value, unit) = number_with_unit(text).unwrap();
            approx::assert_relative_eq!(unit.length(value).unwrap().mm(), mm, max_relative = 1e-15);
        }
        for text in ["6", "mm", "", "6 furlongs", "six mm", "1,000.0 mm"] {
            assert!(number_with_unit(text).is_err(), "{text}");
        }
    }

    #[test]
    fn counts_are_whole_and_bounded() {
        assert_eq!((teeth(0.0), teeth(4.0)), (Ok(None), Ok(Some(4))));
        assert!([-1.0, 2.5, 101.0, 1e30, f64::NAN].into_iter().all(|value| teeth(value).is_err()));
        assert_eq!((spindle_speed(0.0), spindle_speed(12e3)), (Ok(None), Ok(Some(12e3))));
        assert!([-1.0, 0.5, 1e8, f64::NAN].into_iter().all(|value| spindle_speed(value).is_err()));
    }
}
