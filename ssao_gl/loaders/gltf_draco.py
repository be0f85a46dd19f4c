"""KHR_draco_mesh_compression of glTF: primitives unpacked by the package DracoPy, which is an extra."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .gltf_accessors import COMPONENTS, ITEMS, dequantized
from .gltf_document import Document, Tree

DRACO = "KHR_draco_mesh_compression"
WRITTEN = 1 << 20
"""Vertices and triangles that a Draco part of any size may announce; above that so many a byte."""
A_BYTE = 64


def need_draco() -> Any:
    """The decoder of Draco. Raises SceneError that names the cure."""
    try:
        import DracoPy
    except ImportError:
        raise SceneError("is compressed with Draco; pip install 'ssao_gl[draco]', or export it without") from None
    return DracoPy


def unpack_draco(
    document: Document, packed: Mapping[str, Any], primitive: Tree
) -> tuple[NDArray[Any], dict[str, NDArray[Any]]]:
    """Triangles (m, 3) and attributes (n, items) as floats. Raises SceneError."""
    library = need_draco()
    content = document.view(packed["bufferView"]).tobytes()
    accessors = {name: document.entry("accessors", primitive["attributes"][name]) for name in packed["attributes"] if name in primitive["attributes"]}  # fmt: skip
    faces = int(document.entry("accessors", primitive["indices"])["count"]) // 3 if "indices" in primitive else 0
    points = max((int(entry["count"]) for entry in accessors.values()), default=0)
    document.take(faces * 24 + sum(int(e["count"]) * 8 * ITEMS[e["type"]] for e in accessors.values()))
    _check_announced(content, max(WRITTEN, A_BYTE * len(content)), faces, points)
    try:
        mesh = library.decode(content)
        triangles = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
        found = {
            name: np.asarray(mesh.get_attribute_by_unique_id(int(packed["attributes"][name]))["data"]) for name in accessors
        }
    except Exception as error:
        raise SceneError(f"has a part compressed with Draco that cannot be unpacked ({error}); it is broken") from None
    for name, entry in accessors.items():
        rows = found[name].reshape(-1, ITEMS[entry["type"]])
        if entry["componentType"] in COMPONENTS and rows.dtype.kind in "iu":
            rows = rows.astype(COMPONENTS[entry["componentType"]])
        found[name] = dequantized(rows, bool(entry.get("normalized", False)))
    return triangles, found


def _check_announced(content: bytes, most: int, faces: int, points: int) -> None:
    """Counts in the head of a Draco part, before the decoder takes memory for them (Draco bitstream 2.2, 5 and 6)."""
    if max(faces, points) > most:
        raise SceneError(f"announces {max(faces, points)} triangles or vertices in {len(content)} bytes of Draco; it is broken")
    if content[:5] != b"DRACO" or len(content) < 11:
        raise SceneError("has a part compressed with Draco that does not begin as one; it is broken")
    if content[9] & 0x80:  # metadata comes first; its length is not told
        return
    at = 11 + (content[7] == 1 and content[8] == 1)  # the traversal's kind, of a mesh by edgebreaker
    for _ in range(2):
        count, shift = 0, 0
        while at < len(content) and shift < 64:
            byte, at = content[at], at + 1
            count |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                break
        if count > most:
            raise SceneError(f"announces {count} triangles or vertices in {len(content)} bytes of Draco; it is broken")
