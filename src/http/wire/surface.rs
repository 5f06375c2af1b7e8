//! Surfaces in JSON: points, a grid, a mesh, or a Bezier patch. Arrays of points are read point by point, so that a body of a
//! million points is never stored as a JSON tree.

use super::source::{Source, SurfaceWithSource};
use crate::http::codes::RequestFault;
use crate::http::reading::{
    AddMembers, Components, Faulted, Faults, JsonPath, Kind, List, Member, Object, Whole, describe, each_raw, members, number,
};
use crate::json::each;
use crate::surface::{Bezier, BezierError, Grid, GridError, LARGEST_COORDINATE, MeshError, ReceivedSurface, Sink};
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The member `surface`.
pub(crate) const SURFACE: Member<StatedSurface> =
    Member::new("surface", "the surface: points, a grid of them, a mesh, or a Bezier patch", StatedSurface);
const POINTS: Member<Points> = Member::new("points", "sample points [x, y, z] spread evenly over the surface, in any order", Points);
const GRID: Member<GridKind> = Member::new("grid", "points in rows and columns, with facets between neighbours", GridKind);
const ROWS: Member<Whole> = Member::new("rows", "the number of rows", Whole { minimum: 2, maximum: 1_000_000, example: 3 });
const COLUMNS: Member<Whole> =
    Member::new("columns", "the number of points in each row", Whole { minimum: 2, maximum: 1_000_000, example: 3 });
const GRID_POINTS: Member<Points> = Member::new(
    "points",
    "the points [x, y, z], rows times columns of them: all of the first row, then all of the second, and so on",
    Points,
);
const MESH: Member<MeshKind> = Member::new("mesh", "points, and triangles given by indices of points", MeshKind);
const MESH_POINTS: Member<Points> = Member::new("points", "the points [x, y, z]", Points);
const TRIANGLES: Member<Triangles> =
    Member::new("triangles", "three indices of points for each triangle, from 0, counter-clockwise seen from outside the part", Triangles);
const BEZIER: Member<BezierKind> = Member::new("bezier", "a tensor-product Bezier patch", BezierKind);
const SAMPLES: Member<Whole> = Member::new(
    "samples",
    "the number of samples along each parameter: the patch is sampled at the centres of samples x samples equal cells of its parameters",
    Whole { minimum: 2, maximum: 1000, example: 80 },
);

/// A surface in one of its four forms.
pub(crate) struct StatedSurface;

impl Kind for StatedSurface {
    type Value = SurfaceWithSource;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<SurfaceWithSource, Faulted> {
        let mut object = Object::open(raw, path, faults)?;
        let forms = [POINTS.name, GRID.name, MESH.name, BEZIER.name].map(|form| object.has(form));
        // Members that stand beside a form belong in it.
        faults.object_knows(&path.member(MESH.name), vec![TRIANGLES.name]);
        faults.object_knows(&path.member(GRID.name), vec![ROWS.name, COLUMNS.name]);
        let surface = match forms {
            [true, false, false, false] => points(&mut object, faults),
            [false, true, false, false] => object.required(&GRID, faults).map(|surface| SurfaceWithSource::stated(surface, Source::Grid)),
            [false, false, true, false] => object.required(&MESH, faults).map(|surface| SurfaceWithSource::stated(surface, Source::Mesh)),
            [false, false, false, true] => bezier(&mut object, faults),
            _ => {
                // All forms are read, so that all their faults are listed, and faults of unknown members list all forms.
                let _ = (object.optional(&POINTS, faults), object.optional(&GRID, faults), object.optional(&MESH, faults));
                let _ = (object.optional(&BEZIER, faults), object.optional(&SAMPLES, faults));
                Err(if forms.contains(&true) {
                    faults.add(&path, RequestFault::ConflictingFields, "give one of points, grid, mesh, and bezier with samples")
                } else {
                    faults.add(&path, RequestFault::MissingField, "give points, grid, mesh, or bezier with samples")
                })
            }
        };
        object.close(faults)?;
        surface
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let forms: [(_, _, AddMembers<'_>); 4] = [
            ("PointsSurface", "Sample points", &|schema| schema.required(&POINTS)),
            ("GridSurface", "A grid of points", &|schema| schema.required(&GRID)),
            ("MeshSurface", "Triangles with points as corners", &|schema| schema.required(&MESH)),
            ("BezierSurface", "A sampled Bezier patch", &|schema| schema.required(&BEZIER).required(&SAMPLES)),
        ];
        components.refer("Surface", about, |components| components.one_of(SURFACE.about, &forms).into())
    }
}

fn points(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<SurfaceWithSource, Faulted> {
    let raw = object.required_raw(&POINTS, faults)?;
    let mut surface = received(faults);
    each_point(raw, object.path().member(POINTS.name), faults, |point| surface.point(point))?;
    Ok(SurfaceWithSource::stated(surface, Source::Points))
}

/// An empty surface, for reading that records `faults`.
fn received(faults: &Faults) -> ReceivedSurface {
    ReceivedSurface::until(&faults.cancel_flag())
}

fn bezier(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<SurfaceWithSource, Faulted> {
    let (patch, samples) = (object.required(&BEZIER, faults), object.required(&SAMPLES, faults));
    let (patch, samples) = (patch?, samples? as usize);
    // The shape is computed from the samples, as published; the facets have the corners of the cells.
    let cancel = faults.cancel_flag();
    let stop = || cancel.is_cancelled();
    let mesh = patch.tessellate(samples, received(faults).mesh, &stop);
    let surface = patch.sampled(samples, &stop).and_then(|sampled| Ok(ReceivedSurface { sampled, mesh: mesh? })).map_err(|bounds| {
        faults.add(&object.path().member(SAMPLES.name), RequestFault::OutOfRange, format_args!("the number of samples each way {bounds}"))
    })?;
    Ok(SurfaceWithSource::stated(surface, Source::Bezier))
}

pub(crate) struct GridKind;

impl Kind for GridKind {
    type Value = ReceivedSurface;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<ReceivedSurface, Faulted> {
        Object::open(raw, path, faults)?.read(faults, |object, faults| {
            match (object.required(&ROWS, faults), object.required(&COLUMNS, faults)) {
                (Ok(rows), Ok(columns)) => grid(object, rows as usize, columns as usize, faults),
                _ => object.required(&GRID_POINTS, faults).and(Err(Faulted)),
            }
        })
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let add: AddMembers<'_> = &|schema| schema.required(&ROWS).required(&COLUMNS).required(&GRID_POINTS);
        components.refer_object("Grid", about, "Points in rows and columns", add)
    }
}

fn grid(object: &mut Object<'_, '_>, rows: usize, columns: usize, faults: &mut Faults) -> Result<ReceivedSurface, Faulted> {
    let path = object.path();
    let mut grid = Grid::into_sink(rows, columns, received(faults)).map_err(|error| faults.add(&path, RequestFault::OutOfRange, error))?;
    let raw = object.required_raw(&GRID_POINTS, faults)?;
    let path = path.member(GRID_POINTS.name);
    each_point(raw, path, faults, |point| grid.point(point))?;
    grid.finish().map_err(|error: GridError| faults.add(&path, RequestFault::WrongCount, error))
}

pub(crate) struct MeshKind;

impl Kind for MeshKind {
    type Value = ReceivedSurface;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<ReceivedSurface, Faulted> {
        let mut object = Object::open(raw, path, faults)?;
        let points = object.required_raw(&MESH_POINTS, faults).and_then(|raw| {
            let mut points = Vec::with_capacity(most_items(raw));
            each_point(raw, path.member(MESH_POINTS.name), faults, |point| points.push(point)).map(|()| points)
        });
        let triangles = object.required(&TRIANGLES, faults);
        object.close(faults)?;
        mesh(&points?, &triangles?, &path, faults)
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let add: AddMembers<'_> = &|schema| schema.required(&MESH_POINTS).required(&TRIANGLES);
        components.refer_object("Mesh", about, "Triangles with points as corners", add)
    }
}

/// The most points or triangles in an array. Each has its own bracket and at least 8 bytes, `[0,0,0],`. The capacity is
/// reserved at once, because a growing vector takes three times the memory when it moves.
fn most_items(raw: &RawValue) -> usize {
    let text = raw.get().as_bytes();
    memchr::memchr_iter(b'[', text).count().min(text.len() / 8)
}

fn mesh(points: &[[f64; 3]], triangles: &[[u32; 3]], path: &JsonPath<'_>, faults: &mut Faults) -> Result<ReceivedSurface, Faulted> {
    let path = path.member(TRIANGLES.name);
    let mut surface = received(faults);
    let mut result = Ok(());
    for (number, triangle) in triangles.iter().enumerate() {
        let at = |corner: usize| points.get(triangle[corner] as usize).copied().ok_or(corner);
        match (at(0), at(1), at(2)) {
            (Ok(a), Ok(b), Ok(c)) => surface.facet([a, b, c]),
            (a, b, c) => {
                for corner in [a, b, c].into_iter().filter_map(Result::err) {
                    let (index, points) = (u64::from(triangle[corner]), points.len());
                    let error = MeshError::IndexOutOfRange { triangle: number, corner, index, points };
                    result = Err(faults.add(&path.item(number).item(corner), RequestFault::OutOfRange, error));
                }
            }
        }
    }
    result.map(|()| surface)
}

/// An array of triangles, each three indices of points.
pub(crate) struct Triangles;

impl Triangles {
    /// Three indices of points; more than 2^32 - 1 points do not fit a request.
    fn one(raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<[u32; 3], Faulted> {
        let indices = List { item: Self::INDEX, about_item: "", fewest: 3, most: 3 }.read(raw, path, faults)?;
        Ok([indices[0], indices[1], indices[2]])
    }

    const INDEX: Whole = Whole { minimum: 0, maximum: u32::MAX, example: 0 };
}

impl Kind for Triangles {
    type Value = Vec<[u32; 3]>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted> {
        let mut triangles = Vec::with_capacity(most_items(raw));
        if each(raw, |triangle| triangles.push(triangle)).is_ok() {
            return Ok(triangles);
        }
        // The pass above stopped at the first fault, without its location. This pass finds all faults, and accepts
        // whole numbers written as 1.0 or 1e3.
        triangles.clear();
        each_raw(raw, "an array", path, faults, |index, item, faults| {
            // A default replaces a triangle with a fault, so that the indices of the others are checked too. A request
            // with a fault is not planned.
            triangles.push(Self::one(item, path.item(index), faults).unwrap_or_default());
        })?;
        Ok(triangles)
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let triangle =
            ArrayBuilder::new().items(Self::INDEX.schema("the index of a point", components)).min_items(Some(3)).max_items(Some(3));
        let examples = [serde_json::json!([[0, 1, 2], [1, 3, 2]])];
        ArrayBuilder::new().items(triangle).description(Some(about)).examples(examples).into()
    }
}

members! {
    /// The members of a Bezier patch.
    pub(crate) struct BezierMembers for BezierKind ("BezierPatch", "A tensor-product Bezier patch") -> Bezier {
        control_points: required CONTROL_POINTS: Net = ("control_points", Net,
            "the rows of control points [x, y, z]: 2 to 20 rows of 2 to 20 points, all rows of the same length"),
    }
}

impl BezierMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Bezier, Faulted> {
        let path = path.member(CONTROL_POINTS.name);
        Bezier::new(&self.control_points?).map_err(|error| match error {
            BezierError::RaggedRow { row, .. } => faults.add(&path.item(row), RequestFault::WrongCount, error),
            BezierError::Columns(_) => faults.add(&path.item(0), RequestFault::WrongCount, error),
            BezierError::Rows(_) => faults.add(&path, RequestFault::WrongCount, error),
            BezierError::Coordinate { row, column } => faults.add(&path.item(row).item(column), RequestFault::OutOfRange, error),
        })
    }
}

/// Rows of control points. At most one row, and one point of a row, more than the limit are stored: enough to refuse
/// the patch.
pub(crate) struct Net;

const MOST_KEPT: usize = Bezier::LARGEST_ORDER + 1;

impl Kind for Net {
    type Value = Vec<Vec<[f64; 3]>>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted> {
        first_items(raw, path, faults, |row, path, faults| first_items(row, path, faults, point))
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let row = ArrayBuilder::new().items(point_schema()).min_items(Some(2)).max_items(Some(Bezier::LARGEST_ORDER));
        let net = ArrayBuilder::new().items(row).min_items(Some(2)).max_items(Some(Bezier::LARGEST_ORDER));
        net.description(Some(about)).into()
    }
}

/// Reads the items of the array `raw` with `read`; those beyond [`MOST_KEPT`] are left out.
fn first_items<T>(
    raw: &RawValue,
    path: JsonPath<'_>,
    faults: &mut Faults,
    read: impl Fn(&RawValue, JsonPath<'_>, &mut Faults) -> Result<T, Faulted>,
) -> Result<Vec<T>, Faulted> {
    let mut items = Vec::new();
    each_raw(raw, "an array", path, faults, |index, item, faults| {
        if index < MOST_KEPT {
            items.push(read(item, path.item(index), faults));
        }
    })?;
    items.into_iter().collect()
}

/// A point.
pub(crate) struct OnePoint;

impl Kind for OnePoint {
    type Value = [f64; 3];

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<[f64; 3], Faulted> {
        point(raw, path, faults)
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        point_schema().description(Some(about)).into()
    }
}

/// Passes every point of the array `raw` to `take` in order. `take` may have been called before a fault is found.
fn each_point(raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults, mut take: impl FnMut([f64; 3])) -> Result<(), Faulted> {
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
