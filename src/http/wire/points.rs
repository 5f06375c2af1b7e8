//! Arrays of points in a JSON body. They are read point by point, so that a body of a million points is never stored as
//! a JSON tree.

use crate::http::codes::RequestFault;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, describe, each_raw, number};
use crate::json::each;
use crate::surface::LARGEST_COORDINATE;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// Passes every point of the array `raw` to `take` in order. `take` may have been called before a fault is found.
pub(super) fn each_point(raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults, mut take: impl FnMut([f64; 3])) -> Result<(), Faulted> {
    let mut are_in_bounds = true;
    let read = each(raw, |point: [f64; 3]| {
        are_in_bounds &= point.into_iter().all(is_in_bounds);
        take(point);
    });
    if read.is_ok() && are_in_bounds { Ok(()) } else { find_faults(raw, path, faults) }
}

/// An array of points that is kept: a path.
pub(crate) struct PathPoints;

impl Kind for PathPoints {
    type Value = Vec<[f64; 3]>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted> {
        let mut points = Vec::new();
        each_point(raw, path, faults, |point| points.push(point))?;
        Ok(points)
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        Points.schema(about, components)
    }
}

/// Finds all faults of an array of points that is known to have one.
fn find_faults(raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<(), Faulted> {
    let mut result = Ok(());
    each_raw(raw, "an array", path, faults, |index, item, faults| {
        result = result.and(point(item, path.item(index), faults).map(|_| ()));
    })?;
    result.and_then(|()| Err(faults.add(&path, RequestFault::WrongType, "expected an array of points")))
}

/// One point.
pub(super) fn point(raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<[f64; 3], Faulted> {
    let mut coordinates = [Ok(0.0); 3];
    let count = each_raw(raw, "an array", path, faults, |index, item, faults| {
        if let Some(coordinate) = coordinates.get_mut(index) {
            *coordinate = bounded(item, path.item(index), faults);
        }
    })?;
    if count != 3 {
        let detail = format_args!("expected the three coordinates of a point, found {count} items");
        return Err(faults.add(&path, RequestFault::WrongType, detail));
    }
    let [x, y, z] = coordinates;
    Ok([x?, y?, z?])
}

fn bounded(raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<f64, Faulted> {
    let coordinate = number(raw, path, faults)?;
    if is_in_bounds(coordinate) {
        return Ok(coordinate);
    }
    let detail = format_args!("a coordinate must be at most {LARGEST_COORDINATE:e} in magnitude, found {}", describe(raw));
    Err(faults.add(&path, RequestFault::OutOfRange, detail))
}

fn is_in_bounds(coordinate: f64) -> bool {
    coordinate.abs() <= LARGEST_COORDINATE
}

/// An array of points that is only checked, for its faults and its schema.
pub(crate) struct Points;

impl Kind for Points {
    type Value = ();

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<(), Faulted> {
        each_point(raw, path, faults, |_| ())
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let examples = [serde_json::json!([[0.0, 0.0, 5.0], [40.0, 0.0, 5.5], [0.0, 20.0, 0.0], [40.0, 20.0, 0.5]])];
        ArrayBuilder::new().items(point_schema()).description(Some(about)).examples(examples).into()
    }
}

/// The schema of one point.
pub(super) fn point_schema() -> ArrayBuilder {
    let bound = LARGEST_COORDINATE;
    let coordinate = ObjectBuilder::new().schema_type(Type::Number).minimum(Some(-bound)).maximum(Some(bound));
    ArrayBuilder::new().items(coordinate).min_items(Some(3)).max_items(Some(3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::http::codes::Code;

    fn read(json: &str) -> (Vec<[f64; 3]>, Vec<(String, &'static str)>) {
        let (mut points, mut faults) = (Vec::new(), Faults::default());
        let raw = serde_json::from_str(json).unwrap();
        let result = each_point(raw, JsonPath::Root.member("points"), &mut faults, |point| points.push(point));
        let faults: Vec<_> = faults.into_listed().into_iter().map(|fault| (fault.pointer, fault.code.name())).collect();
        assert_eq!(result.is_err(), !faults.is_empty());
        (points, faults)
    }

    #[test]
    fn points_keep_their_order_and_their_exact_values() {
        let (points, faults) = read("[[1, 2.5, -3e2], [0.1, 1e12, -0]]");
        assert_eq!((points, faults.len()), (vec![[1.0, 2.5, -300.0], [0.1, 1e12, -0.0]], 0));
        assert_eq!(read("[]").0.len(), 0);
        // Coordinates far from the origin keep every bit: 17 digits identify a double.
        let far = [5_000_000_123.456_789_f64, 5_000_000_060.3, -5_000_000_000.1];
        assert_eq!(read(&format!("[[{}, {}, {}]]", far[0], far[1], far[2])).0, [far]);
    }

    #[test]
    fn every_fault_has_its_pointer() {
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
