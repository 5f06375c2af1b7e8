//! The JSON format of log lines, one object for each line. Every request writes one, so fields are written into the
//! line directly, without intermediate values or buffers.

use std::fmt::{self, Debug, Write};

use tracing::field::{Field, Visit};
use tracing::span::Record;
use tracing::{Event, Subscriber};
use tracing_subscriber::field::RecordFields;
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::time::{FormatTime, SystemTime};
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields, FormattedFields};
use tracing_subscriber::registry::LookupSpan;

/// Writes an event as a line: time, level, the fields of the event and of its spans, and its source.
#[derive(Debug, Clone, Copy)]
pub(super) struct JsonLine;

impl<S, F> FormatEvent<S, F> for JsonLine
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    F: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(&self, context: &FmtContext<'_, S, F>, mut writer: Writer<'_>, event: &Event<'_>) -> fmt::Result {
        writer.write_str("{\"timestamp\":\"")?;
        SystemTime.format_time(&mut writer)?;
        writer.write_str("\",\"level\":\"")?;
        writer.write_str(event.metadata().level().as_str())?;
        writer.write_char('"')?;
        Members::write(&mut writer, |members| event.record(members))?;
        for span in context.event_scope().into_iter().flatten() {
            if let Some(fields) = span.extensions().get::<FormattedFields<F>>() {
                writer.write_str(fields)?;
            }
        }
        writer.write_str(",\"target\":\"")?;
        writer.write_str(event.metadata().target())?;
        writer.write_str("\"}\n")
    }
}

/// Writes a span's fields as members of a line. Fields with a dot in their names are OpenTelemetry's and are written
/// only to traces: the last line of a request has the same values under other names.
#[derive(Debug, Clone, Copy)]
pub(super) struct JsonMembers;

impl<'w> FormatFields<'w> for JsonMembers {
    fn format_fields<R: RecordFields>(&self, mut writer: Writer<'w>, fields: R) -> fmt::Result {
        Members::write(&mut writer, |members| fields.record(members))
    }

    // The default implementation would separate them with a blank.
    fn add_fields(&self, span: &'w mut FormattedFields<Self>, fields: &Record<'_>) -> fmt::Result {
        self.format_fields(span.as_writer(), fields)
    }
}

/// Writes fields as further members of an object.
struct Members<'a, 'w> {
    writer: &'a mut Writer<'w>,
    written: fmt::Result,
}

impl<'a, 'w> Members<'a, 'w> {
    fn write(writer: &'a mut Writer<'w>, record: impl FnOnce(&mut Self)) -> fmt::Result {
        let mut members = Self { writer, written: Ok(()) };
        record(&mut members);
        members.written
    }

    fn member(&mut self, field: &Field, value: impl FnOnce(&mut Writer<'w>) -> fmt::Result) {
        if field.name().contains('.') || self.written.is_err() {
            return;
        }
        // Names are identifiers and need no escapes.
        self.written = self
            .writer
            .write_str(",\"")
            .and_then(|()| self.writer.write_str(field.name()))
            .and_then(|()| self.writer.write_str("\":"))
            .and_then(|()| value(self.writer));
    }
}

impl Visit for Members<'_, '_> {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        self.member(field, |writer| quoted(writer, format_args!("{value:?}")));
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.member(field, |writer| quoted(writer, format_args!("{value}")));
    }

    fn record_f64(&mut self, field: &Field, value: f64) {
        self.member(field, |writer| if value.is_finite() { write!(writer, "{value}") } else { writer.write_str("null") });
    }

    fn record_i64(&mut self, field: &Field, value: i64) {
        self.member(field, |writer| write!(writer, "{value}"));
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        self.member(field, |writer| write!(writer, "{value}"));
    }

    fn record_bool(&mut self, field: &Field, value: bool) {
        self.member(field, |writer| write!(writer, "{value}"));
    }
}

fn quoted(writer: &mut Writer<'_>, text: fmt::Arguments<'_>) -> fmt::Result {
    writer.write_char('"')?;
    Escaped(writer).write_fmt(text)?;
    writer.write_char('"')
}

/// Writes text as the content of a JSON string.
struct Escaped<'a, 'w>(&'a mut Writer<'w>);

impl Write for Escaped<'_, '_> {
    fn write_str(&mut self, mut text: &str) -> fmt::Result {
        let special = |byte: u8| byte < b' ' || byte == b'"' || byte == b'\\';
        while let Some(at) = text.bytes().position(special) {
            self.0.write_str(&text[..at])?;
            match text.as_bytes()[at] {
                b'\n' => self.0.write_str("\\n")?,
                byte @ (b'"' | b'\\') => write!(self.0, "\\{}", char::from(byte))?,
                byte => write!(self.0, "\\u{byte:04x}")?,
            }
            text = &text[at + 1..];
        }
        self.0.write_str(text)
    }
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::{Arc, Mutex};

    use serde_json::{Value, json};
    use tracing_subscriber::Registry;
    use tracing_subscriber::layer::SubscriberExt;

    use super::*;

    #[derive(Clone, Default)]
    struct Page(Arc<Mutex<Vec<u8>>>);

    impl io::Write for Page {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// The lines that `log` writes, without their timestamps.
    fn lines(log: impl FnOnce()) -> Vec<Value> {
        let page = Page::default();
        let writer = page.clone();
        let layer = tracing_subscriber::fmt::layer().event_format(JsonLine).fmt_fields(JsonMembers).with_writer(move || writer.clone());
        tracing::subscriber::with_default(Registry::default().with(layer), log);
        let text = String::from_utf8(page.0.lock().unwrap().clone()).unwrap();
        let line = |line: &str| {
            let mut line: Value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
            let time = line.as_object_mut().unwrap().remove("timestamp").unwrap();
            assert!(time.as_str().is_some_and(|time| time.starts_with("20") && time.ends_with('Z')), "{time}");
            line
        };
        text.lines().map(line).collect()
    }

    #[test]
    fn a_line_holds_the_fields_of_event_and_span() {
        let logged = lines(|| {
            let span = tracing::info_span!("request", request_id = "order-66", http.route = "/v1/max-feed");
            span.in_scope(|| tracing::warn!(status = 422_u16, least = -3, share = 0.5, none = f64::NAN, probe = false, "message"));
        });
        let expected = json!({
            "level": "WARN", "message": "message", "status": 422, "least": -3, "share": 0.5, "none": null, "probe": false,
            "request_id": "order-66", "target": "scallopd::telemetry::json::tests"
        });
        assert_eq!(logged, [expected]);
    }

    #[test]
    fn special_characters_are_escaped() {
        let hostile = "a \"quoted\\path\"\n\r\t\u{1} \u{7f} ä \u{1f980}\",\"level\":\"ERROR";
        let logged = lines(|| tracing::info!(shown = hostile, debugged = ?hostile, "{hostile}"));
        assert_eq!(logged.len(), 1);
        assert_eq!(logged[0]["shown"], hostile);
        assert_eq!(logged[0]["debugged"], format!("{hostile:?}"));
        assert_eq!(logged[0]["message"], hostile);
        assert_eq!(logged[0]["level"], "INFO");
    }
}
