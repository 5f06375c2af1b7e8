//! The members that requests are made of: for each kind of value, how it is read and what the API document says of it. Both
//! come from one description, so that no bound can differ between them.

use super::object::describe;
use super::{Faulted, Faults, Place};
use crate::http::codes::RequestFault;
use crate::quantity::{Length, OutOfRange};
use serde::Deserializer;
use serde::de::{DeserializeSeed, IgnoredAny, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::fmt;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// A named member of a request.
pub(crate) struct Member<K> {
    /// The name on the wire, with its unit.
    pub(crate) name: &'static str,
    /// What it is, for the document and for the fault that it is missing.
    pub(crate) about: &'static str,
    /// What values it takes.
    pub(crate) kind: K,
}

/// A kind of value.
pub(crate) trait Kind {
    /// What it becomes.
    type Value;
    /// Reads it, recording every fault.
    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted>;
    /// Its schema, with `about` as the description.
    fn schema(&self, about: &str) -> RefOr<Schema>;
}

/// A number within bounds.
pub(crate) struct Number {
    pub(crate) minimum: f64,
    pub(crate) maximum: f64,
    pub(crate) example: f64,
}

impl Kind for Number {
    type Value = f64;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<f64, Faulted> {
        let value = number(raw, place, faults)?;
        in_range(OutOfRange::check(value, self.minimum, self.maximum), raw, place, faults)
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        // The bounds of double precision itself go without saying.
        let bound = |bound: f64| (bound.abs() < f64::MAX).then_some(bound);
        let schema = ObjectBuilder::new().schema_type(Type::Number).description(Some(about)).examples([self.example]);
        schema.minimum(bound(self.minimum)).maximum(bound(self.maximum)).into()
    }
}

/// A length that somebody states, in mm.
pub(crate) struct StatedLength {
    pub(crate) example: f64,
}

impl Kind for StatedLength {
    type Value = Length;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<Length, Faulted> {
        in_range(Length::from_mm(number(raw, place, faults)?), raw, place, faults)
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        Number { minimum: Length::SMALLEST, maximum: Length::LARGEST, example: self.example }.schema(about)
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

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<u32, Faulted> {
        let value = number(raw, place, faults)?;
        let value = in_range(OutOfRange::check(value, self.minimum.into(), self.maximum.into()), raw, place, faults)?;
        if value.fract() != 0.0 {
            return Err(faults.add(&place, RequestFault::WrongType, format_args!("expected a whole number, found {}", describe(raw))));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole and between two u32 bounds")]
        Ok(value as u32)
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::Integer).description(Some(about)).examples([self.example]);
        schema.minimum(Some(f64::from(self.minimum))).maximum(Some(f64::from(self.maximum))).into()
    }
}

/// A vector of three components, of any length but zero.
pub(crate) struct Vector {
    pub(crate) example: [f64; 3],
}

impl Kind for Vector {
    type Value = [f64; 3];

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<[f64; 3], Faulted> {
        let items = items(raw, 16, place, faults)?;
        let [x, y, z] = items.as_slice() else {
            return Err(faults.add(&place, RequestFault::WrongType, format_args!("expected three numbers, found {} items", items.len())));
        };
        let [x, y, z] = [(0, x), (1, y), (2, z)].map(|(index, raw)| number(raw, place.item(index), faults));
        Ok([x?, y?, z?])
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        let component = ObjectBuilder::new().schema_type(Type::Number);
        let schema = ArrayBuilder::new().items(component).min_items(Some(3)).max_items(Some(3));
        schema.description(Some(about)).examples([serde_json::json!(self.example)]).into()
    }
}

/// One of several words.
pub(crate) struct Choice<T: 'static> {
    pub(crate) words: &'static [(&'static str, T)],
}

impl<T: Copy> Kind for Choice<T> {
    type Value = T;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<T, Faulted> {
        let word = text(raw, place, faults)?;
        let known = self.words.iter().find(|(known, _)| *known == word);
        known.map(|(_, value)| *value).ok_or_else(|| {
            let known: Vec<_> = self.words.iter().map(|(known, _)| *known).collect();
            faults.add(&place, RequestFault::UnknownValue, format_args!("expected one of {}, found {}", known.join(", "), describe(raw)))
        })
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::String).description(Some(about));
        schema.enum_values(Some(self.words.iter().map(|(word, _)| *word))).into()
    }
}

/// The finite number that `raw` is. A number too large for double precision, such as 1e999, is out of range, not infinite.
pub(crate) fn number(raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<f64, Faulted> {
    let text = raw.get();
    if !matches!(text.as_bytes()[0], b'-' | b'0'..=b'9') {
        return Err(faults.add(&place, RequestFault::WrongType, format_args!("expected a number, found {}", describe(raw))));
    }
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(faults.add(&place, RequestFault::OutOfRange, format_args!("the number must be finite, found {}", describe(raw)))),
    }
}

/// The text that `raw` is.
pub(crate) fn text(raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<String, Faulted> {
    serde_json::from_str(raw.get())
        .map_err(|_| faults.add(&place, RequestFault::WrongType, format_args!("expected a string, found {}", describe(raw))))
}

/// The items of the array that `raw` is, unread. More than `most` are a fault and are counted, not kept.
pub(crate) fn items<'a>(raw: &'a RawValue, most: usize, place: Place<'_>, faults: &mut Faults) -> Result<Vec<&'a RawValue>, Faulted> {
    let mut all = Vec::new();
    for_runs_of_items(raw, most, most, place, faults, |_, items| all = items)?;
    Ok(all)
}

/// Hands out the items of an array as it comes upon them, in runs of `run` with the index of the first, and returns their number. Where
/// there are more than `most`, or `raw` is no array, that is found after some were handed out.
pub(crate) fn for_runs_of_items<'a>(
    raw: &'a RawValue,
    most: usize,
    run: usize,
    place: Place<'_>,
    faults: &mut Faults,
    take: impl FnMut(usize, Vec<&'a RawValue>),
) -> Result<usize, Faulted> {
    let count = Items { most, run, take }.deserialize(&mut serde_json::Deserializer::from_str(raw.get()));
    let count =
        count.map_err(|_| faults.add(&place, RequestFault::WrongType, format_args!("expected an array, found {}", describe(raw))))?;
    if count > most {
        return Err(faults.add(&place, RequestFault::TooManyItems, format_args!("must have at most {most} items, found {count}")));
    }
    Ok(count)
}

/// Hands out the first items of an array and counts all.
struct Items<F> {
    most: usize,
    run: usize,
    take: F,
}

impl<'de, F: FnMut(usize, Vec<&'de RawValue>)> DeserializeSeed<'de> for Items<F> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, F: FnMut(usize, Vec<&'de RawValue>)> Visitor<'de> for Items<F> {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut sequence: A) -> Result<usize, A::Error> {
        let (mut count, mut items) = (0, Vec::new());
        while count < self.most
            && let Some(item) = sequence.next_element()?
        {
            items.push(item);
            count += 1;
            if items.len() == self.run {
                (self.take)(count - items.len(), std::mem::take(&mut items));
            }
        }
        if !items.is_empty() {
            (self.take)(count - items.len(), items);
        }
        while sequence.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        Ok(count)
    }
}

/// The checked value, or the fault with the bounds that it broke.
pub(crate) fn in_range<T>(checked: Result<T, OutOfRange>, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<T, Faulted> {
    checked.map_err(|bounds| faults.add(&place, RequestFault::OutOfRange, format_args!("{bounds}, found {}", describe(raw))))
}
