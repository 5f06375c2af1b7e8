//! The answer of a path check.

use super::confidence_answer::ConfidenceAnswer;
use super::map::PathMapAnswer;
use super::path_feeds::{FeedsAnswer, PathMoves};
use super::program::ProgramAnswer;
use crate::http::wire::{Warning, answer};
use crate::path::{Finding, FindingKind, Finish, Milled, Residual};
use serde::Serialize;
use utoipa::ToSchema;

answer! {
    /// What a path leaves on a surface.
    pub(crate) struct PathCheckAnswer {
        /// The number of moves, arcs in chords.
        pub(super) moves: usize,
        /// The length of the moves at the feed rate.
        pub(super) cutting_length_mm: f64 [minimum = 0],
        /// The length of the rapid moves.
        pub(super) rapid_length_mm: f64 [minimum = 0],
        /// The time of all moves. The control stops where moves at the feed rate and rapid moves meet; it rounds corners
        /// within the machine's path tolerance, or, if none is stated, stops in those of more than 45°.
        pub(super) machining_time_s: f64 [minimum = 0],
        /// The material left over the selected area that is seen from above, along its normal; negative where the part is
        /// cut. Absent if the path comes over no place.
        pub(super) residual_mm?: ResidualAnswer,
        /// The share of the area left over 1.02 times the tolerance, uncut area included.
        pub(super) over_tolerance_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area left over the tolerance that the cutter could reach.
        pub(super) reachable_over_tolerance_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area over which no move at the feed rate comes.
        pub(super) uncut_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area with ridges of at least half the tolerance.
        pub(super) used_share: f64 [minimum = 0, maximum = 1],
        /// Cuts into the part.
        pub(super) gouge: GougeAnswer,
        /// The standard errors of the shares.
        pub(super) standard_error: StandardErrors,
        /// Ra of the geometry, in um, at `residual_mm.p99` as a scallop height: 99 % of the area are smoother.
        pub(super) ra_um: f64 [minimum = 0],
        /// What is left with tooth marks of the worst phase, over the places where it is under ten times the tolerance. Absent
        /// if teeth, spindle speed or a feed rate is not known.
        pub(super) scallop_height_with_marks_mm?: ResidualAnswer,
        /// The length of the moves at the feed rate that take nothing over a tenth of the tolerance off what the moves before
        /// them left on the selected area. Moves near one that cuts count as cutting.
        pub(super) idle_length_mm: f64 [minimum = 0],
        /// The worst places of each kind, at most a hundred, no two of a kind closer than the cutter's radius, and at most ten
        /// feed rates over a limit; with `places` in `include`, or without `include`.
        pub(super) places?: Vec<PlaceAnswer> [max_items = 110],
        /// The surface as a raster; with `map` in `include`.
        pub(super) map?: PathMapAnswer,
        /// The largest feeds that keep the tolerance; with `feeds` in `include`.
        pub(super) feeds?: FeedsAnswer,
        /// The program with the largest feeds; with `program` in `include`.
        pub(super) program?: ProgramAnswer,
        /// The reliability of the figures.
        pub(super) confidence: ConfidenceAnswer,
        /// Facts that need attention.
        pub(super) warnings: Vec<Warning>,
    }

    /// Percentiles over the area of what is left.
    pub(super) struct ResidualAnswer of (residual: Residual) {
        /// The median.
        p50: f64 = residual.p50,
        /// 90 % of the area have less.
        p90: f64 = residual.p90,
        /// 99 % of the area have less.
        p99: f64 = residual.p99,
        /// The most that was found.
        max: f64 = residual.max,
    }

    /// Cuts into the part.
    pub(super) struct GougeAnswer of (finish: &Finish) {
        /// The share of the area cut by more than 2 um and a fifth of the tolerance.
        share: f64 [minimum = 0, maximum = 1] = finish.gouge_share.value,
        /// The deepest cut of moves at the feed rate.
        depth_mm: f64 [minimum = 0] = finish.gouge.map_or(0.0, |spot| -spot.left.height),
        /// The deepest cut of rapid moves.
        rapid_depth_mm: f64 [minimum = 0] = finish.collision.map_or(0.0, |spot| -spot.left.height),
    }

    /// The standard errors of the shares, which are measured at random places.
    #[expect(clippy::struct_field_names, reason = "the wire names")]
    pub(super) struct StandardErrors of (finish: &Finish) {
        /// Of `over_tolerance_share`.
        over_tolerance_share: f64 [minimum = 0] = finish.over_share.standard_error,
        /// Of `reachable_over_tolerance_share`.
        reachable_over_tolerance_share: f64 [minimum = 0] = finish.over_reachable_share.standard_error,
        /// Of `uncut_share`.
        uncut_share: f64 [minimum = 0] = finish.uncut_share.standard_error,
        /// Of `gouge.share`.
        gouge_share: f64 [minimum = 0] = finish.gouge_share.standard_error,
    }

    /// A place where the path leaves too much or cuts too deep.
    pub(super) struct PlaceAnswer {
        /// What is wrong.
        pub(super) code: PlaceCode,
        /// The place on the surface.
        pub(super) point_mm: [f64; 3] [min_items = 3, max_items = 3],
        /// What is left there, negative in a cut; absent where it is uncut, and of `feed-over-limit`.
        pub(super) value_mm?: f64,
        /// The index of a move, from 0: of a cut the one that cuts deepest, elsewhere the one that was to finish the place. Absent
        /// where it is uncut.
        pub(super) r#move?: usize,
        /// The line of the program that states the move, from 1; absent for points.
        pub(super) line?: u32,
    }
}

/// What is wrong at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = PathPlaceCode)]
pub(super) enum PlaceCode {
    /// A rapid move cuts the part.
    Collision,
    /// A move at the feed rate cuts the part.
    Gouge,
    /// More than the tolerance is left where the cutter can reach.
    OverTolerance,
    /// Tooth marks leave more than the tolerance where the path itself does not: the feed of the move is too high.
    FeedTooHigh,
    /// No move comes over a place that the cutter can reach.
    Uncut,
    /// The first move of a tool with a feed rate over the machine's or the cutter's limit; the machine's is kept. The place is
    /// the end of the move.
    FeedOverLimit,
}

impl From<FindingKind> for PlaceCode {
    fn from(kind: FindingKind) -> Self {
        match kind {
            FindingKind::Collision => Self::Collision,
            FindingKind::Gouge => Self::Gouge,
            FindingKind::OverTolerance => Self::OverTolerance,
            FindingKind::FeedTooHigh => Self::FeedTooHigh,
            FindingKind::Uncut => Self::Uncut,
        }
    }
}

impl PlaceAnswer {
    pub(super) fn of(finding: &Finding, milled: &Milled, path: &PathMoves<'_>) -> Self {
        let Finding { kind, place, left } = finding;
        let nearest = if *kind == FindingKind::OverTolerance { milled.nearest_at(place.point, place.normal) } else { None };
        let by = nearest.or(left.map(|left| left.by)).map(|by| by as usize);
        Self {
            code: (*kind).into(),
            point_mm: place.point,
            value_mm: left.map(|left| left.height),
            r#move: by,
            line: by.and_then(|by| path.line_of(by)),
        }
    }

    /// The end of a move with a feed rate over a limit.
    pub(super) fn over_limit(at: usize, path: &PathMoves<'_>) -> Self {
        Self { code: PlaceCode::FeedOverLimit, point_mm: path.moves[at].to, value_mm: None, r#move: Some(at), line: path.line_of(at) }
    }
}
