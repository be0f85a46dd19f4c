"""A picture in a notebook: what it shows, its visibility, and how it was made, side by side."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..errors import one_line
from ..io.images import png_bytes
from ..io.pages import page

if TYPE_CHECKING:
    from .picture import Picture

WIDTH = 480
"""Largest width of each picture on the page, pixels; larger ones are embedded at twice that."""
SHOWN = ("image", "visibility")
FACTS = ("scene", "camera", "contents", "provider", "renderer")


def picture_html(picture: Picture) -> str:
    """Return a fragment of HTML that needs no other file; whatever names hold is escaped."""
    names = [name for name in SHOWN if name in picture.arrays] or list(picture.arrays)[:2]
    shown = [_shown(picture, name) for name in names]
    return page(__package__, "picture.html", pictures=shown, facts=_facts(picture.report))


def _shown(picture: Picture, name: str) -> dict[str, Any]:
    array = picture.as_png(name)
    png = png_bytes(array, shrink=max(1, array.shape[1] // (2 * WIDTH)))
    data = "data:image/png;base64," + base64.b64encode(png).decode()
    return {"name": name, "data": data, "width": min(WIDTH, picture.arrays[name].shape[1])}


def _facts(report: Mapping[str, Any]) -> dict[str, str]:
    """Return what is known of a picture, in words: settings of groups as ``group.key``."""
    found = {name: one_line(report[name], 120) for name in FACTS if name in report}
    for key, value in report.get("settings", {}).items():
        for name, one in value.items() if isinstance(value, Mapping) else [("", value)]:
            text = f"{one:.5g}" if isinstance(one, float) else "auto" if one is None else str(one)
            found[f"{key}.{name}" if name else key] = one_line(text, 120)
    return found
