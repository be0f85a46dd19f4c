"""Binary PLY files whose faces have different numbers of corners, which trimesh does not read: cut into triangles."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import BinaryIO, Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ..errors import SceneError

TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"), **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"), **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"), **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"), **dict.fromkeys(("double", "float64"), "f8"),
    **dict.fromkeys(("long", "int64"), "i8"), **dict.fromkeys(("ulong", "uint64"), "u8"),
}  # fmt: skip
"""numpy's names, without the order of bytes."""
Order = Literal["big", "little"]
SIGNS = {"big": ">", "little": "<"}
CHUNK = 1 << 24
MAX_POLYGONS = 2_000_000
"""Where they differ each has to be found by itself."""


@dataclass(frozen=True)
class PlyElement:
    """``properties``: lines of the header, in words."""

    name: str
    count: int
    properties: list[list[str]] = field(default_factory=list)


@dataclass(frozen=True)
class Faces:
    """How a face lies in the file: bytes before its number of corners, of that number, the corners' type, bytes after them."""

    before: int
    number: int
    corner: np.dtype[np.generic]
    after: int

    def size(self, corners: int) -> int:
        """Bytes of a face."""
        return self.before + self.number + corners * self.corner.itemsize + self.after


def triangulated(file: BinaryIO, header: bytes, length: int) -> BinaryIO:
    """``file``, a binary PLY file with that header and of that many bytes, or one of triangles in its place.

    Raises SceneError for a torn file.
    """
    order: Order = "big" if b"binary_big_endian" in header else "little"
    elements = elements_of(header)
    layout = _layout(elements, order)
    if layout is None:
        return file
    vertices, faces = elements[:2]
    start = len(header) + vertices.count * size_of(vertices.properties)
    try:
        if _alike(file, start, length, faces.count, layout, order):
            return file
        if faces.count > MAX_POLYGONS:
            raise SceneError(
                f"has {faces.count} faces of different numbers of corners; at most {MAX_POLYGONS}, or export triangles"
            )
        file.seek(0)
        data = file.read()
    finally:
        file.seek(0)
    triangles = _triangles(data, start, faces.count, layout, order)
    records = np.zeros(len(triangles), [("number", "u1"), ("corners", f"{SIGNS[order]}i4", 3)])
    records["number"], records["corners"] = 3, triangles
    kept = [f"property {' '.join(words[1:])}" for words in vertices.properties]
    head = ["ply", f"format binary_{order}_endian 1.0", f"element vertex {vertices.count}", *kept]
    head += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    return io.BytesIO("\n".join(head).encode() + data[len(header) : start] + records.tobytes())


def elements_of(header: bytes) -> list[PlyElement]:
    """Return what a header announces, in order."""
    elements: list[PlyElement] = []
    for words in (line.split() for line in header.decode("utf-8", "replace").splitlines()):
        if words[:1] == ["element"]:
            elements.append(PlyElement(words[1], int(words[2])))
        elif words[:1] == ["property"] and elements:
            elements[-1].properties.append(words)
    return elements


def _layout(elements: Sequence[PlyElement], order: Order) -> Faces | None:
    """None where it is not vertices of plain numbers and then faces with one list, as trimesh expects too."""
    if [element.name for element in elements[:2]] != ["vertex", "face"] or not elements[1].count:
        return None
    lists = [index for index, words in enumerate(elements[1].properties) if words[1] == "list"]
    if len(lists) != 1 or any(words[1] == "list" for words in elements[0].properties):
        return None
    properties, at = elements[1].properties, lists[0]
    number, corner = (np.dtype(SIGNS[order] + TYPES[name]) for name in properties[at][2:4])
    return Faces(size_of(properties[:at]), number.itemsize, corner, size_of(properties[at + 1 :]))


def size_of(properties: Sequence[list[str]]) -> int:
    """Return the bytes of properties none of which is a list."""
    return sum(np.dtype(TYPES[words[1]]).itemsize for words in properties)


def _alike(file: BinaryIO, start: int, length: int, count: int, faces: Faces, order: Order) -> bool:
    """Whether all faces have as many corners as the first."""
    file.seek(start + faces.before)
    first = file.read(faces.number)
    size = faces.size(int.from_bytes(first, order))
    if start + count * size > length:
        return False
    file.seek(start)
    while count > 0:
        rows = min(count, max(CHUNK // size, 1))
        block = np.frombuffer(file.read(rows * size), np.uint8).reshape(rows, size)
        numbers = block[:, faces.before : faces.before + faces.number]
        if (numbers != np.frombuffer(first, np.uint8)).any():
            return False
        count -= rows
    return True


def _triangles(data: bytes, start: int, count: int, faces: Faces, order: Order) -> NDArray[np.int64]:
    """(n, 3) corners: each polygon as a fan about its first one, in the order of the file."""
    places, numbers = np.zeros(count, np.int64), np.zeros(count, np.int64)
    place = start
    for face in range(count):
        corners = place + faces.before + faces.number
        number = int.from_bytes(data[corners - faces.number : corners], order)
        place += faces.size(number)
        if place > len(data):
            raise SceneError(f"ends within face {face} of {count}; it is truncated or broken")
        places[face], numbers[face] = corners, number
    fans, which = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for number in np.unique(numbers[numbers > 2]):
        alike = np.flatnonzero(numbers == number)
        rows = sliding_window_view(np.frombuffer(data, np.uint8), number * faces.corner.itemsize)[places[alike]]
        polygon = np.clip(rows.view(faces.corner).astype(np.int64), -1, np.iinfo(np.int32).max)
        fan = np.stack([np.repeat(polygon[:, :1], number - 2, 1), polygon[:, 1:-1], polygon[:, 2:]], -1)
        fans.append(fan.reshape(-1, 3))
        which.append(np.repeat(alike, number - 2))
    return np.concatenate(fans)[np.argsort(np.concatenate(which), kind="stable")]
