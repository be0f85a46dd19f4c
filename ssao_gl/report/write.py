"""Everything a report leaves in its folder. Each file appears whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..io.atomic import atomic_write
from ..io.json_values import to_json
from .csv_files import measurements_as_csv, rows_as_csv
from .plots import plots

RESULTS, TABLE, TIDY = "results.json", "results.csv", "measurements.csv"
TEXT, PAGE, PAPER = "report.md", "report.html", "report.tex"


def write(found: Mapping[str, Any], folder: Path, *, paper: bool = False) -> list[Path]:
    """Write the page, the text, the data and the plots; returns the paths, the page first. ``paper``: tables in LaTeX, too."""
    from .latex import latex
    from .markdown import markdown
    from .page import report_page

    _text(folder / RESULTS, json.dumps(to_json(found), indent=1, allow_nan=False) + "\n")
    _text(folder / TABLE, rows_as_csv(found))
    _text(folder / TIDY, measurements_as_csv(found))
    if paper:
        _text(folder / PAPER, latex(found))
    drawn = plots(found)
    for plot in drawn:
        _text(folder / f"{plot.name}.svg", plot.svg)
        with atomic_write(folder / f"{plot.name}.png") as temporary:
            temporary.write_bytes(plot.png)
    _text(folder / TEXT, markdown(found, drawn))
    _text(folder / PAGE, report_page(found, drawn, folder))
    names = (PAGE, TEXT, RESULTS, TABLE, TIDY, *([PAPER] if paper else []))
    return [folder / name for name in names] + [
        folder / f"{plot.name}{suffix}" for plot in drawn for suffix in (".svg", ".png")
    ]


def _text(path: Path, text: str) -> None:
    with atomic_write(path) as temporary:
        temporary.write_text(text, "utf-8")
