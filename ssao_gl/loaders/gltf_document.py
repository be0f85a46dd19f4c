"""The container of a glTF file: its JSON tree, its buffers, and how much memory its parts may take (glTF 2.0, 3.6 and 4)."""

from __future__ import annotations

import base64
import json
import struct
from dataclasses import dataclass, field
from typing import Any, BinaryIO
from urllib.parse import unquote_to_bytes

import numpy as np

from ..errors import SceneError
from .gltf_meshopt import MESHOPT, Bytes, unpack_meshopt
from .notes import Notes
from .resolver import FolderResolver

Tree = dict[str, Any]

FREE, RATIO = 64 << 20, 16
"""A file may unpack to ``FREE`` bytes, or to ``RATIO`` times its size if that is more: many accessors may share bytes."""
SPARE = 1 << 20
"""Bytes that a buffer's file may have beyond those that are announced."""
MAX_VALUES = 4_000_000
"""Values in the JSON part: lists of nothing take thirty times their text in memory."""


def index(value: Any) -> int:
    """A reference: Python would take -1 for the last."""
    if not isinstance(value, int) or value < 0:
        raise IndexError(f"{value!r} is no index")
    return value


@dataclass
class Document:
    """A glTF file. Buffers are read, and views cut out of them, when they are asked for; each is checked before.

    held: bytes of the file and of those beside it that were read. taken: bytes that were unpacked of them.
    """

    tree: Tree
    beside: FolderResolver
    held: int
    chunk: Bytes | None = None
    notes: Notes = field(default_factory=Notes)
    taken: int = 0
    rest: bytes = b""
    """Chunks behind the binary one, which only extensions know."""
    _buffers: dict[int, Bytes] = field(default_factory=dict)
    _views: dict[int, Bytes] = field(default_factory=dict)

    def entry(self, key: str, number: Any) -> Tree:
        """An entry of one of the lists of the tree. Raises LookupError."""
        found: Tree = self.tree[key][index(number)]
        return found

    def take(self, count: int) -> None:
        """Count bytes that are about to be unpacked. Raises SceneError when they are more than the file can mean."""
        self.taken += max(int(count), 0)
        if self.taken > max(FREE, RATIO * self.held):
            raise SceneError(
                f"unpacks to {self.taken >> 20} MiB, far more than its {self.held >> 10} KiB can hold; it is broken"
            )

    def view(self, number: Any) -> Bytes:
        """The bytes of a buffer view, unpacked where it is compressed."""
        if index(number) not in self._views:
            entry = self.entry("bufferViews", number)
            packed = next((entry["extensions"][name] for name in MESHOPT if name in entry.get("extensions", {})), None)
            if packed is None:
                self._views[number] = self._cut(entry, f"buffer view {number}")
            else:
                size = int(packed["count"]) * int(packed["byteStride"])
                self.take(2 * size)
                self._views[number] = unpack_meshopt(self._cut(packed, f"buffer view {number}"), packed)
        return self._views[number]

    def _cut(self, entry: Tree, what: str) -> Bytes:
        offset, length = int(entry.get("byteOffset", 0)), int(entry["byteLength"])
        # What is announced is checked before the buffer is read.
        check_fits(what, offset, length, f"buffer {entry['buffer']}", int(self.entry("buffers", entry["buffer"])["byteLength"]))
        return self.buffer(entry["buffer"])[offset : offset + length]

    def buffer(self, number: Any) -> Bytes:
        """The bytes of a buffer. Raises SceneError."""
        if index(number) not in self._buffers:
            entry = self.entry("buffers", number)
            uri, length = entry.get("uri"), int(entry["byteLength"])
            if uri is None:
                content = np.zeros(0, np.uint8) if self.chunk is None else self.chunk
            elif uri.startswith("data:"):
                content = np.frombuffer(data_uri(uri), np.uint8)
            else:
                there = self.beside.size(uri)
                if there > length + SPARE:
                    raise SceneError(f"buffer {number} announces {length} bytes, but its file has {there}; it is another's")
                self._check_length(number, length, there)
                self.held += there
                content = np.frombuffer(self.beside.get(uri), np.uint8)
            self._check_length(number, length, len(content))
            self._buffers[number] = content[:length]
        return self._buffers[number]

    @staticmethod
    def _check_length(number: int, length: int, there: int) -> None:
        if not 0 <= length <= there:
            raise SceneError(f"buffer {number} announces {length} bytes, but {there} are there; it is truncated or broken")


def check_fits(what: str, offset: int, length: int, where: str, room: int) -> None:
    """Raise SceneError when a part does not lie within what it is a part of."""
    if offset < 0 or length < 0 or offset + length > room:
        raise SceneError(f"{what} reaches byte {offset + length} of {where}, which has {room}; it is truncated or broken")


def data_uri(uri: str) -> bytes:
    """The content of a data URI (RFC 2397). Raises ValueError."""
    head, comma, text = uri.partition(",")
    if not comma:
        raise ValueError("a data URI without a comma")
    return base64.b64decode(unquote_to_bytes(text)) if head.endswith(";base64") else unquote_to_bytes(text)


def open_glb(file: BinaryIO, size: int, beside: FolderResolver) -> Document:
    """Read the binary form. Raises SceneError."""
    head = file.read(20)
    if len(head) < 20 or head[:4] != b"glTF":
        raise SceneError("does not begin as a GLB file does ('glTF'); is it truncated, or misnamed?")
    version, total, length = struct.unpack("<III", head[4:16])
    if version != 2:
        raise SceneError(f"is glTF {version}; only version 2 can be read")
    if total > size or 20 + length > size:
        raise SceneError(f"announces {max(total, 20 + length)} bytes, but has {size}; it is truncated")
    if head[16:20] != b"JSON":
        raise SceneError("has no JSON part where a GLB file must have it; it is broken")
    tree = _parse(file.read(length))
    chunk = _binary(file, size)
    return Document(tree, beside, size, chunk, rest=file.read(max(total - file.tell(), 0)))


def open_gltf(file: BinaryIO, size: int, beside: FolderResolver) -> Document:
    """Read the text form. Raises SceneError."""
    return Document(_parse(file.read()), beside, size)


def _parse(text: bytes) -> Tree:
    if text.count(b",") + text.count(b"[") + text.count(b"{") > MAX_VALUES:
        raise SceneError(f"its JSON part has more than {MAX_VALUES} values; it is broken")
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(f"its JSON part cannot be read ({error})") from None
    if not isinstance(tree, dict):
        raise SceneError("its JSON part is not an object")
    version = tree.get("asset", {}).get("version", "2.0") if isinstance(tree.get("asset", {}), dict) else "2.0"
    if str(version).split(".")[0] == "1":
        raise SceneError("is glTF 1; only version 2 can be read")
    return tree


def _binary(file: BinaryIO, size: int) -> Bytes | None:
    """The binary chunk that starts here; None when there is none."""
    head = file.read(8)
    if len(head) < 8:
        return None
    length: int = struct.unpack("<I", head[:4])[0]
    left = size - file.tell()
    if length > left:
        raise SceneError(f"announces {length} bytes of binary data, but {left} are there; it is truncated")
    return np.frombuffer(file.read(length), np.uint8)
