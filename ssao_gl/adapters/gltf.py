"""The JSON part of glTF files, read before trimesh gets them: sizes are checked, nodes flattened, cameras taken out.

trimesh believes the counts of a file, follows deep node trees in quadratic time, and keeps one camera, without the
transforms above it. With the tree flattened here it has no part in any of that.
"""

from __future__ import annotations

import importlib.util
import io
import json
import logging
import math
import struct
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO

import numpy as np

from ..camera import Camera, Orthographic, Perspective
from ..errors import SceneError
from ..view import Matrix

Tree = dict[str, Any]
SizeOf = Callable[[str], int]
"""Bytes of a file that a scene names. Raises SceneError when it is not there."""

FREE, RATIO = 256 << 20, 16
"""A file may unpack to ``FREE`` bytes, or to ``RATIO`` times its size if that is more: many accessors may share bytes."""

COMPONENTS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
ITEMS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
UNSUPPORTED = ("EXT_meshopt_compression", "KHR_meshopt_compression", "EXT_mesh_gpu_instancing")
DRACO = "KHR_draco_mesh_compression"


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
    cameras = prepare(tree, size, size_of, binary)
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, total - length + len(text), len(text), b"JSON")
    return _Spliced(head + text, file, size), cameras  # type: ignore[return-value]


def open_gltf(file: BinaryIO, size: int, size_of: SizeOf) -> tuple[BinaryIO, list[Camera]]:
    """Likewise for the text form."""
    tree = _parse(file.read())
    cameras = prepare(tree, size, size_of, 0)
    return io.BytesIO(json.dumps(tree).encode()), cameras


def prepare(tree: Tree, size: int, size_of: SizeOf, binary: int) -> list[Camera]:
    """Check ``tree`` and flatten its nodes in place. ``binary``: bytes of a GLB's own buffer. Returns the cameras."""
    try:
        _check_extensions(tree)
        _check_sizes(tree, size, size_of, binary)
        return _flatten(tree)
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise SceneError(f"its glTF structure is broken ({type(error).__name__}: {error})") from error


def _parse(text: bytes) -> Tree:
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
    if DRACO in required and importlib.util.find_spec("DracoPy") is None:
        raise SceneError("is compressed with Draco; pip install DracoPy, or export it without")


def _check_sizes(tree: Tree, size: int, size_of: SizeOf, binary: int) -> None:
    """Every buffer, view and accessor must lie within the one before, and all together within bounds."""
    held, buffers = size, []
    for index, buffer in enumerate(tree.get("buffers", [])):
        uri, length = buffer.get("uri"), int(buffer["byteLength"])
        if uri is None:
            there = binary
        elif uri.startswith("data:"):
            there = len(uri) * 3 // 4
        else:
            there = size_of(uri)
            held += there
        if not 0 <= length <= there:
            raise SceneError(f"buffer {index} announces {length} bytes, but {there} are there; it is truncated or broken")
        buffers.append(length)
    views = [(v, int(v.get("byteOffset", 0)), int(v["byteLength"])) for v in tree.get("bufferViews", [])]
    for index, (view, offset, length) in enumerate(views):
        _fits(f"buffer view {index}", offset, length, f"buffer {view['buffer']}", buffers[_index(view["buffer"])])
    unpacked = sum(length for _, _, length in views)
    accessors = tree.setdefault("accessors", []) if views else tree.get("accessors", [])
    for index, accessor in enumerate(accessors):
        count, item = int(accessor["count"]), COMPONENTS[accessor["componentType"]] * ITEMS[accessor["type"]]
        unpacked += max(count, 0) * item
        if "bufferView" in accessor:
            number = _index(accessor["bufferView"])
            view, _, room = views[number]
            stride = int(view.get("byteStride", item))
            reach = max(count - 1, 0) * stride + item if count else 0
            _fits(f"accessor {index}", int(accessor.get("byteOffset", 0)), reach, f"buffer view {number}", room)
    unpacked += sum(_check_primitive(p, accessors) for mesh in tree.get("meshes", []) for p in mesh["primitives"])
    if unpacked > max(FREE, RATIO * held):
        raise SceneError(f"unpacks to {unpacked >> 20} MiB, far more than its {held >> 10} KiB can hold; it is broken")


def _check_primitive(primitive: Mapping[str, Any], accessors: list[Any]) -> int:
    """Bytes that trimesh will need for a primitive; whether it can read its accessors."""
    attributes = primitive["attributes"]
    wanted = {name: attributes[name] for name in ("POSITION", "NORMAL") if name in attributes}
    if "indices" in primitive:
        wanted["indices"] = primitive["indices"]
    for name, number in wanted.items():
        accessor = accessors[_index(number)]
        if "sparse" in accessor:
            raise SceneError(f"accessor {number} ({name}) is sparse, which cannot be read; export without sparse accessors")
        if "bufferView" not in accessor and DRACO not in primitive.get("extensions", {}):
            raise SceneError(f"accessor {number} ({name}) has no data")
        if name == "POSITION" and accessor.get("normalized"):
            raise SceneError("has positions as normalized integers, which cannot be read; export them as floats")
    return sum(8 * int(accessors[n]["count"]) * (1 if name == "indices" else 3) for name, n in wanted.items())


def _fits(what: str, offset: int, length: int, where: str, room: int) -> None:
    if offset < 0 or length < 0 or offset + length > room:
        raise SceneError(f"{what} reaches byte {offset + length} of {where}, which has {room}; it is truncated or broken")


def _index(value: Any) -> int:
    """A reference: Python would take -1 for the last."""
    if not isinstance(value, int) or value < 0:
        raise IndexError(f"{value!r} is no index")
    return value


def _flatten(tree: Tree) -> list[Camera]:
    """Replace the nodes by one for each mesh, with its transform to the world; return the cameras."""
    nodes = tree.get("nodes", [])
    placed: list[Tree] = []
    cameras: list[Camera] = []
    seen = set()
    stack = [(root, np.eye(4)) for root in reversed(_roots(tree, nodes))]
    while stack:
        index, above = stack.pop()
        node = nodes[_index(index)]
        if index in seen:
            raise SceneError(f"node {index} has two parents or is its own ancestor; the nodes must form a tree")
        seen.add(index)
        world = above @ local(node)
        if "mesh" in node:
            mesh = tree["meshes"][_index(node["mesh"])]
            mesh.setdefault("name", node.get("name") or f"mesh {node['mesh']}")
            placed.append({"mesh": node["mesh"], "name": str(len(placed)), "matrix": world.T.ravel().tolist()})
        if "camera" in node:
            cameras += _camera(tree["cameras"][_index(node["camera"])], world, str(node.get("name") or ""), len(cameras))
        stack += [(child, world) for child in reversed(node.get("children", []))]
    tree |= {"nodes": placed, "scenes": [{"nodes": list(range(len(placed)))}], "scene": 0}
    for unused in ("cameras", "animations", "skins"):
        tree.pop(unused, None)
    return cameras


def _roots(tree: Tree, nodes: list[Any]) -> list[int]:
    """Of the file's scene; without any scene, all nodes that are nobody's child."""
    if tree.get("scenes"):
        return list(tree["scenes"][_index(tree.get("scene", 0))].get("nodes", []))
    children = {child for node in nodes for child in node.get("children", [])}
    return [index for index in range(len(nodes)) if index not in children]


def local(node: Mapping[str, Any]) -> Matrix:
    """A node's transform to its parent: a matrix, or translation x rotation x scale."""
    if "matrix" in node:
        return np.asarray(node["matrix"], np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        x, y, z, w = np.asarray(node["rotation"], np.float64) / (np.linalg.norm(node["rotation"]) or 1.0)
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    matrix[:3, :3] *= np.asarray(node.get("scale", (1, 1, 1)), np.float64)
    matrix[:3, 3] = np.asarray(node.get("translation", (0, 0, 0)), np.float64)
    return matrix


def _camera(entry: Mapping[str, Any], world: Matrix, node: str, number: int) -> list[Camera]:
    """The camera, or nothing and a warning when it cannot be used: the scene can still be seen without."""
    name = node or str(entry.get("name") or f"camera {number}")
    try:
        lens: Any
        if entry["type"] == "perspective":
            facts = entry["perspective"]
            far = facts.get("zfar")
            lens = Perspective(float(facts["yfov"]), float(facts["znear"]), None if far is None else float(far))
        else:
            facts = entry["orthographic"]
            lens = Orthographic(2 * float(facts["ymag"]), float(facts["znear"]), float(facts["zfar"]))
        pose = world.copy()
        pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)  # a camera has no size
        if not math.isclose(abs(np.linalg.det(pose[:3, :3])), 1, abs_tol=1e-3):
            raise ValueError("its axes are not at right angles")
        return [Camera(lens, pose, name)]
    except Exception as error:
        logging.getLogger("ssao_gl").warning("the file's camera '%s' is unusable: %s", name, error)
        return []


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
