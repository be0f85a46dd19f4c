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
Source = NDArray[np.int64]
"""For each new vertex the old one that it copies."""


def weld(positions: F32, triangles: U32, colors: NDArray[np.uint8] | None = None) -> tuple[F32, U32, Source | None]:
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
    itself = np.arange(count, dtype=np.uint32)
    for part in _parts(count):
        same = (positions[first[part]] == positions[part]).all(1)
        if colors is not None:
            same &= (colors[first[part]] == colors[part]).all(1)
        first[part] = np.where(same, first[part], itself[part])  # two places may have one key
    kept = first == itself
    if kept.all():
        return positions, triangles, None
    number = np.cumsum(kept, dtype=np.uint32)[first] - np.uint32(1)
    return positions[kept], number[triangles], np.flatnonzero(kept)


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


def crease_normals(positions: F32, triangles: U32, crease: float) -> tuple[F32, U32, F32, Source | None]:
    """Angle-weighted vertex normals; faces that meet at more than ``crease`` radians keep their own.

    Returns positions (n', 3), triangles (m, 3), unit normals (n', 3) and where vertices come from, None when they are the
    same: those on creases are doubled, all others stay. (Thuermer & Wuethrich 1998 for the weights.)
    """
    count = len(positions)
    smooth = np.zeros((count, 3), np.float32)
    for chosen in _parts(len(triangles)):
        part = triangles[chosen]
        face, angles = _faces(positions, part)
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
        face, _ = _faces(positions, part)
        off = np.einsum("tcx,tx->tc", smooth[part], face) < math.cos(min(crease, math.pi) / 2)
        sharp[part[off]] = True
    if not sharp.any():
        return positions, triangles, smooth, None
    return _split(positions, triangles, smooth, sharp, crease)


def _split(
    positions: F32, triangles: U32, smooth: F32, sharp: NDArray[np.bool_], crease: float
) -> tuple[F32, U32, F32, NDArray[np.int64]]:
    """Give each corner at a sharp vertex the normal of the faces around it that are within the crease of its own."""
    at_sharp = np.flatnonzero(sharp[triangles].ravel())
    vertex = triangles.ravel()[at_sharp].astype(np.int64)
    at_sharp = at_sharp[np.argsort(vertex, kind="stable")]
    vertex = np.sort(vertex, kind="stable")
    face, angles = _faces(positions, triangles[at_sharp // 3])
    weighted = face * angles[np.arange(len(at_sharp)), at_sharp % 3][:, None]
    first = np.searchsorted(vertex, vertex, "left")
    valence = np.searchsorted(vertex, vertex, "right") - first
    place = np.arange(len(vertex)) - first
    normal = weighted.copy()
    for step in range(1, int(valence.max())):
        rows = np.flatnonzero(valence > step)
        other = first[rows] + (place[rows] + step) % valence[rows]
        close = np.einsum("ij,ij->i", face[rows], face[other]) >= math.cos(min(crease, math.pi))
        normal[rows[close]] += weighted[other[close]]
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    # Corners of one vertex that got the same normal share a new vertex.
    key = np.column_stack([vertex, np.round(normal * 8191).astype(np.int64)])
    unique, index, inverse = np.unique(key, axis=0, return_index=True, return_inverse=True)
    source = np.concatenate([np.arange(len(positions)), unique[:, 0]])
    corners = triangles.ravel().copy()
    corners[at_sharp] = len(positions) + inverse.ravel()
    used = np.zeros(len(source), bool)
    used[corners] = True
    renumber = np.cumsum(used) - 1
    normals = np.concatenate([smooth, normal[index].astype(np.float32)])[used]
    source = source[used]
    return positions[source], renumber[corners].astype(np.uint32).reshape(-1, 3), normals, source


def _faces(positions: F32, triangles: U32) -> tuple[F32, F32]:
    """Unit normals (t, 3), zero for degenerate triangles, and corner angles (t, 3) in radians."""
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    edges = [b - a, c - b, a - c]
    normal = np.cross(edges[0], -edges[2])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    units = [e / np.maximum(np.linalg.norm(e, axis=1, keepdims=True), 1e-300) for e in edges]
    cosines = [-(units[k] * units[k - 1]).sum(1) for k in range(3)]
    angles = np.arccos(np.clip(np.stack(cosines, 1), -1, 1))
    return normal.astype(np.float32), angles.astype(np.float32)
