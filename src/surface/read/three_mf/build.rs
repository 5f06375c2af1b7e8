//! The facets of a 3MF package: places its build items with their components, recursively.

use super::super::decimal::unbounded;
use super::super::fault::{Fault, FaultKind, Flaw};
use super::model::{Model, Object, Reference, Transform, is_bounded};
use crate::cancellation::CancelFlag;
use crate::surface::Sink;
use std::collections::HashMap;

/// The deepest nesting of components.
const DEEPEST: usize = 32;

/// The largest number of times that objects are placed. Nested components can multiply this number exponentially with
/// their depth.
const MOST_PLACED: u64 = 100_000;

/// The build of a package.
pub(super) struct Build<'a> {
    models: &'a HashMap<String, Model>,
    most_facets: u64,
    facets: u64,
    placed: u64,
    left_out: u64,
    cancel: &'a CancelFlag,
}

impl<'a> Build<'a> {
    /// The build of `models`, by their paths in lower case, with at most four facets for each vertex that a package
    /// may have.
    pub(super) fn new(models: &'a HashMap<String, Model>, vertex_limit: usize, cancel: &'a CancelFlag) -> Self {
        Self { models, most_facets: (vertex_limit as u64).saturating_mul(4), facets: 0, placed: 0, left_out: 0, cancel }
    }

    /// Facets passed to the sink.
    pub(super) fn facets(&self) -> u64 {
        self.facets
    }

    /// Objects that are not part of the surface.
    pub(super) fn left_out(&self) -> u64 {
        self.left_out
    }

    /// Places the build items of the model of this path.
    pub(super) fn place_all<S: Sink>(&mut self, path: &str, items: &[Reference], sink: &mut S) -> Result<(), Fault> {
        items.iter().try_for_each(|item| self.place(path, item, &Transform::IDENTITY, 0, sink))
    }

    fn place<S: Sink>(&mut self, path: &str, reference: &Reference, outer: &Transform, depth: usize, sink: &mut S) -> Result<(), Fault> {
        let at = |flaw: Flaw| flaw.in_entry(path, 0);
        self.placed += 1;
        if depth > DEEPEST || self.placed > MOST_PLACED {
            let expected = format!("components nested at most {DEEPEST} deep, and at most {MOST_PLACED} objects placed");
            return Err(at(Flaw::new(FaultKind::TooLarge, expected, "more")));
        }
        let path = reference.path.as_deref().unwrap_or(path);
        let models = self.models;
        let object = models.get(&path.to_lowercase()).and_then(|model| model.objects.get(&reference.object));
        let object = object.ok_or_else(|| at(Flaw::new(FaultKind::OutOfRange, "the number of an object", reference.object.to_string())))?;
        if !object.is_surface {
            self.left_out += 1;
            return Ok(());
        }
        let transform = reference.transform.then(outer);
        self.place_mesh(object, &transform, sink).map_err(at)?;
        object.components.iter().try_for_each(|component| self.place(path, component, &transform, depth + 1, sink))
    }

    fn place_mesh<S: Sink>(&mut self, object: &Object, transform: &Transform, sink: &mut S) -> Result<(), Flaw> {
        self.facets += object.triangles.len() as u64;
        if self.facets > self.most_facets {
            return Err(Flaw::new(
                FaultKind::TooLarge,
                format!("at most {} facets after placing all components", self.most_facets),
                "more",
            ));
        }
        // A reflection reverses the facets' orientation; the reverse order of their corners restores it.
        let is_reflection = transform.determinant() < 0.0;
        for triangle in &object.triangles {
            if self.cancel.is_cancelled() {
                return Ok(());
            }
            let [a, b, c] = triangle.map(|vertex| transform.apply(object.vertices[vertex as usize]));
            if ![a, b, c].into_iter().all(is_bounded) {
                return Err(unbounded("a vertex beyond it after placing its object"));
            }
            sink.facet(if is_reflection { [a, c, b] } else { [a, b, c] });
        }
        Ok(())
    }
}
