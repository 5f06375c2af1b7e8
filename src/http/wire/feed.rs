//! The feed per tooth, which may be none.

use crate::http::codes::RequestFault;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, Member, PlainKind, describe, members, number};
use crate::quantity::{Length, OutOfRange};
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

pub(super) const FEED_PER_TOOTH: Member<FeedKind> =
    Member { name: "feed_per_tooth_mm", about: "feed per tooth f_z, at least 1e-6; 0 or absent = no feed marks", kind: FeedKind };

members! {
    /// The feed per tooth.
    pub(super) plain struct FeedMembers / FeedSlots {
        feed_per_tooth: optional FEED_PER_TOOTH: FeedKind,
    }
}

/// A stated feed per tooth. 0 means no marks, also where a default says otherwise.
#[derive(Debug, Clone, Copy)]
pub(super) enum Feed {
    NoMarks,
    PerTooth(Length),
}

impl Feed {
    fn from_mm(feed: f64) -> Result<Self, OutOfRange> {
        if feed == 0.0 { Ok(Self::NoMarks) } else { Length::from_mm(feed).map(Self::PerTooth) }
    }

    /// The feed per tooth, `None` where there are no marks.
    pub(super) fn per_tooth(self) -> Option<Length> {
        match self {
            Self::PerTooth(length) => Some(length),
            Self::NoMarks => None,
        }
    }
}

/// A length or 0.
pub(super) struct FeedKind;

impl Kind for FeedKind {
    type Value = Feed;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Feed, Faulted> {
        Feed::from_mm(number(raw, path, faults)?)
            .map_err(|bounds| faults.add(&path, RequestFault::OutOfRange, format_args!("{bounds}, found {}", describe(raw))))
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::Number).description(Some(about)).examples([0.3]);
        schema.minimum(Some(0.0)).maximum(Some(Length::LARGEST)).into()
    }
}

impl PlainKind for FeedKind {
    type Plain = f64;

    fn accept(&self, plain: f64) -> Option<Feed> {
        Feed::from_mm(plain).ok()
    }
}
