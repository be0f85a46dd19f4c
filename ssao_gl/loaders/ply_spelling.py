"""PLY files as trimesh spells them: other names of colours, and strips of triangles."""

from __future__ import annotations

import io
import re
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .ply_polygons import SIGNS, TYPES, Order, PlyElement, elements_of, size_of
from .strips import strip_triangles

NAMES = {
    **{f"{before}{color}": color for before in ("diffuse_", "vertex_") for color in ("red", "green", "blue", "alpha")},
    **{color[0]: color for color in ("red", "green", "blue", "alpha")},
}
"""Spelling -> trimesh's. Single letters are colours where r, g and b are there."""
PROPERTY = re.compile(rb"(?m)^(property[ \t]+\w+[ \t]+)(\w+)([ \t]*\r?)$")


def respelled(header: bytes) -> bytes:
    """Return a header with the usual names of colours; the same one where it has them, or none."""
    names = {match[2].decode() for match in PROPERTY.finditer(header)}
    if "red" in names or not names & set(NAMES):
        return header
    letters = {"r", "g", "b"} <= names

    def usual(match: re.Match[bytes]) -> bytes:
        name = match[2].decode()
        known = NAMES.get(name, name) if len(name) > 1 or letters else name
        return match[1] + known.encode() + match[3]

    return PROPERTY.sub(usual, header)


def unstripped(file: BinaryIO, header: bytes) -> BinaryIO:
    """Return a file of triangles in place of one of vertices and strips; -1 begins another strip. Raises SceneError."""
    elements = elements_of(header)
    usable = [element.name for element in elements] == ["vertex", "tristrips"] and len(elements[1].properties) == 1
    if not usable or any(words[1] == "list" for words in elements[0].properties) or elements[1].properties[0][1] != "list":
        raise SceneError("has strips of triangles beside other things; only vertices and then strips can be read")
    file.seek(len(header))
    body = file.read()
    text = b"format ascii" in header
    order: Order = "big" if b"binary_big_endian" in header else "little"
    vertices, strips = _text(body, elements) if text else _binary(body, elements, order)
    triangles = np.concatenate([np.zeros((0, 3), np.int64), *(strip_triangles(strip) for strip in strips)])
    kept = [f"property {' '.join(words[1:])}" for words in elements[0].properties]
    form = "ascii" if text else f"binary_{order}_endian"
    comments = [line for line in header.decode("utf-8", "replace").splitlines() if line.startswith("comment")]
    head = ["ply", f"format {form} 1.0", *comments, f"element vertex {elements[0].count}", *kept]
    head += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    if text:
        faces = "".join(f"3 {a} {b} {c}\n" for a, b, c in triangles.tolist()).encode()
    else:
        records = np.zeros(len(triangles), [("number", "u1"), ("corners", f"{SIGNS[order]}i4", 3)])
        records["number"], records["corners"] = 3, np.clip(triangles, -1, np.iinfo(np.int32).max)
        faces = records.tobytes()
    return io.BytesIO("\n".join(head).encode() + vertices + faces)


def _text(body: bytes, elements: list[PlyElement]) -> tuple[bytes, list[NDArray[np.int64]]]:
    lines = [line for line in body.splitlines() if line.strip()]
    count, wanted = elements[0].count, elements[1].count
    if len(lines) < count + wanted:
        raise SceneError(f"ends after {len(lines)} of {count + wanted} lines; it is truncated or broken")
    strips = []
    for line in lines[count : count + wanted]:
        numbers = np.array(line.split(), np.int64)
        if len(numbers) != numbers[0] + 1:
            raise SceneError(f"has a strip of {numbers[0]} vertices that names {len(numbers) - 1}; it is broken")
        strips.append(numbers[1:])
    return b"\n".join(lines[:count]) + b"\n", strips


def _binary(body: bytes, elements: list[PlyElement], order: Order) -> tuple[bytes, list[NDArray[np.int64]]]:
    place = start = elements[0].count * size_of(elements[0].properties)
    number, corner = (np.dtype(SIGNS[order] + TYPES[name]) for name in elements[1].properties[0][2:4])
    strips = []
    for strip in range(elements[1].count):
        count = int.from_bytes(body[place : place + number.itemsize], order)
        place += number.itemsize
        if place + count * corner.itemsize > len(body):
            raise SceneError(f"ends within strip {strip} of {elements[1].count}; it is truncated or broken")
        strips.append(np.frombuffer(body, corner, count, place).astype(np.int64))
        place += count * corner.itemsize
    return body[:start], strips
