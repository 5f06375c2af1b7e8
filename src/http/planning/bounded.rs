//! Quantities that a request states as a number within their bounds.

use crate::http::reading::member::{Number, in_range, number};
use crate::http::reading::{Faulted, Faults, Kind, Place};
use crate::quantity::OutOfRange;
use serde_json::value::RawValue;
use utoipa::openapi::{RefOr, Schema};

/// A number that becomes a quantity, which has the last word on its bounds; those here are the ones that the document states.
pub(super) struct Bounded<T> {
    pub(super) minimum: f64,
    pub(super) maximum: f64,
    pub(super) example: f64,
    pub(super) of: fn(f64) -> Result<T, OutOfRange>,
}

impl<T> Kind for Bounded<T> {
    type Value = T;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<T, Faulted> {
        let value = number(raw, place, faults)?;
        in_range((self.of)(value), raw, place, faults)
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        Number { minimum: self.minimum, maximum: self.maximum, example: self.example }.schema(about)
    }
}
