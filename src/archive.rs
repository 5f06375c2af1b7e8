//! ZIP archives in memory, read within limits on the number of entries, the length of their names and the decompressed
//! size.
//!
//! An entry is decompressed while it is read. Every decompressed byte counts towards one limit of the whole archive, so
//! that overlapping or repeated entries cannot exceed it.

use crate::file_fault::{FileFaultKind, Flaw};
use std::fmt;
use std::io::{self, Cursor, Read};
use zip::ZipArchive;
use zip::read::ZipFile;

/// The longest name of an entry, in bytes.
const LONGEST_NAME: usize = 1024;

/// The limits of an archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ArchiveLimits {
    /// The largest number of entries.
    pub(crate) entries: usize,
    /// The largest number of bytes that may be inflated, over all entries.
    pub(crate) inflated_bytes: u64,
}

/// The reason why an archive cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ArchiveFault {
    /// The directory or an entry is missing or damaged.
    Damaged(String),
    /// An entry is encrypted, or compressed by a method other than deflate.
    Unsupported(String),
    /// More entries than the limit.
    TooManyEntries(usize),
    /// The name of an entry is longer than [`LONGEST_NAME`].
    LongName,
    /// More bytes after inflation than the limit.
    TooLarge(u64),
}

impl fmt::Display for ArchiveFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damaged(reason) => write!(f, "a damaged ZIP archive: {reason}"),
            Self::Unsupported(reason) => write!(f, "an entry that is encrypted, or neither stored nor deflated: {reason}"),
            Self::TooManyEntries(limit) => write!(f, "a ZIP archive of more than {limit} entries"),
            Self::LongName => write!(f, "a ZIP archive with an entry whose name is longer than {LONGEST_NAME} bytes"),
            Self::TooLarge(limit) => write!(f, "a ZIP archive of more than {limit} bytes after inflation"),
        }
    }
}

impl std::error::Error for ArchiveFault {}

impl From<&ArchiveFault> for Flaw {
    fn from(fault: &ArchiveFault) -> Self {
        let kind = match fault {
            ArchiveFault::TooManyEntries(_) | ArchiveFault::LongName | ArchiveFault::TooLarge(_) => FileFaultKind::TooLarge,
            ArchiveFault::Damaged(_) => FileFaultKind::Malformed,
            ArchiveFault::Unsupported(_) => FileFaultKind::UnknownFormat,
        };
        Self::new(kind, "a ZIP archive within its limits", fault.to_string())
    }
}

/// An archive whose directory has been read.
#[derive(Debug)]
pub(crate) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    names: Vec<String>,
    limits: ArchiveLimits,
    /// The bytes that may still be inflated.
    left: u64,
}

impl<'a> Archive<'a> {
    /// Whether `bytes` start like a ZIP archive, with or without entries.
    pub(crate) fn is_archive(bytes: &[u8]) -> bool {
        bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06")
    }

    /// Reads the directory of an archive.
    ///
    /// # Errors
    /// [`ArchiveFault`] if the directory is damaged or exceeds a limit.
    pub(crate) fn open(bytes: &'a [u8], limits: ArchiveLimits) -> Result<Self, ArchiveFault> {
        // The directory is read into memory as a whole, and each of its entries begins with this mark. Compressed data
        // contain it by chance once in 4 GiB.
        let marks = memchr::memmem::find_iter(bytes, b"PK\x01\x02").take(limits.entries + 1).count();
        if marks > limits.entries {
            return Err(ArchiveFault::TooManyEntries(limits.entries));
        }
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|error| ArchiveFault::Damaged(error.to_string()))?;
        if zip.file_names_raw().any(|name| name.len() > LONGEST_NAME) {
            return Err(ArchiveFault::LongName);
        }
        let name = |raw: &[u8]| String::from_utf8_lossy(raw).replace('\\', "/").trim_start_matches('/').to_owned();
        let names = zip.file_names_raw().map(name).collect();
        Ok(Self { zip, names, limits, left: limits.inflated_bytes })
    }

    /// The paths of the files in the archive, in the order of its directory, with `/` between folders and none at the
    /// start; folders are left out.
    pub(crate) fn files(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str).filter(|name| !name.ends_with('/'))
    }

    /// The path of the file with this name. Case is ignored, as 3MF compares the names of parts.
    pub(crate) fn file(&self, name: &str) -> Option<&str> {
        let name = name.trim_start_matches('/');
        self.files().find(|file| file.eq_ignore_ascii_case(name))
    }

    /// Starts to inflate the file with this path.
    ///
    /// # Errors
    /// [`ArchiveFault`] if there is no such file, or its data are damaged, encrypted, or compressed by another method
    /// than deflate.
    pub(crate) fn read(&mut self, path: &str) -> Result<Inflating<'_, 'a>, ArchiveFault> {
        let missing = || ArchiveFault::Damaged(format!("no file {path}"));
        let index = self.names.iter().position(|name| name == path).ok_or_else(missing)?;
        let content = self.zip.by_index(index).map_err(|error| match error {
            zip::result::ZipError::UnsupportedArchive(reason) => ArchiveFault::Unsupported(reason.to_string()),
            error => ArchiveFault::Damaged(error.to_string()),
        })?;
        Ok(Inflating { content, left: &mut self.left })
    }

    /// The whole content of a file.
    ///
    /// # Errors
    /// As [`Archive::read`]; also if the file exceeds the limit or its checksum differs.
    pub(crate) fn content(&mut self, path: &str) -> Result<Vec<u8>, ArchiveFault> {
        let mut content = Vec::new();
        let read = self.read(path)?.read_to_end(&mut content);
        read.map_err(|error| self.limits.fault(&error))?;
        Ok(content)
    }

    /// The limits of the archive.
    pub(crate) fn limits(&self) -> ArchiveLimits {
        self.limits
    }
}

impl ArchiveLimits {
    /// The fault that caused an error of [`Inflating`].
    pub(crate) fn fault(self, error: &io::Error) -> ArchiveFault {
        match error.kind() {
            io::ErrorKind::FileTooLarge => ArchiveFault::TooLarge(self.inflated_bytes),
            _ => ArchiveFault::Damaged(error.to_string()),
        }
    }
}

/// A file of an archive that is being inflated. Reading fails with [`io::ErrorKind::FileTooLarge`] beyond the archive's
/// limit, and at the end if the checksum differs from the directory's.
pub(crate) struct Inflating<'r, 'a> {
    content: ZipFile<'r, Cursor<&'a [u8]>>,
    left: &'r mut u64,
}

impl Read for Inflating<'_, '_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.content.read(buffer)?;
        *self.left = self.left.checked_sub(read as u64).ok_or(io::ErrorKind::FileTooLarge)?;
        Ok(read)
    }
}
