//! ZIP archives in memory, read within limits on the number of entries, the length of their names and the decompressed
//! size.
//!
//! The directory is read entry by entry; its counts are not trusted. An entry is decompressed while it is read. Every
//! decompressed byte counts towards one limit of the whole archive, so that overlapping or repeated entries cannot
//! exceed it.

use crate::cancellation::CancelFlag;
use rawzip::{CompressionMethod, ZipArchive, ZipArchiveEntryWayfinder, ZipSliceArchive};
use std::cell::Cell;
use std::fmt;
use std::io::{self, Read};

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
    /// The directory is missing or damaged.
    Damaged(String),
    /// More entries than the limit.
    TooManyEntries(usize),
    /// The name of an entry is longer than [`LONGEST_NAME`].
    LongName,
    /// More bytes after inflation than the limit.
    TooLarge(u64),
    /// An encrypted entry.
    Encrypted,
    /// An entry that is neither stored nor deflated.
    Compression(u16),
}

impl fmt::Display for ArchiveFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damaged(reason) => write!(f, "a damaged ZIP archive: {reason}"),
            Self::TooManyEntries(limit) => write!(f, "a ZIP archive of more than {limit} entries"),
            Self::LongName => write!(f, "a ZIP archive with an entry whose name is longer than {LONGEST_NAME} bytes"),
            Self::TooLarge(limit) => write!(f, "a ZIP archive of more than {limit} bytes after inflation"),
            Self::Encrypted => f.write_str("an encrypted entry"),
            Self::Compression(method) => write!(f, "an entry compressed by method {method}, which is neither stored (0) nor deflated (8)"),
        }
    }
}

impl ArchiveFault {
    /// Whether a limit was exceeded; otherwise the format is violated.
    pub(crate) fn is_limit(&self) -> bool {
        matches!(self, Self::TooManyEntries(_) | Self::LongName | Self::TooLarge(_))
    }
}

/// An archive whose directory has been read.
#[derive(Debug)]
pub(crate) struct Archive<'a> {
    zip: ZipSliceArchive<&'a [u8]>,
    entries: Vec<ArchiveEntry>,
    limits: ArchiveLimits,
    /// The bytes that may still be inflated.
    left: Cell<u64>,
    cancel: CancelFlag,
}

/// A file of an archive.
#[derive(Debug, Clone)]
pub(crate) struct ArchiveEntry {
    name: String,
    method: CompressionMethod,
    is_encrypted: bool,
    position: ZipArchiveEntryWayfinder,
}

impl ArchiveEntry {
    /// The path of the file in the archive, with `/` between folders and none at the start.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }
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
        let zip = ZipArchive::from_slice(bytes).map_err(damaged)?;
        let mut entries = Vec::new();
        let mut directory = zip.entries();
        while let Some(entry) = directory.next_entry().map_err(damaged)? {
            if entries.len() == limits.entries {
                return Err(ArchiveFault::TooManyEntries(limits.entries));
            }
            let path = entry.file_path();
            let path: &[u8] = path.as_ref();
            if path.len() > LONGEST_NAME {
                return Err(ArchiveFault::LongName);
            }
            entries.push(ArchiveEntry {
                name: String::from_utf8_lossy(path).replace('\\', "/").trim_start_matches('/').to_owned(),
                method: entry.compression_method(),
                is_encrypted: entry.flags().is_encrypted(),
                position: entry.wayfinder(),
            });
        }
        Ok(Self { zip, entries, limits, left: Cell::new(limits.inflated_bytes), cancel: CancelFlag::default() })
    }

    /// The same archive with a cancel flag: once `cancel` is set, reading fails.
    pub(crate) fn until(self, cancel: &CancelFlag) -> Self {
        Self { cancel: cancel.clone(), ..self }
    }

    /// The files of the archive, in the order of its directory; folders are left out.
    pub(crate) fn files(&self) -> impl Iterator<Item = &ArchiveEntry> {
        self.entries.iter().filter(|entry| !entry.name.ends_with('/'))
    }

    /// The file with this name. Case is ignored, as 3MF compares the names of parts.
    pub(crate) fn file(&self, name: &str) -> Option<&ArchiveEntry> {
        let name = name.trim_start_matches('/');
        self.files().find(|entry| entry.name.eq_ignore_ascii_case(name))
    }

    /// Starts to inflate a file.
    ///
    /// # Errors
    /// [`ArchiveFault`] if the file's data are damaged, encrypted, or compressed by another method than deflate.
    pub(crate) fn read(&self, entry: &ArchiveEntry) -> Result<Inflating<'_>, ArchiveFault> {
        if entry.is_encrypted {
            return Err(ArchiveFault::Encrypted);
        }
        let local = self.zip.get_entry(entry.position).map_err(damaged)?;
        let content = match entry.method {
            CompressionMethod::STORE => Content::Stored(local.data()),
            CompressionMethod::DEFLATE => Content::Deflated(flate2::bufread::DeflateDecoder::new(local.data())),
            other => return Err(ArchiveFault::Compression(other.as_u16())),
        };
        Ok(Inflating { content: local.verifying_reader(content), left: &self.left, cancel: &self.cancel })
    }

    /// The whole content of a file.
    ///
    /// # Errors
    /// As [`Archive::read`]; also if the file exceeds the limit or its checksum differs.
    pub(crate) fn content(&self, entry: &ArchiveEntry) -> Result<Vec<u8>, ArchiveFault> {
        let mut content = Vec::new();
        self.read(entry)?.read_to_end(&mut content).map_err(|error| self.fault(&error))?;
        Ok(content)
    }

    /// The fault that caused an error of [`Inflating`].
    pub(crate) fn fault(&self, error: &io::Error) -> ArchiveFault {
        match error.kind() {
            io::ErrorKind::FileTooLarge => ArchiveFault::TooLarge(self.limits.inflated_bytes),
            _ => ArchiveFault::Damaged(error.to_string()),
        }
    }
}

fn damaged(error: impl fmt::Display) -> ArchiveFault {
    ArchiveFault::Damaged(error.to_string())
}

/// A file of an archive that is being inflated. Reading fails with [`io::ErrorKind::FileTooLarge`] beyond the archive's
/// limit, and at the end if size or checksum differ from the directory's.
pub(crate) struct Inflating<'a> {
    content: rawzip::ZipSliceVerifier<Content<'a>>,
    left: &'a Cell<u64>,
    cancel: &'a CancelFlag,
}

enum Content<'a> {
    Stored(&'a [u8]),
    Deflated(flate2::bufread::DeflateDecoder<&'a [u8]>),
}

impl Read for Content<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Stored(bytes) => bytes.read(buffer),
            Self::Deflated(decoder) => decoder.read(buffer),
        }
    }
}

impl Read for Inflating<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.cancel.is_cancelled() {
            return Err(io::Error::other("it is no longer needed"));
        }
        let read = self.content.read(buffer)?;
        match self.left.get().checked_sub(read as u64) {
            Some(left) => self.left.set(left),
            None => return Err(io::ErrorKind::FileTooLarge.into()),
        }
        Ok(read)
    }
}
