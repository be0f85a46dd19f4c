"""Accessors of glTF: typed rows of numbers, by component type, normalization and sparse substitution (glTF 2.0, 3.6.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .gltf_document import Document, Tree, check_fits

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
ITEMS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def raw(document: Document, number: Any, what: str = "") -> NDArray[Any]:
    """Rows (count, items) as they are stored. Raises SceneError for what does not lie within its view or has no data."""
    entry = document.entry("accessors", number)
    dtype, items, count = np.dtype(COMPONENTS[entry["componentType"]]), ITEMS[entry["type"]], int(entry["count"])
    where = f"accessor {number}"
    if count < 0:
        raise SceneError(f"{where} announces {count} entries; it is broken")
    if "bufferView" in entry:
        stride = document.entry("bufferViews", entry["bufferView"]).get("byteStride")
        rows = _rows(document, entry, where, dtype, items, count, None if stride is None else int(stride))
    elif "sparse" in entry:
        document.take(count * items * dtype.itemsize)
        rows = np.zeros((count, items), dtype)
    else:
        raise SceneError(f"{where}{f' ({what})' if what else ''} has no data")
    return _substituted(document, entry["sparse"], where, rows) if "sparse" in entry else rows


def _rows(
    document: Document, entry: Tree, where: str, dtype: np.dtype[Any], items: int, count: int, stride: int | None
) -> NDArray[Any]:
    size = items * dtype.itemsize
    step, offset = stride or size, int(entry.get("byteOffset", 0))
    room = _length(document, entry["bufferView"])
    check_fits(where, offset, (count - 1) * step + size if count else 0, f"buffer view {entry['bufferView']}", room)
    content = document.view(entry["bufferView"])
    if not count:
        return np.zeros((0, items), dtype)
    return np.ndarray((count, items), dtype, content.data, offset, (step, dtype.itemsize))


def _length(document: Document, number: Any) -> int:
    """Bytes that a view announces: what is asked of it is checked before it is read."""
    return int(document.entry("bufferViews", number)["byteLength"])


def _substituted(document: Document, sparse: Tree, where: str, rows: NDArray[Any]) -> NDArray[Any]:
    """A copy of ``rows`` with some of them replaced."""
    count, places = int(sparse["count"]), sparse["indices"]
    where = f"{where} (sparse)"
    if not 0 <= count <= len(rows):
        raise SceneError(f"{where} replaces {count} of {len(rows)} entries; it is broken")
    which = _rows(document, places, where, np.dtype(COMPONENTS[places["componentType"]]), 1, count, None).ravel()
    values = _rows(document, sparse["values"], where, rows.dtype, rows.shape[1], count, None)
    if count and (which.dtype.kind != "u" or int(which.max()) >= len(rows)):
        raise SceneError(f"{where} replaces entry {int(which.max())}; there are 0 to {len(rows) - 1}")
    document.take(rows.nbytes)
    rows = rows.copy()
    rows[which] = values
    return rows


def values(document: Document, number: Any, what: str = "") -> NDArray[Any]:
    """Rows (count, items) as they are meant: floats; integers that are normalized as numbers in -1..1 or 0..1."""
    rows = raw(document, number, what)
    document.take(rows.size * 4 if rows.dtype.kind != "f" else 0)
    return dequantized(rows, bool(document.entry("accessors", number).get("normalized", False)))


def dequantized(rows: NDArray[Any], normalized: bool) -> NDArray[Any]:
    """Integers as floats: normalized ones over the largest of their type (glTF 2.0, 3.6.2.2), others as they are."""
    if rows.dtype.kind == "f":
        return rows
    if not normalized:
        return rows.astype(np.float32 if rows.dtype.itemsize < 4 else np.float64)
    return np.maximum(rows / np.float64(np.iinfo(rows.dtype).max), -1).astype(np.float32)
