"""The exceptions that calls raise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional

from .objects import NotRanked

__all__ = [
    "ConnectionLost",
    "Fault",
    "InvalidAnswer",
    "NoCutterFits",
    "Problem",
    "ScallopdError",
    "Timeout",
    "ToleranceExceeded",
]


class ScallopdError(Exception):
    """Base class of every exception of this package."""


class Timeout(ScallopdError, TimeoutError):
    """The server accepted or answered nothing within the client's time-out. The call was not repeated."""


class ConnectionLost(ScallopdError, ConnectionError):
    """No attempt got an answer in the time in which the client repeats a call."""


class InvalidAnswer(ScallopdError):
    """The answer is not the service's: another program listens there, or a proxy answered in its place."""


@dataclass(frozen=True)
class Fault:
    """One fault of a request."""

    pointer: str
    """The location: a JSON pointer (RFC 6901) into the request."""
    code: str
    """One of the service's fault codes."""
    detail: str
    """What is wrong and what is expected, for people."""


class Problem(ScallopdError):
    """The service refused the request (problem details, RFC 9457)."""

    def __init__(self, content: Mapping[str, Any], retry_after_s: Optional[float] = None) -> None:
        self.type = str(content["type"])
        """The problem's stable name, such as `invalid-request`."""
        self.title = str(content.get("title", ""))
        self.status = int(content["status"])
        self.detail = str(content.get("detail", ""))
        self.instance = str(content.get("instance", ""))
        self.request_id: Optional[str] = content.get("request_id")
        """The request's id, which is in the server's log lines."""
        self.errors: List[Fault] = [
            Fault(str(error.get("pointer", "")), str(error.get("code", "")), str(error.get("detail", "")))
            for error in content.get("errors", [])
        ]
        """All faults of the request."""
        self.retry_after_s = retry_after_s
        """With status 429 or 503: the seconds that the server asks to wait."""
        self.members: Dict[str, Any] = dict(content)
        """The whole problem as the server wrote it."""
        # The only fault is the problem's own detail, which has no location.
        place = f"{self.errors[0].pointer}: " if len(self.errors) == 1 and self.errors[0].pointer else ""
        lines = [f"{self.status} {self.type}: {place}{self.detail}"]
        if len(self.errors) > 1:
            lines += [f"  {fault.pointer}: {fault.detail} ({fault.code})" for fault in self.errors]
        super().__init__("\n".join(lines))


class ToleranceExceeded(Problem):
    """The step-over alone uses up the tolerance, so no feed is possible."""

    @property
    def step_over_height_mm(self) -> float:
        """The height that the step-over leaves at any feed."""
        return float(self.members["step_over_height_mm"])

    @property
    def max_step_over_mm(self) -> float:
        """The step-over at which the feed becomes zero; a smaller one leaves room for a feed."""
        return float(self.members["max_step_over_mm"])


class NoCutterFits(Problem):
    """None of the cutters can finish the surface."""

    @property
    def not_ranked(self) -> List[NotRanked]:
        """For each cutter the reason."""
        return list(self.members["not_ranked"])


_CLASSES = {"tolerance-exceeded": ToleranceExceeded, "no-cutter-fits": NoCutterFits}


def problem_from(content: Mapping[str, Any], retry_after_s: Optional[float]) -> Problem:
    """The problem as the class for its type."""
    return _CLASSES.get(str(content["type"]), Problem)(content, retry_after_s)
