"""Voxels that triangles go through."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..scene.model import Mesh
from .grid import Grid

SPACING = 0.5
"""Of points on a triangle, at most, in voxels."""
AT_ONCE = 1 << 18
"""Points that are placed at a time."""


def fill_mesh(voxels: NDArray[np.uint8], grid: Grid, mesh: Mesh) -> None:
    """Fill ``voxels`` (z, y, x) that triangles go through, every instance: a surface hides all, however thin it is."""
    flat, (_, height, width) = voxels.reshape(-1), voxels.shape
    for transform in mesh.transforms:
        matrix = grid.to_voxels @ transform
        corners = mesh.positions[mesh.triangles].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        longest = np.linalg.norm(corners - np.roll(corners, 1, 1), axis=2).max(1)
        rows = np.ceil(longest / SPACING).astype(np.int64) + 1
        for count in np.unique(rows):
            chosen = corners[rows == count].transpose(1, 2, 0).astype(np.float32)
            for places in _barycentric(int(count)):
                step = max(1, AT_ONCE // len(places))
                for start in range(0, chosen.shape[2], step):
                    x, y, z = np.tensordot(places, chosen[..., start : start + step], 1).transpose(1, 0, 2).astype(np.int32)
                    flat[(z.astype(np.int64) * height + y) * width + x] = 255


def _barycentric(rows: int) -> Iterator[NDArray[np.float32]]:
    """Yield the points (n, 3) of a triangular lattice with ``rows`` points along each edge, in parts."""
    most, at_once = max(rows - 1, 1), max(1, AT_ONCE // rows)
    for start in range(0, rows, at_once):
        i, j = np.meshgrid(np.arange(start, min(start + at_once, rows)), np.arange(rows), indexing="ij")
        kept = i + j < rows
        a, b = i[kept] / most, j[kept] / most
        yield np.column_stack([a, b, 1 - a - b]).astype(np.float32)
