"""Visibility of vertices, written as an attribute of a glTF file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..loaders.gltf_document import Document, Tree
from ..loaders.gltf_draco import DRACO
from ..loaders.gltf_primitives import primitive_content
from ..loaders.gltf_writing import GltfWriter
from .primitives import Primitive

F32 = NDArray[np.float32]
COLOR = "COLOR_0"


def write_attribute(
    writer: GltfWriter,
    document: Document,
    primitive: Primitive,
    visibility: F32,
    attribute: str = COLOR,
    indirect: F32 | None = None,
) -> None:
    """Set an attribute of a primitive to ``visibility`` (n,).

    COLOR_0 takes the vertex colours that are there times visibility and ``indirect`` light (n, 3), at most 1, as linear light, alpha as it is: a viewer that knows
    nothing of occlusion shows it. Any other attribute is one 32-bit float a vertex.
    """
    entry = primitive.entry(writer.tree)
    if attribute != COLOR:
        entry["attributes"][attribute] = writer.accessor(visibility[:, None].astype("<f4"))
    else:
        colors = _colors(document, entry, len(visibility))
        colors[:, :3] *= visibility[:, None] if indirect is None else np.minimum(visibility[:, None] + indirect, 1)
        entry["attributes"][COLOR] = _stored(writer, document, entry, colors)
    packed = entry.get("extensions", {}).get(DRACO)
    if packed is not None:
        packed["attributes"].pop(attribute, None)  # beside the compressed ones, which keep the decoder's order of vertices


def _colors(document: Document, entry: Tree, count: int) -> NDArray[np.float64]:
    """(n, 4) linear: those that are there, else white."""
    colors = np.ones((count, 4))
    if COLOR in entry["attributes"]:
        found: Any = primitive_content(document, entry)[1][COLOR]
        if found.shape in ((count, 3), (count, 4)):
            colors[:, : found.shape[1]] = found
    return colors


def _stored(writer: GltfWriter, document: Document, entry: Tree, colors: NDArray[np.float64]) -> int:
    """Return an accessor of the component type that is there; of bytes where there was none."""
    known = entry["attributes"].get(COLOR)
    kind = 5121 if known is None else int(document.entry("accessors", known)["componentType"])
    if kind == 5126:
        return writer.accessor(colors.astype("<f4"))
    most, dtype = (65535, "<u2") if kind == 5123 else (255, "u1")
    return writer.accessor(np.round(np.clip(colors, 0, 1) * most).astype(dtype), normalized=True)
