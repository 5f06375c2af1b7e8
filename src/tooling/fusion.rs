//! Reader of Autodesk Fusion's tool libraries: JSON with the tools in `data`, each with its type, unit, geometry and
//! presets.
//!
//! Each tool is read and dropped before the next, so that memory grows only with the number of finishing cutters. A
//! tool's lengths are in its `unit`; its `holder`, which has another unit, is not read. Speed and feed come from the
//! preset with "finish" in its name, otherwise from the first preset.

use super::cutter_shape::{Dimension, Dimensions, LibraryShape};
use super::dimension::{LengthUnit, Scalar, spindle_speed, teeth, tool_number};
use super::library_fault::{Flaws, json_flaw};
use super::{ReadTool, ToolLibrary, ToolParts, ToolPlace};
use crate::file_fault::{FileFault, Flaw};
use crate::json::each;
use crate::milling::Cutter;
use crate::quantity::Length;
use serde::Deserialize;
use serde::de::{Deserializer, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::fmt;

/// The longest text of a tool; Fusion writes 2 kB for one.
const LONGEST_TOOL: usize = 1 << 20;

/// Adds the tools of `data`, the member of a library file.
///
/// # Errors
/// `data` is not an array, or the library is full.
pub(super) fn read(data: &RawValue, file: &str, library: &mut ToolLibrary) -> Result<(), FileFault> {
    let (mut result, mut position) = (Ok(()), 0);
    let read = each(data, |item| {
        position += 1;
        if result.is_ok() {
            result = add(item, position, file, library);
        }
    });
    read.map_err(|_| Flaw::malformed("an array of tools", "another value").of_member("data").in_file(file))?;
    result
}

/// Adds the tool at this position of the file, counted from 1.
fn add(item: &RawValue, position: usize, file: &str, library: &mut ToolLibrary) -> Result<(), FileFault> {
    if item.get().len() > LONGEST_TOOL {
        let flaw = Flaw::too_large(format!("a tool of at most {LONGEST_TOOL} bytes"), format!("{} bytes", item.get().len()));
        return library.add(Err(flaw.into()), &ToolPlace { file, position, name: None }).map_err(|flaw| flaw.in_file(file));
    }
    let read: Result<Tool, Flaws> = serde_json::from_str(item.get()).map_err(|error| json_flaw("a tool in JSON", &error).into());
    let name = read.as_ref().ok().and_then(Tool::name);
    let tool = match TypeAlone::other(item) {
        // The other members of such a tool may differ from those of a cutter.
        Some(kind) => Ok(ReadTool::Other(kind)),
        None => read.and_then(|tool| tool.read(position)),
    };
    library.add(tool, &ToolPlace { file, position, name: name.as_deref() }).map_err(|flaw| flaw.in_file(file))
}

/// Only the type of a tool; its other members are not read.
#[derive(Deserialize)]
struct TypeAlone {
    #[serde(rename = "type")]
    kind: Option<Scalar>,
}

impl TypeAlone {
    /// The type of a tool that is not a finishing cutter; `None` for a finishing cutter.
    fn other(item: &RawValue) -> Option<String> {
        let Self { kind } = serde_json::from_str(item.get()).ok()?;
        kind?.text().ok().filter(|kind| shape_of(kind).is_none())
    }
}

/// The shape of the finishing cutters of this type.
fn shape_of(kind: &str) -> Option<LibraryShape> {
    LibraryShape::named(kind)
}

/// A tool. Members that are not named here are skipped.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Tool {
    #[serde(rename = "type")]
    kind: Option<Scalar>,
    unit: Option<Scalar>,
    description: Option<Scalar>,
    product_id: Option<Scalar>,
    geometry: Option<Geometry>,
    post_process: Option<PostProcess>,
    start_values: Option<StartValues>,
}

#[derive(Deserialize)]
#[expect(non_snake_case, reason = "the names of the format")]
struct Geometry {
    DC: Option<Scalar>,
    RE: Option<Scalar>,
    NOF: Option<Scalar>,
    LCF: Option<Scalar>,
    TA: Option<Scalar>,
    SFDM: Option<Scalar>,
    #[serde(rename = "lower-radius")]
    lower_radius: Option<Scalar>,
    #[serde(rename = "profile-radius")]
    profile_radius: Option<Scalar>,
    #[serde(rename = "upper-radius")]
    upper_radius: Option<Scalar>,
}

#[derive(Deserialize)]
struct PostProcess {
    number: Option<Scalar>,
}

#[derive(Deserialize)]
struct StartValues {
    #[serde(default)]
    presets: Presets,
}

#[derive(Deserialize)]
struct Preset {
    name: Option<Scalar>,
    n: Option<Scalar>,
    v_f: Option<Scalar>,
    f_z: Option<Scalar>,
}

/// The preset for finishing; the others are dropped.
#[derive(Default)]
struct Presets {
    chosen: Option<Preset>,
}

impl<'de> Deserialize<'de> for Presets {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PresetsVisitor)
    }
}

struct PresetsVisitor;

impl<'de> Visitor<'de> for PresetsVisitor {
    type Value = Presets;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of presets")
    }

    fn visit_unit<E>(self) -> Result<Presets, E> {
        Ok(Presets::default())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Presets, A::Error> {
        let mut presets = Presets::default();
        let mut has_finish = false;
        while let Some(preset) = items.next_element::<Preset>()? {
            let is_finish = preset.name().is_some_and(|name| name.to_lowercase().contains("finish"));
            if presets.chosen.is_none() || (is_finish && !has_finish) {
                has_finish = is_finish;
                presets.chosen = Some(preset);
            }
        }
        Ok(presets)
    }
}

impl Preset {
    fn name(&self) -> Option<String> {
        self.name.as_ref().and_then(|name| name.text().ok())
    }
}

impl Tool {
    /// The tool's name: its description, otherwise its product number.
    fn name(&self) -> Option<String> {
        let names = [&self.description, &self.product_id].into_iter().flatten();
        names.filter_map(|name| name.text().ok()).find(|name| !name.trim().is_empty())
    }

    fn read(&self, position: usize) -> Result<ReadTool, Flaws> {
        let kind = self.kind.as_ref().ok_or_else(|| Flaw::missing("the type of the tool").of_member("type"))?;
        let kind = kind.text().map_err(|flaw| flaw.of_member("type"))?;
        let Some(shape) = shape_of(&kind) else { return Ok(ReadTool::Other(kind)) };
        let geometry = self.geometry.as_ref().ok_or_else(|| Flaw::missing("the geometry of the cutter").of_member("geometry"))?;
        let mut flaws = Flaws::default();
        // A tapered cutter differs in its flank from the straight cutter with the same tip.
        let is_straight = matches!(shape, LibraryShape::Ball | LibraryShape::BullNose | LibraryShape::Flat);
        if is_straight && flaws.take(geometry.taper()).is_some_and(|taper| taper != 0.0) {
            return Ok(ReadTool::Other(format!("tapered {kind}")));
        }
        let unit = flaws.take(self.unit());
        let number = flaws.take(self.number()).flatten();
        let teeth = flaws.take(geometry.teeth()).flatten();
        let mut parts = ToolParts { name: self.name(), number, teeth, ..ToolParts::default() };
        let Some(unit) = unit else { return Err(flaws) };
        let cutter = flaws.take(geometry.cutter(shape, unit));
        parts.flute_length = flaws.take(geometry.flute_length(unit)).flatten();
        if let Some(preset) = self.start_values.as_ref().and_then(|values| values.presets.chosen.as_ref()) {
            let speed = flaws.take(preset.speed()).flatten();
            let feed = flaws.take(preset.feed_per_tooth(unit, teeth, speed)).flatten();
            parts = ToolParts { spindle_speed_rpm: speed, max_feed_per_tooth: feed, preset: preset.name(), ..parts };
        }
        ReadTool::unless_flawed(cutter, parts, position, flaws)
    }

    fn unit(&self) -> Result<LengthUnit, Flaw> {
        let expected = "\"millimeters\" or \"inches\"";
        let unit = self.unit.as_ref().ok_or_else(|| Flaw::missing(expected).of_member("unit"))?;
        match unit.text().ok().as_deref().and_then(LengthUnit::named) {
            Some(unit) if unit == LengthUnit::MILLIMETRE || unit == LengthUnit::INCH => Ok(unit),
            _ => Err(Flaw::malformed(expected, unit.shown()).of_member("unit")),
        }
    }

    fn number(&self) -> Result<Option<u32>, Flaw> {
        let number = self.post_process.as_ref().and_then(|post| post.number.as_ref());
        number.map(|number| number.number().and_then(tool_number).map_err(|flaw| flaw.of_member("post-process.number"))).transpose()
    }
}

fn member_of(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::CornerRadius => "geometry.RE",
        Dimension::Taper => "geometry.TA",
        Dimension::ShankDiameter => "geometry.SFDM",
        Dimension::LensRadius | Dimension::TipRadius => "geometry.lower-radius",
        Dimension::SideRadius => "geometry.profile-radius",
        Dimension::UpperRadius => "geometry.upper-radius",
    }
}

impl Geometry {
    fn number(member: &'static str, value: Option<&Scalar>) -> Result<Option<f64>, Flaw> {
        value.map(|value| value.number().map_err(|flaw| flaw.of_member(member))).transpose()
    }

    fn taper(&self) -> Result<f64, Flaw> {
        Ok(Self::number("geometry.TA", self.TA.as_ref())?.unwrap_or(0.0))
    }

    fn teeth(&self) -> Result<Option<u32>, Flaw> {
        let member = "geometry.NOF";
        Self::number(member, self.NOF.as_ref())?.map_or(Ok(None), teeth).map_err(|flaw| flaw.of_member(member))
    }

    fn flute_length(&self, unit: LengthUnit) -> Result<Option<Length>, Flaw> {
        Self::length("geometry.LCF", self.LCF.as_ref(), unit)
    }

    /// A length; 0 means unknown.
    fn length(member: &'static str, value: Option<&Scalar>, unit: LengthUnit) -> Result<Option<Length>, Flaw> {
        let length = Self::number(member, value)?.map_or(Ok(None), |length| unit.length_unless_zero(length));
        length.map_err(|flaw| flaw.of_member(member))
    }

    fn cutter(&self, shape: LibraryShape, unit: LengthUnit) -> Result<Cutter, Flaw> {
        let diameter = Self::number("geometry.DC", self.DC.as_ref())?.ok_or_else(|| Flaw::missing("the diameter of the cutter"));
        let diameter = diameter.and_then(|diameter| unit.length(diameter)).map_err(|flaw| flaw.of_member("geometry.DC"))?;
        let length = |dimension, value: &Option<Scalar>| Self::length(member_of(dimension), value.as_ref(), unit);
        let stated = Dimensions {
            corner_radius: length(Dimension::CornerRadius, &self.RE)?,
            is_corner_stated: self.RE.is_some(),
            taper_deg: Self::number(member_of(Dimension::Taper), self.TA.as_ref())?,
            shank_diameter: length(Dimension::ShankDiameter, &self.SFDM)?,
            lens_radius: None,
            tip_radius: length(Dimension::TipRadius, &self.lower_radius)?,
            side_radius: length(Dimension::SideRadius, &self.profile_radius)?,
            upper_radius: length(Dimension::UpperRadius, &self.upper_radius)?,
            flute_length: self.flute_length(unit)?,
        };
        shape.cutter(diameter, &stated).map_err(|(dimension, flaw)| flaw.of_member(member_of(dimension)))
    }
}

impl Preset {
    fn number(member: &'static str, value: Option<&Scalar>) -> Result<Option<f64>, Flaw> {
        value.map(Scalar::number).transpose().map_err(|flaw| flaw.of_member(member))
    }

    fn speed(&self) -> Result<Option<f64>, Flaw> {
        let member = "start-values.presets.n";
        Self::number(member, self.n.as_ref())?.map_or(Ok(None), spindle_speed).map_err(|flaw| flaw.of_member(member))
    }

    /// The feed per tooth. If it is missing, it is computed from the feed rate: f_z = v_f / (z n).
    fn feed_per_tooth(&self, unit: LengthUnit, teeth: Option<u32>, speed: Option<f64>) -> Result<Option<Length>, Flaw> {
        let stated = "start-values.presets.f_z";
        if let Some(feed) = Self::number(stated, self.f_z.as_ref())?.filter(|feed| *feed != 0.0) {
            return unit.length(feed).map(Some).map_err(|flaw| flaw.of_member(stated));
        }
        let rate_member = "start-values.presets.v_f";
        let rate = Self::number(rate_member, self.v_f.as_ref())?.filter(|rate| *rate != 0.0);
        let (Some(rate), Some(teeth), Some(speed)) = (rate, teeth, speed) else { return Ok(None) };
        unit.length(rate / (f64::from(teeth) * speed)).map(Some).map_err(|flaw| flaw.of_member(rate_member))
    }
}
