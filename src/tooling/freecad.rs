//! FreeCAD's tools: one tool in each `.fctb` file, JSON with a shape and dimensions as text with a unit; and the
//! `.fctl` list of a library, which gives them numbers.

use super::dimension::{LengthUnit, number_with_unit, shown, teeth, tool_number};
use super::fault::{Flaw, LibraryFault};
use super::scalar::Scalar;
use super::shape::Shape;
use super::{MOST_TOOLS, ReadTool, ToolParts};
use crate::quantity::Length;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use std::fmt;

/// Reads the tool of a `.fctb` file, whose number in the library is `number`.
pub(super) fn read_tool(text: &[u8], file: &str, number: Option<u32>) -> Result<ReadTool, LibraryFault> {
    let tool: Tool = serde_json::from_slice(text).map_err(|error| Flaw::json("a tool of FreeCAD in JSON", &error).in_file(file))?;
    let name = tool.name.as_ref().and_then(|name| name.text().ok());
    tool.read(number).map_err(|flaw| flaw.of_tool(file, 1, name.as_deref()))
}

/// A tool of a `.fctl` list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ListedTool {
    pub(super) number: Option<u32>,
    /// The name of the tool's file, without folders.
    pub(super) file: String,
}

/// Reads a `.fctl` list.
pub(super) fn read_list(text: &[u8], file: &str) -> Result<Vec<ListedTool>, LibraryFault> {
    let list: List =
        serde_json::from_slice(text).map_err(|error| Flaw::json("a list of tools of FreeCAD in JSON", &error).in_file(file))?;
    let listed = list.tools.0.into_iter().enumerate().map(|(index, item)| item.read().map_err(|flaw| flaw.of_tool(file, index + 1, None)));
    listed.collect()
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
    fn read(self) -> Result<ListedTool, Flaw> {
        let path =
            self.path.ok_or_else(|| Flaw::missing("the tool's file").of_member("path"))?.text().map_err(|flaw| flaw.of_member("path"))?;
        let file = path.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
        let number = self.nr.map(|number| number.number().and_then(tool_number).map_err(|flaw| flaw.of_member("nr"))).transpose()?;
        Ok(ListedTool { number, file })
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
}

impl Tool {
    fn read(&self, number: Option<u32>) -> Result<ReadTool, Flaw> {
        let kind = self.kind()?;
        let shape = match kind.to_lowercase().as_str() {
            "ballend" => Shape::Ball,
            "bullnose" | "torus" => Shape::BullNose,
            "endmill" => Shape::Flat,
            _ => return Ok(ReadTool::Other(kind)),
        };
        let parameters = self.parameter.as_ref().ok_or_else(|| Flaw::missing("the dimensions of the cutter").of_member("parameter"))?;
        let diameter = length("parameter.Diameter", parameters.diameter.as_ref())?;
        let diameter = diameter.ok_or_else(|| Flaw::missing("the diameter of the cutter").of_member("parameter.Diameter"))?;
        let (member, corner_radius, is_stated) =
            if shape == Shape::BullNose { parameters.corner(diameter)? } else { ("parameter.CornerRadius", None, false) };
        let cutter = shape.cutter(diameter, corner_radius, is_stated).map_err(|flaw| flaw.of_member(member))?;
        let flutes = parameters.flutes.as_ref().map_or(Ok(None), |flutes| flutes.number().and_then(teeth));
        let parts = ToolParts {
            name: self.name.as_ref().and_then(|name| name.text().ok()).filter(|name| !name.trim().is_empty()),
            number,
            teeth: flutes.map_err(|flaw| flaw.of_member("parameter.Flutes"))?,
            max_feed_per_tooth: length("parameter.Chipload", parameters.chipload.as_ref())?,
            flute_length: length("parameter.CuttingEdgeHeight", parameters.cutting_edge_height.as_ref())?,
            ..ToolParts::default()
        };
        Ok(ReadTool::Finishing(Box::new(parts.with(cutter, 1))))
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
    /// The corner radius of a bull-nose cutter, with the member that states it: either the corner radius, or the radius
    /// of the flat bottom, for which the corner radius is DC/2 - FlatRadius.
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
