//! Tool libraries read into finishing cutters: Autodesk Fusion (`.json`, `.tools`), FreeCAD (`.fctb`, and zips of them with their
//! `.fctl`), and CSV.
//!
//! A library is any mix of tools. Ball-end, bull-nose and flat cutters are read; the others are counted by their type. A cutter that is
//! described in a way that cannot be read refuses the library, with file, tool and member, because a candidate that is missing in
//! silence would change which cutter is recommended. Lengths are in the unit that each tool states.
//!
//! The format comes from the content. Nothing grows without bound: see [`MOST_TOOLS`] and the limits in `container`.

mod container;
mod csv;
mod dimension;
mod fault;
mod freecad;
mod fusion;
mod scalar;
mod shape;

pub use fault::{LibraryFault, LibraryFaultKind};

use crate::milling::Cutter;
use crate::quantity::Length;
use fault::Flaw;
use std::collections::BTreeMap;

/// The most tools of a library, of all types together.
pub const MOST_TOOLS: usize = 10_000;

/// The most teeth of a cutter that a library may state.
pub const MOST_TEETH: u32 = 100;

/// The highest spindle speed that a library may state, in rpm.
pub const HIGHEST_SPINDLE_SPEED: f64 = 1e6;

/// The longest name of a tool, a type or a preset that is kept, in characters.
const LONGEST_NAME: usize = 100;

/// The finishing cutters of a library.
///
/// ```
/// use scallopd::tooling::ToolLibrary;
///
/// let csv = "name,type,diameter_mm,corner_radius_mm,teeth\nB6,ball_end,6,,2\nT10,toroidal,10,2,4\nD8,drill,8,,2\n";
/// let library = ToolLibrary::read(csv.as_bytes(), Some("mills.csv")).unwrap();
/// assert_eq!(library.tools().len(), 2);
/// assert_eq!(library.tools()[0].cutter.corner_radius().mm(), 3.0);
/// assert_eq!(library.others().collect::<Vec<_>>(), [("drill", 1)]);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ToolLibrary {
    tools: Vec<LibraryTool>,
    others: BTreeMap<String, u64>,
    skipped_files: u64,
}

/// A finishing cutter of a library.
#[derive(Debug, Clone, PartialEq)]
pub struct LibraryTool {
    /// The tool's description; where it has none, its product number or its number in the library. At most 100 characters.
    pub name: String,
    /// The number by which the machine's program calls the tool.
    pub number: Option<u32>,
    /// The cutter.
    pub cutter: Cutter,
    /// z, the number of teeth, at least 1.
    pub teeth: Option<u32>,
    /// n, the spindle speed, positive, in rpm.
    pub spindle_speed_rpm: Option<f64>,
    /// f_z, the feed per tooth that the library states, as the largest that the cutter should run with.
    pub max_feed_per_tooth: Option<Length>,
    /// The length of the cutting edges along the axis.
    pub flute_length: Option<Length>,
    /// The name of the preset from which speed and feed are taken, where the library has presets: the one whose name says finish, else the
    /// first. At most 100 characters.
    pub preset: Option<String>,
}

impl ToolLibrary {
    /// Reads a library. `file_name` names it in faults.
    ///
    /// # Errors
    /// The first [`LibraryFault`] of the library: what is wrong with which member of which tool in which file.
    pub fn read(bytes: &[u8], file_name: Option<&str>) -> Result<Self, LibraryFault> {
        container::read(bytes, file_name.unwrap_or("the library"))
    }

    /// The finishing cutters, in the order of the library.
    #[must_use]
    pub fn tools(&self) -> &[LibraryTool] {
        &self.tools
    }

    /// The finishing cutters, by value.
    #[must_use]
    pub fn into_tools(self) -> Vec<LibraryTool> {
        self.tools
    }

    /// The types of the tools that are no finishing cutters, in alphabetical order, each with the number of its tools.
    pub fn others(&self) -> impl Iterator<Item = (&str, u64)> {
        self.others.iter().map(|(kind, count)| (kind.as_str(), *count))
    }

    /// Files of a zip that hold no tools: pictures, shapes, texts.
    #[must_use]
    pub fn skipped_files(&self) -> u64 {
        self.skipped_files
    }

    fn count(&self) -> u64 {
        self.tools.len() as u64 + self.others.values().sum::<u64>()
    }

    /// Adds a tool, unless the library is full.
    fn add(&mut self, tool: ReadTool) -> Result<(), Flaw> {
        if self.count() >= MOST_TOOLS as u64 {
            return Err(Flaw::too_large(format!("at most {MOST_TOOLS} tools"), "more"));
        }
        match tool {
            ReadTool::Finishing(tool) => self.tools.push(*tool),
            ReadTool::Other(kind) => *self.others.entry(shortened(&kind)).or_default() += 1,
        }
        Ok(())
    }

    /// Adds the tools of another file.
    fn append(&mut self, other: Self) -> Result<(), Flaw> {
        if self.count() + other.count() > MOST_TOOLS as u64 {
            return Err(Flaw::too_large(format!("at most {MOST_TOOLS} tools"), "more"));
        }
        self.tools.extend(other.tools);
        for (kind, count) in other.others {
            *self.others.entry(kind).or_default() += count;
        }
        Ok(())
    }
}

/// A tool of a library, as a reader of one format understands it.
#[derive(Debug)]
enum ReadTool {
    Finishing(Box<LibraryTool>),
    /// A tool of this type, which is no finishing cutter.
    Other(String),
}

/// What a reader of one format found out about a finishing cutter.
#[derive(Debug, Default)]
struct ToolParts {
    name: Option<String>,
    number: Option<u32>,
    teeth: Option<u32>,
    spindle_speed_rpm: Option<f64>,
    max_feed_per_tooth: Option<Length>,
    flute_length: Option<Length>,
    preset: Option<String>,
}

impl ToolParts {
    /// The tool, where `position` counts the tools of the file from 1.
    fn with(self, cutter: Cutter, position: usize) -> LibraryTool {
        LibraryTool {
            name: self.name.map_or_else(|| format!("tool {}", self.number.map_or(position as u64, u64::from)), |name| shortened(&name)),
            number: self.number,
            cutter,
            teeth: self.teeth,
            spindle_speed_rpm: self.spindle_speed_rpm,
            max_feed_per_tooth: self.max_feed_per_tooth,
            flute_length: self.flute_length,
            preset: self.preset.map(|preset| shortened(&preset)),
        }
    }
}

/// `text` without blanks around it, with its control characters escaped, cut to [`LONGEST_NAME`] characters.
fn shortened(text: &str) -> String {
    let text = text.trim();
    let mut escaped = text.chars().flat_map(|c| {
        let (plain, escaped) = if c.is_control() { (None, Some(c.escape_default())) } else { (Some(c), None) };
        plain.into_iter().chain(escaped.into_iter().flatten())
    });
    let mut short: String = escaped.by_ref().take(LONGEST_NAME).collect();
    if escaped.next().is_some() {
        short.push_str("...");
    }
    short
}
