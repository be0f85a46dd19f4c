"""glTF files, read before trimesh gets them: sizes are checked, nodes flattened, all that is not drawn left out.

trimesh believes the counts of a file, and unpacks whatever is in it.
"""

from __future__ import annotations

import importlib.util
import io
import json
import struct
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO

from ..errors import SceneError
from ..scene.camera import Camera
from .gltf_nodes import Tree, flatten, index
from .gltf_prune import DRACO, drawn

SizeOf = Callable[[str], int]
"""Bytes of a file that a scene names. Raises SceneError when it is not there."""

FREE, RATIO = 64 << 20, 16
"""A file may unpack to ``FREE`` bytes, or to ``RATIO`` times its size if that is more: many accessors may share bytes."""
SPARE = 1 << 20
"""Bytes that a buffer's file may have beyond those that are announced."""
MAX_VALUES = 4_000_000
"""Values in the JSON part: lists of nothing take thirty times their text in memory."""

COMPONENTS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
ITEMS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
UNSUPPORTED = ("EXT_meshopt_compression", "KHR_meshopt_compression", "EXT_mesh_gpu_instancing")


def open_glb(file: BinaryIO, size: int, size_of: SizeOf) -> tuple[BinaryIO, list[Camera]]:
    """``file`` as trimesh should see it, and its cameras. Raises SceneError."""
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
    binary = _binary_size(file, size)
    tree, cameras = prepare(tree, size, size_of, binary)
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, total - length + len(text), len(text), b"JSON")
    return _Spliced(head + text, file, size), cameras  # type: ignore[return-value]


def open_gltf(file: BinaryIO, size: int, size_of: SizeOf) -> tuple[BinaryIO, list[Camera]]:
    """Likewise for the text form."""
    tree = _parse(file.read())
    tree, cameras = prepare(tree, size, size_of, 0)
    return io.BytesIO(json.dumps(tree).encode()), cameras


def prepare(tree: Tree, size: int, size_of: SizeOf, binary: int) -> tuple[Tree, list[Camera]]:
    """What of ``tree`` is drawn, checked, its nodes flattened; and the cameras. ``binary``: bytes of a GLB's own buffer."""
    try:
        _check_extensions(tree)
        placed, cameras = flatten(tree)
        tree = drawn(tree, placed)
        _check_sizes(tree, size, size_of, binary)
        return tree, cameras
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise SceneError(f"its glTF structure is broken ({type(error).__name__}: {error})") from error


def _parse(text: bytes) -> Tree:
    if text.count(b",") + text.count(b"[") + text.count(b"{") > MAX_VALUES:
        raise SceneError(f"its JSON part has more than {MAX_VALUES} values; it is broken")
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(f"its JSON part cannot be read ({error})") from None
    if not isinstance(tree, dict):
        raise SceneError("its JSON part is not an object")
    return tree


def _binary_size(file: BinaryIO, size: int) -> int:
    """Bytes of the binary chunk that starts here; 0 when there is none."""
    start = file.tell()
    head = file.read(8)
    file.seek(start)
    if len(head) < 8:
        return 0
    length: int = struct.unpack("<I", head[:4])[0]
    if start + 8 + length > size:
        raise SceneError(f"announces {length} bytes of binary data, but {size - start - 8} are there; it is truncated")
    return length


def _check_extensions(tree: Tree) -> None:
    required = tree.get("extensionsRequired", [])
    for name in UNSUPPORTED:
        if name in required:
            raise SceneError(f"needs the glTF extension {name}, which cannot be read; export it without")
    if DRACO in required:
        _need_draco()


def _need_draco() -> None:
    if importlib.util.find_spec("DracoPy") is None:
        raise SceneError("is compressed with Draco; pip install DracoPy, or export it without")


def _check_sizes(tree: Tree, size: int, size_of: SizeOf, binary: int) -> None:
    """Every buffer, view and accessor must lie within the one before, and all together within bounds."""
    buffers: list[int] = []
    beside: dict[str, int] = {}
    for number, buffer in enumerate(tree["buffers"]):
        uri, length = buffer.get("uri"), int(buffer["byteLength"])
        if uri is None:
            there = binary
        elif uri.startswith("data:"):
            there = len(uri) * 3 // 4
        else:
            there = beside[uri] = size_of(uri)
            if there > length + SPARE:
                raise SceneError(f"buffer {number} announces {length} bytes, but its file has {there}; it is another's")
        if not 0 <= length <= there:
            raise SceneError(f"buffer {number} announces {length} bytes, but {there} are there; it is truncated or broken")
        buffers.append(length)
    held = size + sum(beside.values())
    views = [(v, int(v.get("byteOffset", 0)), int(v["byteLength"])) for v in tree["bufferViews"]]
    for number, (view, offset, length) in enumerate(views):
        _fits(f"buffer view {number}", offset, length, f"buffer {view['buffer']}", buffers[index(view["buffer"])])
    unpacked = sum(length for _, _, length in views)
    for number, accessor in enumerate(tree["accessors"]):
        count, item = int(accessor["count"]), COMPONENTS[accessor["componentType"]] * ITEMS[accessor["type"]]
        unpacked += max(count, 0) * item
        if "bufferView" in accessor:
            view, _, room = views[index(accessor["bufferView"])]
            stride = int(view.get("byteStride", item))
            reach = max(count - 1, 0) * stride + item if count else 0
            where = f"buffer view {accessor['bufferView']}"
            _fits(f"accessor {number}", int(accessor.get("byteOffset", 0)), reach, where, room)
    unpacked += sum(_check_primitive(p, tree["accessors"]) for mesh in tree["meshes"] for p in mesh["primitives"])
    if unpacked > max(FREE, RATIO * held):
        raise SceneError(f"unpacks to {unpacked >> 20} MiB, far more than its {held >> 10} KiB can hold; it is broken")


def _check_primitive(primitive: Mapping[str, Any], accessors: list[Any]) -> int:
    """Bytes that trimesh will need for a primitive; whether it can read its accessors."""
    attributes = primitive["attributes"]
    wanted = {name: attributes[name] for name in ("POSITION", "NORMAL") if name in attributes}
    if "indices" in primitive:
        wanted["indices"] = primitive["indices"]
    for name, number in wanted.items():
        accessor = accessors[index(number)]
        if "sparse" in accessor:
            raise SceneError(f"accessor {number} ({name}) is sparse, which cannot be read; export without sparse accessors")
        if "bufferView" not in accessor:
            if DRACO not in primitive.get("extensions", {}):
                raise SceneError(f"accessor {number} ({name}) has no data")
            _need_draco()
    return sum(8 * int(accessors[n]["count"]) * (1 if name == "indices" else 3) for name, n in wanted.items())


def _fits(what: str, offset: int, length: int, where: str, room: int) -> None:
    if offset < 0 or length < 0 or offset + length > room:
        raise SceneError(f"{what} reaches byte {offset + length} of {where}, which has {room}; it is truncated or broken")


class _Spliced(io.RawIOBase):
    """Some bytes, then the rest of a file, so that a large binary part is not copied to change the text before it."""

    def __init__(self, head: bytes, rest: BinaryIO, size: int) -> None:
        self._head, self._rest, self._at = head, rest, 0
        self._size = len(head) + size - rest.tell()

    def readable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._at

    def read(self, size: int = -1) -> bytes:
        # No more than there is: a file object takes the memory that it is asked for before it looks.
        left = self._size - self._at
        size = min(size, left) if size >= 0 else left
        part = self._head[self._at : self._at + size]
        if len(part) < size:
            part += self._rest.read(size - len(part))
        self._at += len(part)
        return part
