"""The JSON objects that requests or answers of several endpoints have in common, as typed dictionaries. Their names and units are
those of the HTTP API. The objects of one endpoint or of a family of endpoints are beside its methods.
"""

from __future__ import annotations

from typing import List, Literal, Optional, Sequence, TypedDict

# `Warning` is not listed: it would hide the built-in exception where the names are imported with a star.
__all__ = [
    "AnswerColumn",
    "Contact",
    "Curvature",
    "Cutter",
    "CutterType",
    "Machine",
    "Model",
    "NotRanked",
    "PrincipalCurvature",
    "Vector",
]

Model = Literal["analytic", "envelope"]
Vector = Sequence[float]
AnswerColumn = List[Optional[float]]
CutterType = Literal["toroidal", "bull_nose", "ball_end", "flat_end"]


# Requests


class _CutterShape(TypedDict):
    type: CutterType
    diameter_mm: float


class Cutter(_CutterShape, total=False):
    """A cutter. `corner_radius_mm` belongs to the toroidal one (also called bull-nose) and lies between 0 and the radius."""

    corner_radius_mm: float
    teeth: int


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


class Contact(TypedDict, total=False):
    """A contact: `slope_deg` with `feed_angle_deg`, or `normal` with `feed` and, for a tilted tool, `tool_axis`."""

    slope_deg: float
    feed_angle_deg: float
    normal: Vector
    feed: Vector
    tool_axis: Vector


class Machine(TypedDict, total=False):
    """A machine: a preset's name, values, or both; values override the preset's."""

    preset: str
    feed_rate_mm_min: float
    acceleration_m_s2: float
    jerk_m_s3: float
    rapid_rate_mm_min: float
    max_spindle_speed_rpm: float
    clearance_height_mm: float


# Answers


class _WarningText(TypedDict):
    code: str
    detail: str


class Warning(_WarningText, total=False):
    """A fact about an answer that needs attention; in a batch with the number of contacts."""

    contacts: int
    first_index: int


class NotRanked(TypedDict, total=False):
    """A cutter that is not ranked, and the reason."""

    cutter: int
    name: str
    code: str
    detail: str
    uncut_share: float
    uncut_height_mm: float
