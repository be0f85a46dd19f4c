"""Vertex normals of meshes that have none: vertices are welded, and split where two faces meet at a sharp edge."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

CHUNK = 1 << 18
"""Triangles a step: temporaries stay small beside the mesh itself."""

BUCKETS = 16
F32 = NDArray[np.float32]
U32 = NDArray[np.uint32]
NormalSource = NDArray[np.uint32]
"""For each new vertex the old one that it copies."""

MANY = 64
"""Faces at a vertex from which not every pair of them is compared: the tip of a finely divided cone has thousands."""


def weld(positions: F32, triangles: U32, colors: NDArray[np.uint8] | None = None) -> tuple[F32, U32, NormalSource | None]:
    """Make one of vertices at exactly the same place, and of the same colour: STL files have three for each triangle.

    Returns positions (n', 3), triangles (m, 3) and where vertices come from, None when they are the same.
    """
    count = len(positions)
    keys = np.empty(count, np.uint64)
    for part in _parts(count):
        keys[part] = _keys(positions[part], None if colors is None else colors[part])
    first = np.empty(count, np.uint32)
    for bucket in range(BUCKETS):  # a sort of all keys at once would take several times their memory
        rows = np.flatnonzero(keys.view(np.uint8)[::8] % BUCKETS == bucket)
        _, index, inverse = np.unique(keys[rows], return_index=True, return_inverse=True)
        first[rows] = rows[index][inverse]
    del keys
    kept = np.empty(count, bool)
    for part in _parts(count):
        itself = np.arange(part.start, part.start + len(first[part]), dtype=np.uint32)
        same = (positions[first[part]] == positions[part]).all(1)
        if colors is not None:
            same &= (colors[first[part]] == colors[part]).all(1)
        first[part] = np.where(same, first[part], itself)  # two places may have one key
        kept[part] = first[part] == itself
    if kept.all():
        return positions, triangles, None
    number = np.cumsum(kept, dtype=np.uint32)
    number -= 1
    welded = np.empty_like(triangles)
    for part in _parts(len(triangles)):
        welded[part] = number[first[triangles[part]]]
    return positions[kept], welded, np.flatnonzero(kept).astype(np.uint32)


def _keys(positions: F32, colors: NDArray[np.uint8] | None) -> NDArray[np.uint64]:
    """64 bits that are the same for the same place and colour, and hardly ever for others."""
    words = list((positions + np.float32(0)).view(np.uint32).astype(np.uint64).T)  # -0 becomes 0
    if colors is not None:
        words += list(np.ascontiguousarray(colors).view(np.uint32).astype(np.uint64).T)
    keys = np.zeros(len(positions), np.uint64)
    for word in words:
        keys = (keys ^ word) * np.uint64(0x9E3779B97F4A7C15)
        keys ^= keys >> np.uint64(29)
    return keys


def _parts(count: int) -> Iterator[slice]:
    return (slice(start, start + CHUNK) for start in range(0, count, CHUNK))


def crease_normals(positions: F32, triangles: U32, crease: float) -> tuple[F32, U32, F32, NormalSource | None]:
    """Angle-weighted vertex normals; faces that meet at more than ``crease`` radians keep their own.

    Returns positions (n', 3), triangles (m, 3), unit normals (n', 3) and where vertices come from, None when they are the
    same: those on creases are doubled, all others stay. (Thuermer & Wuethrich 1998 for the weights.)
    """
    count = len(positions)
    smooth = np.zeros((count, 3), np.float32)
    for chosen in _parts(len(triangles)):
        part = triangles[chosen]
        face, angles = _face_normals(positions, part), _angles(positions, part)
        for corner in range(3):
            for axis in range(3):
                weights = angles[:, corner] * face[:, axis]
                np.add.at(smooth[:, axis], part[:, corner], weights)
    for chosen in _parts(count):
        smooth[chosen] /= np.maximum(np.linalg.norm(smooth[chosen], axis=1, keepdims=True), 1e-30)

    # Where every face lies within half the crease of the average, no pair of them can exceed it.
    sharp = np.zeros(count, bool)
    for chosen in _parts(len(triangles)):
        part = triangles[chosen]
        face = _face_normals(positions, part)
        off = np.einsum("tcx,tx->tc", smooth[part], face) < math.cos(min(crease, math.pi) / 2)
        sharp[part[off]] = True
    if not sharp.any():
        return positions, triangles, smooth, None
    return _split(positions, triangles, smooth, sharp, crease)


def _split(
    positions: F32, triangles: U32, smooth: F32, sharp: NDArray[np.bool_], crease: float
) -> tuple[F32, U32, F32, NormalSource]:
    """Give each corner at a sharp vertex the normal of the faces around it that are within the crease of its own."""
    corners = triangles.ravel()
    kept = np.flatnonzero(~sharp)
    before = np.zeros(len(positions) + 1, np.int64)  # corners at sharp vertices up to each
    for part in _parts(len(corners)):
        np.add.at(before, corners[part] + np.uint32(1), sharp[corners[part]])
    np.cumsum(before, out=before)
    # Every corner may need a vertex of its own; pages that stay empty cost nothing.
    source = np.empty(len(kept) + before[-1], np.uint32)
    normals = np.empty((len(source), 3), np.float32)
    made = len(kept)
    source[:made], normals[:made] = kept, smooth[kept]
    number = np.cumsum(~sharp, dtype=np.uint32)
    number -= 1
    split = number[corners]
    low = 0
    while low < len(positions):
        high = max(int(np.searchsorted(before, before[low] + CHUNK, "right")) - 1, low + 1)
        here = np.flatnonzero((corners >= low) & (corners < high))
        here = here[sharp[corners[here]]]
        if len(here):
            here = here[np.argsort(corners[here], kind="stable")]
            vertex, normal, which = _corner_normals(positions, triangles, smooth, here, crease)
            end = made + len(vertex)
            source[made:end], normals[made:end] = vertex, normal
            split[here] = made + which
            made = end
        low = high
    return positions[source[:made]], split.reshape(-1, 3), normals[:made], source[:made]


def _corner_normals(
    positions: F32, triangles: U32, smooth: F32, corners: NDArray[np.int64], crease: float
) -> tuple[U32, F32, NDArray[np.int64]]:
    """Return new vertices (the old one of each, its normal) for some corners, in order of their vertices, and which each
    gets."""
    part = triangles[corners // 3]
    vertex = triangles.ravel()[corners]
    face, angles = _face_normals(positions, part), _angles(positions, part)
    weighted = face * angles[np.arange(len(corners)), corners % 3][:, None]
    first = np.searchsorted(vertex, vertex, "left")
    valence = np.searchsorted(vertex, vertex, "right") - first
    place = np.arange(len(vertex)) - first
    normal = weighted.copy()
    few = valence <= MANY
    for step in range(1, int(valence[few].max(initial=0))):
        rows = np.flatnonzero(few & (valence > step))
        other = first[rows] + (place[rows] + step) % valence[rows]
        close = np.einsum("ij,ij->i", face[rows], face[other]) >= math.cos(min(crease, math.pi))
        normal[rows[close]] += weighted[other[close]]
    rows = np.flatnonzero(~few)  # the average where it is close to the face, else the face's own
    close = np.einsum("ij,ij->i", face[rows], smooth[vertex[rows]]) >= math.cos(min(crease, math.pi) / 2)
    normal[rows] = np.where(close[:, None], smooth[vertex[rows]], face[rows])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    # Corners of one vertex that got the same normal share a new vertex.
    x, y, z = np.round(normal * 8191).astype(np.int64).T + 8191
    key = (np.cumsum(place == 0) << 42) + (x << 28) + (y << 14) + z
    _, index, which = np.unique(key, return_index=True, return_inverse=True)
    return vertex[index], normal[index], which


def _corner_points(positions: F32, triangles: U32) -> list[NDArray[np.float64]]:
    return [positions[triangles[:, k]].astype(np.float64) for k in range(3)]


def _face_normals(positions: F32, triangles: U32) -> F32:
    """Return unit normals (t, 3), zero for degenerate triangles."""
    a, b, c = _corner_points(positions, triangles)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    unit: F32 = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0).astype(np.float32)
    return unit


def _angles(positions: F32, triangles: U32) -> F32:
    """Angles (t, 3) at the corners, radians."""
    a, b, c = _corner_points(positions, triangles)
    units = [e / np.maximum(np.linalg.norm(e, axis=1, keepdims=True), 1e-300) for e in (b - a, c - b, a - c)]
    cosines = [-(units[k] * units[k - 1]).sum(1) for k in range(3)]
    angles: F32 = np.arccos(np.clip(np.stack(cosines, 1), -1, 1)).astype(np.float32)
    return angles
