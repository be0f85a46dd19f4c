"""Everything a report leaves in its folder. Each file appears whole or not at all."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..experiment.steps import ESTIMATE
from ..io.atomic import atomic_write
from ..io.json_values import to_json
from .plots import plots
from .tables import KEYS

TRACKS = {ESTIMATE: "as shipped", "fitted": "fitted"}
"""Kind of a row -> its track."""

RESULTS, TABLE, TEXT, PAGE = "results.json", "results.csv", "report.md", "report.html"


def write(found: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write the page, the text, the data and the plots; returns the paths, the page first."""
    from .markdown import markdown
    from .page import report_page

    _text(folder / RESULTS, json.dumps(to_json(found), indent=1, allow_nan=False) + "\n")
    _text(folder / TABLE, rows_as_csv(found))
    drawn = plots(found)
    for plot in drawn:
        _text(folder / f"{plot.name}.svg", plot.svg)
        with atomic_write(folder / f"{plot.name}.png") as temporary:
            temporary.write_bytes(plot.png)
    _text(folder / TEXT, markdown(found, drawn))
    _text(folder / PAGE, report_page(found, drawn, folder))
    names = (PAGE, TEXT, RESULTS, TABLE)
    return [folder / name for name in names] + [
        folder / f"{plot.name}{suffix}" for plot in drawn for suffix in (".svg", ".png")
    ]


def rows_as_csv(found: Mapping[str, Any]) -> str:
    """Return one line for each estimator in each view, in both tracks."""
    views = {row["view"]: row for row in found["rows"]["view"]}
    groups = ("gbuffer", "method", "filter", "other", "total")
    head = ["track", "scene", "camera", "width", "height", "variant", "family", "preset"]
    head += [*KEYS, *(f"{name}_ms" for name in groups), *(f"{name}_cpu_ms" for name in groups)]
    head += ["prepared_ms", "prepared_bytes", "baseline_ms", "baseline_cpu_ms", "radius_factor", "strength", "power", "refused"]
    out = io.StringIO()
    lines = csv.writer(out, lineterminator="\n")
    lines.writerow(head)
    for kind in (ESTIMATE, "fitted"):
        for row in found["rows"][kind]:
            lines.writerow(_csv_row(kind, row, views.get(row["view"], {}), groups))
    return out.getvalue()


def _csv_row(kind: str, row: Mapping[str, Any], view: Mapping[str, Any], groups: Sequence[str]) -> list[Any]:
    times, baseline, scalars, prepared = (row.get(key) or {} for key in ("times", "baseline", "scalars", "prepared"))
    cells = [TRACKS[kind], view.get("scene"), view.get("camera"), *view.get("size", ["", ""])]
    cells += [row["variant"], row["family"], row["preset"]]
    cells += [row.get("errors", {}).get(key) for key in KEYS]
    cells += [times.get(name, {}).get(clock, [None] * 3)[1] for clock in ("wall", "cpu") for name in groups]
    cells += [prepared.get(name) for name in ("ms", "bytes")]
    cells += [baseline.get(clock, [None] * 3)[1] for clock in ("wall", "cpu")]
    cells += [scalars.get(name) for name in ("radius", "strength", "power")]
    return [*cells, row.get("refused")]


def _text(path: Path, text: str) -> None:
    with atomic_write(path) as temporary:
        temporary.write_text(text, "utf-8")
