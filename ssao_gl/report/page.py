"""The report as one page that needs nothing else: styles, script, plots and pictures are inside."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..experiment.pictures import SCALE, SPAN
from ..experiment.steps import ESTIMATE
from ..experiment.sweep import folder_name, images_of
from ..io.pages import page
from .facts import facts
from .plots import INK, Plot
from .tables import tables, text

FOLDED = 40
"""Tables with more rows are closed until they are clicked."""


def report_page(found: Mapping[str, Any], drawn: Sequence[Plot], folder: Path) -> str:
    """Return the whole page; pictures are taken from the report's folder, as far as they are there."""
    listed, pictures = tables(found), _pictures(found, folder)
    titles = [*(plot.title for plot in drawn), *(table.title for table in listed), *(["Pictures"] if pictures else [])]
    return page(
        __package__,
        "report.html",
        title="Ambient occlusion: error against time",
        lead=_lead(found),
        command=found["command"],
        sections=[*titles, "Made with"],
        plots=drawn,
        drawing=_drawing,
        tables=listed,
        folded=FOLDED,
        pictures=pictures,
        scale=", ".join(f"rgb{color}" for color in SCALE),
        span=SPAN,
        facts=facts(found),
        anchor=folder_name,
        text=text,
    )


def _lead(found: Mapping[str, Any]) -> str:
    views = found["rows"]["view"]
    scenes = len({row["scene"] for row in views})
    return (
        f"{len(found['order'])} variants of {len(found['families'])} methods in {len(views)} views of {scenes} scenes,"
        f" against ray-traced ambient occlusion of the same surfaces. {found['machine']['renderer']}, {found['made'][:10]}."
    )


def _drawing(plot: Plot) -> str:
    """Return the SVG itself, in the colours of the page."""
    return plot.svg[plot.svg.index("<svg") :].replace(INK, "currentColor")


def _pictures(found: Mapping[str, Any], folder: Path) -> list[dict[str, Any]]:
    """Truth, method and error map of each estimator, for the views that have pictures."""
    rmse = {(row["view"], row["variant"]): row["errors"]["rmse"] for row in found["rows"][ESTIMATE] if "errors" in row}
    views = (_view(row["view"], found["order"], rmse, images_of(folder)) for row in found["rows"]["view"])
    return [view for view in views if view is not None and view["trios"]]


def _view(
    name: str, labels: Sequence[str], rmse: Mapping[tuple[str, str], float | None], folder: Path
) -> dict[str, Any] | None:
    truth = folder / f"{folder_name(name)}-truth.png"
    if not truth.is_file():
        return None
    trios = []
    for label in labels:
        stem = f"{folder_name(name)}-{folder_name(label)}"
        pair = folder / f"{stem}.png", folder / f"{stem}-error.png"
        if all(path.is_file() for path in pair):
            trios.append(
                {"label": label, "rmse": text(rmse.get((name, label)), ".4f"), "images": [_data(path) for path in pair]}
            )
    return {"name": name, "id": f"truth-{folder_name(name)}", "truth": _data(truth), "trios": trios}


def _data(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()
