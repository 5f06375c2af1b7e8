//! The volumes of a part that the settings of a slicer exclude from it: PrusaSlicer names ranges of triangles of an
//! object, Bambu Studio and OrcaSlicer name components.

use super::super::input::ReadError;
use super::Package;
use super::xml::{self, Event, XmlElement};
use crate::file_fault::{FileFaultKind, Flaw, quoted};
use std::collections::HashMap;

/// The settings files: PrusaSlicer's, and those of Bambu Studio and OrcaSlicer.
const SETTINGS: [&str; 3] = ["Metadata/Slic3r_PE_model.config", "Metadata/Slic3r_model.config", "Metadata/model_settings.config"];

/// The largest number of volumes of a package.
const MOST: usize = 100_000;

/// A volume that is not a part.
#[derive(Debug, Clone)]
struct Volume {
    /// The kind as the settings name it, such as `ParameterModifier`.
    kind: String,
    name: String,
    /// The first and the last triangle, if the volume is a range of triangles of its object.
    triangles: Option<[usize; 2]>,
    /// The object of the component, if the volume is one.
    component: Option<u32>,
}

/// The excluded volumes of a package, by the object that they belong to.
#[derive(Debug, Default)]
pub(super) struct Volumes(HashMap<u32, Vec<Volume>>);

impl Volumes {
    /// Reads the settings of a package.
    ///
    /// # Errors
    /// A settings file is damaged, or a negative volume is subtracted from the part.
    pub(super) fn read(package: &mut Package) -> Result<Self, ReadError> {
        let mut volumes = Self::default();
        for path in SETTINGS {
            if package.archive.file(path).is_some() {
                volumes.read_settings(package, path)?;
            }
        }
        Ok(volumes)
    }

    fn read_settings(&mut self, package: &mut Package, path: &str) -> Result<(), ReadError> {
        let mut object = None;
        let mut volume: Option<Volume> = None;
        let mut depth = 0;
        let mut count = 0;
        xml::read(package, path, |event| {
            match event {
                Event::Start(element) => {
                    depth += 1;
                    match (depth, element.name()) {
                        (2, "object") => object = whole(&element, "id"),
                        (3, "volume" | "part") => {
                            count += 1;
                            if count > MOST {
                                return Err(Flaw::new(FileFaultKind::TooLarge, format!("at most {MOST} volumes"), "more"));
                            }
                            volume = Some(Volume::of(&element));
                        }
                        (4, "metadata") => {
                            if let Some(volume) = &mut volume {
                                volume.metadata(&element);
                            }
                        }
                        _ => {}
                    }
                }
                Event::End => {
                    if depth == 3
                        && let (Some(object), Some(volume)) = (object, volume.take())
                        && !volume.is_part()
                    {
                        volume.refuse_negative()?;
                        self.0.entry(object).or_default().push(volume);
                    }
                    depth -= 1;
                }
            }
            Ok(())
        })
    }

    /// The ranges of the excluded triangles of an object.
    pub(super) fn triangles(&self, object: u32) -> Vec<[usize; 2]> {
        self.0.get(&object).into_iter().flatten().filter_map(|volume| volume.triangles).collect()
    }

    /// Whether the component `inner` of an object is excluded.
    pub(super) fn excludes(&self, object: u32, inner: u32) -> bool {
        self.0.get(&object).into_iter().flatten().any(|volume| volume.component == Some(inner))
    }

    /// The excluded volumes of an object, each by kind and name.
    pub(super) fn names(&self, object: u32) -> impl Iterator<Item = String> {
        self.0.get(&object).into_iter().flatten().map(|volume| format!("{} {}", volume.kind, quoted(volume.name.as_bytes())))
    }
}

impl Volume {
    fn of(element: &XmlElement) -> Self {
        let range =
            [whole(element, "firstid"), whole(element, "lastid")].map(|number| number.and_then(|number| usize::try_from(number).ok()));
        Self {
            kind: element.attribute("subtype").unwrap_or_default(),
            name: String::new(),
            triangles: if let [Some(first), Some(last)] = range { Some([first, last]) } else { None },
            component: if element.name() == "part" { whole(element, "id") } else { None },
        }
    }

    fn metadata(&mut self, element: &XmlElement) {
        let value = || element.attribute("value").unwrap_or_default();
        match element.attribute("key").as_deref() {
            Some("name") => self.name = value(),
            Some("volume_type") => self.kind = value(),
            // Before volumes had types.
            Some("modifier") if self.kind.is_empty() && value() == "1" => "ParameterModifier".clone_into(&mut self.kind),
            _ => {}
        }
    }

    fn is_part(&self) -> bool {
        matches!(self.kind.as_str(), "" | "ModelPart" | "normal_part")
    }

    fn refuse_negative(&self) -> Result<(), Flaw> {
        if !self.kind.to_ascii_lowercase().starts_with("negative") {
            return Ok(());
        }
        let found =
            format!("the negative volume {}, which the slicer subtracts; export the finished part as STL", quoted(self.name.as_bytes()));
        Err(Flaw::new(FileFaultKind::Malformed, "a part without negative volumes", found))
    }
}

fn whole(element: &XmlElement, attribute: &str) -> Option<u32> {
    element.attribute(attribute)?.trim().parse().ok()
}
