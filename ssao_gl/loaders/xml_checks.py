"""3MF and COLLADA files, checked before their readers unfold them: no entities, no cycles, no parts of parts without end."""

from __future__ import annotations

import io
import zipfile
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from xml.parsers import expat

from ..errors import SceneError

ENCODINGS = ("utf-8", "utf-16", "us-ascii", "ascii", "iso-8859-1")
"""Those that all XML parsers read alike, so that what is checked is what is read."""
MAX_DEPTH = 200
MAX_PLACED = 5000
"""Parts that a file may place, all references followed; their readers take a millisecond and more for each."""
FREE, RATIO = 32 << 20, 4
"""Text of geometry that a file may unfold to by placing it again and again, or so many times its size if that is more."""


@dataclass(slots=True)
class XmlElement:
    """An element of interest: its name and attributes without namespaces, the nearest such one above it, its bytes, its text."""

    name: str
    attributes: Mapping[str, str]
    parent: int
    start: int
    size: int = 0
    text: list[str] = field(default_factory=list)


def outline(text: bytes, wanted: frozenset[str], root: str) -> list[XmlElement]:
    """The elements named in ``wanted``, in the order of the file. Raises SceneError for what is not safe or no such XML."""
    found: list[XmlElement] = []
    open_: list[int] = []
    depth: list[bool] = []
    parser = expat.ParserCreate(namespace_separator="}")

    def start(tag: str, attributes: Mapping[str, str]) -> None:
        space, _, name = tag.rpartition("}")
        if not depth and (name != root or not space):
            raise SceneError(f"is XML, but begins with '{name[:50]}'; expected '{root}' in a namespace")
        depth.append(name in wanted)
        if len(depth) > MAX_DEPTH:
            raise SceneError(f"is nested more than {MAX_DEPTH} levels deep; it is broken")
        if depth[-1]:
            plain = {key.rpartition("}")[2]: value for key, value in attributes.items()}
            found.append(XmlElement(name, plain, open_[-1] if open_ else -1, parser.CurrentByteIndex))
            open_.append(len(found) - 1)

    def end(tag: str) -> None:
        if depth.pop():
            element = found[open_.pop()]
            element.size = parser.CurrentByteIndex - element.start

    def more(part: str) -> None:
        if depth and depth[-1]:
            found[open_[-1]].text.append(part)

    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = start, end, more
    parser.StartDoctypeDeclHandler, parser.XmlDeclHandler = _refuse_doctype, _check_encoding
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise SceneError(f"its XML cannot be read ({error})") from None
    return found


def _refuse_doctype(*_: object) -> None:
    raise SceneError("has a document type with entities of its own, which are not read; remove the DOCTYPE")


def _check_encoding(version: str, encoding: str | None, standalone: int) -> None:
    if encoding is not None and encoding.lower() not in ENCODINGS:
        raise SceneError(f"is XML in the encoding '{encoding[:50]}'; expected UTF-8")


class _Placed:
    """Who places whom: how many parts come of it, and how much text."""

    def __init__(self, size: int) -> None:
        self.children: dict[str, list[str]] = defaultdict(list)
        self.own: dict[str, int] = defaultdict(int)
        self._budget = max(FREE, RATIO * size)

    def check(self, roots: Iterable[str]) -> None:
        """Raises SceneError when ``roots`` unfold to too much, or hold themselves."""
        known: dict[str, tuple[int, int]] = {}
        placed = text = 0
        for root in roots:
            parts, size = self._unfold(root, known)
            placed, text = placed + parts, text + size
            if placed > MAX_PLACED:
                raise SceneError(f"places more than {MAX_PLACED} parts, which cannot be read in sensible time; merge them")
            self.check_text(text)

    def check_text(self, size: int) -> None:
        """Raises SceneError when so much text is more than a file of this size can mean."""
        if size > self._budget:
            raise SceneError(f"unfolds to {size >> 20} MiB of geometry, far more than it holds; it is broken")

    def _unfold(self, root: str, known: dict[str, tuple[int, int]]) -> tuple[int, int]:
        """(parts, bytes) of ``root`` and all below it."""
        path: dict[str, None] = {}
        stack = [(root, False)]
        while stack:
            name, done = stack.pop()
            if done:
                del path[name]
                below = [known[child] for child in self.children.get(name, ())]
                known[name] = 1 + sum(parts for parts, _ in below), self.own.get(name, 0) + sum(size for _, size in below)
            elif name not in known:
                if name in path:
                    raise SceneError(f"'{name[:50]}' is part of itself; parts must form a tree")
                if len(path) > MAX_DEPTH:
                    raise SceneError(f"places parts of parts more than {MAX_DEPTH} levels deep; it is broken")
                path[name] = None
                stack.append((name, True))
                stack += [(child, False) for child in self.children.get(name, ()) if child not in known or child in path]
        return known[root]


def check_3mf(files: Mapping[str, bytes]) -> None:
    """Objects and the components of which they are made, in all models of the archive. Raises SceneError."""
    models = {name: content for name, content in files.items() if name.lower().endswith(".model")}
    size = sum(map(len, models.values()))
    placed, roots, read = _Placed(size), [], size
    for content in models.values():
        elements = outline(content, frozenset(("object", "component", "item")), "model")
        for element in elements:
            child = element.attributes.get("objectid", "")
            if element.name == "item":
                roots.append(child)
            elif element.name == "component" and element.parent >= 0:
                placed.children[elements[element.parent].attributes.get("id", "")].append(child)
                # A file is read again for every component that names it.
                read += len(files.get(element.attributes.get("path", "").strip("/"), b""))
    placed.check_text(read)
    placed.check(roots)


def check_dae(text: bytes) -> bytes:
    """Nodes and the nodes and geometries that they place; the corners of polygons. Raises SceneError."""
    if zipfile.is_zipfile(io.BytesIO(text)):
        raise SceneError("is not a .dae file but a ZIP archive")
    names = ("node", "visual_scene", "geometry", "instance_node", "instance_geometry", "vcount")
    elements = outline(text, frozenset(names), "COLLADA")
    placed = _Placed(len(text))
    for number, element in enumerate(elements):
        if element.name in ("node", "visual_scene"):
            placed.children[f"{element.parent}"].append(f"{number}")
            placed.children[f"#{element.attributes.get('id')}"].append(f"{number}")
        elif element.name == "geometry":
            placed.own[f"#{element.attributes.get('id')}"] += element.size
        elif element.name == "vcount":
            _check_corners("".join(element.text), len(text))
        else:
            placed.children[f"{element.parent}"].append(element.attributes.get("url", ""))
    placed.check(f"{number}" for number, element in enumerate(elements) if element.name == "visual_scene")
    return text


def _check_corners(counts: str, size: int) -> None:
    """Memory is taken for as many corners as the polygons say they have."""
    try:
        corners = sum(abs(int(float(count))) for count in counts.split())
    except (ValueError, OverflowError):
        raise SceneError("has a polygon whose number of corners is no number; it is broken") from None
    if corners > size:
        raise SceneError(f"announces {corners} corners of polygons, more than its {size} bytes can hold; it is broken")
