//! Parser of a 3MF model: its unit, its objects and its build items.

use super::super::LARGEST_COORDINATE;
use super::super::faces::too_many_vertices;
use super::super::input::ReadError;
use super::super::words::coordinate;
use super::Package;
use super::xml::{self, Event, XmlElement};
use crate::file_fault::{FileFaultKind, Flaw, quoted};
use crate::surface::Unit;
use std::collections::HashMap;
use std::sync::Arc;

/// The largest number of objects, components and build items of a package together.
const MOST_PARTS: usize = 100_000;

/// Namespaces of the extensions that a model may require: the core, and extensions that do not change the facets of the
/// surface.
const UNDERSTOOD: [&str; 4] = [
    "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
];

/// A model file.
#[derive(Debug)]
pub(super) struct PackageModel {
    pub(super) unit: Unit,
    pub(super) objects: HashMap<u32, PackageObject>,
    pub(super) items: Vec<Reference>,
}

/// An object that others can place.
#[derive(Debug)]
pub(super) struct PackageObject {
    /// Whether it is part of the surface, by its type.
    pub(super) is_surface: bool,
    pub(super) vertices: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) components: Vec<Reference>,
}

/// A build item or component: an object and its transform.
#[derive(Debug, Clone)]
pub(super) struct Reference {
    pub(super) object: u32,
    /// The model file of the object, if it is another file.
    pub(super) path: Option<Arc<str>>,
    pub(super) transform: Transform,
    /// Whether a slicer's build item is printed.
    pub(super) is_printable: bool,
}

/// An affine map of row vectors: (x, y, z, 1) multiplied by a matrix of four rows and three columns, stored row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transform([f64; 12]);

impl Transform {
    pub(super) const IDENTITY: Self = Self([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);

    pub(super) fn apply(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let m = &self.0;
        [0, 1, 2].map(|column| x * m[column] + y * m[3 + column] + z * m[6 + column] + m[9 + column])
    }

    /// This map and then `next`.
    pub(super) fn then(&self, next: &Self) -> Self {
        let mut linear = *next;
        linear.0[9..].fill(0.0);
        let [a, b, c, offset] = [0, 3, 6, 9].map(|row| [self.0[row], self.0[row + 1], self.0[row + 2]]);
        let rows = [linear.apply(a), linear.apply(b), linear.apply(c), next.apply(offset)];
        let mut product = [0.0; 12];
        product.copy_from_slice(rows.as_flattened());
        Self(product)
    }

    /// The determinant of the linear part: negative for a reflection.
    pub(super) fn determinant(&self) -> f64 {
        let m = &self.0;
        m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6])
    }

    /// Reads a map of twelve numbers.
    fn stated(text: &str) -> Result<Self, Flaw> {
        let mut numbers = [0.0; 12];
        let mut words = text.split_ascii_whitespace();
        for number in &mut numbers {
            *number = coordinate(words.next().unwrap_or_default().as_bytes(), "a transform of twelve numbers")?;
        }
        let transform = Self(numbers);
        if words.next().is_some() {
            return Err(Flaw::quoting("a transform of twelve numbers", text.as_bytes()));
        }
        // No number is NaN; the determinant of bounded numbers is finite.
        if transform.determinant() == 0.0 {
            return Err(Flaw::quoting("a transform that is not singular", text.as_bytes()));
        }
        Ok(transform)
    }
}

/// The numbers of further vertices, triangles and parts that the models of a package may have.
#[derive(Debug)]
pub(super) struct Room {
    vertex_limit: usize,
    vertices: usize,
    triangles: usize,
    parts: usize,
}

impl Room {
    /// Room for `limit` vertices and twice as many triangles, as in a closed mesh.
    pub(super) fn for_vertices(limit: usize) -> Self {
        Self { vertex_limit: limit, vertices: limit, triangles: limit.saturating_mul(2), parts: MOST_PARTS }
    }

    fn take_vertex(&mut self) -> Result<(), Flaw> {
        self.vertices = self.vertices.checked_sub(1).ok_or_else(|| too_many_vertices(self.vertex_limit))?;
        Ok(())
    }

    fn take_triangle(&mut self) -> Result<(), Flaw> {
        let more = || Flaw::new(FileFaultKind::TooLarge, format!("at most {} triangles", self.vertex_limit.saturating_mul(2)), "more");
        self.triangles = self.triangles.checked_sub(1).ok_or_else(more)?;
        Ok(())
    }

    fn take_part(&mut self) -> Result<(), Flaw> {
        let more = || Flaw::new(FileFaultKind::TooLarge, format!("at most {MOST_PARTS} objects, components and build items"), "more");
        self.parts = self.parts.checked_sub(1).ok_or_else(more)?;
        Ok(())
    }
}

/// The element around the current one in a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Context {
    PackageModel,
    Resources,
    PackageObject,
    Mesh,
    Vertices,
    Triangles,
    Components,
    Build,
    /// An element that does not affect the surface, or whose children do not.
    Other,
}

impl PackageModel {
    /// Reads the model file of this path.
    pub(super) fn read(package: &mut Package, path: &str, room: &mut Room) -> Result<Self, ReadError> {
        let model = Self { unit: Unit::Millimetre, objects: HashMap::new(), items: Vec::new() };
        let mut parser = Parser { model, room, contexts: Vec::new(), object: None };
        xml::read(package, path, |event| match event {
            Event::Start(element) => parser.start(&element),
            Event::End => parser.end(),
        })?;
        Ok(parser.model)
    }

    /// The components of all objects and the build items.
    pub(super) fn references(&self) -> impl Iterator<Item = &Reference> {
        self.objects.values().flat_map(|object| &object.components).chain(&self.items)
    }
}

struct Parser<'a> {
    model: PackageModel,
    room: &'a mut Room,
    contexts: Vec<Context>,
    /// The object that is being read, with its number.
    object: Option<(u32, PackageObject)>,
}

impl Parser<'_> {
    fn start(&mut self, element: &XmlElement) -> Result<(), Flaw> {
        let name = element.name();
        let context = match (self.contexts.last(), name) {
            (None, "model") => {
                self.open_model(element)?;
                Context::PackageModel
            }
            (None, _) => return Err(Flaw::quoting("the element model", name.as_bytes())),
            (Some(Context::PackageModel), "resources") => Context::Resources,
            (Some(Context::PackageModel), "build") => Context::Build,
            (Some(Context::Resources), "object") => {
                self.open_object(element)?;
                Context::PackageObject
            }
            (Some(Context::PackageObject), "mesh") => Context::Mesh,
            (Some(Context::PackageObject), "components") => Context::Components,
            (Some(Context::Mesh), "vertices") => Context::Vertices,
            (Some(Context::Mesh), "triangles") => Context::Triangles,
            (Some(Context::Vertices), "vertex") => {
                self.vertex(element)?;
                Context::Other
            }
            (Some(Context::Triangles), "triangle") => {
                self.triangle(element)?;
                Context::Other
            }
            (Some(Context::Components), "component") => {
                self.room.take_part()?;
                let component = reference(element)?;
                self.object()?.components.push(component);
                Context::Other
            }
            (Some(Context::Build), "item") => {
                self.room.take_part()?;
                self.model.items.push(reference(element)?);
                Context::Other
            }
            _ => Context::Other,
        };
        self.contexts.push(context);
        Ok(())
    }

    fn end(&mut self) -> Result<(), Flaw> {
        if self.contexts.pop() == Some(Context::PackageObject)
            && let Some((number, mut object)) = self.object.take()
        {
            object.vertices.shrink_to_fit();
            object.triangles.shrink_to_fit();
            if self.model.objects.insert(number, object).is_some() {
                return Err(Flaw::new(FileFaultKind::Malformed, "each object number once", number.to_string()));
            }
        }
        Ok(())
    }

    fn open_model(&mut self, element: &XmlElement) -> Result<(), Flaw> {
        let expected = "micron, millimeter, centimeter, inch, foot or meter";
        self.model.unit = match element.attribute("unit").as_deref() {
            None | Some("millimeter") => Unit::Millimetre,
            Some("micron") => Unit::Micrometre,
            Some("centimeter") => Unit::Centimetre,
            Some("inch") => Unit::Inch,
            Some("foot") => Unit::Foot,
            Some("meter") => Unit::Metre,
            Some(other) => return Err(Flaw::quoting(expected, other.as_bytes())),
        };
        let required = element.attribute("requiredextensions").unwrap_or_default();
        for prefix in required.split_ascii_whitespace() {
            let declared = format!("xmlns:{prefix}");
            let namespace = element.attributes().find(|(key, _)| *key == declared).map(|(_, value)| value.into_owned());
            if !namespace.as_deref().is_some_and(|namespace| UNDERSTOOD.contains(&namespace)) {
                // The namespaces of 3MF differ in their last parts.
                let name = namespace.as_deref().map_or(prefix, |name| name.rsplit("3dmanufacturing/").next().unwrap_or(name));
                let found = quoted(name.as_bytes());
                return Err(Flaw::new(
                    FileFaultKind::Malformed,
                    "a model of meshes and components alone",
                    format!("the required extension {found}"),
                ));
            }
        }
        Ok(())
    }

    fn open_object(&mut self, element: &XmlElement) -> Result<(), Flaw> {
        self.room.take_part()?;
        let number = number(element, "id")?;
        let kind = element.attribute("type");
        let is_surface = !matches!(kind.as_deref(), Some("support" | "other"));
        self.object = Some((number, PackageObject { is_surface, vertices: Vec::new(), triangles: Vec::new(), components: Vec::new() }));
        Ok(())
    }

    fn object(&mut self) -> Result<&mut PackageObject, Flaw> {
        // The contexts allow no vertex outside an object.
        self.object.as_mut().map(|(_, object)| object).ok_or_else(|| Flaw::quoting("an object around it", b""))
    }

    fn vertex(&mut self, element: &XmlElement) -> Result<(), Flaw> {
        self.room.take_vertex()?;
        let mut vertex = [None; 3];
        for (name, value) in element.attributes() {
            let axis = match name {
                "x" => 0,
                "y" => 1,
                "z" => 2,
                _ => continue,
            };
            vertex[axis] = Some(coordinate(value.trim().as_bytes(), "a number")?);
        }
        let [Some(x), Some(y), Some(z)] = vertex else {
            return Err(Flaw::new(FileFaultKind::Malformed, "a vertex with x, y and z", "one of them missing"));
        };
        self.object()?.vertices.push([x, y, z]);
        Ok(())
    }

    fn triangle(&mut self, element: &XmlElement) -> Result<(), Flaw> {
        self.room.take_triangle()?;
        let object = self.object()?;
        let mut triangle = [None; 3];
        for (name, value) in element.attributes() {
            let corner = match name {
                "v1" => 0,
                "v2" => 1,
                "v3" => 2,
                _ => continue,
            };
            let vertex = value.trim().parse::<u32>().ok().filter(|vertex| (*vertex as usize) < object.vertices.len());
            let missing = || {
                let expected = format!("the number of one of {} vertices, from 0", object.vertices.len());
                Flaw::new(FileFaultKind::OutOfRange, expected, quoted(value.as_bytes()))
            };
            triangle[corner] = Some(vertex.ok_or_else(missing)?);
        }
        let [Some(a), Some(b), Some(c)] = triangle else {
            return Err(Flaw::new(FileFaultKind::Malformed, "a triangle with v1, v2 and v3", "one of them missing"));
        };
        object.triangles.push([a, b, c]);
        Ok(())
    }
}

fn reference(element: &XmlElement) -> Result<Reference, Flaw> {
    let transform = element.attribute("transform").map_or(Ok(Transform::IDENTITY), |text| Transform::stated(&text))?;
    let path = element.attribute("path").map(|path| path.trim_start_matches('/').into());
    let is_printable = element.attribute("printable").is_none_or(|printable| printable.trim() != "0");
    Ok(Reference { object: number(element, "objectid")?, path, transform, is_printable })
}

fn number(element: &XmlElement, attribute: &'static str) -> Result<u32, Flaw> {
    let text = element.attribute(attribute).unwrap_or_default();
    text.trim().parse().map_err(|_| Flaw::quoting(format!("a whole number as {attribute}"), text.as_bytes()))
}

/// Whether a placed vertex can be a coordinate.
pub(super) fn is_bounded(point: [f64; 3]) -> bool {
    point.iter().all(|value| value.abs() <= LARGEST_COORDINATE)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "small whole numbers are exact")]
mod tests {
    use super::*;

    #[test]
    fn maps_are_composed_in_the_order_of_their_application() {
        let turn = Transform::stated("0 1 0 -1 0 0 0 0 1 10 0 0").unwrap();
        let scale = Transform::stated("2 0 0 0 2 0 0 0 -2 0 5 0").unwrap();
        let point = [1.0, 2.0, 3.0];
        assert_eq!(turn.apply(point), [8.0, 1.0, 3.0]);
        assert_eq!(turn.then(&scale).apply(point), scale.apply(turn.apply(point)));
        assert_eq!((turn.determinant(), scale.determinant(), turn.then(&scale).determinant()), (1.0, -8.0, -8.0));
        assert_eq!(turn.then(&Transform::IDENTITY), turn);
        for wrong in
            ["1 0 0", "1 0 0 0 1 0 0 0 0 0 0 0", "1 0 0 0 1 0 0 0 1 0 0 x", "1 0 0 0 1 0 0 0 1 0 0 0 0", "nan 0 0 0 1 0 0 0 1 0 0 0"]
        {
            assert!(Transform::stated(wrong).is_err(), "{wrong}");
        }
    }
}
