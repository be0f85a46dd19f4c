"""The report as one page that needs nothing else: styles, script, plots and pictures are inside."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..experiment.pictures import SCALE, SPAN
from ..experiment.sweep import folder_name, images_of
from .facts import facts
from .plots import INK, Plot
from .tables import Table, tables, text

FOLDED = 40
"""Tables with more rows are closed until they are clicked."""


def page(found: Mapping[str, Any], drawn: Sequence[Plot], folder: Path) -> str:
    """The whole page; pictures are taken from the report's folder, as far as they are there."""
    listed = tables(found)
    parts = {
        "css": _asset("page.css"),
        "js": _asset("page.js"),
        "lead": escape(_lead(found)),
        "command": escape(found["command"]),
        "nav": _nav([plot.title for plot in drawn] + [table.title for table in listed] + ["Pictures", "Made with"]),
        "plots": "\n".join(map(_figure, drawn)),
        "tables": "\n".join(map(_table, listed)),
        "pictures": _pictures(found, folder),
        "facts": _section("Made with", "", _definitions(facts(found))),
    }
    return re.sub(r"@(\w+)@", lambda match: parts[match[1]], _asset("page.html"))


def _asset(name: str) -> str:
    return files(__package__).joinpath("web", name).read_text("utf-8")


def _lead(found: Mapping[str, Any]) -> str:
    views, labels = found["rows"]["view"], found["order"]
    scenes = len({row["scene"] for row in views})
    return (
        f"{len(labels)} variants of {len({label.split()[0] for label in labels})} methods in {len(views)} views of {scenes} scenes,"
        f" against ray-traced ambient occlusion of the same surfaces. {found['machine']['renderer']}, {found['made'][:10]}."
    )


def _nav(titles: Sequence[str]) -> str:
    return " ".join(f'<a href="#{folder_name(title)}">{escape(title)}</a>' for title in titles)


def _section(title: str, note: str, body: str) -> str:
    words = f'<p class="note">{escape(note)}</p>' if note else ""
    return f'<section id="{folder_name(title)}"><h2>{escape(title)}</h2>{words}{body}</section>'


def _definitions(pairs: Mapping[str, str]) -> str:
    return "<dl>" + "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in pairs.items()) + "</dl>"


def _figure(plot: Plot) -> str:
    """The SVG itself, in the colours of the page."""
    svg = plot.svg[plot.svg.index("<svg") :].replace(INK, "currentColor")
    return _section(plot.title, "", f'<figure role="img" aria-label="{escape(plot.title)}">{svg}</figure>')


def _table(table: Table) -> str:
    heads = "".join(
        f'<th{_number(column.spec)} title="{escape(column.help or column.title)}">{escape(column.title)}</th>'
        for column in table.columns
    )
    front = next((i for i, column in enumerate(table.columns) if column.title == "front"), None)
    rows = []
    for row in table.rows:
        cells = "".join(_cell(cell, column.spec) for cell, column in zip(row, table.columns, strict=True))
        rows.append(f"<tr{' class=front' if front is not None and row[front] else ''}>{cells}</tr>")
    body = f"<thead><tr>{heads}</tr></thead><tbody>{''.join(rows)}</tbody>"
    made = f'<div class="scroll"><table>{body}</table></div>'
    if len(rows) > FOLDED:
        made = f'<details class="fold"><summary>{len(rows)} rows</summary>{made}</details>'
    return _section(table.title, table.note, made)


def _number(spec: str) -> str:
    return ' class="n"' if spec else ""


def _cell(cell: str | float | None, spec: str) -> str:
    value = "" if cell is None else cell
    sorting = f' data-v="{escape(str(value))}"' if spec else ""
    return f"<td{_number(spec)}{sorting}>{escape(text(cell, spec))}</td>"


def _pictures(found: Mapping[str, Any], folder: Path) -> str:
    """Truth, method and error map of each variant, for the views that have pictures."""
    rmse = {
        (row["view"], row["variant"] or f"rays {row['spp']}"): row["errors"]["rmse"]
        for kind in ("shipped", "rays")
        for row in found["rows"][kind]
        if "errors" in row
    }
    grids = [_grid(row["view"], found["order"], rmse, images_of(folder)) for row in found["rows"]["view"]]
    shown = [grid for grid in grids if grid]
    if not shown:
        return ""
    note = "Truth, method, and method minus truth: red is too bright, blue too dark, on one scale. A click enlarges all three."
    return _section("Pictures", note, _legend() + "".join(shown))


def _grid(view: str, labels: Sequence[str], rmse: Mapping[tuple[str, str], float | None], folder: Path) -> str:
    truth = folder / f"{folder_name(view)}-truth.png"
    if not truth.is_file():
        return ""
    name = f"truth-{folder_name(view)}"
    rows, first = [], True
    for label in (*labels, "rays 1", "rays 8"):
        stem = f"{folder_name(view)}-{folder_name(label)}"
        pair = folder / f"{stem}.png", folder / f"{stem}-error.png"
        if not all(path.is_file() for path in pair):
            continue
        source = f'id="{name}" src="{_data(truth)}"' if first else f'data-same="{name}"'
        images = f'<img {source} alt="truth">' + "".join(f'<img src="{_data(path)}" alt="{escape(label)}">' for path in pair)
        title = f"{label}, RMSE {text(rmse.get((view, label)), '.4f')}"
        heading = f'<div class="name"><b>{escape(label)}</b> RMSE {text(rmse.get((view, label)), ".4f")}</div>'
        rows.append(f'<div class="pictures trio" data-title="{escape(f"{view}: {title}")}">{heading}{images}</div>')
        first = False
    heads = '<div class="pictures"><span class="head">truth</span><span class="head">method</span><span class="head">error</span></div>'
    return f"<details open><summary>{escape(view)}</summary>{heads}{''.join(rows)}</details>"


def _legend() -> str:
    stops = ", ".join(f"rgb{color}" for color in SCALE)
    words = f"<span>{-SPAN:g} too dark</span><span>0</span><span>too bright +{SPAN:g}</span>"
    return f'<div class="legend"><i style="background: linear-gradient(to right, {stops})"></i>{words}</div>'


def _data(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()
