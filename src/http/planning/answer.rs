//! The answer of a cutter recommendation.

use super::candidates::{CandidateAnswer, ComparedCutter, Recommended, always_faster, candidates, line_degrees};
use crate::http::codes::ConfidenceCode;
use crate::http::wire::{Source, Sourced, Warning};
use crate::planning::{Confidence, Level, Reason, Recommendation};
use crate::quantity::{Angle, Area};
use crate::surface::{Basis, Bounds, Shape};
use serde::Serialize;
use utoipa::ToSchema;

/// Which cutter finishes the surface sooner, how, and how far to trust it.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct RecommendationAnswer {
    /// The faster cutter, in its direction.
    recommended: Recommended,
    /// The slope below which the toroidal cutter is faster on a surface of this form. 90 where it is faster on every slope, 0 where the
    /// ball-end cutter is; `always_faster` names it then.
    #[schema(minimum = 0, maximum = 90)]
    critical_slope_deg: f64,
    /// The cutter that is faster on every slope; absent where there is a critical slope.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    always_faster: Option<ComparedCutter>,
    /// The form factor below which the toroidal cutter is faster on a surface of this size and slope; 1 where the ball-end cutter is faster
    /// even on a square.
    #[schema(minimum = 1)]
    critical_form_factor: f64,
    /// The surface's shape.
    surface: SurfaceAnswer,
    /// Both cutters, the toroidal one first.
    #[schema(min_items = 2, max_items = 2)]
    candidates: Vec<CandidateAnswer>,
    /// How far to trust the recommendation.
    confidence: ConfidenceAnswer,
    /// What must be looked at.
    warnings: Vec<Warning>,
}

/// The shape of a surface. Directions are lines seen from above, from +X counter-clockwise, in [0, 180).
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = SurfaceShape)]
struct SurfaceAnswer {
    /// In which form the surface was sent; of a file, the format that its content showed.
    source: Source,
    /// How many points the shape was taken of; 0 where it was taken of facets.
    points: u64,
    /// How many facets the shape was taken of.
    facets: u64,
    /// The angle between the plane that fits best and the horizontal.
    #[schema(minimum = 0, maximum = 90)]
    slope_deg: f64,
    /// The mean of the slopes of all facets or samples. Only where facets or a patch have slopes.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, maximum = 90)]
    mean_slope_deg: Option<f64>,
    /// mu, the long side over the short side of the rectangle that spreads as much.
    #[schema(minimum = 1)]
    form_factor: f64,
    /// chi, the area of that rectangle.
    #[schema(minimum = 0)]
    characteristic_size_mm2: f64,
    /// Along which the surface spreads most. Absent where it spreads as much in every direction, or most along the vertical.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, exclusive_maximum = 180)]
    principal_direction_deg: Option<f64>,
    /// The steepest direction of the plane that fits best. Absent where that is level.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, exclusive_maximum = 180)]
    steepest_direction_deg: Option<f64>,
    /// The angle between these two directions; the method takes it for 90. Absent where one of them is.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, maximum = 90)]
    direction_gap_deg: Option<f64>,
    /// sqrt(l3/l1) of the eigenvalues: 0 for a plane.
    #[schema(minimum = 0, maximum = 1)]
    flatness: f64,
    /// The eigenvalues l1 >= l2 >= l3 of the covariance matrix.
    #[schema(min_items = 3, max_items = 3)]
    eigenvalues_mm2: [f64; 3],
    /// The centroid [x, y, z].
    #[schema(min_items = 3, max_items = 3)]
    centroid_mm: [f64; 3],
    /// The box around what the shape was taken of.
    bounds_mm: BoundsAnswer,
    /// The area. Only where facets or a patch have one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    area_mm2: Option<f64>,
}

/// A box with sides along the axes.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Bounds)]
struct BoundsAnswer {
    /// The smallest x, y and z.
    #[schema(min_items = 3, max_items = 3)]
    min: [f64; 3],
    /// The largest x, y and z.
    #[schema(min_items = 3, max_items = 3)]
    max: [f64; 3],
}

/// How far to trust a recommendation.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Confidence)]
struct ConfidenceAnswer {
    /// `high`: the surface is of the kind for which the method was built; `moderate`: times and critical slope are estimates; `low`: the
    /// recommendation may be wrong, so simulate both candidates.
    level: LevelName,
    /// What keeps the level from being high, the gravest first.
    reasons: Vec<ReasonAnswer>,
}

/// A level of confidence.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ConfidenceLevel)]
enum LevelName {
    High,
    Moderate,
    Low,
}

/// A weakness of the method that this surface touches.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = ConfidenceReason)]
struct ReasonAnswer {
    code: ConfidenceCode,
    /// To which level it lowers the confidence.
    level: LevelName,
    /// What it is about, for a person.
    detail: String,
    /// The figure that shows it, in the unit that `detail` names.
    value: f64,
    /// The threshold that the figure crossed, in the same unit.
    threshold: f64,
}

impl RecommendationAnswer {
    pub(super) fn new(recommendation: &Recommendation, shape: &Shape, sourced: &Sourced) -> Self {
        let plan = &recommendation.plan;
        Self {
            recommended: plan.recommended().into(),
            critical_slope_deg: plan.critical_slope.angle().degrees(),
            always_faster: always_faster(plan.critical_slope),
            critical_form_factor: plan.critical_form_factor.form_factor().ratio(),
            surface: SurfaceAnswer::new(shape, sourced.source),
            candidates: candidates(plan),
            confidence: (&recommendation.confidence).into(),
            warnings: sourced.warnings(shape),
        }
    }
}

impl SurfaceAnswer {
    fn new(shape: &Shape, source: Source) -> Self {
        let (points, facets) = if shape.basis == Basis::Points { (shape.elements, 0) } else { (0, shape.elements) };
        Self {
            source,
            points,
            facets,
            slope_deg: shape.slope.degrees(),
            mean_slope_deg: shape.mean_slope.map(Angle::degrees),
            form_factor: shape.form_factor.ratio(),
            characteristic_size_mm2: shape.characteristic_size.mm2(),
            principal_direction_deg: shape.principal_direction.map(line_degrees),
            steepest_direction_deg: shape.steepest_direction.map(line_degrees),
            direction_gap_deg: shape.direction_gap.map(Angle::degrees),
            flatness: shape.flatness,
            eigenvalues_mm2: shape.eigenvalues.map(Area::mm2),
            centroid_mm: shape.centroid,
            bounds_mm: shape.bounds.into(),
            area_mm2: shape.area.map(Area::mm2),
        }
    }
}

impl From<Bounds> for BoundsAnswer {
    fn from(bounds: Bounds) -> Self {
        Self { min: bounds.min, max: bounds.max }
    }
}

impl From<&Confidence> for ConfidenceAnswer {
    fn from(confidence: &Confidence) -> Self {
        Self { level: confidence.level().into(), reasons: confidence.reasons().iter().map(ReasonAnswer::from).collect() }
    }
}

impl From<Level> for LevelName {
    fn from(level: Level) -> Self {
        match level {
            Level::High => Self::High,
            Level::Moderate => Self::Moderate,
            Level::Low => Self::Low,
        }
    }
}

impl From<&Reason> for ReasonAnswer {
    fn from(reason: &Reason) -> Self {
        Self {
            code: reason.weakness.into(),
            level: reason.level.into(),
            detail: reason.to_string(),
            value: reason.figure,
            threshold: reason.threshold,
        }
    }
}
