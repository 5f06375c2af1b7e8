//! A streaming reader of multipart forms (`multipart/form-data`, RFC 7578). It stores only the last chunk of the body,
//! and passes data on without copying them. The framework's reader buffers all data that are ready, so that a
//! compressed body would expand in memory, and it limits neither a part's head nor the preamble.

use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;
use crate::http::request_body::next_data;
use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderMap, header};
use bytes::Buf;
use memchr::memmem::{self, Finder};

/// The longest head of a part in bytes; browsers and libraries send some hundred.
const LONGEST_HEAD: usize = 1 << 14;

/// The most parts of a form: an upload has a surface, parameters and some libraries.
const MOST_PARTS: usize = 100;

/// The longest boundary [RFC 2046, section 5.1.1].
const LONGEST_BOUNDARY: usize = 70;

/// A form, read one part after another.
pub(crate) struct MultipartForm {
    body: Body,
    /// CRLF, two hyphens and the boundary.
    delimiter: Finder<'static>,
    /// Data that have arrived and have not been passed on.
    held: Bytes,
    position: Position,
    parts: usize,
    length: Option<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Position {
    /// A part's data, or the preamble before the first part.
    Data,
    /// The rest of a delimiter's line.
    Delimiter,
    /// The data after the last delimiter.
    Epilogue,
}

/// The head of a part.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Head {
    pub(crate) name: Option<String>,
    pub(crate) file_name: Option<String>,
    pub(crate) media_type: Option<String>,
}

impl<S: Send + Sync> FromRequest<S> for MultipartForm {
    type Rejection = Problem;

    async fn from_request(request: Request, _: &S) -> Result<Self, Problem> {
        let boundary = boundary(request.headers())?;
        Ok(Self::new(request.into_body(), &boundary))
    }
}

impl MultipartForm {
    fn new(body: Body, boundary: &str) -> Self {
        let delimiter = Finder::new(&format!("\r\n--{boundary}")).into_owned();
        // The first delimiter may start the body, without a line break before it.
        let length = body.size_hint().exact();
        Self { body, delimiter, held: Bytes::from_static(b"\r\n"), position: Position::Data, parts: 0, length }
    }

    /// The length of the whole form in bytes, if the client states it and does not compress the form.
    pub(crate) fn stated_length(&self) -> Option<u64> {
        self.length
    }

    /// Skips the rest of the current part, and returns the head of the next.
    pub(crate) async fn next(&mut self) -> Result<Option<Head>, Problem> {
        while self.chunk().await?.is_some() {}
        if self.position == Position::Epilogue {
            return Ok(None);
        }
        while self.held.len() < 2 {
            self.more().await?;
        }
        if self.held.starts_with(b"--") {
            self.position = Position::Epilogue;
            // All data are read, so that the connection can be used again.
            while next_data(&mut self.body).await?.is_some() {}
            return Ok(None);
        }
        self.parts += 1;
        if self.parts > MOST_PARTS {
            return Err(malformed(format!("the form has more than {MOST_PARTS} parts")));
        }
        let head = self.head().await?;
        self.position = Position::Data;
        Ok(Some(head))
    }

    /// The next data of the current part; `None` at its end.
    pub(crate) async fn chunk(&mut self) -> Result<Option<Bytes>, Problem> {
        if self.position != Position::Data {
            return Ok(None);
        }
        loop {
            if let Some(end) = self.delimiter.find(&self.held) {
                let data = self.held.split_to(end);
                self.held.advance(self.delimiter.needle().len());
                self.position = Position::Delimiter;
                return Ok(Some(data));
            }
            let data = self.held.split_to(self.delimiter_begun());
            if !data.is_empty() {
                return Ok(Some(data));
            }
            self.more().await?;
        }
    }

    /// The start of a delimiter of which only a part has arrived, otherwise the end of the buffer.
    fn delimiter_begun(&self) -> usize {
        let needle = self.delimiter.needle();
        let length = self.held.len();
        let possible = (length + 1).saturating_sub(needle.len())..length;
        possible.into_iter().find(|at| needle.starts_with(&self.held[*at..])).unwrap_or(length)
    }

    /// Reads the head of a part, from the delimiter to the empty line.
    async fn head(&mut self) -> Result<Head, Problem> {
        loop {
            let searched = &self.held[..self.held.len().min(LONGEST_HEAD)];
            if let Some(end) = memmem::find(searched, b"\r\n\r\n") {
                let head = read_head(&searched[..end])?;
                self.held.advance(end + 4);
                return Ok(head);
            }
            if searched.len() == LONGEST_HEAD {
                return Err(malformed(format!("the head of a part is longer than {LONGEST_HEAD} bytes")));
            }
            self.more().await?;
        }
    }

    /// Buffers the body's next data; the end of the body is an error here.
    async fn more(&mut self) -> Result<(), Problem> {
        let Some(data) = next_data(&mut self.body).await? else {
            return Err(malformed("the form ends before its last boundary".to_owned()));
        };
        // The buffer holds at most the start of a delimiter here, so that a copy is rare.
        self.held = if self.held.is_empty() { data } else { [&self.held[..], &data].concat().into() };
        Ok(())
    }
}

/// Parses the lines of a head. The first is the rest of the delimiter's line.
fn read_head(lines: &[u8]) -> Result<Head, Problem> {
    let lines = std::str::from_utf8(lines).map_err(|_| malformed("the head of a part is not UTF-8".to_owned()))?;
    let mut lines = lines.split("\r\n");
    if !lines.next().unwrap_or_default().trim_matches([' ', '\t']).is_empty() {
        return Err(malformed("a boundary is followed by neither a line's end nor two hyphens".to_owned()));
    }
    let mut head = Head::default();
    for line in lines {
        let Some((name, value)) = line.split_once(':') else {
            return Err(malformed("a line in the head of a part has no colon".to_owned()));
        };
        match name.trim().to_ascii_lowercase().as_str() {
            "content-disposition" => {
                head.name = parameter(value, "name");
                head.file_name = parameter(value, "filename");
            }
            "content-type" => head.media_type = Some(value.trim().to_owned()),
            _ => {}
        }
    }
    Ok(head)
}

/// The parameter `name` of a header's value: `...; name=token` or `...; name="quoted"`. In quotation marks, a backslash
/// escapes the next character.
fn parameter(value: &str, name: &str) -> Option<String> {
    let (_, mut rest) = value.split_once(';')?;
    loop {
        let (key, after) = rest.split_once('=')?;
        let key = key.trim_matches([' ', '\t', ';']);
        let (value, after) = parameter_value(after);
        if key.eq_ignore_ascii_case(name) {
            return Some(value);
        }
        rest = after;
    }
}

/// A parameter's value, and the rest of the text.
fn parameter_value(text: &str) -> (String, &str) {
    let Some(quoted) = text.trim_start().strip_prefix('"') else {
        let (token, rest) = text.split_once(';').unwrap_or((text, ""));
        return (token.trim().to_owned(), rest);
    };
    let (mut value, mut is_plain) = (String::new(), false);
    for (index, character) in quoted.char_indices() {
        match character {
            '\\' if !is_plain => is_plain = true,
            '"' if !is_plain => return (value, &quoted[index + 1..]),
            _ => {
                value.push(character);
                is_plain = false;
            }
        }
    }
    (value, "")
}

fn boundary(headers: &HeaderMap) -> Result<String, Problem> {
    let media_type = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let essence = media_type.split(';').next().unwrap_or_default().trim();
    if !essence.eq_ignore_ascii_case("multipart/form-data") {
        let detail =
            "send a form with the header content-type: multipart/form-data; boundary=...; JSON goes to the same path without /upload";
        return Err(Problem::new(ServiceProblem::UnsupportedMediaType, detail));
    }
    let boundary = parameter(media_type, "boundary").filter(|boundary| (1..=LONGEST_BOUNDARY).contains(&boundary.len()));
    boundary.ok_or_else(|| malformed(format!("the header content-type must name a boundary of 1 to {LONGEST_BOUNDARY} characters")))
}

fn malformed(detail: String) -> Problem {
    Problem::new(ServiceProblem::MalformedForm, detail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::StatusCode;
    use proptest::prelude::*;

    type Part = (Head, Vec<u8>);

    /// All parts of a body that arrives in chunks of `size` bytes.
    fn read(body: &[u8], size: usize) -> Result<Vec<Part>, String> {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let (mut sender, channel) = http_body_util::channel::Channel::<Bytes>::new(1);
        let pieces: Vec<Bytes> = body.chunks(size).map(Bytes::copy_from_slice).collect();
        runtime.block_on(async {
            let sending = async {
                for piece in pieces {
                    if sender.send_data(piece).await.is_err() {
                        return;
                    }
                }
                drop(sender);
            };
            let reading = async {
                let mut form = MultipartForm::new(Body::new(channel), "edge");
                let mut parts = Vec::new();
                while let Some(head) = form.next().await.map_err(|problem| format!("{problem:?}"))? {
                    let mut data = Vec::new();
                    while let Some(chunk) = form.chunk().await.map_err(|problem| format!("{problem:?}"))? {
                        data.extend(chunk);
                    }
                    parts.push((head, data));
                }
                drop(form);
                Ok(parts)
            };
            tokio::join!(sending, reading).1
        })
    }

    fn part(name: &str, data: &[u8]) -> Part {
        (Head { name: Some(name.to_owned()), ..Head::default() }, data.to_vec())
    }

    fn written(parts: &[Part]) -> Vec<u8> {
        let mut body = Vec::new();
        for (head, data) in parts {
            body.extend(format!("--edge\r\nContent-Disposition: form-data; name=\"{}\"\r\n\r\n", head.name.as_deref().unwrap()).bytes());
            body.extend(data.iter().chain(b"\r\n"));
        }
        body.extend(b"--edge--\r\n");
        body
    }

    proptest! {
        #[test]
        fn parts_are_read_wherever_the_body_is_cut(
            data in proptest::collection::vec(proptest::collection::vec(prop_oneof![Just(b"\r\n--edg".to_vec()), Just(b"\r".to_vec()), Just(b"--".to_vec()), any::<[u8; 3]>().prop_map(Vec::from)], 0..20), 0..4),
            size in 1_usize..50,
        ) {
            let parts: Vec<Part> = data.iter().map(|pieces| part("surface", &pieces.concat())).collect();
            prop_assume!(parts.iter().all(|(_, data)| memmem::find(data, b"\r\n--edge").is_none()));
            prop_assert_eq!(read(&written(&parts), size), Ok(parts));
        }

        #[test]
        fn a_form_cut_off_is_refused(length in 0_usize..120) {
            let whole = written(&[part("surface", b"1,2,3"), part("parameters", b"{}")]);
            // Cut before the closing hyphens and the line break, 4 bytes.
            let end = whole.len() - 4;
            let result = read(&whole[..length.min(end)], 7);
            prop_assert!(result.is_err(), "{:?}", result);
        }
    }

    #[test]
    fn long_data_arrive_complete() {
        let long: Vec<u8> = (0..=250).cycle().take(3_000_017).collect();
        let parts = [part("surface", &long), part("parameters", b"{}")];
        assert_eq!(read(&written(&parts), 70_000), Ok(parts.to_vec()));
    }

    #[test]
    fn preamble_and_epilogue_are_ignored() {
        let body = b"preamble\r\n--edge \t\r\nX-Other: 1\r\ncontent-type: model/stl\r\ncontent-disposition:form-data; filename=\"a;\\\"b.stl\"; name=surface\r\n\r\n\r\n--edge\r\n\r\nno head\r\n--edge--epilogue\r\n--edge";
        let named = Head { name: Some("surface".into()), file_name: Some("a;\"b.stl".into()), media_type: Some("model/stl".into()) };
        assert_eq!(read(body, 9), Ok(vec![(named, Vec::new()), (Head::default(), b"no head".to_vec())]));
    }

    #[test]
    fn malformed_forms_are_refused() {
        for body in [
            &b""[..],
            b"x",
            b"--edge",
            b"--edgeX\r\n\r\n\r\n--edge--",
            b"--edge\r\nno colon\r\n\r\n\r\n--edge--",
            b"--edge\r\n\xff: 1\r\n\r\n\r\n--edge--",
        ] {
            assert!(read(body, 5).is_err(), "{}", String::from_utf8_lossy(body));
        }
        let endless_head = [&b"--edge\r\nX: "[..], &vec![b'x'; 2 * LONGEST_HEAD]].concat();
        assert!(read(&endless_head, 100).unwrap_err().contains("longer than"));
    }

    #[test]
    fn boundaries_are_read_with_and_without_quotation_marks() {
        let of = |value: &'static str| {
            let headers = [(header::CONTENT_TYPE, value.parse().unwrap())].into_iter().collect();
            boundary(&headers).map_err(|problem| axum::response::IntoResponse::into_response(problem).status())
        };
        assert_eq!(of("multipart/form-data; boundary=edge"), Ok("edge".into()));
        assert_eq!(of("Multipart/Form-Data; charset=utf-8; BOUNDARY=\"e; dge\""), Ok("e; dge".into()));
        assert_eq!(of("multipart/form-data"), Err(StatusCode::BAD_REQUEST));
        assert_eq!(of("multipart/form-data; boundary="), Err(StatusCode::BAD_REQUEST));
        assert_eq!(of("multipart/mixed; boundary=edge"), Err(StatusCode::UNSUPPORTED_MEDIA_TYPE));
        assert_eq!(of("application/json"), Err(StatusCode::UNSUPPORTED_MEDIA_TYPE));
    }
}
