"""glTF files put together from arrays, for tests of what is read of them."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from PIL import Image

from ..scene_files import Tree, glb

TYPES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
QUAD = np.array([[-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0]], "f4")
FACES = np.array([0, 1, 2, 1, 3, 2], "u2")
UV = np.array([[0, 1], [1, 1], [0, 0], [1, 0]], "f4")


class Parts:
    """A tree that grows: each array becomes a view and an accessor, whose number comes back."""

    def __init__(self, **tree: Any) -> None:
        self.tree: Tree = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], **tree}
        self._bytes = b""

    def view(self, content: bytes) -> int:
        self._bytes += b"\0" * (-len(self._bytes) % 4)
        self.tree["bufferViews"].append({"buffer": 0, "byteOffset": len(self._bytes), "byteLength": len(content)})
        self._bytes += content
        return len(self.tree["bufferViews"]) - 1

    def accessor(self, rows: Any, normalized: bool = False) -> int:
        rows = np.asarray(rows)
        flat = rows.reshape(len(rows), -1)
        kind = TYPES[rows.dtype.str[1:]]
        stored = flat
        entry: Tree = {"componentType": kind, "count": len(flat), "type": SHAPES[flat.shape[1]]}
        pad = -stored.strides[0] % 4 if flat.shape[1] > 1 else 0
        if pad:  # rows of attributes begin at multiples of 4 bytes
            stored = np.pad(np.ascontiguousarray(flat).view("u1").reshape(len(flat), -1), ((0, 0), (0, pad)))
        entry["bufferView"] = self.view(np.ascontiguousarray(stored).tobytes())
        if pad:
            self.tree["bufferViews"][-1]["byteStride"] = stored.strides[0]
        if normalized:
            entry["normalized"] = True
        self.tree["accessors"].append(entry)
        return len(self.tree["accessors"]) - 1

    def quad(self, **attributes: int) -> Tree:
        """A primitive of two triangles."""
        return {"attributes": {"POSITION": self.accessor(QUAD), **attributes}, "indices": self.accessor(FACES)}

    def texture(self, image: Any, **sampler: Any) -> None:
        """Material 0 with a texture."""
        out = io.BytesIO()
        Image.fromarray(np.asarray(image, np.uint8)).save(out, "PNG")
        self.tree["images"] = [{"bufferView": self.view(out.getvalue()), "mimeType": "image/png"}]
        self.tree["samplers"], self.tree["textures"] = [sampler], [{"source": 0, "sampler": 0}]
        self.tree["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]

    def show(self, *primitives: Tree, **node: Any) -> bytes:
        """The file, with one mesh at one node unless the tree has its own."""
        self.tree.setdefault("meshes", [{"primitives": list(primitives)}])
        self.tree.setdefault("nodes", [{"mesh": 0, **node}])
        self.tree.setdefault("scenes", [{"nodes": list(range(len(self.tree["nodes"])))}])
        self.tree["buffers"] = [{"byteLength": len(self._bytes)}]
        return glb(self.tree, self._bytes)
