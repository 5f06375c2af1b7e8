//! The facets of a 3MF package: places its build items with their components, recursively; objects that contain themselves are
//! refused.

use super::super::words::unbounded;
use super::package_model::{PackageModel, PackageObject, Reference, Transform, is_bounded};
use super::volumes::Volumes;
use crate::file_fault::{FileFault, FileFaultKind, Flaw};
use crate::surface::Sink;
use std::collections::{HashMap, HashSet};

/// The deepest nesting of components.
const DEEPEST: usize = 32;

/// The largest number of times that objects are placed. Nested components can multiply this number exponentially with
/// their depth.
const MOST_PLACED: u64 = 100_000;

/// The largest number of volumes that are named.
const MOST_NAMED: usize = 10;

/// The build of a package.
pub(super) struct Build<'a> {
    models: &'a HashMap<String, PackageModel>,
    most_facets: u64,
    facets: u64,
    placed: u64,
    left_out: u64,
    /// The path of the root model in lower case, to which the settings refer.
    root: String,
    settings: &'a Volumes,
    /// The volumes that were left out, each once.
    volumes: Vec<String>,
}

impl<'a> Build<'a> {
    /// The build of `models`, by their paths in lower case, with at most four facets for each vertex that a package
    /// may have.
    pub(super) fn new(models: &'a HashMap<String, PackageModel>, root: &str, settings: &'a Volumes, vertex_limit: usize) -> Self {
        let most_facets = (vertex_limit as u64).saturating_mul(4);
        Self { models, most_facets, facets: 0, placed: 0, left_out: 0, root: root.to_lowercase(), settings, volumes: Vec::new() }
    }

    /// The volumes that were left out.
    pub(super) fn into_volumes(self) -> Vec<String> {
        self.volumes
    }

    fn note(&mut self, volumes: impl IntoIterator<Item = String>) {
        for volume in volumes {
            if self.volumes.len() < MOST_NAMED && !self.volumes.contains(&volume) {
                self.volumes.push(volume);
            }
        }
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
    pub(super) fn place_all(&mut self, path: &str, items: &[Reference], sink: &mut dyn Sink) -> Result<(), FileFault> {
        items.iter().try_for_each(|item| self.place(path, item, &Transform::IDENTITY, 0, sink))
    }

    fn place(&mut self, path: &str, reference: &Reference, outer: &Transform, depth: usize, sink: &mut dyn Sink) -> Result<(), FileFault> {
        let at = |flaw: Flaw| flaw.in_entry(path, 0);
        self.placed += 1;
        if depth > DEEPEST || self.placed > MOST_PLACED {
            let expected = format!("components nested at most {DEEPEST} deep, and at most {MOST_PLACED} objects placed");
            return Err(at(Flaw::new(FileFaultKind::TooLarge, expected, "more")));
        }
        let path = reference.path.as_deref().unwrap_or(path);
        let models = self.models;
        let object = models.get(&path.to_lowercase()).and_then(|model| model.objects.get(&reference.object));
        let object =
            object.ok_or_else(|| at(Flaw::new(FileFaultKind::OutOfRange, "the number of an object", reference.object.to_string())))?;
        if !object.is_surface {
            self.left_out += 1;
            return Ok(());
        }
        if !reference.is_printable {
            self.note([format!("the object {}, which is not printable", reference.object)]);
            return Ok(());
        }
        let transform = reference.transform.then(outer);
        let settings = self.settings;
        let is_root = path.to_lowercase() == self.root;
        let ranges = if is_root { settings.triangles(reference.object) } else { Vec::new() };
        if is_root {
            self.note(settings.names(reference.object));
        }
        self.place_mesh(object, &ranges, &transform, sink).map_err(at)?;
        let is_part = |component: &&Reference| !(is_root && settings.excludes(reference.object, component.object));
        object.components.iter().filter(is_part).try_for_each(|component| self.place(path, component, &transform, depth + 1, sink))
    }

    /// Places the triangles of an object that are not in one of `excluded` ranges.
    fn place_mesh(
        &mut self,
        object: &PackageObject,
        excluded: &[[usize; 2]],
        transform: &Transform,
        sink: &mut dyn Sink,
    ) -> Result<(), Flaw> {
        let mut is_part = vec![true; if excluded.is_empty() { 0 } else { object.triangles.len() }];
        for [first, last] in excluded {
            let end = last.saturating_add(1).min(is_part.len());
            is_part[(*first).min(end)..end].fill(false);
        }
        let left_out = is_part.iter().filter(|is_part| !**is_part).count();
        self.facets += (object.triangles.len() - left_out) as u64;
        if self.facets > self.most_facets {
            return Err(Flaw::new(
                FileFaultKind::TooLarge,
                format!("at most {} facets after placing all components", self.most_facets),
                "more",
            ));
        }
        // A reflection reverses the facets' orientation; the reverse order of their corners restores it.
        let is_reflection = transform.determinant() < 0.0;
        for (index, triangle) in object.triangles.iter().enumerate() {
            if !is_part.get(index).copied().unwrap_or(true) {
                continue;
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

/// An object of a package: the path of its model in lower case, and its number.
type Key = (String, u32);

/// The numbers of a cycle that a fault names.
const MOST_NAMED_IN_CYCLE: usize = 8;

/// Checks the objects that the build items of the model `root` place: none may contain itself.
///
/// The depth-first search does not use recursion, because a cycle can pass through all objects of a package.
pub(super) fn refuse_cycles(models: &HashMap<String, PackageModel>, root: &str, items: &[Reference]) -> Result<(), FileFault> {
    let mut done = HashSet::new();
    for item in items {
        // The objects from the item down to the current one, each with the number of its components that were followed.
        let mut chain: Vec<(Key, usize)> = vec![(key(item, root), 0)];
        let mut open: HashSet<Key> = chain.iter().map(|(key, _)| key.clone()).collect();
        while let Some((current, followed)) = chain.last_mut() {
            let components = models.get(&current.0).and_then(|model| model.objects.get(&current.1)).map(|object| &object.components);
            let next = components.and_then(|components| components.get(*followed)).filter(|_| !done.contains(&*current));
            let Some(component) = next else {
                open.remove(current);
                done.insert(current.clone());
                chain.pop();
                continue;
            };
            *followed += 1;
            let inner = key(component, &current.0);
            if open.contains(&inner) {
                return Err(cycle(&chain, &inner, root));
            }
            if !done.contains(&inner) {
                open.insert(inner.clone());
                chain.push((inner, 0));
            }
        }
    }
    Ok(())
}

/// The object that `reference` names in the model of this path.
fn key(reference: &Reference, path: &str) -> Key {
    (reference.path.as_deref().unwrap_or(path).to_lowercase(), reference.object)
}

/// The fault of the cycle that the last object of `chain` closes with its component `first`. It is located in the root
/// model, which places the objects.
fn cycle(chain: &[(Key, usize)], first: &Key, root: &str) -> FileFault {
    let start = chain.iter().position(|(key, _)| key == first).unwrap_or(0);
    let mut numbers: Vec<String> = chain[start..].iter().take(MOST_NAMED_IN_CYCLE).map(|((_, number), _)| number.to_string()).collect();
    if chain.len() - start > MOST_NAMED_IN_CYCLE {
        numbers.push("...".to_owned());
    }
    numbers.push(first.1.to_string());
    let found = format!("a cycle of objects: {}", numbers.join(" > "));
    Flaw::new(FileFaultKind::Malformed, "objects that do not contain themselves", found).in_entry(root, 0)
}
