//! `GET /v1/about`: what a client needs to know before it sends anything.

use super::app_state::BodyLimits;
use super::planning::{FEED_PLACES, LARGEST_PROGRAM, MOST_PATH_POINTS, PLACES};
use super::problem::ProblemBody;
use super::wire::{Contacts, MODEL, MOST_CUTTERS, answer};
use crate::motion::PRESETS;
use crate::surface::MOST_FACETS;
use axum::Json;
use axum::extract::State;

answer! {
    /// The service, its limits, and what it reads.
    pub(super) struct About of (limits: BodyLimits) {
        /// The version of the service.
        version: &'static str [example = "0.1.0"] = env!("CARGO_PKG_VERSION"),
        /// The limits in force.
        limits: Limits = Limits::of(limits),
        /// The formats of surfaces in files.
        surface_formats: Vec<&'static str> = vec!["csv", "tsv", "xyz", "pcd", "stl", "obj", "ply", "3mf"],
        /// The formats of paths in files: G-code, Heidenhain's Klartext, APT and cutter location statements, columns.
        path_formats: Vec<&'static str> = vec!["iso", "klartext", "apt", "csv"],
        /// The formats of tool libraries: Fusion's, FreeCAD's, and columns.
        tool_library_formats: Vec<&'static str> = vec!["json", "tools", "fctb", "csv"],
        /// The names of the machine presets.
        presets: Vec<&'static str> = PRESETS.iter().map(|preset| preset.name).collect(),
        /// The models of the scallop height.
        models: Vec<&'static str> = MODEL.kind.words.iter().map(|(word, _)| *word).collect(),
        /// The methods of recommendations.
        methods: Vec<&'static str> = vec!["surface", "rectangle"],
    }

    /// Limits of requests. More is refused with a problem that names the limit.
    struct Limits of (limits: BodyLimits) {
        /// The largest JSON body, decompressed.
        json_bytes: u64 = limits.json,
        /// The largest form with files, decompressed.
        upload_bytes: u64 = limits.upload,
        /// The largest program in a form.
        program_bytes: usize = LARGEST_PROGRAM,
        /// The most facets of a surface.
        facets: usize = MOST_FACETS,
        /// The most contacts of a batch.
        contacts: usize = Contacts::MOST,
        /// The most cutters of a recommendation, those of libraries included.
        cutters: usize = MOST_CUTTERS,
        /// The most points of a path, arcs in chords.
        path_points: usize = MOST_PATH_POINTS,
        /// The places at which the check of a path looks at the surface.
        places: usize = PLACES,
        /// Those for which it finds the largest feeds.
        feed_places: usize = FEED_PLACES,
    }
}

/// About the service
///
/// Its version, the limits in force, the formats that it reads, and the names of presets, models and methods.
#[utoipa::path(
    get, path = "/v1/about", tag = "service", operation_id = "about",
    responses(
        (status = 200, description = "Version, limits and formats", body = About),
        (status = 503, description = "The server is busy; try again after the time in Retry-After", body = ProblemBody, content_type = "application/problem+json"),
    ),
)]
pub(super) async fn show(State(limits): State<BodyLimits>) -> Json<About> {
    Json(About::of(limits))
}
