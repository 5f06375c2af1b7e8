//! A surface file that is the only file of a ZIP archive.

use super::super::format::EXPECTED;
use super::super::input::ReadError;
use super::super::{FormatHint, ReadSummary, Reader, Sink};
use super::Package;
use crate::archive::{Archive, ArchiveFault, ArchiveLimits, Inflating};
use crate::file_fault::{FileFaultKind, Flaw};
use crate::surface::read::input::Input;
use std::io::{self, BufRead, BufReader, Read};

/// Reads the only file of an archive, whatever its format.
///
/// # Errors
/// The archive has several files, or the file another archive or a fault.
pub(super) fn read(package: &mut Package, reader: Reader, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
    let refused = |found: String| ReadError::from(Flaw::new(FileFaultKind::UnknownFormat, EXPECTED, found).at_byte(0));
    let Package { archive, input } = package;
    let named = [
        ("xl/workbook.xml", "an Excel workbook; save the points as CSV"),
        ("word/document.xml", "a Word document"),
        ("Document.xml", "a FreeCAD document; export the surface as STL or 3MF"),
    ];
    if let Some((_, found)) = named.into_iter().find(|(path, _)| archive.file(path).is_some()) {
        return Err(refused(found.to_owned()));
    }
    let files: Vec<String> = archive.files().filter(|path| !is_companion(path)).map(str::to_owned).collect();
    let [path] = &files[..] else {
        return Err(refused(format!("a ZIP archive of {} files that is not a 3MF package; send the file itself", files.len())));
    };
    let limits = archive.limits();
    let content = archive.read(path).map_err(|fault| Flaw::from(&fault).in_entry(path, 0))?;
    let mut content = BufReader::new(Unzipped { content, input, limits });
    if Archive::is_archive(content.fill_buf().map_err(|error| unzipped(error, path))?) {
        return Err(refused("a ZIP archive in a ZIP archive; send the file itself".to_owned()));
    }
    let result = Reader { hint: FormatHint::new(None, Some(path)), ..reader }.read(content, sink);
    result.map_err(|error| match error {
        ReadError::Source(error) => unzipped(error, path),
        fault @ ReadError::Fault(_) => fault,
    })
}

/// The fault of a file that cannot be inflated, or the error of the archive's own source.
fn unzipped(error: io::Error, path: &str) -> ReadError {
    match error.get_ref().and_then(|inner| inner.downcast_ref::<ArchiveFault>()) {
        Some(fault) => Flaw::from(fault).in_entry(path, 0).into(),
        None => error.into(),
    }
}

/// Whether an operating system has added the file: the companions `._name` and folder settings.
fn is_companion(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or_default();
    path.starts_with("__MACOSX/") || name.starts_with("._") || matches!(name, ".DS_Store" | "Thumbs.db" | "desktop.ini")
}

/// A file that is being inflated, until nobody waits for the result.
struct Unzipped<'a, 'b, 'c> {
    content: Inflating<'a, 'b>,
    input: &'a mut Input<'c>,
    limits: ArchiveLimits,
}

impl Read for Unzipped<'_, '_, '_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.input.check()?;
        self.content.read(buffer).map_err(|error| io::Error::other(self.limits.fault(&error)))
    }
}
