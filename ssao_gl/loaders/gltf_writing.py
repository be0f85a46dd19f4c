"""GLB files out of glTF ones: what was there stays as it is, what is new is appended to the binary part (glTF 2.0, 4)."""

from __future__ import annotations

import copy
import json
import struct
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .gltf_accessors import COMPONENTS, ITEMS
from .gltf_document import Document, Tree
from .gltf_meshopt import MESHOPT
from .resolver import FolderResolver

COMPONENT = {np.dtype(kind).str.lstrip("<|"): number for number, kind in COMPONENTS.items()}
TYPE = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
VERTICES, INDICES = 34962, 34963
"""Targets of buffer views (glTF 2.0, 5.11.5)."""
PICTURES = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp", b"\xabKTX": "image/ktx2"}
"""First bytes of picture files -> their media type."""


class GltfWriter:
    """The tree of a glTF file, to be changed, and its binary part, which only grows.

    The bytes of a GLB's binary part stay where they are, and chunks behind it follow as they were; buffers and pictures in
    other files are packed into it. The JSON part is written anew with the same keys and values in the same order.
    """

    def __init__(self, document: Document) -> None:
        """``document`` is copied. Raises SceneError for buffers that cannot be read."""
        self.tree: Tree = copy.deepcopy(document.tree)
        self._rest = document.rest
        self._parts: list[bytes] = []
        self._size = 0
        self._pack(document)

    def document(self, beside: FolderResolver) -> Document:
        """Return what is there now as a document to be read; what it draws may be changed without changing this."""
        self._close()
        chunk = np.frombuffer(b"".join(self._parts), np.uint8)
        return Document(copy.deepcopy(self.tree), beside, len(chunk), chunk)

    def view(self, content: bytes, **entry: Any) -> int:
        """Append bytes; return the number of their buffer view."""
        entry = {"buffer": 0, "byteOffset": self._append(content), "byteLength": len(content)} | entry
        return self._add("bufferViews", entry)

    def accessor(self, rows: NDArray[Any], *, normalized: bool = False, kind: str = "", target: int | None = VERTICES) -> int:
        """Append rows (n, items) of a component type of glTF; return the number of their accessor.

        kind: VEC3 and its kin, by the number of items if it is not given. Attributes begin at multiples of 4 bytes.
        """
        rows = np.ascontiguousarray(rows)
        count, items = rows.shape
        size = items * rows.itemsize
        step = size + -size % 4 if target == VERTICES else size
        content = np.zeros((count, step), np.uint8)
        content[:, :size] = rows.view(np.uint8).reshape(count, size)
        entry: Tree = {} if target is None else {"target": target}
        if target == VERTICES and step != size:
            entry["byteStride"] = step
        made: Tree = {
            "bufferView": self.view(content.tobytes(), **entry),
            "componentType": COMPONENT[rows.dtype.str.lstrip("<|")],
            "count": count,
            "type": kind or TYPE[items],
        }
        if normalized:
            made["normalized"] = True
        return self._add("accessors", made)

    def picture(self, png: bytes, name: str) -> int:
        """Append a PNG picture; return the number of a texture of it, clamped and with mipmaps."""
        image = self._add("images", {"bufferView": self.view(png), "mimeType": "image/png", "name": name})
        sampler = self._add("samplers", {"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071})
        return self._add("textures", {"sampler": sampler, "source": image, "name": name})

    def add_material(self, entry: Tree) -> int:
        """Append a material; return its number."""
        return self._add("materials", entry)

    def write(self, file: IO[bytes]) -> None:
        """Write a GLB file. Raises SceneError for more than 4 GiB."""
        self._close()
        text = json.dumps(self.tree, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "surrogatepass")
        text += b" " * (-len(text) % 4)
        pad = b"\0" * (-self._size % 4)
        binary = self._size + len(pad) if self._size else 0
        total = 20 + len(text) + (8 + binary if binary else 0) + len(self._rest)
        if total >= 2**32:
            raise SceneError(
                f"would take {total / 2**30:.1f} GiB as GLB, which holds at most 4; bake smaller textures, or to NPY"
            )
        file.write(struct.pack("<4sIII4s", b"glTF", 2, total, len(text), b"JSON") + text)
        if binary:
            file.write(struct.pack("<I4s", binary, b"BIN\0"))
            for part in (*self._parts, pad):
                file.write(part)
        file.write(self._rest)

    def _close(self) -> None:
        """Say how long the binary part is."""
        if self._size:
            buffers = self.tree.setdefault("buffers", [])
            if not buffers:
                buffers.append({})
            buffers[0]["byteLength"] = self._size

    def _add(self, key: str, entry: Tree) -> int:
        entries: list[Tree] = self.tree.setdefault(key, [])
        entries.append(entry)
        return len(entries) - 1

    def _append(self, content: bytes) -> int:
        """Return where the bytes are: at a multiple of 4, as any component asks for."""
        pad = b"\0" * (-self._size % 4)
        self._parts += [pad, content]
        start = self._size + len(pad)
        self._size = start + len(content)
        return start

    def _pack(self, document: Document) -> None:
        """Make one buffer of all of them, and put pictures of other files into it."""
        buffers = self.tree.get("buffers", [])
        starts: dict[int, tuple[int, int]] = {}  # buffer -> its number, and where it starts in it, now
        kept: list[Tree] = []
        for number, entry in enumerate(buffers):
            if number and "uri" not in entry:  # the fallback of EXT_meshopt_compression, which has no bytes
                starts[number] = (len(kept), 0)
                kept.append(entry)
                continue
            whole = document.chunk if number == 0 and "uri" not in entry and document.chunk is not None else None
            starts[number] = (0, self._append((document.buffer(number) if whole is None else whole).tobytes()))
            if number == 0:
                kept.append({key: value for key, value in entry.items() if key != "uri"})
        if len(kept) < len(buffers):
            self.tree["buffers"] = kept
            for view in self.tree.get("bufferViews", []):
                for part in (view, *(view["extensions"][name] for name in MESHOPT if name in view.get("extensions", {}))):
                    number, start = starts[part["buffer"]]
                    part["buffer"], part["byteOffset"] = number, part.get("byteOffset", 0) + start
        for image in self.tree.get("images", []):
            self._pack_picture(image, document)

    def _pack_picture(self, image: Tree, document: Document) -> None:
        uri = image.get("uri")
        if not isinstance(uri, str) or uri.startswith("data:"):
            return
        try:
            content = document.beside.get(uri)
        except SceneError:
            document.notes.add(f"the picture '{uri[:100]}' is not in its folder; the output names it as the file does")
            return
        found = next((media for start, media in PICTURES.items() if content.startswith(start)), None)
        del image["uri"]
        image["bufferView"] = self.view(content)
        image["mimeType"] = found or image.get("mimeType", "image/png")


def items_of(entry: Tree) -> int:
    """Numbers in a row of an accessor."""
    return ITEMS[entry["type"]]


def write_glb(writer: GltfWriter, path: Path) -> None:
    """Write to a path that is there for it (see :func:`~ssao_gl.io.atomic.atomic_write`)."""
    with path.open("wb") as file:
        writer.write(file)
