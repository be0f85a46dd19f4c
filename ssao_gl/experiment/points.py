"""Rows of single views to points of a plot: mean error against mean time of each variant. Pure arithmetic on rows."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from . import pareto
from .statistics import mean

PointRow = Mapping[str, Any]
PlotPoint = Mapping[str, Any]

TIMES = (0.25, 64.0)
"""Multiples of the baseline between which hypervolume is taken."""

MEDIAN = 1
"""Index in [lower quartile, median, upper quartile]."""


def size_text(size: Sequence[int]) -> str:
    """``1280x720``."""
    return f"{size[0]}x{size[1]}"


def points(rows: Iterable[PointRow], views: Collection[str], *, track: str) -> list[PlotPoint]:
    """One point for each variant, over those of ``views`` in which it took part; the front is marked.

    errors: means over views. wall, cpu: milliseconds by group of passes, means over views of the medians over rounds.
    ratio, cpu_ratio: sum of the totals over the sum of the baseline's times in the same views; None without a baseline.
    A variant that sits out some views is not compared with the others: it is never on the front.
    """
    by_label: dict[str, list[PointRow]] = {}
    for row in rows:
        if row["view"] in views:
            by_label.setdefault(row["variant"], []).append(row)
    found = [_point(label, some, track) for label, some in by_label.items() if any("errors" in row for row in some)]
    return marked(found, len(views))


def marked(some: Sequence[PlotPoint], views: int, clock: str = "wall") -> list[PlotPoint]:
    """Return the same points, with ``front`` set among those that took part in all views."""
    full = [point for point in some if point["views"] == views and point["errors"].get("rmse") is not None]
    best = dict(zip(map(id, full), pareto.front([time_and_error(point, clock) for point in full]), strict=True))
    return [{**point, "front": best.get(id(point), False)} for point in some]


def time_and_error(point: PlotPoint, clock: str = "wall") -> pareto.Point:
    """(milliseconds after the G-buffer, RMSE)."""
    return point[clock]["total"], point["errors"]["rmse"]


def constants(views: Sequence[PointRow], fitting: Collection[str]) -> list[dict[str, Any]]:
    """Return what costs nothing: visibility 1 everywhere, and the mean of the truth over the fitting views (all, without any).

    From the mean ``m`` and mean square ``s`` of the truth: ``rmse^2 = s - 2 c m + c^2``, ``bias = c - m``.
    """
    seen = [view for view in views if view["mean"] is not None]
    if not seen:
        return []
    level = mean([view["mean"] for view in seen if view["view"] in fitting or not fitting]) or 1.0
    made = []
    for label, c in (("constant 1", 1.0), ("constant mean", level)):
        squares = [max(view["square"] - 2 * c * view["mean"] + c * c, 0.0) for view in seen]
        errors = {"rmse": mean([value**0.5 for value in squares]), "bias": mean([c - view["mean"] for view in seen])}
        made.append({"label": label, "level": c, "views": len(seen), "errors": errors})
    return made


def method_hypervolume(some: Sequence[PlotPoint], baseline: float | None, worst: float) -> float | None:
    """Of points of one method, or of all: see :func:`pareto.method_hypervolume`. ``baseline``: its mean milliseconds."""
    if not baseline or not worst:
        return None
    return pareto.hypervolume(map(time_and_error, some), (TIMES[0] * baseline, TIMES[1] * baseline), worst)


def _point(label: str, rows: Sequence[PointRow], track: str) -> PlotPoint:
    good = [row for row in rows if "errors" in row]
    metrics = dict.fromkeys(name for row in good for name in row["errors"])
    groups = [name for name in ("gbuffer", "method", "filter", "other", "total") if name in good[0]["times"]]
    clocks = {
        clock: {name: mean([row["times"][name][clock][MEDIAN] for row in good]) for name in groups} for clock in ("wall", "cpu")
    }
    return {
        "label": label,
        "family": good[0]["family"],
        "preset": good[0]["preset"],
        "realtime": good[0]["realtime"],
        "track": track,
        "views": len(good),
        "errors": {name: mean([row["errors"].get(name) for row in good]) for name in metrics},
        "prepared": {name: mean([row["prepared"][name] for row in good]) for name in ("ms", "bytes")},
        **clocks,
        "ratio": _ratio(good, "wall"),
        "cpu_ratio": _ratio(good, "cpu"),
    }


def _ratio(rows: Sequence[PointRow], clock: str) -> float | None:
    timed = [row for row in rows if row.get("baseline")]
    below = sum(row["baseline"][clock][MEDIAN] for row in timed)
    return sum(row["times"]["total"][clock][MEDIAN] for row in timed) / below if below > 0 else None
