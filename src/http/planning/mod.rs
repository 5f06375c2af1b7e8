//! The planning endpoints: critical slope of a rectangle, cutter recommendation for a surface in JSON or in a file, and
//! machine presets. Each endpoint has a file; they share the other files.

mod answer;
mod candidates;
mod checked_path;
mod confidence_answer;
mod critical_slope;
mod library;
mod machines;
mod map;
mod parameters;
mod path_check;
mod path_feeds;
mod path_object;
mod plan_answer;
mod plan_task;
mod program;
mod recommendation;
mod surface_answer;
mod upload;

pub(super) use checked_path::{FEED_PLACES, PLACES};
pub(super) use path_check::LARGEST_PROGRAM;
pub(super) use path_object::MOST_POINTS as MOST_PATH_POINTS;

use super::document::examples;
use super::routes::{RouteClass, Routes};
use utoipa_axum::routes;

/// The routes of planning.
pub(super) fn routes() -> Routes {
    use RouteClass::{Batch, Single, Upload};
    Routes::new()
        .documented(Single, routes!(critical_slope::answer))
        .with_examples(examples!("critical_slope"))
        .documented(Single, routes!(machines::list))
        .with_examples(examples!("machines"))
        .documented(Batch, routes!(recommendation::answer))
        .with_examples(examples!("cutter_recommendation"))
        .documented(Upload, routes!(upload::answer))
        .with_examples(examples!("cutter_recommendation_upload"))
        .documented(Batch, routes!(path_check::answer))
        .with_examples(examples!("path_check"))
        .documented(Upload, routes!(path_check::answer_upload))
        .with_examples(examples!("path_check_upload"))
}
