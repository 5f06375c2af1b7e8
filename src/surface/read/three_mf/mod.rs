//! Reader of 3MF: a ZIP package with models in XML. The objects of a model are meshes or consist of other objects
//! (components); build items place them.
//!
//! The directory of a ZIP archive is at its end, so the compressed file is stored, up to [`DEFAULT_ARCHIVE_LIMIT`]. The
//! models are decompressed and parsed as streams. The meshes are stored too, up to the limit on vertices, because
//! components place them. Objects of the types `support` and `other` are not part of the surface and are counted. The
//! summary has the model's unit, and every coordinate is in that unit.
//!
//! A slicer's settings in the package may exclude volumes of an object from the part: modifiers, support blockers and
//! enforcers are left out and named; a negative volume is refused. Build items that are not printable are left out.
//!
//! A ZIP archive of one file that is not a package is read as that file.
//!
//! The core specification and its production extension (models in several files) are read. Extensions that do not
//! change the surface, such as materials, are ignored; a model that requires any other extension is refused.

mod build;
mod package_model;
mod volumes;
mod xml;
mod zipped;

use super::input::{Input, ReadError};
use super::{Format, Notes, ReadSummary, Reader, Sink};
use crate::archive::{Archive, ArchiveLimits};
use crate::file_fault::{FileFaultKind, Flaw};
use build::{Build, refuse_cycles};
use package_model::{PackageModel, Room};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;
use volumes::Volumes;
use xml::Event;

/// The default limit on the size of a compressed 3MF file, in bytes;
/// [`Reader::with_archive_limit`](super::Reader::with_archive_limit) changes it.
pub const DEFAULT_ARCHIVE_LIMIT: usize = 256 << 20;

/// The limits of a package: 2 GiB of decompressed XML are some 25 million facets.
const LIMITS: ArchiveLimits = ArchiveLimits { entries: 10_000, inflated_bytes: 2 << 30 };

/// Reads a 3MF file, or the only file of another ZIP archive, within the limits of `reader`.
pub(super) fn read(input: &mut Input, reader: Reader, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
    let (limit, vertex_limit) = (reader.archive_limit, reader.package_vertex_limit);
    let Some(bytes) = input.rest_within(limit)? else {
        let flaw = Flaw::new(FileFaultKind::TooLarge, format!("a 3MF file of at most {limit} bytes"), "a larger one");
        return Err(flaw.at_byte(limit as u64).into());
    };
    let archive = Archive::open(&bytes, LIMITS).map_err(|fault| Flaw::from(&fault).at_byte(0))?;
    let mut package = Package { archive, input };
    let Some(root) = root_model(&mut package)? else { return zipped::read(&mut package, reader, sink) };
    let volumes = Volumes::read(&mut package)?;
    let mut room = Room::for_vertices(vertex_limit);
    let model = PackageModel::read(&mut package, &root, &mut room)?;
    let unit = model.unit;
    let items = model.items.clone();
    let mut models = HashMap::from([(root.to_lowercase(), model)]);
    // Models in other files that build items and components refer to. The models that these refer to are read in
    // the next round.
    let mut wanted = models_named_by(&models[&root.to_lowercase()]);
    while let Some(path) = wanted.pop() {
        if models.contains_key(&path.to_lowercase()) {
            continue;
        }
        let part = PackageModel::read(&mut package, &path, &mut room)?;
        if part.unit != unit {
            return Err(Flaw::new(FileFaultKind::Malformed, "one unit in all models of the package", "another").in_entry(&path, 0).into());
        }
        wanted.extend(models_named_by(&part));
        models.insert(path.to_lowercase(), part);
    }
    refuse_cycles(&models, &root, &items)?;
    let mut build = Build::new(&models, &root, &volumes, vertex_limit);
    build.place_all(&root, &items, sink)?;
    if build.facets() == 0 {
        return Err(Flaw::new(FileFaultKind::Empty, "a build item with a mesh", "none").in_entry(&root, 0).into());
    }
    let facets = build.facets();
    let notes = Notes { other_elements: build.left_out(), volumes: build.into_volumes(), ..Notes::default() };
    Ok(ReadSummary { format: Format::ThreeMf, points: 0, facets, unit: Some(unit), notes })
}

/// The files of a package, and the input that they came from, which ends reading when nobody waits for the result.
struct Package<'a, 'b> {
    archive: Archive<'a>,
    input: &'a mut Input<'b>,
}

impl Package<'_, '_> {
    /// The path in the archive of a part of this name, which may have percent escapes.
    fn file(&self, name: &str) -> Option<&str> {
        let decoded = || -> Cow<'_, str> { percent_encoding::percent_decode_str(name).decode_utf8_lossy() };
        self.archive.file(name).or_else(|| self.archive.file(&decoded()))
    }
}

fn models_named_by(model: &PackageModel) -> Vec<Arc<str>> {
    model.references().filter_map(|reference| reference.path.clone()).collect()
}

/// The path of the package's root model, by its relationships; `None` for an archive that is not a package.
fn root_model(package: &mut Package) -> Result<Option<Arc<str>>, ReadError> {
    let relationships = "_rels/.rels";
    if package.archive.file(relationships).is_some() {
        let mut target = None;
        xml::read(package, relationships, |event| {
            if let Event::Start(element) = event
                && element.name() == "Relationship"
                && element.attribute("Type").is_some_and(|kind| kind.ends_with("/3dmodel"))
            {
                target = target.take().or_else(|| element.attribute("Target"));
            }
            Ok(())
        })?;
        if let Some(target) = target {
            return Ok(Some(target.trim_start_matches('.').trim_start_matches('/').into()));
        }
    }
    Ok(package.archive.file("3D/3dmodel.model").map(Into::into))
}
