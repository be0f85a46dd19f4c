"""The report as one page that needs nothing else: styles, script, plots and pictures are inside."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..experiment.pictures import SCALE, SPAN, ZONE_COLORS
from ..experiment.steps import ESTIMATE
from ..experiment.sweep import folder_name, images_of
from ..io.pages import page
from .columns import text
from .facts import facts
from .plots import INK, Plot
from .tables import tables
from .zone_tables import worst_first

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
        zone_colors=ZONE_COLORS,
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
    """Zones, truth, method and error map of each estimator, for the views that have pictures."""
    errors = {(row["view"], row["variant"]): row["errors"] for row in found["rows"][ESTIMATE] if "errors" in row}
    shares = {row["view"]: row["zones"] for row in found["rows"]["view"]}
    views = (_view(name, found["order"], errors, shares[name], images_of(folder)) for name in worst_first(found))
    return [view for view in views if view is not None and view["trios"]]


def _view(
    name: str,
    labels: Sequence[str],
    errors: Mapping[tuple[str, str], Mapping[str, float | None]],
    shares: Mapping[str, float | None],
    folder: Path,
) -> dict[str, Any] | None:
    truth, zones = (folder / f"{folder_name(name)}-{what}.png" for what in ("truth", "zones"))
    if not (truth.is_file() and zones.is_file()):
        return None
    trios = []
    for label in labels:
        stem = f"{folder_name(name)}-{folder_name(label)}"
        pair = folder / f"{stem}.png", folder / f"{stem}-error.png"
        if all(path.is_file() for path in pair):
            trios.append(
                {"label": label, "figures": _figures(errors.get((name, label), {})), "images": [_data(path) for path in pair]}
            )
    return {
        "name": name,
        "id": f"truth-{folder_name(name)}",
        "truth": _data(truth),
        "zones": _data(zones),
        "shares": {zone: text(share, ".0%") for zone, share in shares.items()},
        "trios": trios,
    }


def _figures(errors: Mapping[str, float | None]) -> str:
    """Return what stands above the pictures of an estimator: its error, and where it is."""
    zones = ", ".join(f"{zone} {text(errors.get(f'rmse_{zone}_net'), '.3f')}" for zone in ZONE_COLORS)
    return f"RMSE {text(errors.get('rmse'), '.4f')} ({zones}, blotches {text(errors.get('blotches_net'), '.3f')})"


def _data(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()
