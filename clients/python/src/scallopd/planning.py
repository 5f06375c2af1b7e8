"""Comparisons of cutters on a surface: the methods and the objects that only they use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Literal, Mapping, Optional, Sequence, TypedDict, Union, cast

from .endpoints import Endpoints, parameters_in_help
from .multipart import File, Source
from .objects import AnswerColumn, Cutter, CutterType, Machine, Model, NotRanked, Roughness, Vector, Warning

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "About",
    "Candidate",
    "CriticalSlope",
    "CriticalSlopeParameters",
    "CutterMap",
    "LibraryFilter",
    "MachinePreset",
    "Mesh",
    "Operation",
    "Operations",
    "OperationsPlan",
    "Passes",
    "PathCheck",
    "PathCheckParameters",
    "PathFeeds",
    "PathPlace",
    "StatedPath",
    "Plan",
    "Planning",
    "ProgramOptions",
    "Recommendation",
    "RecommendationParameters",
    "Recommended",
    "RestOf",
    "Selection",
    "Surface",
]


# Critical slope


class CriticalSlopeParameters(TypedDict, total=False):
    """Parameters of `critical_slope` beside the cutters: the rectangle by its sides or by its form factor and size."""

    width_mm: float
    height_mm: float
    form_factor: float
    characteristic_size_mm2: float
    slope_deg: float
    model: Model
    roughness: Roughness
    scallop_height_mm: float  # The older name of the tolerance.


class CriticalSlope(TypedDict, total=False):
    """Answer of `critical_slope`. `always_faster` names the cutter that is faster on every slope, where there is one; with `slope_deg`
    come the two candidates, the recommended one and the critical form factor."""

    form_factor: float
    characteristic_size_mm2: float
    critical_slope_deg: float
    always_faster: Literal["toroidal", "ball_end"]
    critical_form_factor: float
    recommended: Dict[str, Any]
    candidates: List[Dict[str, Any]]
    warnings: List[Warning]


# Machines


class MachinePreset(TypedDict):
    """A machine that a request can name."""

    name: str
    description: str
    feed_rate_mm_min: float
    acceleration_m_s2: float
    jerk_m_s3: float
    usual_path_tolerance_mm: float
    source: str


# Recommendation


class Candidate(Cutter, total=False):
    """A cutter that a recommendation compares. With `teeth` and `spindle_speed_rpm` the tolerance covers the tooth marks too."""

    name: str
    spindle_speed_rpm: float
    max_feed_per_tooth_mm: float
    flute_length_mm: float


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


class Selection(TypedDict, total=False):
    """The facets to machine: those that meet every stated condition."""

    slope_deg: Sequence[float]
    box_mm: Mapping[str, Vector]
    pieces: Sequence[int]
    facets: Sequence[Sequence[int]]


class LibraryFilter(TypedDict, total=False):
    """The cutters of tool libraries that join those of the request: those that meet every stated condition."""

    diameter_mm: Sequence[float]
    types: Sequence[Literal["toroidal", "bull_nose", "ball_end", "flat_end"]]
    numbers: Sequence[int]


class ProgramOptions(TypedDict, total=False):
    """How the program of `include` is written."""

    dialect: Literal["iso", "klartext"]
    unit: Literal["mm", "inch"]
    number_lines: bool
    decimals: int
    header: Sequence[str]
    footer: Sequence[str]
    tool: int
    spindle_speed_rpm: float
    coolant: bool
    tool_length_offset: bool
    origin_mm: Vector


class Operations(TypedDict):
    """How many operations a plan may have: 1 to 3."""

    max: int


class RestOf(TypedDict):
    """A cutter that has machined everything before: only what it could not reach is machined."""

    cutter: Cutter


class RecommendationParameters(TypedDict, total=False):
    """Parameters of a recommendation beside the surface, cutters, tolerance and machine."""

    roughness: Roughness
    scallop_height_mm: float  # The older name of the tolerance.
    pattern: Literal["zigzag", "one_way"]
    library_filter: LibraryFilter
    max_slope_deg: float
    method: Literal["surface", "rectangle"]
    model: Model
    directions_deg: Sequence[float]
    unit: str
    facing: str
    max_uncut_share: float
    operations: Operations
    rest_of: RestOf
    select: Selection
    avoid: Surface
    include: Sequence[Literal["map", "maps", "passes", "program"]]
    program: ProgramOptions


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
    """A cutter's best plan. Method `rectangle`, and a candidate whose `figures` are `estimated`, lack those of the milled path."""

    cutter: int
    name: str
    preset: str
    type: CutterType
    direction_deg: float
    machining_time_s: float
    feed: Literal["stated", "assumed"]
    figures: Literal["milled", "estimated"]
    passes: float
    path_length_mm: float
    links: Dict[str, float]
    step_over_xy_mm: Dict[str, float]
    feed_rate_mm_min: float
    feed_per_tooth_mm: float
    scallop_height_mm: Dict[str, float]
    ra_um: float
    over_tolerance_share: float
    uncut_share: float
    uncut_height_mm: float
    gouge_mm: float
    used_share: float
    layout_ratio: float
    least_time_s: float
    by_direction: Dict[str, List[float]]
    rectangle: Dict[str, float]


class Operation(TypedDict, total=False):
    """One operation of a plan; `step_down_mm` in place of `step_over_xy_mm` for waterlines."""

    cutter: int
    name: str
    family: Literal["zigzag", "one_way", "waterline"]
    direction_deg: float
    region: Dict[str, Any]
    machining_time_s: float
    passes: int
    path_length_mm: float
    step_over_xy_mm: Dict[str, float]
    step_down_mm: Dict[str, float]
    feed_rate_mm_min: float
    links: Dict[str, float]
    scallop_height_mm: Dict[str, float]
    over_tolerance_share: float
    gouge_mm: float


class OperationsPlan(TypedDict):
    """The fastest plan of the allowed number of operations, with the figures of all together."""

    machining_time_s: float
    tool_changes: int
    operations: List[Operation]
    scallop_height_mm: Dict[str, float]
    over_tolerance_share: float
    uncut_share: float
    gouge_mm: float
    used_share: float


class Passes(TypedDict, total=False):
    """The passes point by point, in cutting order; a run begins at each index of `run_starts`. `move` is
    how the tool gets to a point; `contact_mm` is None on links, on rapid moves, over gaps and beyond borders."""

    run_starts: List[int]
    operation: List[int]
    move: List[Literal["cut", "link", "rapid"]]
    contact_mm: List[Optional[List[float]]]
    normal: List[Optional[List[float]]]
    tip_mm: List[List[float]]
    step_over_mm: AnswerColumn
    feed_per_tooth_mm: AnswerColumn
    feed_rate_mm_min: AnswerColumn
    scallop_height_mm: AnswerColumn
    surface_curvature: Dict[str, AnswerColumn]


class CutterMap(TypedDict):
    """Where one cutter does not fit, on the cells of `map`: how high it stands over its contact there."""

    cutter: int
    uncut_mm: AnswerColumn


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
    """Answer of a recommendation; `map`, `maps`, `passes` and `program` where `include` asks for them."""

    critical_slope_deg: float
    always_faster: Literal["toroidal", "ball_end"]
    critical_form_factor: float
    rest_area_share: float
    plan: OperationsPlan
    map: Dict[str, Any]
    maps: List[CutterMap]
    passes: Passes
    program: Dict[str, str]


# Paths that exist


class StatedPath(TypedDict, total=False):
    """A path: the text of a `program`, the `passes` of an answer, or the points `tip_mm`, of which those with an index in `rapid` are
    reached by a rapid move."""

    program: str
    passes: Passes
    tip_mm: Sequence[Vector]
    rapid: Sequence[int]
    feed_rate_mm_min: Union[float, Sequence[float]]


class PathCheckParameters(TypedDict, total=False):
    """Parameters of a check beside the surface, the path, the cutter, the tolerance and the machine. `cutters`, by T numbers, is in place
    of a cutter, which is then None; `roughness` in place of the tolerance."""

    cutters: Mapping[str, Candidate]
    roughness: Roughness
    scallop_height_mm: float  # The older name of the tolerance.
    include: Sequence[Literal["map", "places", "feeds", "program"]]
    old_feeds_in_comments: bool
    tip: Literal["lowest_point", "centre"]
    origin_mm: Vector
    max_slope_deg: float
    unit: str
    facing: str
    select: Selection
    avoid: Surface


class PathPlace(TypedDict, total=False):
    """A place where a path leaves too much or cuts too deep; `move` and `line` are absent where no move comes over it."""

    code: Literal["collision", "gouge", "over-tolerance", "feed-too-high", "uncut", "feed-over-limit"]
    point_mm: List[float]
    value_mm: float
    move: int
    line: int


class PathFeeds(TypedDict, total=False):
    """The largest feeds that keep the tolerance, for each point of a path; None at points that no move at the feed rate leads to."""

    feed_per_tooth_mm: List[Optional[float]]
    feed_rate_mm_min: List[Optional[float]]
    line: List[int]
    machining_time_s: float
    never_kept_share: float


class PathCheck(TypedDict, total=False):
    """What a path leaves on a surface; `map`, `places`, `feeds` and `program` where `include` asks for them, `places` also without it."""

    moves: int
    cutting_length_mm: float
    rapid_length_mm: float
    machining_time_s: float
    residual_mm: Dict[str, float]
    over_tolerance_share: float
    reachable_over_tolerance_share: float
    uncut_share: float
    used_share: float
    gouge: Dict[str, float]
    standard_error: Dict[str, float]
    ra_um: float
    scallop_height_with_marks_mm: Dict[str, float]
    idle_length_mm: float
    places: List[PathPlace]
    map: Dict[str, Any]
    feeds: PathFeeds
    program: Dict[str, str]
    confidence: Dict[str, Any]
    warnings: List[Warning]


class About(TypedDict):
    """The service's version, its limits in force, and what it reads."""

    version: str
    limits: Dict[str, int]
    surface_formats: List[str]
    path_formats: List[str]
    tool_library_formats: List[str]
    presets: List[str]
    models: List[str]
    methods: List[str]


@parameters_in_help
class Planning(Endpoints):
    """Recommendations of cutters, the inclined rectangle and the machines."""

    def critical_slope(
        self,
        toroidal: Mapping[str, float],
        ball_end: Mapping[str, float],
        scallop_tolerance_mm: Optional[float] = None,
        machine: Union[str, Machine, None] = None,
        **rectangle: Unpack[CriticalSlopeParameters],
    ) -> CriticalSlope:
        """The slope of an inclined rectangle up to which the toroidal cutter is the faster one."""
        body = {"toroidal": toroidal, "ball_end": ball_end, "scallop_tolerance_mm": scallop_tolerance_mm, "machine": _machine(machine)}
        return cast(CriticalSlope, self._post("critical-slope", {**body, **rectangle}))

    def machines(self) -> List[MachinePreset]:
        """The machines that requests can name."""
        return cast(List[MachinePreset], self._get("machines")["machines"])

    def about(self) -> About:
        """The service's version, its limits in force, and the formats that it reads."""
        return cast(About, self._get("about"))

    def recommend(
        self,
        surface: Surface,
        cutters: Sequence[Candidate],
        scallop_tolerance_mm: Optional[float] = None,
        machine: Union[str, Machine, None] = None,
        **parameters: Unpack[RecommendationParameters],
    ) -> Recommendation:
        """Ranks cutters by the time in which they finish a surface. Raises `NoCutterFits` where none can."""
        body = _recommendation(cutters, scallop_tolerance_mm, machine, cast(Dict[str, Any], parameters))
        return cast(Recommendation, self._post("cutter-recommendation", {**body, "surface": surface}))

    def recommend_file(
        self,
        surface: Union[Source, File],
        cutters: Sequence[Candidate],
        scallop_tolerance_mm: Optional[float] = None,
        machine: Union[str, Machine, None] = None,
        *,
        libraries: Sequence[Union[Source, File]] = (),
        **parameters: Unpack[RecommendationParameters],
    ) -> Recommendation:
        """`recommend` with the surface in a file (STL, OBJ, PLY, 3MF or text), whose bytes are read while they are sent.

        A file is a path, bytes or an open binary file; `File(source, name)` names bytes, because the suffix helps to detect the
        format. The cutters of `libraries` (Fusion, FreeCAD or CSV) join `cutters`. A file that cannot be read twice, such as a
        pipe, is sent once: the call is then not repeated.
        """
        body = _recommendation(cutters, scallop_tolerance_mm, machine, cast(Dict[str, Any], parameters))
        files = [("surface", surface), *(("library", library) for library in libraries)]
        return cast(Recommendation, self._upload("cutter-recommendation/upload", body, files))

    def check_path(
        self,
        surface: Surface,
        path: StatedPath,
        cutter: Optional[Candidate],
        scallop_tolerance_mm: Optional[float] = None,
        machine: Union[str, Machine, None] = None,
        **parameters: Unpack[PathCheckParameters],
    ) -> PathCheck:
        """What a path leaves on a surface, where it cuts into the part, and how long it takes."""
        body = {
            "cutter": cutter,
            "scallop_tolerance_mm": scallop_tolerance_mm,
            "machine": _machine(machine),
            **cast(Dict[str, Any], parameters),
        }
        return cast(PathCheck, self._post("path-check", {**body, "surface": surface, "path": path}))

    def check_path_file(
        self,
        surface: Union[Source, File],
        path: Union[Source, File],
        cutter: Optional[Candidate],
        scallop_tolerance_mm: Optional[float] = None,
        machine: Union[str, Machine, None] = None,
        **parameters: Unpack[PathCheckParameters],
    ) -> PathCheck:
        """`check_path` with the surface and the program in files."""
        body = {
            "cutter": cutter,
            "scallop_tolerance_mm": scallop_tolerance_mm,
            "machine": _machine(machine),
            **cast(Dict[str, Any], parameters),
        }
        return cast(PathCheck, self._upload("path-check/upload", body, [("surface", surface), ("path", path)]))


def _machine(machine: Union[str, Machine, None]) -> Optional[Machine]:
    return {"preset": machine} if isinstance(machine, str) else machine


def _recommendation(
    cutters: Sequence[Candidate], scallop_tolerance_mm: Optional[float], machine: Union[str, Machine, None], parameters: Dict[str, Any]
) -> Dict[str, Any]:
    return {
        # An upload may take all its cutters from libraries.
        "cutters": cutters if len(cutters) > 0 else None,
        "scallop_tolerance_mm": scallop_tolerance_mm,
        "machine": _machine(machine),
        **parameters,
    }
