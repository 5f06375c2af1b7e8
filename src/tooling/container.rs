//! Detects the format of a library file by its content, and reads the files of a zip.

use super::library_fault::{LibraryFaults, json_flaw};
use super::quoted;
use super::{ToolLibrary, ToolPlace, csv, freecad, fusion};
use crate::archive::{Archive, ArchiveLimits};
use crate::cancellation::CancelFlag;
use crate::file_fault::{FileFault, FileFaultKind, Flaw};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;
use std::collections::HashMap;

/// The largest library file, and the largest decompressed size of a zip: 3 kB for each of 10,000 tools.
const LARGEST: usize = 32 << 20;

/// The limits of a zip. A FreeCAD library has a file for each tool.
const LIMITS: ArchiveLimits = ArchiveLimits { entries: 20_000, inflated_bytes: LARGEST as u64 };

const EXPECTED: &str = "a tool library: JSON of Fusion or FreeCAD, a zip of them, or CSV";

/// Reads a library of any format. Once `cancel` is set, it returns early.
pub(super) fn read(bytes: &[u8], file: &str, library: &mut ToolLibrary, cancel: &CancelFlag) -> Result<(), LibraryFaults> {
    if bytes.len() > LARGEST {
        let flaw = Flaw::too_large(format!("a file of at most {LARGEST} bytes"), format!("{} bytes", bytes.len()));
        return Err(flaw.in_file(file).into());
    }
    if Archive::is_archive(bytes) {
        read_archive(bytes, file, library, cancel)?;
    } else {
        read_plain(bytes, file, None, library, cancel)?;
    }
    if library.count() == 0 {
        return Err(Flaw::new(FileFaultKind::Empty, "a tool", "none").in_file(file).into());
    }
    Ok(())
}

/// The members of a JSON file that identify its format. null counts as absent.
#[derive(Deserialize)]
struct Members<'a> {
    #[serde(borrow)]
    data: Option<&'a RawValue>,
    parameter: Option<IgnoredAny>,
    shape: Option<IgnoredAny>,
    tools: Option<IgnoredAny>,
}

impl<'a> Members<'a> {
    fn of(text: &'a str) -> Result<Self, Flaw> {
        let flaw = |error| json_flaw(EXPECTED, &error);
        if text.trim_start().starts_with('[') {
            let _syntax: IgnoredAny = serde_json::from_str(text).map_err(flaw)?;
            return Err(Flaw::malformed(EXPECTED, "an array"));
        }
        serde_json::from_str(text).map_err(flaw)
    }
}

/// Reads a file that is not an archive. `number` is the tool's number in a list of FreeCAD.
fn read_plain(bytes: &[u8], file: &str, number: Option<u32>, library: &mut ToolLibrary, cancel: &CancelFlag) -> Result<(), LibraryFaults> {
    let unknown = |found: &'static str| LibraryFaults::from(Flaw::new(FileFaultKind::UnknownFormat, EXPECTED, found).in_file(file));
    let text = decoded(bytes, cancel).map_err(unknown)?;
    if !text.trim_start().starts_with(['{', '[']) {
        return csv::read(&text, file, library, cancel);
    }
    match Members::of(&text).map_err(|flaw| flaw.in_file(file))? {
        Members { data: Some(data), .. } => Ok(fusion::read(data, file, library)?),
        Members { parameter: Some(_), .. } | Members { shape: Some(_), .. } => Ok(freecad::read_tool(&text, file, number, library)?),
        Members { tools: Some(_), .. } => Err(unknown("a list of FreeCAD, which names the files of its tools; send a zip of them all")),
        _ => Err(unknown("JSON without the members data (Fusion) or parameter (FreeCAD)")),
    }
}

/// The tools that the lists of a zip name, by the names of their files in lower case.
#[derive(Default)]
struct Listed(HashMap<String, ListedFile>);

/// The first entry of a list that names a file.
struct ListedFile {
    number: Option<u32>,
    list: String,
    position: usize,
    is_found: bool,
}

impl Listed {
    /// Reads all lists of an archive. The inner `None` means that the archive has no lists, so that all its tools are
    /// read.
    fn read(archive: &mut Archive, path: impl Fn(&str) -> String) -> Result<Option<Self>, LibraryFaults> {
        let (mut listed, mut faults, mut has_lists) = (Self::default(), Vec::new(), false);
        let lists: Vec<String> =
            archive.files().filter(|name| extension(name) == "fctl" && !is_companion(name)).map(str::to_owned).collect();
        for name in lists {
            has_lists = true;
            let list = path(&name);
            let content = archive.content(&name).map_err(|fault| Flaw::from(&fault).in_file(&list));
            match content.and_then(|content| freecad::read_list(&content, &list)) {
                Ok(tools) => listed.add(tools, &list)?,
                Err(fault) => faults.push(fault),
            }
        }
        LibraryFaults::of_files(faults).map_or(Ok(has_lists.then_some(listed)), Err)
    }

    fn add(&mut self, tools: Vec<freecad::ListedTool>, list: &str) -> Result<(), FileFault> {
        for (index, tool) in tools.into_iter().enumerate() {
            if self.0.len() >= LIMITS.entries {
                return Err(Flaw::too_large(format!("at most {} listed tools", LIMITS.entries), "more").in_file(list));
            }
            let file = ListedFile { number: tool.number, list: list.to_owned(), position: index + 1, is_found: false };
            self.0.entry(tool.file.to_lowercase()).or_insert(file);
        }
        Ok(())
    }

    /// Adds the listed tools without a file to the faulty ones, in the order of the lists.
    fn add_missing(self, library: &mut ToolLibrary) -> Result<(), FileFault> {
        let mut missing: Vec<_> = self.0.into_iter().filter(|(_, file)| !file.is_found).collect();
        missing.sort_by(|(_, one), (_, other)| (&one.list, one.position).cmp(&(&other.list, other.position)));
        for (name, file) in missing {
            let flaw = Flaw::malformed("every listed tool in the zip", format!("no file {} in the zip", quoted(&name)));
            let place = ToolPlace { file: &file.list, position: file.position, name: Some(&name) };
            library.add(Err(flaw.of_member("path").into()), &place).map_err(|flaw| flaw.in_file(&file.list))?;
        }
        Ok(())
    }
}

/// Reads all libraries and tools of a zip, in the order of its directory. If it has lists of FreeCAD, tool files that
/// none of them names are counted, not read.
fn read_archive(bytes: &[u8], file: &str, library: &mut ToolLibrary, cancel: &CancelFlag) -> Result<(), LibraryFaults> {
    let mut archive = Archive::open(bytes, LIMITS).map_err(|fault| Flaw::from(&fault).in_file(file))?;
    let path = |name: &str| format!("{file}/{name}");
    let mut listed = Listed::read(&mut archive, path)?;
    let mut faults = Vec::new();
    let names: Vec<String> = archive.files().map(str::to_owned).collect();
    for name in names.iter().take_while(|_| !cancel.is_cancelled()) {
        let path = path(name);
        let extension = extension(name);
        match extension.as_str() {
            _ if is_companion(name) => library.skipped_files += 1,
            "fctl" => {}
            "json" | "fctb" | "csv" | "txt" | "tsv" => {
                let own_name = name.rsplit('/').next().unwrap_or_default().to_lowercase();
                let listed = listed.as_mut().map(|listed| listed.0.get_mut(&own_name));
                if matches!(listed, Some(None)) && extension == "fctb" {
                    library.unlisted_files += 1;
                    continue;
                }
                let listed = listed.flatten();
                let number = listed.as_ref().and_then(|file| file.number);
                if let Some(file) = listed {
                    file.is_found = true;
                }
                let read = match archive.content(name).map_err(|fault| Flaw::from(&fault).in_file(&path)) {
                    Ok(bytes) if Archive::is_archive(&bytes) => Err(nested(&path).into()),
                    Ok(bytes) if extension == "fctb" => read_tool_file(&bytes, &path, number, library, cancel),
                    Ok(bytes) => read_plain(&bytes, &path, number, library, cancel),
                    Err(fault) => Err(fault.into()),
                };
                let Err(found) = read else { continue };
                let is_limit = found.all().iter().any(|fault| fault.kind() == FileFaultKind::TooLarge);
                faults.extend(found.into_all());
                if is_limit || faults.len() >= super::MOST_FAULTY {
                    break;
                }
            }
            "zip" | "tools" => faults.push(nested(&path)),
            _ => library.skipped_files += 1,
        }
    }
    if let Some(faults) = LibraryFaults::of_files(faults) {
        return Err(faults);
    }
    Ok(listed.map_or(Ok(()), |listed| listed.add_missing(library))?)
}

/// Reads a tool file of FreeCAD in a zip. A file that is not a tool is recorded as a faulty tool, and the other files
/// are still read.
fn read_tool_file(
    bytes: &[u8],
    path: &str,
    number: Option<u32>,
    library: &mut ToolLibrary,
    cancel: &CancelFlag,
) -> Result<(), LibraryFaults> {
    let text = match decoded(bytes, cancel) {
        Ok(text) => text,
        Err(found) => {
            let flaw = Flaw::malformed("a tool of FreeCAD in JSON", found);
            let name = path.rsplit('/').next();
            library.add(Err(flaw.into()), &ToolPlace { file: path, position: 1, name }).map_err(|flaw| flaw.in_file(path))?;
            return Ok(());
        }
    };
    Ok(freecad::read_tool(&text, path, number, library)?)
}

/// Whether a file is the companion `._name` that macOS writes beside each file.
fn is_companion(name: &str) -> bool {
    name.rsplit('/').next().is_some_and(|own_name| own_name.starts_with("._"))
}

fn nested(path: &str) -> FileFault {
    Flaw::too_large("no zip inside a zip", "one").in_file(path)
}

/// The extension of a file's name, in lower case.
fn extension(name: &str) -> String {
    name.rsplit_once('.').map_or("", |(_, extension)| extension).to_lowercase()
}

/// A file as text: UTF-8, UTF-16 with a byte-order mark, or otherwise Latin-1. The error describes a binary file. Once
/// `cancel` is set, the rest of a file that is not UTF-8 is left out.
fn decoded(bytes: &[u8], cancel: &CancelFlag) -> Result<String, &'static str> {
    let mut text = match bytes {
        [0xff, 0xfe, rest @ ..] => from_utf_16(rest, u16::from_le_bytes, cancel),
        [0xfe, 0xff, rest @ ..] => from_utf_16(rest, u16::from_be_bytes, cancel),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => std::str::from_utf8(bytes).map_or_else(|_| collected(bytes.iter().map(|byte| char::from(*byte)), cancel), str::to_owned),
    };
    text.truncate(text.trim_end_matches(['\0', '\u{1a}']).len());
    let is_binary = text.chars().take(4096).any(|c| c.is_control() && !c.is_whitespace());
    if is_binary { Err("a binary file") } else { Ok(text) }
}

fn from_utf_16(bytes: &[u8], unit: fn([u8; 2]) -> u16, cancel: &CancelFlag) -> String {
    let units = bytes.as_chunks::<2>().0.iter().map(|pair| unit(*pair));
    collected(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)), cancel)
}

/// The text of these characters, up to the character at which `cancel` is set.
fn collected(characters: impl Iterator<Item = char>, cancel: &CancelFlag) -> String {
    /// The number of characters between two checks, which take less than a millisecond.
    const STEP: usize = 1 << 16;
    let mut text = String::new();
    let mut characters = characters.peekable();
    while characters.peek().is_some() && !cancel.is_cancelled() {
        text.extend(characters.by_ref().take(STEP));
    }
    text
}
