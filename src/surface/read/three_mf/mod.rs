//! Reader of 3MF: a ZIP package with models in XML. The objects of a model are meshes or consist of other objects
//! (components); build items place them.
//!
//! The directory of a ZIP archive is at its end, so the compressed file is stored, up to [`DEFAULT_ARCHIVE_LIMIT`]. The
//! models are decompressed and parsed as streams. The meshes are stored too, up to the limit on vertices, because
//! components place them. Objects of the types `support` and `other` are not part of the surface and are counted. The
//! summary has the model's unit, and every coordinate is in that unit.
//!
//! The core specification and its production extension (models in several files) are read. Extensions that do not
//! change the surface, such as materials, are ignored; a model that requires any other extension is refused.

mod build;
mod cycle;
mod model;
mod xml;

use super::fault::{Fault, FaultKind, Flaw};
use super::{Format, Notes, Sink, Summary};
use crate::archive::{Archive, ArchiveFault, ArchiveLimits};
use crate::cancellation::CancelFlag;
use build::Build;
use cycle::refuse_cycles;
use model::{Model, Room};
use std::collections::HashMap;
use std::sync::Arc;
use xml::Event;

/// The default limit on the size of a compressed 3MF file, in bytes;
/// [`Reader::with_archive_limit`](super::Reader::with_archive_limit) changes it.
pub const DEFAULT_ARCHIVE_LIMIT: usize = 256 << 20;

/// The limits of a package: 2 GiB of decompressed XML are some 25 million facets.
const LIMITS: ArchiveLimits = ArchiveLimits { entries: 10_000, inflated_bytes: 2 << 30 };

/// The reader of 3MF.
#[derive(Debug)]
pub(super) struct Reader {
    bytes: Vec<u8>,
    limit: usize,
    vertex_limit: usize,
}

impl Reader {
    pub(super) fn new(archive_limit: usize, vertex_limit: usize) -> Self {
        Self { bytes: Vec::new(), limit: archive_limit, vertex_limit }
    }

    pub(super) fn push(&mut self, chunk: &[u8]) -> Result<(), Fault> {
        if self.bytes.len() + chunk.len() > self.limit {
            let expected = format!("a 3MF file of at most {} bytes", self.limit);
            return Err(Flaw::new(FaultKind::TooLarge, expected, "a larger one").at_byte(self.limit as u64));
        }
        self.bytes.extend_from_slice(chunk);
        Ok(())
    }

    /// The memory held, in bytes.
    pub(super) fn held_bytes(&self) -> usize {
        self.bytes.capacity()
    }

    /// Once `cancel` is set, reading returns early, with any result.
    pub(super) fn finish<S: Sink>(self, sink: &mut S, cancel: &CancelFlag) -> Result<Summary, Fault> {
        let archive = Archive::open(&self.bytes, LIMITS).map_err(|fault| package_flaw(&fault).at_byte(0))?.until(cancel);
        let root = root_model(&archive)?;
        let mut room = Room::for_vertices(self.vertex_limit);
        let model = Model::read(&archive, &root, &mut room)?;
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
            let part = Model::read(&archive, &path, &mut room)?;
            if part.unit != unit {
                return Err(Flaw::new(FaultKind::Malformed, "one unit in all models of the package", "another").in_entry(&path, 0));
            }
            wanted.extend(models_named_by(&part));
            models.insert(path.to_lowercase(), part);
        }
        refuse_cycles(&models, &root, &items)?;
        let mut build = Build::new(&models, self.vertex_limit, cancel);
        build.place_all(&root, &items, sink)?;
        if build.facets() == 0 {
            return Err(Flaw::new(FaultKind::Empty, "a build item with a mesh", "none").in_entry(&root, 0));
        }
        let notes = Notes { other_elements: build.left_out(), ..Notes::default() };
        Ok(Summary { format: Format::ThreeMf, points: 0, facets: build.facets(), unit: Some(unit), notes })
    }
}

fn models_named_by(model: &Model) -> Vec<Arc<str>> {
    model.references().filter_map(|reference| reference.path.clone()).collect()
}

/// The path of the package's root model, by its relationships.
fn root_model(archive: &Archive) -> Result<Arc<str>, Fault> {
    let relationships = "_rels/.rels";
    if archive.file(relationships).is_some() {
        let mut target = None;
        xml::read(archive, relationships, |event| {
            if let Event::Start(element) = event
                && element.name() == "Relationship"
                && element.attribute("Type").is_some_and(|kind| kind.ends_with("/3dmodel"))
            {
                target = target.take().or_else(|| element.attribute("Target"));
            }
            Ok(())
        })?;
        if let Some(target) = target {
            return Ok(target.trim_start_matches('/').into());
        }
    }
    let found = match () {
        () if archive.file("3D/3dmodel.model").is_some() => return Ok("3D/3dmodel.model".into()),
        () if archive.file("xl/workbook.xml").is_some() => "an Excel workbook; save the points as CSV",
        () if archive.file("word/document.xml").is_some() => "a Word document",
        () if archive.file("Document.xml").is_some() => "a FreeCAD document; export the surface as STL or 3MF",
        () => "a ZIP archive that is not a 3MF package; send the file itself",
    };
    Err(Flaw::new(FaultKind::UnknownFormat, super::format::EXPECTED, found).at_byte(0))
}

fn package_flaw(fault: &ArchiveFault) -> Flaw {
    let kind = match fault {
        _ if fault.is_limit() => FaultKind::TooLarge,
        ArchiveFault::Damaged(_) => FaultKind::Malformed,
        _ => FaultKind::UnknownFormat,
    };
    Flaw::new(kind, "a 3MF package within its limits", fault.to_string())
}
