//! Reader of FreeCAD's tools. A `.fctb` file is one tool in JSON, with a shape and dimensions as text with a unit. A
//! `.fctl` file lists the tools of a library with their numbers.

use super::cutter_shape::{Dimension, Dimensions, LibraryShape};
use super::dimension::{LengthUnit, Scalar, angle_deg, number_with_unit, shown, teeth, tool_number};
use super::library_fault::{Flaws, json_flaw};
use super::{MOST_TOOLS, ReadTool, ToolLibrary, ToolParts, ToolPlace};
use crate::file_fault::{FileFault, Flaw};
use crate::milling::Cutter;
use crate::quantity::Length;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use std::fmt;

/// The longest text of a tool; FreeCAD writes 1 kB for one.
const LONGEST_TOOL: usize = 1 << 20;

/// The longest list: 400 bytes for each of 10,000 tools.
const LONGEST_LIST: usize = 4 << 20;

/// Refuses a text of more than `most` bytes.
fn within(length: usize, most: usize, what: &str) -> Result<(), Flaw> {
    if length <= most { Ok(()) } else { Err(Flaw::too_large(format!("{what} of at most {most} bytes"), format!("{length} bytes"))) }
}

/// Reads the tool of a `.fctb` file, whose number in the library is `number`.
///
/// # Errors
/// The library is full. Faults of the file are recorded as faults of the tool.
pub(super) fn read_tool(text: &str, file: &str, number: Option<u32>, library: &mut ToolLibrary) -> Result<(), FileFault> {
    let read = within(text.len(), LONGEST_TOOL, "a tool")
        .and_then(|()| serde_json::from_str::<Tool>(text).map_err(|error| json_flaw("a tool of FreeCAD in JSON", &error)));
    let read = read.map_err(Flaws::from);
    let name = read.as_ref().ok().and_then(Tool::name);
    let tool = read.and_then(|tool| tool.read(number));
    let place = ToolPlace { file, position: 1, name: name.as_deref() };
    library.add(tool, &place).map_err(|flaw| flaw.in_file(file))
}

/// A tool of a `.fctl` list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ListedTool {
    pub(super) number: Option<u32>,
    /// The name of the tool's file, without folders.
    pub(super) file: String,
}

/// Reads a `.fctl` list.
pub(super) fn read_list(text: &[u8], file: &str) -> Result<Vec<ListedTool>, FileFault> {
    within(text.len(), LONGEST_LIST, "a list").map_err(|flaw| flaw.in_file(file))?;
    let list: List = serde_json::from_slice(text).map_err(|error| json_flaw("a list of tools of FreeCAD in JSON", &error).in_file(file))?;
    list.tools.0.into_iter().enumerate().map(|(index, item)| item.read(index).map_err(|flaw| flaw.in_file(file))).collect()
}

#[derive(Deserialize)]
struct List {
    tools: ListItems,
}

/// The items of a list, at most [`MOST_TOOLS`].
struct ListItems(Vec<ListItem>);

impl<'de> Deserialize<'de> for ListItems {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(ListVisitor).map(Self)
    }
}

struct ListVisitor;

impl<'de> Visitor<'de> for ListVisitor {
    type Value = Vec<ListItem>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an array of at most {MOST_TOOLS} tools")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
        let mut all = Vec::new();
        while let Some(item) = items.next_element()? {
            if all.len() >= MOST_TOOLS {
                return Err(A::Error::invalid_length(all.len() + 1, &self));
            }
            all.push(item);
        }
        Ok(all)
    }
}

#[derive(Deserialize)]
struct ListItem {
    nr: Option<Scalar>,
    path: Option<Scalar>,
}

impl ListItem {
    /// The item at this index of the list.
    fn read(self, index: usize) -> Result<ListedTool, Flaw> {
        let member = |name: &str| format!("tools[{index}].{name}");
        let path = self.path.ok_or_else(|| Flaw::missing("the tool's file")).and_then(|path| path.text());
        let path = path.map_err(|flaw| flaw.of_member(member("path")))?;
        let file = path.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
        let number = self.nr.map(|number| number.number().and_then(tool_number)).transpose();
        Ok(ListedTool { number: number.map_err(|flaw| flaw.of_member(member("nr")))?, file })
    }
}

#[derive(Deserialize)]
struct Tool {
    name: Option<Scalar>,
    shape: Option<Scalar>,
    #[serde(rename = "shape-type")]
    shape_type: Option<Scalar>,
    parameter: Option<Parameters>,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Parameters {
    diameter: Option<Scalar>,
    corner_radius: Option<Scalar>,
    torus_radius: Option<Scalar>,
    flat_radius: Option<Scalar>,
    cutting_edge_height: Option<Scalar>,
    flutes: Option<Scalar>,
    chipload: Option<Scalar>,
    taper_angle: Option<Scalar>,
    taper_diameter: Option<Scalar>,
    shank_diameter: Option<Scalar>,
}

impl Tool {
    fn name(&self) -> Option<String> {
        self.name.as_ref().and_then(|name| name.text().ok()).filter(|name| !name.trim().is_empty())
    }

    fn read(&self, number: Option<u32>) -> Result<ReadTool, Flaws> {
        let kind = self.kind()?;
        // The Better Tool Library imports tools of Fusion under names such as `_fusion_ball_end_mill`.
        let bare = kind.trim_start_matches('_').to_lowercase();
        let Some(shape) = LibraryShape::named(bare.strip_prefix("fusion_").unwrap_or(&bare)) else { return Ok(ReadTool::Other(kind)) };
        let parameters = self.parameter.as_ref().ok_or_else(|| Flaw::missing("the dimensions of the cutter").of_member("parameter"))?;
        let mut flaws = Flaws::default();
        let cutter = flaws.take(parameters.cutter(shape));
        let teeth = parameters.flutes.as_ref().map_or(Ok(None), |flutes| flutes.number().and_then(teeth));
        let parts = ToolParts {
            name: self.name(),
            number,
            teeth: flaws.take(teeth.map_err(|flaw| flaw.of_member("parameter.Flutes"))).flatten(),
            max_feed_per_tooth: flaws.take(length("parameter.Chipload", parameters.chipload.as_ref())).flatten(),
            flute_length: flaws.take(length("parameter.CuttingEdgeHeight", parameters.cutting_edge_height.as_ref())).flatten(),
            ..ToolParts::default()
        };
        ReadTool::unless_flawed(cutter, parts, 1, flaws)
    }

    /// The shape's name: `shape-type`, or the name of the shape's file without its extension.
    fn kind(&self) -> Result<String, Flaw> {
        let (member, shape) = match (&self.shape_type, &self.shape) {
            (Some(shape), _) => ("shape-type", shape),
            (None, Some(shape)) => ("shape", shape),
            (None, None) => return Err(Flaw::missing("the shape of the tool").of_member("shape")),
        };
        let text = shape.text().map_err(|flaw| flaw.of_member(member))?;
        let file = text.rsplit(['/', '\\']).next().unwrap_or_default();
        Ok(file.rsplit_once('.').map_or(file, |(stem, _)| stem).to_owned())
    }
}

impl Parameters {
    fn cutter(&self, shape: LibraryShape) -> Result<Cutter, Flaw> {
        let diameter = length("parameter.Diameter", self.diameter.as_ref())?;
        let diameter = diameter.ok_or_else(|| Flaw::missing("the diameter of the cutter").of_member("parameter.Diameter"))?;
        let (member, corner_radius, is_corner_stated) =
            if shape == LibraryShape::BullNose { self.corner(diameter)? } else { ("parameter.CornerRadius", None, false) };
        let mut stated = Dimensions { corner_radius, is_corner_stated, ..Dimensions::default() };
        if shape == LibraryShape::TaperedBall {
            // The angle is that between the flanks.
            let taper = self.taper_angle.as_ref().map(|angle| angle.text().and_then(|text| angle_deg(&text)));
            stated.taper_deg = taper.transpose().map_err(|flaw| flaw.of_member("parameter.TaperAngle"))?.map(|angle| angle / 2.0);
            stated.shank_diameter = length("parameter.TaperDiameter", self.taper_diameter.as_ref())?
                .map_or_else(|| length("parameter.ShankDiameter", self.shank_diameter.as_ref()), |diameter| Ok(Some(diameter)))?;
        }
        let member_of = |dimension| match dimension {
            Dimension::Taper => "parameter.TaperAngle",
            Dimension::ShankDiameter => "parameter.TaperDiameter",
            _ => member,
        };
        shape.cutter(diameter, &stated).map_err(|(dimension, flaw)| flaw.of_member(member_of(dimension)))
    }

    /// The corner radius of a bull-nose cutter, with the member that states it: the corner's radius itself, or the
    /// radius of the flat bottom, from which the corner radius is DC/2 - FlatRadius.
    fn corner(&self, diameter: Length) -> Result<(&'static str, Option<Length>, bool), Flaw> {
        for (member, value) in [("parameter.CornerRadius", &self.corner_radius), ("parameter.TorusRadius", &self.torus_radius)] {
            if let Some(radius) = value {
                return Ok((member, length(member, Some(radius))?, true));
            }
        }
        let member = "parameter.FlatRadius";
        let Some(flat) = &self.flat_radius else { return Ok(("parameter.CornerRadius", None, false)) };
        let flat = length(member, Some(flat))?.map_or(0.0, Length::mm);
        let corner = diameter.mm() / 2.0 - flat;
        if corner.abs() <= 1e-9 * diameter.mm() {
            return Ok((member, None, true));
        }
        let expected = format!("a flat inside the diameter, of a radius up to {}", shown(diameter.mm() / 2.0));
        let corner = Length::from_mm(corner).map_err(|_| Flaw::out_of_range(expected, shown(flat)).of_member(member))?;
        Ok((member, Some(corner), true))
    }
}

/// A length with its unit; 0 means unknown. A bare JSON number is in millimetres, FreeCAD's internal unit.
fn length(member: &'static str, value: Option<&Scalar>) -> Result<Option<Length>, Flaw> {
    let read = |value: &Scalar| match value {
        Scalar::Text(text) => number_with_unit(text).and_then(|(value, unit)| unit.length_unless_zero(value)),
        other => other.number().and_then(|value| LengthUnit::MILLIMETRE.length_unless_zero(value)),
    };
    value.map_or(Ok(None), read).map_err(|flaw| flaw.of_member(member))
}
