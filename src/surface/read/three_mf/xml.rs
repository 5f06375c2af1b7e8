//! Elements of an XML file in an archive, read as a stream in bounded memory.

use super::super::input::ReadError;
use super::Package;
use crate::archive::ArchiveLimits;
use crate::file_fault::{FileFaultKind, Flaw};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event as Parsed};
use std::borrow::Cow;
use std::io::{self, BufRead, BufReader};

/// The longest tag or text between two tags, in bytes.
const LONGEST_EVENT: u64 = 1 << 20;

/// The deepest nesting of elements.
const DEEPEST: usize = 64;

/// The start or end of an element.
pub(super) enum Event<'a> {
    /// A start tag. For an empty element, an end follows too.
    Start(XmlElement<'a>),
    End,
}

/// An element with its attributes.
pub(super) struct XmlElement<'a>(BytesStart<'a>);

/// The number of elements between two checks whether reading may go on.
const ELEMENTS_AT_ONCE: usize = 1 << 14;

/// Passes the elements of a file to `each`.
pub(super) fn read(package: &mut Package, path: &str, mut each: impl FnMut(Event<'_>) -> Result<(), Flaw>) -> Result<(), ReadError> {
    let missing = || Flaw::new(FileFaultKind::Malformed, "this file in the package", "nothing").in_entry(path, 0);
    let entry = package.file(path).ok_or_else(missing)?.to_owned();
    let Package { archive, input } = package;
    let limits = archive.limits();
    let content = archive.read(&entry).map_err(|fault| Flaw::from(&fault).in_entry(path, 0))?;
    let mut reader = Reader::from_reader(Metered { inner: BufReader::with_capacity(1 << 16, content), read: 0 });
    reader.config_mut().expand_empty_elements = true;
    let (mut buffer, mut depth) = (Vec::new(), 0);
    for count in 1_usize.. {
        if count.is_multiple_of(ELEMENTS_AT_ONCE) {
            input.check()?;
        }
        buffer.clear();
        reader.get_mut().read = 0;
        let position = reader.buffer_position();
        let result = match reader.read_event_into(&mut buffer) {
            Ok(Parsed::Start(_)) if depth == DEEPEST => {
                Err(Flaw::new(FileFaultKind::TooLarge, format!("at most {DEEPEST} nested elements"), "more"))
            }
            Ok(Parsed::Start(element)) => {
                depth += 1;
                each(Event::Start(XmlElement(element)))
            }
            Ok(Parsed::End(_)) => {
                depth -= 1;
                each(Event::End)
            }
            Ok(Parsed::Eof) if depth > 0 => Err(Flaw::new(FileFaultKind::Truncated, "the end of every element", "the end of the file")),
            Ok(Parsed::Eof) => break,
            Ok(Parsed::DocType(_)) => Err(Flaw::new(FileFaultKind::Malformed, "no document type definition", "one")),
            Ok(_) => Ok(()),
            Err(error) => Err(flaw(limits, &error)),
        };
        result.map_err(|flaw| flaw.in_entry(path, position))?;
    }
    Ok(())
}

fn flaw(limits: ArchiveLimits, error: &quick_xml::Error) -> Flaw {
    match error {
        quick_xml::Error::Io(error) if error.kind() == io::ErrorKind::QuotaExceeded => {
            Flaw::new(FileFaultKind::TooLarge, format!("at most {LONGEST_EVENT} bytes in a tag or text"), "more")
        }
        quick_xml::Error::Io(error) => Flaw::from(&limits.fault(error)),
        error => Flaw::quoting("well-formed XML", error.to_string().as_bytes()),
    }
}

impl XmlElement<'_> {
    /// The name without a prefix.
    pub(super) fn name(&self) -> &str {
        local(self.0.name().into_inner())
    }

    /// The value of the attribute of this name, with any prefix, without entities.
    pub(super) fn attribute(&self, name: &str) -> Option<String> {
        let (_, value) = self.attributes().find(|(key, _)| local(key) == name)?;
        // A value with a damaged entity is taken as it is.
        Some(quick_xml::escape::unescape(&value).map_or_else(|_| value.to_string(), Cow::into_owned))
    }

    /// All attributes, with their prefixes.
    pub(super) fn attributes(&self) -> impl Iterator<Item = (&str, Cow<'_, str>)> {
        let mut attributes = self.0.attributes();
        attributes.with_checks(false);
        attributes.filter_map(Result::ok).map(|attribute| (attribute.key.into_inner(), attribute.value))
    }
}

/// A name without its prefix.
fn local(name: &str) -> &str {
    name.rsplit_once(':').map_or(name, |(_, local)| local)
}

/// A reader that bounds the bytes of one event in the parser's buffer.
struct Metered<R> {
    inner: R,
    read: u64,
}

impl<R: BufRead> io::Read for Metered<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.inner.read(buffer)
    }
}

impl<R: BufRead> BufRead for Metered<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.read > LONGEST_EVENT {
            return Err(io::ErrorKind::QuotaExceeded.into());
        }
        self.inner.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.read += amount as u64;
        self.inner.consume(amount);
    }
}
