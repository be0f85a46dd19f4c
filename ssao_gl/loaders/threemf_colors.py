"""Colours of 3MF objects and their triangles (3MF Core Specification 1.3, 5; Materials and Properties Extension 1.2, 3)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from .notes import Notes

WHITE = (255, 255, 255, 255)
GROUPS = {"basematerials": ("base", "displaycolor"), "colorgroup": ("color", "color")}
"""Element of a group of colours -> element and attribute of each of them."""
UNREAD = frozenset({"texture2dgroup", "compositematerials", "multiproperties"})


@dataclass
class _Object:
    """``corners``: of each triangle its group, and the three numbers of its corners' colours in it."""

    group: str | None
    index: int
    corners: list[tuple[str | None, int, int, int]] = field(default_factory=list)


class _Model:
    """What a model says of colours, collected while it is parsed."""

    def __init__(self) -> None:
        self.colors: dict[str, list[tuple[int, ...]]] = {}
        self.objects: list[_Object] = []
        self.unread: set[str] = set()
        self._group: tuple[str, str, str] | None = None

    def start(self, tag: str, attributes: Mapping[str, str]) -> None:
        """Take an element: groups, their colours, objects, triangles."""
        name = tag.rpartition("}")[2]
        if name in GROUPS:
            self._group = (*GROUPS[name], attributes.get("id", ""))
            self.colors[self._group[2]] = []
        elif name in UNREAD:
            self.unread.add(name)
        elif self._group is not None and name == self._group[0]:
            self.colors[self._group[2]].append(_rgba(attributes.get(self._group[1], "")))
        elif name == "object":
            self.objects.append(_Object(attributes.get("pid"), _number(attributes.get("pindex"), 0)))
        elif name == "triangle" and self.objects:
            of = self.objects[-1]
            first = _number(attributes.get("p1"), of.index)
            second, third = (_number(attributes.get(key), first) for key in ("p2", "p3"))
            of.corners.append((attributes.get("pid", of.group), first, second, third))

    def end(self, tag: str) -> None:
        """Leave an element."""
        if tag.rpartition("}")[2] in GROUPS:
            self._group = None

    def face_colors(self, made: _Object) -> NDArray[np.uint8] | None:
        """(m, 4) sRGB of an object's triangles, the mean of their corners'; None where none has one."""
        rows = [[self._color(group, corner) for corner in corners] for group, *corners in made.corners]
        if all(color is None for row in rows for color in row):
            return None
        mean = np.mean([[color or WHITE for color in row] for row in rows], axis=1)
        return np.asarray(mean.round(), np.uint8)

    def _color(self, group: str | None, index: int) -> tuple[int, ...] | None:
        colors = self.colors.get(group or "", ())
        return colors[index] if 0 <= index < len(colors) else None


def object_colors(files: Mapping[str, bytes], notes: Notes) -> list[tuple[int, NDArray[np.uint8] | None]]:
    """Return how many triangles each object has that has some, in the order of the file, and their colours (m, 4) or None.

    files: the archive's, which were checked. What is not read is noted.
    """
    content = next((data for name, data in files.items() if "3d/3dmodel.model" in name.lower()), b"")
    model = _Model()
    parser = expat.ParserCreate(namespace_separator="}")
    parser.StartElementHandler, parser.EndElementHandler = model.start, model.end
    parser.Parse(content, True)
    if model.unread:
        notes.add(f"colours of these kinds are not read: {', '.join(sorted(model.unread))}")
    return [(len(made.corners), model.face_colors(made)) for made in model.objects if made.corners]


def _rgba(text: str) -> tuple[int, ...]:
    """Return the bytes of ``#RRGGBB`` or ``#RRGGBBAA``; white for what is neither."""
    digits = text.strip().removeprefix("#")
    if not re.fullmatch(r"[0-9a-fA-F]{6}([0-9a-fA-F]{2})?", digits):
        return WHITE
    return tuple(bytes.fromhex(digits.ljust(8, "f")))


def _number(text: str | None, default: int) -> int:
    return int(text) if text is not None and re.fullmatch(r"[0-9]{1,9}", text) else default
