"""A recommendation as a table."""

from __future__ import annotations

from typing import List, Mapping, Optional

from .objects import NotRanked
from .planning import Plan, Recommendation

HEADS = ["cutter", "direction deg", "time s", "passes", "step-over mm", "feed mm/min", "uncut %"]


def rows(recommendation: Recommendation) -> List[List[str]]:
    """The rows under `HEADS`: the ranked cutters, fastest first, then those that are not ranked with the reason in the second cell."""
    return [_ranked(plan) for plan in recommendation["candidates"]] + [not_ranked(cutter) for cutter in recommendation["not_ranked"]]


def _ranked(plan: Plan) -> List[str]:
    # Method `rectangle` has one step-over; a plan that was only estimated has neither passes nor step-over.
    step_over: object = plan.get("step_over_xy_mm")
    median = step_over.get("median") if isinstance(step_over, Mapping) else step_over
    uncut = plan.get("uncut_share")
    return [
        plan.get("name") or f"{plan['cutter']}: {plan['type']}",
        f"{plan['direction_deg']:.1f}",
        f"{plan['machining_time_s']:.1f}",
        _figure(plan.get("passes"), 0),
        _figure(median, 3),
        _figure(plan.get("feed_rate_mm_min"), 0),
        _figure(None if uncut is None else 100 * uncut, 2),
    ]


def not_ranked(cutter: NotRanked) -> List[str]:
    """The row of a cutter that is not ranked."""
    return [cutter.get("name") or str(cutter["cutter"]), cutter["detail"], "", "", "", "", ""]


def _figure(value: object, digits: int) -> str:
    return f"{value:.{digits}f}" if isinstance(value, (int, float)) else ""


def notes(recommendation: Recommendation) -> List[str]:
    """A plan of several operations, the confidence with its reasons, and the warnings, a line each."""
    confidence = recommendation["confidence"]
    reasons = [f"  {reason['detail']}" for reason in confidence["reasons"]]
    return [
        *_several(recommendation),
        f"confidence: {confidence['level']}",
        *reasons,
        *(f"warning: {warning['detail']}" for warning in recommendation["warnings"]),
    ]


def _several(recommendation: Recommendation) -> List[str]:
    plan = recommendation.get("plan")
    if plan is None or len(plan["operations"]) < 2:
        return []
    operations = [f"{operation.get('name') or operation['cutter']} {operation['family']}" for operation in plan["operations"]]
    changes = plan["tool_changes"]
    return [f"in {len(operations)} operations {plan['machining_time_s']:.1f} s, tool changes {changes}: {', '.join(operations)}"]


def text(recommendation: Recommendation, limit: Optional[int] = None) -> str:
    """The table and the notes for a console, with at most `limit` rows."""
    return "\n".join([align([HEADS, *rows(recommendation)[:limit]]), *notes(recommendation)])


def align(table: List[List[str]]) -> str:
    """The rows with their cells under each other; a reason in place of figures does not widen its column."""
    widths = [max(len(row[column]) for row in table if column == 0 or row[2]) for column in range(len(HEADS))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in table)
