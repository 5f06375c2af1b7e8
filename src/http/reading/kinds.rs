//! The kinds of values that members take: quantities, whole numbers, vectors and words.

use super::array::each_raw;
use super::object::description;
use super::{Components, Faulted, Faults, JsonPath, Kind, describe, not_finite};
use crate::http::codes::RequestFault;
use crate::milling::Contact;
use crate::quantity::{Angle, Length, OutOfRange};
use serde::Deserialize;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{Deprecated, RefOr, Schema};

/// A number that becomes a quantity; its bounds come from the quantity's constructor.
pub(crate) struct Quantity<T> {
    /// Constructs the quantity from a number in the member's unit. It must return the bounds as the error for NaN.
    of: fn(f64) -> Result<T, OutOfRange>,
    example: f64,
    /// The smallest number, if it is below the quantity's own bound.
    minimum: Option<f64>,
    /// A text for the fault of a number out of bounds.
    hint: &'static str,
}

impl<T> Quantity<T> {
    pub(crate) const fn new(of: fn(f64) -> Result<T, OutOfRange>, example: f64) -> Self {
        Self { of, example, minimum: None, hint: "" }
    }

    /// A quantity that also accepts numbers from `minimum` up to the quantity's own bound. `hint` explains
    /// them.
    pub(crate) const fn down_to(self, minimum: f64, hint: &'static str) -> Self {
        Self { minimum: Some(minimum), hint, ..self }
    }

    /// The schema of its numbers.
    fn number(&self, about: &str) -> ObjectBuilder {
        let Err(OutOfRange { minimum, maximum }) = (self.of)(f64::NAN) else { unreachable!("NaN is not a quantity") };
        // The limits of double precision are not bounds of the quantity.
        let bound = |bound: f64| (bound.abs() < f64::MAX).then_some(bound);
        let schema = ObjectBuilder::new().schema_type(Type::Number).description(description(about)).examples([self.example]);
        schema.minimum(self.minimum.or(bound(minimum))).maximum(bound(maximum))
    }
}

impl Quantity<Length> {
    /// A length in mm.
    pub(crate) const fn length(example: f64) -> Self {
        Self::new(Length::from_mm, example)
    }
}

impl Quantity<Angle> {
    /// A slope in degrees, 0 (floor) to 90 (wall).
    pub(crate) const fn slope(example: f64) -> Self {
        Self::new(|degrees| Contact::checked_slope_deg(degrees).and_then(Angle::from_degrees), example)
    }
}

impl<T> Kind for Quantity<T> {
    type Value = T;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<T, Faulted> {
        let hint = self.hint;
        (self.of)(number(raw, path, faults)?)
            .map_err(|bounds| faults.add(&path, RequestFault::OutOfRange, format_args!("{bounds}, found {}{hint}", describe(raw))))
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        self.number(about).into()
    }
}

/// A quantity whose member has a newer name.
pub(crate) struct Renamed<T>(pub(crate) Quantity<T>);

impl<T> Kind for Renamed<T> {
    type Value = T;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<T, Faulted> {
        self.0.read(raw, path, faults)
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        self.0.number(about).deprecated(Some(Deprecated::True)).into()
    }
}

/// A whole number within bounds.
pub(crate) struct Whole {
    pub(crate) minimum: u32,
    pub(crate) maximum: u32,
    pub(crate) example: u32,
}

impl Kind for Whole {
    type Value = u32;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<u32, Faulted> {
        let value = number(raw, path, faults)?;
        let checked = OutOfRange::check(value, self.minimum.into(), self.maximum.into());
        let value =
            checked.map_err(|bounds| faults.add(&path, RequestFault::OutOfRange, format_args!("{bounds}, found {}", describe(raw))))?;
        if value.fract() != 0.0 {
            return Err(faults.add(&path, RequestFault::WrongType, format_args!("expected a whole number, found {}", describe(raw))));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole and between two u32 bounds")]
        Ok(value as u32)
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::Integer).description(description(about)).examples([self.example]);
        schema.minimum(Some(f64::from(self.minimum))).maximum(Some(f64::from(self.maximum))).into()
    }
}

/// Any finite number.
pub(crate) struct Number;

impl Kind for Number {
    type Value = f64;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<f64, Faulted> {
        number(raw, path, faults)
    }

    fn schema(&self, _: &str, _: &mut Components) -> RefOr<Schema> {
        ObjectBuilder::new().schema_type(Type::Number).into()
    }
}

/// Two or three numbers of the kind `of`.
pub(crate) struct Tuple<K, const N: usize> {
    pub(crate) of: K,
    pub(crate) example: [f64; N],
}

/// A vector of any length except zero.
pub(crate) type Vector = Tuple<Number, 3>;

/// Two numbers of the same quantity.
pub(crate) type NumberPair = Tuple<Quantity<f64>, 2>;

impl<K: Kind<Value = f64>, const N: usize> Kind for Tuple<K, N> {
    type Value = [f64; N];

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<[f64; N], Faulted> {
        let mut items = [raw; N];
        let count = each_raw(raw, "an array", path, faults, |index, item, _| {
            if let Some(place) = items.get_mut(index) {
                *place = item;
            }
        })?;
        if count != N {
            let expected = if N == 2 { "two" } else { "three" };
            let detail = format_args!("expected {expected} numbers, found {count} items");
            return Err(faults.add(&path, RequestFault::WrongType, detail));
        }
        // Every item is read, so that all faults are listed.
        let numbers: [_; N] = std::array::from_fn(|index| self.of.read(items[index], path.item(index), faults));
        let mut values = [0.0; N];
        for (value, number) in values.iter_mut().zip(numbers) {
            *value = number?;
        }
        Ok(values)
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let schema = ArrayBuilder::new().items(self.of.schema("", components)).min_items(Some(N)).max_items(Some(N));
        schema.description(description(about)).examples([serde_json::json!(self.example.as_slice())]).into()
    }
}

/// One of several words.
pub(crate) struct Choice<T: 'static> {
    /// The name of the words' schema in the OpenAPI document, if members share it.
    pub(crate) name: Option<&'static str>,
    pub(crate) words: &'static [(&'static str, T)],
}

impl<T> Choice<T> {
    /// The word of a value.
    pub(crate) fn word(&self, value: &T) -> &'static str
    where
        T: PartialEq,
    {
        let Some((word, _)) = self.words.iter().find(|(_, of_word)| of_word == value) else { unreachable!("every value has a word") };
        word
    }

    /// The schema of the words themselves.
    fn words_schema(&self) -> ObjectBuilder {
        ObjectBuilder::new().schema_type(Type::String).enum_values(Some(self.words.iter().map(|(word, _)| *word)))
    }
}

impl<T: Copy> Kind for Choice<T> {
    type Value = T;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<T, Faulted> {
        let word = text(raw, path, faults)?;
        let known = self.words.iter().find(|(known, _)| *known == word);
        known.map(|(_, value)| *value).ok_or_else(|| {
            let known: Vec<_> = self.words.iter().map(|(known, _)| *known).collect();
            let detail = format_args!("expected one of {}, found {}", known.join(", "), describe(raw));
            faults.add(&path, RequestFault::UnknownValue, detail)
        })
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        match self.name {
            Some(name) => components.refer(name, about, |_| self.words_schema().into()),
            None => self.words_schema().description(description(about)).into(),
        }
    }
}

/// True or false.
pub(crate) struct Flag;

impl Kind for Flag {
    type Value = bool;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<bool, Faulted> {
        raw.get()
            .parse()
            .map_err(|_| faults.add(&path, RequestFault::WrongType, format_args!("expected true or false, found {}", describe(raw))))
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        ObjectBuilder::new().schema_type(Type::Boolean).description(description(about)).into()
    }
}

/// Reads a finite number. One too large for double precision, such as 1e999, is out of range, not infinite.
pub(crate) fn number(raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<f64, Faulted> {
    let text = raw.get();
    if let Some(token) = not_finite::token(text) {
        return Err(faults.add(&path, RequestFault::NotFinite, format_args!("the number must be finite, found {token}")));
    }
    if !matches!(text.as_bytes()[0], b'-' | b'0'..=b'9') {
        let hint = if begins_with_a_number(text) { number_hint(path.name()) } else { "" };
        return Err(faults.add(&path, RequestFault::WrongType, format_args!("expected a number, found {}{hint}", describe(raw))));
    }
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(faults.add(&path, RequestFault::OutOfRange, format_args!("the number must be finite, found {}", describe(raw)))),
    }
}

/// Whether a JSON text is a string that begins with a number, such as "0,5" or "0.5 in".
fn begins_with_a_number(text: &str) -> bool {
    text.strip_prefix('"')
        .is_some_and(|text| text.trim_start_matches(['+', '-', '.', ' ']).starts_with(|first: char| first.is_ascii_digit()))
}

/// How the number of a member is written.
fn number_hint(name: &str) -> &'static str {
    const UNITS: &[(&str, &str)] = &[
        ("_mm", "; write the length in mm as a plain number with a decimal point, such as 0.5"),
        ("_deg", "; write the angle in degrees as a plain number with a decimal point, such as 0.5"),
        ("_share", "; write the share as a plain number from 0 to 1 with a decimal point, such as 0.5 for 50 %"),
    ];
    let of_unit = UNITS.iter().find(|(unit, _)| name.ends_with(unit));
    of_unit.map_or("; write a plain number with a decimal point, without a unit, such as 0.5; lengths are in mm", |(_, hint)| *hint)
}

/// Reads a string.
pub(crate) fn text(raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<String, Faulted> {
    match String::deserialize(raw) {
        Ok(text) if not_finite::token(raw.get()).is_none() => Ok(text),
        _ => Err(faults.add(&path, RequestFault::WrongType, format_args!("expected a string, found {}", describe(raw)))),
    }
}
