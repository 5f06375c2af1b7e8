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
from typing import Mapping, Optional, Type

# The star imports offer what each module lists in its `__all__`, so that a new name is listed once (F403).
# ruff: noqa: F403
from . import calculations, errors, multipart, objects, planning
from .calculations import *
from .errors import *
from .multipart import *
from .objects import *
from .planning import *
from .transport import Transport

__version__ = "0.1.0"

# In this form, because pyright does not understand a list that unpacks others.
__all__ = ["Client", "__version__"]
__all__ += calculations.__all__
__all__ += planning.__all__
__all__ += objects.__all__
__all__ += multipart.__all__
__all__ += errors.__all__


class Client(calculations.Calculations, planning.Planning):
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
        return_failed_batches: bool = False,
    ) -> None:
        """
        `base_url`: the server, with the path under which a proxy offers it, if any.
        `timeout`: seconds that an attempt may take from connecting to the answer's last byte. In an upload each piece of 256 KiB
        has this time to be sent, and the answer has it from the last piece on. The default exceeds the server's own limit of 60
        s, whose answer has more detail.
        `retry_for`: seconds that a call waits, in all, between attempts, when the server is overloaded or restarts. Zero disables
        repeating; connections that broke while idle are always replaced. A call that timed out is not repeated.
        `headers`: sent with every request, such as `authorization` for a proxy.
        `return_failed_batches`: whether a batch whose contacts all failed is returned, as one whose contacts failed in part: null in
        every column and the reasons in `failures`. By default it raises `Problem`.
        """
        self._returns_failed_batches = return_failed_batches
        self._transport = Transport(base_url, timeout, retry_for, headers or {}, ssl_context)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException], traceback: Optional[TracebackType]) -> None:
        self.close()

    def close(self) -> None:
        """Closes the idle connections. The client stays usable."""
        self._transport.close()
