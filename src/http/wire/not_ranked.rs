//! Wire object of a cutter that is not ranked, with the reason.

use crate::http::codes::NotRankedCode;
use serde::Serialize;
use utoipa::ToSchema;

/// A cutter that is not ranked, and the reason.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = NotRankedCutter)]
pub(crate) struct NotRanked {
    /// The position of the cutter in the request, from 0; cutters of libraries follow, and then their faulty tools.
    pub(crate) cutter: usize,
    /// The cutter's name, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) name: Option<String>,
    pub(crate) code: NotRankedCode,
    /// The reason in words, for people.
    pub(crate) detail: String,
    /// The share of the area that the cutter leaves uncut; only with the code `cannot-reach`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, maximum = 1)]
    pub(crate) uncut_share: Option<f64>,
    /// The largest height that the cutter leaves there; only with the code `cannot-reach`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub(crate) uncut_height_mm: Option<f64>,
    /// The error of that height, due to the raster on which it was computed; only with the code `cannot-reach`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub(crate) uncut_height_error_mm: Option<f64>,
}

impl NotRanked {
    pub(crate) fn new(cutter: usize, name: Option<String>, code: NotRankedCode, detail: String) -> Self {
        Self { cutter, name, code, detail, uncut_share: None, uncut_height_mm: None, uncut_height_error_mm: None }
    }
}
