//! Arrays of points in a JSON body, handed on point by point: a body of a million points is never built up as a document.

use crate::http::codes::RequestFault;
use crate::http::reading::member::number;
use crate::http::reading::{Faulted, Faults, Kind, Place, describe};
use crate::surface::LARGEST_COORDINATE;
use serde::de::{Deserializer, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::fmt;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// Hands every point of the array `raw` to `take`, in order. After a fault `take` may have had some of the points.
pub(super) fn each_point(raw: &RawValue, place: Place<'_>, faults: &mut Faults, mut take: impl FnMut([f64; 3])) -> Result<(), Faulted> {
    let mut in_bounds = true;
    let read = each(raw, |point: [f64; 3]| {
        in_bounds &= is_in_bounds(point);
        take(point);
    });
    if read.is_ok() && in_bounds {
        return Ok(());
    }
    // The fast way stops at the first fault and does not know its place. This one looks at each item twice and finds them all.
    let mut result = Ok(());
    let mut index = 0;
    each_raw(raw, place, faults, |item, faults| {
        result = result.and(point(item, place.item(index), faults).map(|_| ()));
        index += 1;
    })?;
    result
}

/// One point.
pub(super) fn point(raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<[f64; 3], Faulted> {
    let (mut coordinates, mut count) = ([Ok(0.0); 3], 0);
    each_raw(raw, place, faults, |item, faults| {
        if let Some(coordinate) = coordinates.get_mut(count) {
            *coordinate = bounded(item, place.item(count), faults);
        }
        count += 1;
    })?;
    if count != 3 {
        return Err(faults.add(
            &place,
            RequestFault::WrongType,
            format_args!("expected the three coordinates of a point, found {count} items"),
        ));
    }
    let [x, y, z] = coordinates;
    Ok([x?, y?, z?])
}

fn bounded(raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<f64, Faulted> {
    let coordinate = number(raw, place, faults)?;
    if coordinate.abs() <= LARGEST_COORDINATE {
        return Ok(coordinate);
    }
    let detail = format_args!("a coordinate must be at most {LARGEST_COORDINATE:e} in magnitude, found {}", describe(raw));
    Err(faults.add(&place, RequestFault::OutOfRange, detail))
}

fn is_in_bounds(point: [f64; 3]) -> bool {
    point.iter().all(|coordinate| coordinate.abs() <= LARGEST_COORDINATE)
}

/// Hands every item of the array `raw` to `take` unread, in order.
pub(super) fn each_raw<'a>(
    raw: &'a RawValue,
    place: Place<'_>,
    faults: &mut Faults,
    mut take: impl FnMut(&'a RawValue, &mut Faults),
) -> Result<(), Faulted> {
    each(raw, |item: &'a RawValue| take(item, faults))
        .map_err(|_| faults.add(&place, RequestFault::WrongType, format_args!("expected an array, found {}", describe(raw))))
}

/// Hands every item of the array `raw` to `take`, until one is no `T`.
fn each<'a, T: serde::Deserialize<'a>>(raw: &'a RawValue, take: impl FnMut(T)) -> serde_json::Result<()> {
    struct Each<T, F>(F, std::marker::PhantomData<T>);
    impl<'de, T: serde::Deserialize<'de>, F: FnMut(T)> Visitor<'de> for Each<T, F> {
        type Value = ();
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an array")
        }
        fn visit_seq<A: SeqAccess<'de>>(mut self, mut items: A) -> Result<(), A::Error> {
            while let Some(item) = items.next_element()? {
                (self.0)(item);
            }
            Ok(())
        }
    }
    serde_json::Deserializer::from_str(raw.get()).deserialize_seq(Each(take, std::marker::PhantomData))
}

/// An array of points, checked and dropped: for the faults in it, and for the document.
pub(super) struct Points;

impl Kind for Points {
    type Value = ();

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<(), Faulted> {
        each_point(raw, place, faults, |_| ())
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        let examples = [serde_json::json!([[0.0, 0.0, 5.0], [40.0, 0.0, 5.5], [0.0, 20.0, 0.0], [40.0, 20.0, 0.5]])];
        ArrayBuilder::new().items(point_schema()).description(Some(about)).examples(examples).into()
    }
}

/// The schema of one point.
pub(super) fn point_schema() -> RefOr<Schema> {
    let bound = LARGEST_COORDINATE;
    let coordinate = ObjectBuilder::new().schema_type(Type::Number).minimum(Some(-bound)).maximum(Some(bound));
    ArrayBuilder::new().items(coordinate).min_items(Some(3)).max_items(Some(3)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(json: &str) -> (Vec<[f64; 3]>, Vec<(String, &'static str)>) {
        let (mut points, mut faults) = (Vec::new(), Faults::default());
        let raw: &RawValue = serde_json::from_str(json).unwrap();
        let result = each_point(raw, Place::Root.member("points"), &mut faults, |point| points.push(point));
        let faults: Vec<_> = faults.into_listed().into_iter().map(|fault| (fault.pointer, fault.code.name())).collect();
        assert_eq!(result.is_err(), !faults.is_empty());
        (points, faults)
    }

    #[test]
    fn points_come_in_order_and_as_written() {
        let (points, faults) = read("[[1, 2.5, -3e2], [0.1, 1e12, -0]]");
        assert_eq!((points, faults.len()), (vec![[1.0, 2.5, -300.0], [0.1, 1e12, -0.0]], 0));
        assert_eq!(read("[]").0.len(), 0);
        // Coordinates far from the origin keep every bit: text of 17 digits names one double only.
        let far = [5_000_000_123.456_789_f64, 5_000_000_060.3, -5_000_000_000.1];
        assert_eq!(read(&format!("[[{}, {}, {}]]", far[0], far[1], far[2])).0, [far]);
    }

    #[test]
    fn every_fault_has_its_place() {
        let faults = read(r#"[[1, 2, 3], [1, 2], [1, "2", null], 7, [1e999, 0, 2e12], [1, 2, 3, 4]]"#).1;
        let expected = [
            ("/points/1", "wrong-type"),
            ("/points/2/1", "wrong-type"),
            ("/points/2/2", "wrong-type"),
            ("/points/3", "wrong-type"),
            ("/points/4/0", "out-of-range"),
            ("/points/4/2", "out-of-range"),
            ("/points/5", "wrong-type"),
        ];
        assert_eq!(faults, expected.map(|(pointer, code)| (pointer.to_owned(), code)));
        assert_eq!(read("{}").1, [("/points".to_owned(), "wrong-type")]);
    }
}
