"""Everything a report leaves in its folder. Each file appears whole or not at all."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..io.atomic import atomic_write
from ..io.json_values import to_json
from .plots import plots
from .tables import KEYS

RESULTS, TABLE, TEXT, PAGE = "results.json", "results.csv", "report.md", "report.html"


def write(found: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write the page, the text, the data and the plots; returns the paths, the page first."""
    from .markdown import markdown
    from .page import page

    _text(folder / RESULTS, json.dumps(to_json(found), indent=1, allow_nan=False) + "\n")
    _text(folder / TABLE, rows_as_csv(found))
    drawn = plots(found)
    for plot in drawn:
        _text(folder / f"{plot.name}.svg", plot.svg)
        with atomic_write(folder / f"{plot.name}.png") as temporary:
            temporary.write_bytes(plot.png)
    _text(folder / TEXT, markdown(found, drawn))
    _text(folder / PAGE, page(found, drawn, folder))
    names = (PAGE, TEXT, RESULTS, TABLE)
    return [folder / name for name in names] + [
        folder / f"{plot.name}{suffix}" for plot in drawn for suffix in (".svg", ".png")
    ]


def rows_as_csv(found: Mapping[str, Any]) -> str:
    """One line for each variant in each view, in both tracks, and for rays."""
    views = {row["view"]: row for row in found["rows"]["view"]}
    groups = ("gbuffer", "method", "filter", "other", "total")
    head = ["track", "scene", "camera", "width", "height", "variant", "method", "preset"]
    head += [*KEYS, *(f"{name}_ms" for name in groups), *(f"{name}_cpu_ms" for name in groups)]
    head += ["yardstick_ms", "yardstick_cpu_ms", "radius_factor", "strength", "power", "refused"]
    out = io.StringIO()
    lines = csv.writer(out, lineterminator="\n")
    lines.writerow(head)
    for kind in ("shipped", "fitted", "rays"):
        for row in found["rows"][kind]:
            view, times, yard = views.get(row["view"], {}), row.get("times", {}), row.get("yardstick") or {}
            scalars = row.get("scalars", {})
            size = view.get("size", ["", ""])
            label = row["variant"] or f"rays {row['spp']}"
            lines.writerow(
                [
                    kind,
                    view.get("scene"),
                    view.get("camera"),
                    *size,
                    label,
                    row.get("method", "rays"),
                    row.get("preset", row.get("spp")),
                ]
                + [row.get("errors", {}).get(key) for key in KEYS]
                + [times.get(name, {}).get(clock, [None] * 3)[1] for clock in ("wall", "cpu") for name in groups]
                + [yard.get(clock, [None] * 3)[1] for clock in ("wall", "cpu")]
                + [scalars.get(name) for name in ("radius", "strength", "power")]
                + [row.get("refused")]
            )
    return out.getvalue()


def _text(path: Path, text: str) -> None:
    with atomic_write(path) as temporary:
        temporary.write_text(text, "utf-8")
