"""Calculations at one contact and, as batches, at many: the methods and the objects that only they use.

Columns are written as `Sequence` in requests: lists, tuples, `array.array`, numpy arrays and other buffers are accepted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, TypedDict, Union, cast

from .endpoints import Endpoints, parameters_in_help
from .objects import AnswerColumn, Contact, Curvature, Cutter, Model, PrincipalCurvature, Roughness, Vector, Warning

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "BatchContact",
    "BatchFailure",
    "Calculations",
    "Check",
    "Column",
    "ContactColumns",
    "Contacts",
    "CurvatureColumns",
    "CuttingBatchLimits",
    "CuttingColumns",
    "CuttingLimits",
    "CuttingParameters",
    "FeedBatchParameters",
    "FeedColumns",
    "FeedParameters",
    "HeightBatchParameters",
    "HeightColumns",
    "HeightParameters",
    "MaxFeed",
    "Runout",
    "ScallopHeight",
    "SharedParameters",
    "StepOver",
    "StepOverBatchParameters",
    "StepOverParameters",
]

Column = Sequence[Optional[float]]


# Every calculation


class Runout(TypedDict, total=False):
    """Runout of the cutter."""

    radial_mm: float
    axial_mm: float


class SharedParameters(TypedDict, total=False):
    """Parameters of every calculation."""

    surface_radius_mm: float
    surface_curvature: Union[Curvature, PrincipalCurvature]
    runout: Runout
    model: Model


# Every batch


class BatchContact(Contact, total=False):
    """A contact of a batch, with its own parameters in place of the shared ones."""

    step_over_mm: float
    step_over_xy_mm: float
    feed_per_tooth_mm: float
    surface_radius_mm: float
    surface_curvature: Union[Curvature, PrincipalCurvature]


class CurvatureColumns(TypedDict, total=False):
    """Curvatures of many contacts."""

    along_per_mm: Column
    across_per_mm: Column
    twist_per_mm: Column


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


class _BatchForm(TypedDict, total=False):
    columns: Sequence[str]
    significant_digits: int


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


# Scallop height


class HeightParameters(SharedParameters, total=False):
    """Parameters of `scallop_height`: one of the two step-overs, and the feed."""

    step_over_mm: float
    step_over_xy_mm: float
    feed_per_tooth_mm: float


class HeightBatchParameters(HeightParameters, _BatchForm, total=False):
    """Parameters of `scallop_height_batch`."""


class Check(TypedDict):
    """The comparison of the model's height with that of the cutter's exact shape."""

    envelope_scallop_height_mm: float
    deviation: float


class _Heights(TypedDict):
    model: Model
    scallop_height_mm: float
    ra_um: float
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


class HeightColumns(_Batch, total=False):
    """Answer of a batch: the selected columns, None for a contact without an answer."""

    scallop_height_mm: AnswerColumn
    ra_um: AnswerColumn
    step_over_height_mm: AnswerColumn
    feed_height_mm: AnswerColumn
    feed_share: AnswerColumn
    effective_radius_mm: AnswerColumn
    transverse_effective_radius_mm: AnswerColumn
    step_over_mm: AnswerColumn
    step_over_xy_mm: AnswerColumn
    envelope_scallop_height_mm: AnswerColumn
    deviation: AnswerColumn


# Feed


class FeedParameters(SharedParameters, total=False):
    """Parameters of `max_feed` beside the tolerance: one of the two step-overs, and limits of the feed."""

    roughness: Roughness
    step_over_mm: float
    step_over_xy_mm: float
    spindle_speed_rpm: float
    max_feed_per_tooth_mm: float
    max_feed_rate_mm_min: float


class FeedBatchParameters(FeedParameters, _BatchForm, total=False):
    """Parameters of `max_feed_batch`."""


class _FeedAnswer(ScallopHeight):
    feed_per_tooth_mm: float
    limited_by: str


class MaxFeed(_FeedAnswer, total=False):
    """Answer of `max_feed`; the rate where teeth and spindle speed are known."""

    feed_rate_mm_min: float


class FeedColumns(HeightColumns, total=False):
    """Answer of `max_feed_batch`."""

    feed_per_tooth_mm: AnswerColumn
    feed_rate_mm_min: AnswerColumn
    limited_by: List[Optional[str]]


# Step-over


class StepOverParameters(SharedParameters, total=False):
    """Parameters of `step_over` beside the tolerance."""

    roughness: Roughness
    feed_per_tooth_mm: float


class StepOverBatchParameters(StepOverParameters, _BatchForm, total=False):
    """Parameters of `step_over_batch`."""


class StepOver(ScallopHeight):
    """Answer of `step_over`: the largest step-over, and the heights there."""


# Step-over and feed together


class CuttingLimits(SharedParameters, total=False):
    """Parameters of `cutting_parameters` beside the tolerance."""

    roughness: Roughness
    spindle_speed_rpm: float
    max_feed_per_tooth_mm: float
    max_feed_rate_mm_min: float
    min_step_over_mm: float
    max_step_over_mm: float


class CuttingBatchLimits(CuttingLimits, _BatchForm, total=False):
    """Parameters of `cutting_parameters_batch`."""


class _CuttingAnswer(ScallopHeight):
    feed_per_tooth_mm: float
    limited_by: List[str]


class CuttingParameters(_CuttingAnswer, total=False):
    """Answer of `cutting_parameters`."""

    feed_rate_mm_min: float
    area_rate_mm2_min: float


class CuttingColumns(HeightColumns, total=False):
    """Answer of `cutting_parameters_batch`."""

    feed_per_tooth_mm: AnswerColumn
    feed_rate_mm_min: AnswerColumn
    area_rate_mm2_min: AnswerColumn
    limited_by: List[Optional[List[str]]]


@parameters_in_help
class Calculations(Endpoints):
    """Scallop heights, and the feeds and step-overs under a tolerance."""

    def scallop_height(self, cutter: Cutter, contact: Contact, **parameters: Unpack[HeightParameters]) -> ScallopHeight:
        """The scallop height that a step-over and a feed leave."""
        return cast(ScallopHeight, self._post("scallop-height", {"cutter": cutter, "contact": contact, **parameters}))

    def scallop_height_batch(self, cutter: Cutter, contacts: Contacts, **parameters: Unpack[HeightBatchParameters]) -> HeightColumns:
        """`scallop_height` for many contacts, given as rows or as columns. The answer is columns in the same order."""
        return cast(HeightColumns, self._post_batch("scallop-height/batch", {"cutter": cutter, **parameters, "contacts": contacts}))

    def max_feed(
        self, cutter: Cutter, contact: Contact, scallop_tolerance_mm: Optional[float] = None, **parameters: Unpack[FeedParameters]
    ) -> MaxFeed:
        """The largest feed under a tolerance. Raises `ToleranceExceeded` where the step-over alone uses it up."""
        body = {"cutter": cutter, "contact": contact, "scallop_tolerance_mm": scallop_tolerance_mm, **parameters}
        return cast(MaxFeed, self._post("max-feed", body))

    def max_feed_batch(
        self, cutter: Cutter, contacts: Contacts, scallop_tolerance_mm: Optional[float] = None, **parameters: Unpack[FeedBatchParameters]
    ) -> FeedColumns:
        """`max_feed` for many contacts."""
        body = {"cutter": cutter, "scallop_tolerance_mm": scallop_tolerance_mm, **parameters, "contacts": contacts}
        return cast(FeedColumns, self._post_batch("max-feed/batch", body))

    def step_over(
        self, cutter: Cutter, contact: Contact, scallop_tolerance_mm: Optional[float] = None, **parameters: Unpack[StepOverParameters]
    ) -> StepOver:
        """The largest step-over under a tolerance."""
        body = {"cutter": cutter, "contact": contact, "scallop_tolerance_mm": scallop_tolerance_mm, **parameters}
        return cast(StepOver, self._post("step-over", body))

    def step_over_batch(
        self,
        cutter: Cutter,
        contacts: Contacts,
        scallop_tolerance_mm: Optional[float] = None,
        **parameters: Unpack[StepOverBatchParameters],
    ) -> HeightColumns:
        """`step_over` for many contacts."""
        body = {"cutter": cutter, "scallop_tolerance_mm": scallop_tolerance_mm, **parameters, "contacts": contacts}
        return cast(HeightColumns, self._post_batch("step-over/batch", body))

    def cutting_parameters(
        self, cutter: Cutter, contact: Contact, scallop_tolerance_mm: Optional[float] = None, **limits: Unpack[CuttingLimits]
    ) -> CuttingParameters:
        """The step-over and feed per tooth that finish the most area per time under a tolerance."""
        body = {"cutter": cutter, "contact": contact, "scallop_tolerance_mm": scallop_tolerance_mm, **limits}
        return cast(CuttingParameters, self._post("cutting-parameters", body))

    def cutting_parameters_batch(
        self, cutter: Cutter, contacts: Contacts, scallop_tolerance_mm: Optional[float] = None, **limits: Unpack[CuttingBatchLimits]
    ) -> CuttingColumns:
        """`cutting_parameters` for many contacts."""
        body = {"cutter": cutter, "scallop_tolerance_mm": scallop_tolerance_mm, **limits, "contacts": contacts}
        return cast(CuttingColumns, self._post_batch("cutting-parameters/batch", body))
