"""Voxels that triangles go through."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.model import Mesh
from ..scene.texels import alpha_at
from .grid import Grid

SPACING = 0.5
"""Of points on a triangle, at most, in voxels."""
AT_ONCE = 1 << 18
"""Points that are placed at a time."""


def fill_mesh(voxels: NDArray[np.uint8], grid: Grid, mesh: Mesh) -> None:
    """Fill ``voxels`` (z, y, x) that triangles go through, every instance: a surface hides all, however thin it is.

    What alpha cuts out fills nothing.
    """
    flat, (_, height, width) = voxels.reshape(-1), voxels.shape
    for transform in mesh.transforms:
        matrix = grid.to_voxels @ transform
        corners = mesh.positions[mesh.triangles].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        longest = np.linalg.norm(corners - np.roll(corners, 1, 1), axis=2).max(1)
        rows = np.ceil(longest / SPACING).astype(np.int64) + 1
        for count in np.unique(rows):
            chosen = np.flatnonzero(rows == count)
            for places in _barycentric(int(count)):
                for some in np.array_split(chosen, math.ceil(len(chosen) * len(places) / AT_ONCE)):
                    points = np.tensordot(places, corners[some].transpose(1, 2, 0).astype(np.float32), 1)
                    x, y, z = points.transpose(1, 0, 2)[:, _solid(mesh, some, places)].astype(np.int32)
                    flat[(z.astype(np.int64) * height + y) * width + x] = 255


def _solid(mesh: Mesh, triangles: NDArray[np.int64], places: NDArray[np.float32]) -> Any:
    """Return where there is a surface at ``places`` (m, 3) of ``triangles`` (n,): (m, n), or all."""
    if mesh.cutoff is None:
        return ...
    which, u, v = np.tile(triangles, len(places)), *np.repeat(places[:, 1:].astype(np.float64), len(triangles), 0).T
    return (alpha_at(mesh, which, u, v) >= mesh.cutoff).reshape(len(places), -1)


def _barycentric(rows: int) -> Iterator[NDArray[np.float32]]:
    """Yield the points (n, 3) of a triangular lattice with ``rows`` points along each edge, in parts."""
    most, at_once = max(rows - 1, 1), max(1, AT_ONCE // rows)
    for start in range(0, rows, at_once):
        i, j = np.meshgrid(np.arange(start, min(start + at_once, rows)), np.arange(rows), indexing="ij")
        kept = i + j < rows
        a, b = i[kept] / most, j[kept] / most
        yield np.column_stack([a, b, 1 - a - b]).astype(np.float32)
