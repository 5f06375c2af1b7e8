"""The JSON objects of requests and answers, as typed dictionaries. Their names and units are those of the HTTP API.

Columns are written as `Sequence` in requests: lists, tuples, `array.array`, numpy arrays and other buffers are accepted.
"""

from __future__ import annotations

from typing import Any, Dict, List, Literal, Mapping, Optional, Sequence, TypedDict, Union

Model = Literal["analytic", "envelope"]
Vector = Sequence[float]
Column = Sequence[Optional[float]]
CutterType = Literal["toroidal", "bull_nose", "ball_end", "flat_end"]


# Requests


class _CutterShape(TypedDict):
    type: CutterType
    diameter_mm: float


class Cutter(_CutterShape, total=False):
    """A cutter. `corner_radius_mm` belongs to the toroidal one (also called bull-nose) and lies between 0 and the radius."""

    corner_radius_mm: float
    teeth: int


class Candidate(Cutter, total=False):
    """A cutter that a recommendation compares. With `teeth` and `spindle_speed_rpm` the tolerance covers the tooth marks too."""

    name: str
    spindle_speed_rpm: float
    max_feed_per_tooth_mm: float
    flute_length_mm: float


class Curvature(TypedDict, total=False):
    """Curvature of the surface in the axes of the feed, 1/radius, positive where convex; `across` points to the left of the
    feed seen from outside the part."""

    along_per_mm: float
    across_per_mm: float
    twist_per_mm: float


class PrincipalCurvature(TypedDict):
    """Curvature by its principal values; the angle runs from the feed to the first direction, counter-clockwise seen from outside."""

    principal_per_mm: Sequence[float]
    angle_deg: float


class CurvatureColumns(TypedDict, total=False):
    """Curvatures of many contacts."""

    along_per_mm: Column
    across_per_mm: Column
    twist_per_mm: Column


class Contact(TypedDict, total=False):
    """A contact: `slope_deg` with `feed_angle_deg`, or `normal` with `feed` and, for a tilted tool, `tool_axis`."""

    slope_deg: float
    feed_angle_deg: float
    normal: Vector
    feed: Vector
    tool_axis: Vector


class BatchContact(Contact, total=False):
    """A contact of a batch, with its own parameters in place of the shared ones."""

    step_over_mm: float
    step_over_xy_mm: float
    feed_per_tooth_mm: float
    surface_radius_mm: float
    surface_curvature: Union[Curvature, PrincipalCurvature]


class ContactColumns(TypedDict, total=False):
    """The contacts of a batch as columns of one length; None stands for the shared parameter."""

    slope_deg: Sequence[float]
    feed_angle_deg: Sequence[float]
    normal: Sequence[Vector]
    feed: Sequence[Vector]
    tool_axis: Sequence[Vector]
    step_over_mm: Column
    step_over_xy_mm: Column
    feed_per_tooth_mm: Column
    surface_radius_mm: Column
    surface_curvature: CurvatureColumns


Contacts = Union[Sequence[BatchContact], ContactColumns]


class Runout(TypedDict, total=False):
    """Runout of the cutter."""

    radial_mm: float
    axial_mm: float


class Machine(TypedDict, total=False):
    """A machine: a preset's name, values, or both; values override the preset's."""

    preset: str
    feed_rate_mm_min: float
    acceleration_m_s2: float
    jerk_m_s3: float
    rapid_rate_mm_min: float
    max_spindle_speed_rpm: float
    clearance_height_mm: float


class SharedParameters(TypedDict, total=False):
    """Parameters of every calculation."""

    surface_radius_mm: float
    surface_curvature: Union[Curvature, PrincipalCurvature]
    runout: Runout
    model: Model


class HeightParameters(SharedParameters, total=False):
    """Parameters of `scallop_height`: one of the two step-overs, and the feed."""

    step_over_mm: float
    step_over_xy_mm: float
    feed_per_tooth_mm: float


class FeedParameters(SharedParameters, total=False):
    """Parameters of `max_feed` beside the tolerance: one of the two step-overs, and limits of the feed."""

    step_over_mm: float
    step_over_xy_mm: float
    spindle_speed_rpm: float
    max_feed_per_tooth_mm: float
    max_feed_rate_mm_min: float


class StepOverParameters(SharedParameters, total=False):
    """Parameters of `step_over` beside the tolerance."""

    feed_per_tooth_mm: float


class CuttingLimits(SharedParameters, total=False):
    """Parameters of `cutting_parameters` beside the tolerance."""

    spindle_speed_rpm: float
    max_feed_per_tooth_mm: float
    max_feed_rate_mm_min: float
    min_step_over_mm: float
    max_step_over_mm: float


class _BatchForm(TypedDict, total=False):
    columns: Sequence[str]
    significant_digits: int


class HeightBatchParameters(HeightParameters, _BatchForm, total=False):
    """Parameters of `scallop_height_batch`."""


class FeedBatchParameters(FeedParameters, _BatchForm, total=False):
    """Parameters of `max_feed_batch`."""


class StepOverBatchParameters(StepOverParameters, _BatchForm, total=False):
    """Parameters of `step_over_batch`."""


class CuttingBatchLimits(CuttingLimits, _BatchForm, total=False):
    """Parameters of `cutting_parameters_batch`."""


class CriticalSlopeParameters(TypedDict, total=False):
    """Parameters of `critical_slope` beside the cutters: the rectangle by its sides or by its form factor and size."""

    width_mm: float
    height_mm: float
    form_factor: float
    characteristic_size_mm2: float
    slope_deg: float
    model: Model


class Selection(TypedDict, total=False):
    """The facets to machine: those that meet every stated condition."""

    slope_deg: Sequence[float]
    box_mm: Mapping[str, Vector]
    pieces: Sequence[int]


class RecommendationParameters(TypedDict, total=False):
    """Parameters of a recommendation beside the surface, cutters, tolerance and machine."""

    pattern: Literal["zigzag", "one_way"]
    max_slope_deg: float
    method: Literal["surface", "rectangle"]
    model: Model
    directions_deg: Sequence[float]
    unit: str
    facing: str
    max_uncut_share: float
    select: Selection
    include: Sequence[Literal["map", "passes"]]


class Mesh(TypedDict):
    """Triangles, by the indices of their corners."""

    points: Sequence[Vector]
    triangles: Sequence[Sequence[int]]


class Surface(TypedDict, total=False):
    """A surface in one of the service's forms."""

    points: Sequence[Vector]
    grid: Mapping[str, Any]
    mesh: Mesh
    bezier: Mapping[str, Any]
    samples: int


# Answers


class _WarningText(TypedDict):
    code: str
    detail: str


class Warning(_WarningText, total=False):
    """A fact about an answer that needs attention; in a batch with the number of contacts."""

    contacts: int
    first_index: int


class Check(TypedDict):
    """The comparison of the model's height with that of the cutter's exact shape."""

    envelope_scallop_height_mm: float
    deviation: float


class _Heights(TypedDict):
    model: Model
    scallop_height_mm: float
    step_over_height_mm: float
    feed_height_mm: float
    feed_share: float
    effective_radius_mm: Optional[float]
    transverse_effective_radius_mm: Optional[float]
    step_over_mm: float
    step_over_xy_mm: float
    warnings: List[Warning]


class ScallopHeight(_Heights, total=False):
    """Answer of `scallop_height`."""

    check: Check


class StepOver(ScallopHeight):
    """Answer of `step_over`: the largest step-over, and the heights there."""


class _FeedAnswer(ScallopHeight):
    feed_per_tooth_mm: float
    limited_by: str


class MaxFeed(_FeedAnswer, total=False):
    """Answer of `max_feed`; the rate where teeth and spindle speed are known."""

    feed_rate_mm_min: float


class _CuttingAnswer(ScallopHeight):
    feed_per_tooth_mm: float
    limited_by: List[str]


class CuttingParameters(_CuttingAnswer, total=False):
    """Answer of `cutting_parameters`."""

    feed_rate_mm_min: float
    area_rate_mm2_min: float


class BatchFailure(TypedDict):
    """A contact without an answer."""

    index: int
    pointer: str
    code: str
    detail: str


class _Batch(TypedDict):
    model: Model
    summary: Dict[str, Any]
    failures: List[BatchFailure]
    warnings: List[Warning]


AnswerColumn = List[Optional[float]]


class HeightColumns(_Batch, total=False):
    """Answer of a batch: the selected columns, None for a contact without an answer."""

    scallop_height_mm: AnswerColumn
    step_over_height_mm: AnswerColumn
    feed_height_mm: AnswerColumn
    feed_share: AnswerColumn
    effective_radius_mm: AnswerColumn
    transverse_effective_radius_mm: AnswerColumn
    step_over_mm: AnswerColumn
    step_over_xy_mm: AnswerColumn
    envelope_scallop_height_mm: AnswerColumn
    deviation: AnswerColumn


class FeedColumns(HeightColumns, total=False):
    """Answer of `max_feed_batch`."""

    feed_per_tooth_mm: AnswerColumn
    feed_rate_mm_min: AnswerColumn
    limited_by: List[Optional[str]]


class CuttingColumns(HeightColumns, total=False):
    """Answer of `cutting_parameters_batch`."""

    feed_per_tooth_mm: AnswerColumn
    feed_rate_mm_min: AnswerColumn
    area_rate_mm2_min: AnswerColumn
    limited_by: List[Optional[List[str]]]


class CriticalSlope(TypedDict, total=False):
    """Answer of `critical_slope`. `always_faster` names the cutter that is faster on every slope, where there is one; with `slope_deg`
    come the two candidates, the recommended one and the critical form factor."""

    critical_slope_deg: float
    always_faster: Literal["toroidal", "ball_end"]
    critical_form_factor: float
    recommended: Dict[str, Any]
    candidates: List[Dict[str, Any]]
    warnings: List[Warning]


class _MachineValues(TypedDict):
    name: str
    description: str
    feed_rate_mm_min: float
    acceleration_m_s2: float
    jerk_m_s3: float
    source: str


class MachinePreset(_MachineValues, total=False):
    """A machine that a request can name."""

    rapid_rate_mm_min: float
    max_spindle_speed_rpm: float
    clearance_height_mm: float


class Recommended(TypedDict, total=False):
    """The fastest plan; step-over and feed rate are medians."""

    cutter: int
    name: str
    preset: str
    direction_deg: float
    machining_time_s: float
    step_over_xy_mm: float
    feed_rate_mm_min: float


class Plan(TypedDict, total=False):
    """A cutter's best plan. Method `rectangle` lacks the simulation's figures."""

    cutter: int
    name: str
    preset: str
    type: CutterType
    direction_deg: float
    machining_time_s: float
    passes: float
    path_length_mm: float
    links: Dict[str, float]
    step_over_xy_mm: Dict[str, float]
    feed_rate_mm_min: float
    feed_per_tooth_mm: float
    scallop_height_mm: Dict[str, float]
    over_tolerance_share: float
    uncut_share: float
    uncut_height_mm: float
    uncut_height_error_mm: float
    least_time_s: float
    by_direction: Dict[str, List[float]]
    rectangle: Dict[str, float]


class NotRanked(TypedDict, total=False):
    """A cutter that is not ranked, and the reason."""

    cutter: int
    name: str
    code: str
    detail: str
    uncut_share: float
    uncut_height_mm: float
    uncut_height_error_mm: float


class Passes(TypedDict, total=False):
    """The passes point by point, in cutting order; a run begins at each index of `run_starts`. `contact_mm` is None where the
    tip was raised to keep clear of the surface."""

    run_starts: List[int]
    contact_mm: List[Optional[List[float]]]
    normal: List[Optional[List[float]]]
    tip_mm: List[List[float]]
    step_over_mm: AnswerColumn
    feed_per_tooth_mm: AnswerColumn
    feed_rate_mm_min: AnswerColumn
    scallop_height_mm: AnswerColumn
    surface_curvature: Dict[str, AnswerColumn]


class _RecommendationAnswer(TypedDict):
    method: str
    model: Model
    recommended: Recommended
    candidates: List[Plan]
    not_ranked: List[NotRanked]
    surface: Dict[str, Any]
    confidence: Dict[str, Any]
    warnings: List[Warning]


class Recommendation(_RecommendationAnswer, total=False):
    """Answer of a recommendation; `map` and `passes` where `include` asks for them."""

    critical_slope_deg: float
    always_faster: Literal["toroidal", "ball_end"]
    critical_form_factor: float
    map: Dict[str, Any]
    passes: Passes
