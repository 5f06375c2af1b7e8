"""Client of scallopd, the service for scallop heights, feeds, step-overs and cutter recommendations of finish milling.

    import scallopd

    client = scallopd.Client("http://127.0.0.1:8080")
    cutter = {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4}
    answer = client.max_feed(
        cutter, {"slope_deg": 40, "feed_angle_deg": 30}, scallop_tolerance_mm=0.013, step_over_mm=0.687, spindle_speed_rpm=10000
    )
    print(answer["feed_rate_mm_min"])

Needs nothing beside Python 3.9 or later.
"""

from __future__ import annotations

import ssl
from types import TracebackType
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Type, Union, cast

from .errors import ConnectionLost, Fault, InvalidAnswer, NoCutterFits, Problem, ScallopdError, Timeout, ToleranceExceeded
from .multipart import File, Form, Source
from .objects import (
    BatchContact,
    Candidate,
    Contact,
    ContactColumns,
    Contacts,
    CriticalSlope,
    CriticalSlopeParameters,
    Curvature,
    Cutter,
    CuttingBatchLimits,
    CuttingColumns,
    CuttingLimits,
    CuttingParameters,
    FeedBatchParameters,
    FeedColumns,
    FeedParameters,
    HeightBatchParameters,
    HeightColumns,
    HeightParameters,
    Machine,
    MachinePreset,
    MaxFeed,
    NotRanked,
    Passes,
    Plan,
    Recommendation,
    RecommendationParameters,
    ScallopHeight,
    StepOver,
    StepOverBatchParameters,
    StepOverParameters,
    Surface,
)
from .transport import Body, JsonBody, Transport

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "BatchContact",
    "Candidate",
    "Client",
    "ConnectionLost",
    "Contact",
    "ContactColumns",
    "Contacts",
    "CriticalSlope",
    "Curvature",
    "CuttingColumns",
    "CuttingParameters",
    "Cutter",
    "Fault",
    "FeedColumns",
    "File",
    "HeightColumns",
    "InvalidAnswer",
    "Machine",
    "MachinePreset",
    "MaxFeed",
    "NoCutterFits",
    "NotRanked",
    "Passes",
    "Plan",
    "Problem",
    "Recommendation",
    "RecommendationParameters",
    "ScallopHeight",
    "ScallopdError",
    "Source",
    "StepOver",
    "Surface",
    "Timeout",
    "ToleranceExceeded",
]


class Client:
    """Calls one server.

    Threads may share a client: each call under way uses a connection of its own, and idle connections are kept for the next
    calls. A process made by `fork` needs a client of its own.

    A parameter that is None is not sent. Numbers of a batch come from any sequences: lists, tuples, `array.array`, numpy arrays.

    Raises, beside `Problem` for what the service refuses: `Timeout`, `ConnectionLost`, `InvalidAnswer`. All are `ScallopdError`.
    """

    def __init__(
        self,
        base_url: str = "http://127.0.0.1:8080",
        *,
        timeout: float = 75.0,
        retry_for: float = 10.0,
        headers: Optional[Mapping[str, str]] = None,
        ssl_context: Optional[ssl.SSLContext] = None,
    ) -> None:
        """
        `base_url`: the server, with the path under which a proxy offers it, if any.
        `timeout`: seconds that an attempt may take from connecting to the answer's last byte. In an upload each piece of 256 KiB
        has this time to be sent, and the answer has it from the last piece on. The default exceeds the server's own limit of 60
        s, whose answer has more detail.
        `retry_for`: seconds that a call waits, in all, between attempts, when the server is overloaded or restarts. Zero disables
        repeating; connections that broke while idle are always replaced. A call that timed out is not repeated.
        `headers`: sent with every request, such as `authorization` for a proxy.
        """
        self._transport = Transport(base_url, timeout, retry_for, headers or {}, ssl_context)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException], traceback: Optional[TracebackType]) -> None:
        self.close()

    def close(self) -> None:
        """Closes the idle connections. The client stays usable."""
        self._transport.close()

    def scallop_height(self, cutter: Cutter, contact: Contact, **parameters: Unpack[HeightParameters]) -> ScallopHeight:
        """The scallop height that a step-over and a feed leave."""
        return cast(ScallopHeight, self._post("scallop-height", {"cutter": cutter, "contact": contact, **parameters}))

    def max_feed(self, cutter: Cutter, contact: Contact, scallop_tolerance_mm: float, **parameters: Unpack[FeedParameters]) -> MaxFeed:
        """The largest feed under a tolerance. Raises `ToleranceExceeded` where the step-over alone uses it up."""
        body = {"cutter": cutter, "contact": contact, "scallop_tolerance_mm": scallop_tolerance_mm, **parameters}
        return cast(MaxFeed, self._post("max-feed", body))

    def step_over(
        self, cutter: Cutter, contact: Contact, scallop_tolerance_mm: float, **parameters: Unpack[StepOverParameters]
    ) -> StepOver:
        """The largest step-over under a tolerance."""
        body = {"cutter": cutter, "contact": contact, "scallop_tolerance_mm": scallop_tolerance_mm, **parameters}
        return cast(StepOver, self._post("step-over", body))

    def cutting_parameters(
        self, cutter: Cutter, contact: Contact, scallop_tolerance_mm: float, **limits: Unpack[CuttingLimits]
    ) -> CuttingParameters:
        """The step-over and feed per tooth that finish the most area per time under a tolerance."""
        body = {"cutter": cutter, "contact": contact, "scallop_tolerance_mm": scallop_tolerance_mm, **limits}
        return cast(CuttingParameters, self._post("cutting-parameters", body))

    def scallop_height_batch(self, cutter: Cutter, contacts: Contacts, **parameters: Unpack[HeightBatchParameters]) -> HeightColumns:
        """`scallop_height` for many contacts, given as rows or as columns. The answer is columns in the same order."""
        return cast(HeightColumns, self._post("scallop-height/batch", {"cutter": cutter, **parameters, "contacts": contacts}))

    def max_feed_batch(
        self, cutter: Cutter, contacts: Contacts, scallop_tolerance_mm: float, **parameters: Unpack[FeedBatchParameters]
    ) -> FeedColumns:
        """`max_feed` for many contacts."""
        body = {"cutter": cutter, "scallop_tolerance_mm": scallop_tolerance_mm, **parameters, "contacts": contacts}
        return cast(FeedColumns, self._post("max-feed/batch", body))

    def step_over_batch(
        self, cutter: Cutter, contacts: Contacts, scallop_tolerance_mm: float, **parameters: Unpack[StepOverBatchParameters]
    ) -> HeightColumns:
        """`step_over` for many contacts."""
        body = {"cutter": cutter, "scallop_tolerance_mm": scallop_tolerance_mm, **parameters, "contacts": contacts}
        return cast(HeightColumns, self._post("step-over/batch", body))

    def cutting_parameters_batch(
        self, cutter: Cutter, contacts: Contacts, scallop_tolerance_mm: float, **limits: Unpack[CuttingBatchLimits]
    ) -> CuttingColumns:
        """`cutting_parameters` for many contacts."""
        body = {"cutter": cutter, "scallop_tolerance_mm": scallop_tolerance_mm, **limits, "contacts": contacts}
        return cast(CuttingColumns, self._post("cutting-parameters/batch", body))

    def critical_slope(
        self,
        toroidal: Mapping[str, float],
        ball_end: Mapping[str, float],
        scallop_height_mm: float,
        machine: Union[str, Machine],
        **rectangle: Unpack[CriticalSlopeParameters],
    ) -> CriticalSlope:
        """The slope of an inclined rectangle up to which the toroidal cutter is the faster one."""
        body = {"toroidal": toroidal, "ball_end": ball_end, "scallop_height_mm": scallop_height_mm, "machine": _machine(machine)}
        return cast(CriticalSlope, self._post("critical-slope", {**body, **rectangle}))

    def machines(self) -> List[MachinePreset]:
        """The machines that requests can name."""
        return cast(List[MachinePreset], self._transport.call("GET", "/v1/machines")["machines"])

    def recommend(
        self,
        surface: Surface,
        cutters: Sequence[Candidate],
        scallop_height_mm: float,
        machine: Union[str, Machine],
        **parameters: Unpack[RecommendationParameters],
    ) -> Recommendation:
        """Ranks cutters by the time in which they finish a surface. Raises `NoCutterFits` where none can."""
        body = _recommendation(cutters, scallop_height_mm, machine, cast(Dict[str, Any], parameters))
        return cast(Recommendation, self._post("cutter-recommendation", {**body, "surface": surface}))

    def recommend_file(
        self,
        surface: Union[Source, File],
        cutters: Sequence[Candidate],
        scallop_height_mm: float,
        machine: Union[str, Machine],
        *,
        libraries: Sequence[Union[Source, File]] = (),
        **parameters: Unpack[RecommendationParameters],
    ) -> Recommendation:
        """`recommend` with the surface in a file (STL, OBJ, PLY, 3MF or text), whose bytes are read while they are sent.

        A file is a path, bytes or an open binary file; `File(source, name)` names bytes, because the suffix helps to detect the
        format. The cutters of `libraries` (Fusion, FreeCAD or CSV) join `cutters`. A file that cannot be read twice, such as a
        pipe, is sent once: the call is then not repeated.
        """
        body = _recommendation(cutters, scallop_height_mm, machine, cast(Dict[str, Any], parameters))
        parts = [("surface", _file(surface))] + [("library", _file(library)) for library in libraries]
        form = Form(_without_none(body), parts)
        return cast(Recommendation, self._transport.call("POST", "/v1/cutter-recommendation/upload", form))

    def _post(self, operation: str, body: Mapping[str, Any]) -> Any:
        request: Body = JsonBody(_without_none(body))
        return self._transport.call("POST", f"/v1/{operation}", request)


def _without_none(body: Mapping[str, Any]) -> Dict[str, Any]:
    return {name: value for name, value in body.items() if value is not None}


def _machine(machine: Union[str, Machine]) -> Machine:
    return {"preset": machine} if isinstance(machine, str) else machine


def _recommendation(
    cutters: Sequence[Candidate], scallop_height_mm: float, machine: Union[str, Machine], parameters: Dict[str, Any]
) -> Dict[str, Any]:
    return {
        # An upload may take all its cutters from libraries.
        "cutters": cutters if len(cutters) > 0 else None,
        "scallop_height_mm": scallop_height_mm,
        "machine": _machine(machine),
        **parameters,
    }


def _file(source: Union[Source, File]) -> File:
    return source if isinstance(source, File) else File(source)
