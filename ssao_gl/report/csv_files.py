"""The results as CSV: a line for each estimator in each view, and the same in tidy form, a line for each measurement."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ..experiment.steps import ESTIMATE
from .columns import ALL_KEYS

TRACKS = {ESTIMATE: "as shipped", "fitted": "fitted"}
"""Kind of a row -> its track."""
GROUPS = ("gbuffer", "method", "filter", "other", "total")
SUBJECT = ("track", "scene", "camera", "width", "height", "variant", "family", "preset")
"""What was measured: an estimator in a view."""
MEASUREMENT = ("quantity", "part", "clock", "statistic", "unit", "value")
"""What was found of it. quantity: error, time, prepared or baseline; part: which error, or which passes."""
QUARTILES = ("lower quartile", "median", "upper quartile")
UNITS = {"psnr": "dB"}


def rows_as_csv(found: Mapping[str, Any]) -> str:
    """Return one line for each estimator in each view, in both tracks.

    over_cheaper: by which share its RMSE is above (below 0: under) that of the best cheaper preset of its method there.
    """
    head = [*SUBJECT, *ALL_KEYS, *(f"{name}_ms" for name in GROUPS), *(f"{name}_cpu_ms" for name in GROUPS)]
    head += [
        "prepared_ms",
        "prepared_bytes",
        "baseline_ms",
        "baseline_cpu_ms",
        "radius_factor",
        "strength",
        "power",
        "refused",
        "over_cheaper",
    ]
    over = {(one["view"], one["variant"]): one["share"] for at in found["sizes"] for one in at["preset_order"]}
    return _csv(
        head,
        (
            [*subject, *_cells(row), over.get((row["view"], row["variant"])) if row["kind"] == ESTIMATE else None]
            for subject, row in _rows(found)
        ),
    )


def measurements_as_csv(found: Mapping[str, Any]) -> str:
    """Return one line for each measurement: what was measured, of which estimator in which view, in which unit."""
    return _csv([*SUBJECT, *MEASUREMENT], ([*subject, *one] for subject, row in _rows(found) for one in _measurements(row)))


def _csv(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    out = io.StringIO()
    lines = csv.writer(out, lineterminator="\n")
    lines.writerow(head)
    lines.writerows(rows)
    return out.getvalue()


def _rows(found: Mapping[str, Any]) -> Iterator[tuple[list[Any], Mapping[str, Any]]]:
    """Yield what was measured, by :data:`SUBJECT`, and its row of the results."""
    views = {row["view"]: row for row in found["rows"]["view"]}
    for kind, track in TRACKS.items():
        for row in found["rows"][kind]:
            view = views.get(row["view"], {})
            where = [view.get("scene"), view.get("camera"), *view.get("size", ["", ""])]
            yield [track, *where, row["variant"], row["family"], row["preset"]], row


def _cells(row: Mapping[str, Any]) -> list[Any]:
    times, baseline, scalars, prepared = (row.get(key) or {} for key in ("times", "baseline", "scalars", "prepared"))
    cells = [row.get("errors", {}).get(key) for key in ALL_KEYS]
    cells += [times.get(name, {}).get(clock, [None] * 3)[1] for clock in ("wall", "cpu") for name in GROUPS]
    cells += [prepared.get(name) for name in ("ms", "bytes")]
    cells += [baseline.get(clock, [None] * 3)[1] for clock in ("wall", "cpu")]
    cells += [scalars.get(name) for name in ("radius", "strength", "power")]
    return [*cells, row.get("refused")]


def _measurements(row: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    """Yield the values of one row, by :data:`MEASUREMENT`; what was not measured is no line."""
    for key in ALL_KEYS:
        if (value := row.get("errors", {}).get(key)) is not None:
            yield "error", key, "", "", UNITS.get(key, ""), value
    times = row.get("times") or {}
    passes = {f"pass {name}": one for name, one in times.get("passes", {}).items()}
    timed = [("time", part, one) for part, one in ({name: times.get(name) for name in GROUPS} | passes).items() if one]
    timed += [("baseline", "total", row["baseline"])] if row.get("baseline") else []
    for quantity, part, one in timed:
        for clock in ("wall", "cpu"):
            for statistic, value in zip(QUARTILES, one.get(clock) or (), strict=False):
                if value is not None:
                    yield quantity, part, clock, statistic, "ms", value
    for part, value in (row.get("prepared") or {}).items():
        yield "prepared", part, "", "", {"ms": "ms", "bytes": "bytes"}.get(part, ""), value
