//! Autodesk Fusion's tool libraries: JSON with the tools in `data`, each with its type, its unit, its geometry and its
//! presets.
//!
//! Each tool is read and dropped before the next, so that memory grows with the finishing cutters alone. A tool's
//! lengths are in its `unit`; its `holder`, which has another unit, is not read. The preset with "finish" in its name,
//! else the first, gives speed and feed.

use super::dimension::{LengthUnit, spindle_speed, teeth, tool_number};
use super::fault::{Flaw, LibraryFault};
use super::scalar::Scalar;
use super::shape::Shape;
use super::{ReadTool, ToolLibrary, ToolParts};
use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, SeqAccess, Visitor};
use std::fmt;

/// Reads a library file.
pub(super) fn read(text: &[u8], file: &str) -> Result<ToolLibrary, LibraryFault> {
    match serde_json::from_slice::<LibraryFile>(text) {
        Ok(LibraryFile { data: Tools(Ok(library)) }) => Ok(library),
        Ok(LibraryFile { data: Tools(Err(fault)) }) => Err(fault.flaw.of_tool(file, fault.position, fault.name.as_deref())),
        Err(error) => Err(Flaw::json("a tool library of Fusion in JSON", &error).in_file(file)),
    }
}

/// The members of a library file.
#[derive(Deserialize)]
struct LibraryFile {
    data: Tools,
}

/// The tools of `data`, or the first fault of one.
struct Tools(Result<ToolLibrary, Box<ToolFault>>);

struct ToolFault {
    position: usize,
    name: Option<String>,
    flaw: Flaw,
}

impl<'de> Deserialize<'de> for Tools {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(ToolsVisitor).map(Self)
    }
}

struct ToolsVisitor;

impl<'de> Visitor<'de> for ToolsVisitor {
    type Value = Result<ToolLibrary, Box<ToolFault>>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of tools")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
        let mut library = ToolLibrary::default();
        for position in 1.. {
            let in_tool = |error: A::Error| A::Error::custom(format_args!("in tool {position}, {error}"));
            let Some(tool) = items.next_element::<Tool>().map_err(in_tool)? else { break };
            if let Err(flaw) = tool.read(position).and_then(|tool| library.add(tool)) {
                while items.next_element::<IgnoredAny>()?.is_some() {}
                return Ok(Err(Box::new(ToolFault { position, name: tool.name(), flaw })));
            }
        }
        Ok(Ok(library))
    }
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
    /// The tool's name: its description, else its product number.
    fn name(&self) -> Option<String> {
        let names = [&self.description, &self.product_id].into_iter().flatten();
        names.filter_map(|name| name.text().ok()).find(|name| !name.trim().is_empty())
    }

    fn read(&self, position: usize) -> Result<ReadTool, Flaw> {
        let kind = self.kind.as_ref().ok_or_else(|| Flaw::missing("the type of the tool").of_member("type"))?;
        let kind = kind.text().map_err(|flaw| flaw.of_member("type"))?;
        let shape = match kind.trim().to_lowercase().as_str() {
            "ball end mill" => Shape::Ball,
            "bull nose end mill" => Shape::BullNose,
            "flat end mill" => Shape::Flat,
            _ => return Ok(ReadTool::Other(kind)),
        };
        let geometry = self.geometry.as_ref().ok_or_else(|| Flaw::missing("the geometry of the cutter").of_member("geometry"))?;
        // The flank of a tapered cutter differs from that of a straight cutter with the same tip.
        if geometry.taper()? != 0.0 {
            return Ok(ReadTool::Other(format!("tapered {kind}")));
        }
        let unit = self.unit()?;
        let diameter = Geometry::number("geometry.DC", geometry.DC.as_ref())?;
        let diameter = diameter.ok_or_else(|| Flaw::missing("the diameter of the cutter").of_member("geometry.DC"))?;
        let diameter = unit.length(diameter).map_err(|flaw| flaw.of_member("geometry.DC"))?;
        let corner = Geometry::number("geometry.RE", geometry.RE.as_ref())?;
        let corner_radius =
            corner.map_or(Ok(None), |radius| unit.length_unless_zero(radius)).map_err(|flaw| flaw.of_member("geometry.RE"))?;
        let cutter = shape.cutter(diameter, corner_radius, corner.is_some()).map_err(|flaw| flaw.of_member("geometry.RE"))?;
        let teeth = Geometry::number("geometry.NOF", geometry.NOF.as_ref())?
            .map_or(Ok(None), teeth)
            .map_err(|flaw| flaw.of_member("geometry.NOF"))?;
        let flutes = Geometry::number("geometry.LCF", geometry.LCF.as_ref())?;
        let flute_length =
            flutes.map_or(Ok(None), |length| unit.length_unless_zero(length)).map_err(|flaw| flaw.of_member("geometry.LCF"))?;
        let parts = ToolParts { name: self.name(), number: self.number()?, teeth, flute_length, ..ToolParts::default() };
        let parts = match self.start_values.as_ref().and_then(|values| values.presets.chosen.as_ref()) {
            Some(preset) => preset.with(parts, unit)?,
            None => parts,
        };
        Ok(ReadTool::Finishing(Box::new(parts.with(cutter, position))))
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

impl Geometry {
    fn number(member: &'static str, value: Option<&Scalar>) -> Result<Option<f64>, Flaw> {
        value.map(|value| value.number().map_err(|flaw| flaw.of_member(member))).transpose()
    }

    fn taper(&self) -> Result<f64, Flaw> {
        Ok(Self::number("geometry.TA", self.TA.as_ref())?.unwrap_or(0.0))
    }
}

impl Preset {
    /// Speed and feed of the preset. A missing feed per tooth is computed from the feed rate: f_z = v_f / (z n).
    fn with(&self, parts: ToolParts, unit: LengthUnit) -> Result<ToolParts, Flaw> {
        let number = |member: &str, value: &Option<Scalar>| {
            let value = value.as_ref().map(Scalar::number).transpose();
            value.map_err(|flaw| flaw.of_member(format!("start-values.presets.{member}")))
        };
        let speed = number("n", &self.n)?.map_or(Ok(None), spindle_speed).map_err(|flaw| flaw.of_member("start-values.presets.n"))?;
        let feed = match number("f_z", &self.f_z)?.filter(|feed| *feed != 0.0) {
            Some(feed) => Some(unit.length(feed).map_err(|flaw| flaw.of_member("start-values.presets.f_z"))?),
            None => match (number("v_f", &self.v_f)?.filter(|rate| *rate != 0.0), parts.teeth, speed) {
                (Some(rate), Some(teeth), Some(speed)) => {
                    Some(unit.length(rate / (f64::from(teeth) * speed)).map_err(|flaw| flaw.of_member("start-values.presets.v_f"))?)
                }
                _ => None,
            },
        };
        Ok(ToolParts { spindle_speed_rpm: speed, max_feed_per_tooth: feed, preset: self.name(), ..parts })
    }
}
