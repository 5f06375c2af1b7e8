//! Detects the format of a library file by its content, and reads the files of a zip.

use super::fault::{Flaw, LibraryFault, LibraryFaultKind, quoted};
use super::{ToolLibrary, csv, freecad, fusion};
use crate::archive::{Archive, ArchiveFault, ArchiveLimits};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::HashMap;

/// The largest library file, and the largest sum of the files of a zip after inflation: 3 kB for each of 10,000 tools.
const LARGEST: usize = 32 << 20;

/// The limits of a zip. A FreeCAD library has a file for each tool.
const LIMITS: ArchiveLimits = ArchiveLimits { entries: 20_000, inflated_bytes: LARGEST as u64 };

const EXPECTED: &str = "a tool library: JSON of Fusion or FreeCAD, a zip of them, or CSV";

/// Reads a library of any format.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<ToolLibrary, LibraryFault> {
    if bytes.len() > LARGEST {
        return Err(Flaw::too_large(format!("a file of at most {LARGEST} bytes"), format!("{} bytes", bytes.len())).in_file(file));
    }
    let library = if Archive::is_archive(bytes) { read_archive(bytes, file)? } else { read_plain(bytes, file, None)? };
    if library.count() == 0 {
        return Err(Flaw::new(LibraryFaultKind::Empty, "a tool", "none").in_file(file));
    }
    Ok(library)
}

/// The members of a JSON file that identify its format.
#[derive(Deserialize)]
struct Members {
    data: Option<IgnoredAny>,
    parameter: Option<IgnoredAny>,
    shape: Option<IgnoredAny>,
    tools: Option<IgnoredAny>,
}

/// Reads a file that is not an archive. `number` is the tool's number in a list of FreeCAD.
fn read_plain(bytes: &[u8], file: &str, number: Option<u32>) -> Result<ToolLibrary, LibraryFault> {
    let text = decoded(bytes).map_err(|found| Flaw::new(LibraryFaultKind::UnknownFormat, EXPECTED, found).in_file(file))?;
    if !text.trim_start().starts_with(['{', '[']) {
        return csv::read(&text, file);
    }
    let members: Members = serde_json::from_str(&text).map_err(|error| Flaw::json(EXPECTED, &error).in_file(file))?;
    match members {
        Members { data: Some(_), .. } => fusion::read(text.as_bytes(), file),
        Members { parameter: Some(_), .. } | Members { shape: Some(_), .. } => {
            let tool = freecad::read_tool(text.as_bytes(), file, number)?;
            let mut library = ToolLibrary::default();
            library.add(tool).map_err(|flaw| flaw.in_file(file))?;
            Ok(library)
        }
        Members { tools: Some(_), .. } => {
            let found = "a list of FreeCAD, which names the files of its tools; send a zip of them all";
            Err(Flaw::new(LibraryFaultKind::UnknownFormat, EXPECTED, found).in_file(file))
        }
        _ => {
            let found = "JSON without the members data (Fusion) or parameter (FreeCAD)";
            Err(Flaw::new(LibraryFaultKind::UnknownFormat, EXPECTED, found).in_file(file))
        }
    }
}

/// Reads all libraries and tools of a zip, in the order of its directory.
fn read_archive(bytes: &[u8], file: &str) -> Result<ToolLibrary, LibraryFault> {
    let archive = Archive::open(bytes, LIMITS).map_err(|fault| flaw(&fault).in_file(file))?;
    let path = |name: &str| format!("{file}/{name}");
    let content = |entry| archive.content(entry).map_err(|fault| flaw(&fault));
    let mut numbers = HashMap::new();
    let mut lists = Vec::new();
    for entry in archive.files().filter(|entry| extension(entry.name()) == "fctl") {
        let listed = content(entry).map_err(|flaw| flaw.in_file(&path(entry.name())))?;
        for (index, tool) in freecad::read_list(&listed, &path(entry.name()))?.into_iter().enumerate() {
            if numbers.len() >= LIMITS.entries {
                return Err(Flaw::too_large(format!("at most {} listed tools", LIMITS.entries), "more").in_file(&path(entry.name())));
            }
            lists.push((tool.file.to_lowercase(), path(entry.name()), index + 1));
            numbers.insert(tool.file.to_lowercase(), tool.number);
        }
    }
    let mut library = ToolLibrary::default();
    for entry in archive.files() {
        let (name, path) = (entry.name(), path(entry.name()));
        let own_name = name.rsplit('/').next().unwrap_or_default().to_lowercase();
        match extension(name).as_str() {
            "fctl" => {}
            // macOS adds a companion `._name` to each file.
            _ if own_name.starts_with("._") => library.skipped_files += 1,
            "json" | "fctb" | "csv" | "txt" | "tsv" => {
                let bytes = content(entry).map_err(|flaw| flaw.in_file(&path))?;
                if Archive::is_archive(&bytes) {
                    return Err(nested(&path));
                }
                let number = numbers.remove(&own_name).flatten();
                library.append(read_plain(&bytes, &path, number)?).map_err(|flaw| flaw.in_file(file))?;
            }
            "zip" | "tools" => return Err(nested(&path)),
            _ => library.skipped_files += 1,
        }
    }
    for (name, list, position) in lists {
        if numbers.contains_key(&name) {
            let found = format!("no file {} in the zip", quoted(&name));
            return Err(Flaw::malformed("every listed tool in the zip", found).of_member("path").of_tool(&list, position, None));
        }
    }
    Ok(library)
}

fn nested(path: &str) -> LibraryFault {
    Flaw::too_large("no zip inside a zip", "one").in_file(path)
}

/// The extension of a file's name, in lower case.
fn extension(name: &str) -> String {
    name.rsplit_once('.').map_or("", |(_, extension)| extension).to_lowercase()
}

fn flaw(fault: &ArchiveFault) -> Flaw {
    let kind = if fault.is_limit() { LibraryFaultKind::TooLarge } else { LibraryFaultKind::Malformed };
    Flaw::new(kind, "a ZIP archive within its limits", fault.to_string())
}

/// A file as text: UTF-8, UTF-16 with a byte-order mark, or else Latin-1. The inner error describes a binary file.
fn decoded(bytes: &[u8]) -> Result<String, &'static str> {
    let utf_16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.as_chunks::<2>().0.iter().map(|pair| unit(*pair)).collect();
        String::from_utf16_lossy(&units)
    };
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => utf_16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf_16(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => std::str::from_utf8(bytes).map_or_else(|_| bytes.iter().map(|byte| char::from(*byte)).collect(), str::to_owned),
    };
    let text = text.trim_end_matches(['\0', '\u{1a}']);
    let is_binary = text.chars().take(4096).any(|c| c.is_control() && !c.is_whitespace());
    if is_binary { Err("a binary file") } else { Ok(text.to_owned()) }
}
