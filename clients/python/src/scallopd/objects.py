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
    "ProfileArc",
    "Roughness",
    "Vector",
]

Model = Literal["analytic", "envelope"]
Vector = Sequence[float]
AnswerColumn = List[Optional[float]]
CutterType = Literal["toroidal", "bull_nose", "ball_end", "flat_end", "tapered_ball", "lens", "oval", "conical_barrel", "profile"]


# Requests


class ProfileArc(TypedDict):
    """An arc of a cutter's lower profile. The angles are those of the outward normal, 0 straight down and 90 horizontal."""

    radius_mm: float
    centre_offset_mm: float
    centre_height_mm: float
    from_deg: float
    to_deg: float


class _CutterShape(TypedDict):
    type: CutterType


class Cutter(_CutterShape, total=False):
    """A cutter with the dimensions of its type:

    - `toroidal` (`bull_nose` is the same): `diameter_mm`, `corner_radius_mm`; `ball_end` and `flat_end`: `diameter_mm`;
    - `tapered_ball`: `diameter_mm` of the ball, `taper_deg` (half the angle of the cone), `shank_diameter_mm`;
    - `lens`: `diameter_mm`, `lens_radius_mm`, `corner_radius_mm`;
    - `oval`: `diameter_mm`, `tip_radius_mm`, `side_radius_mm`; `conical_barrel`: the same and `taper_deg`;
    - `profile`: `arcs`, from the axis outwards.
    """

    diameter_mm: float
    corner_radius_mm: float
    taper_deg: float
    shank_diameter_mm: float
    lens_radius_mm: float
    tip_radius_mm: float
    side_radius_mm: float
    arcs: Sequence[ProfileArc]
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
    path_tolerance_mm: float
    time_factor: float
    tool_change_s: float


class Roughness(TypedDict, total=False):
    """The roughness of a drawing in place of a scallop height: `ra_um` or `rz_um`, and how much rougher the real surface is."""

    ra_um: float
    rz_um: float
    allowance: float


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
