"""A scene's spheres in a grid: which ray hits which sphere, exactly, and how far away."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..scene.bounds import similarity_scale
from ..scene.spheres import Spheres
from .blockers import F32, F64, Hits, check_memory

CELL = 3.0
"""Side of a cell in mean radii."""
CELLS_PER_SPHERE, ENTRIES_PER_SPHERE, SPARE = 64, 24, 1 << 16
"""Most cells, and most places in their lists, for so many spheres and for none; beyond them, cells are made larger."""
SPHERE_BYTES = 150
"""Memory of a sphere in the grid, with the cells around it (measured on molecules: 100 to 130)."""


class SphereBlockers:
    """Hollow spheres, every instance."""

    def __init__(self, placed: Sequence[tuple[Spheres, F64]], name: str = "the scene") -> None:
        """``placed``: spheres with matrices (3, 4) to local coordinates.

        Raises SettingsError without numba, SceneError for more than memory can hold.
        """
        self._kernels = _kernels()
        count = sum(len(spheres.centers) for spheres, _ in placed)
        check_memory(name, f"{count:,} spheres", count * SPHERE_BYTES, "for rays")
        self._spheres = np.concatenate([_local(spheres, matrix) for spheres, matrix in placed])
        self._low, self._cell, self._shape = self._grid()
        self._starts, self._members = self._lists()

    def _grid(self) -> tuple[float, float, tuple[int, int, int]]:
        """Return where the grid begins on every axis, the side of its cells, and how many there are along each."""
        centers, radii = self._spheres[:, :3].astype(np.float64), self._spheres[:, 3].astype(np.float64)
        low, high = float((centers - radii[:, None]).min()), (centers + radii[:, None]).max(0)
        cell = max(CELL * float(radii.mean()), 1e-9)
        most_cells = CELLS_PER_SPHERE * len(radii) + SPARE
        most_entries = ENTRIES_PER_SPHERE * len(radii) + SPARE
        while True:
            counts = np.maximum(np.ceil((high - low) / cell), 1)
            entries = ((2 * radii / cell + 1) ** 3).sum()
            if counts.prod() <= most_cells and entries <= most_entries:
                return low, cell, (int(counts[0]), int(counts[1]), int(counts[2]))
            cell *= 1.25

    def _lists(self) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
        """Return where each cell's list begins (cells + 1,), and the lists."""
        place = (self._spheres, self._low, self._cell, self._shape)
        starts = np.zeros(self._shape[0] * self._shape[1] * self._shape[2] + 1, np.int64)
        self._kernels.count_cells(*place, starts)
        np.cumsum(starts, out=starts)
        members = np.empty(starts[-1], np.uint32)
        self._kernels.fill_cells(*place, starts[:-1].copy(), members)
        return starts, members

    def _first(self, origins: F32, directions: F32, reach: F32, *, whole: bool) -> tuple[F64, NDArray[np.int64]]:
        distance, found = np.empty(len(origins)), np.empty(len(origins), np.int64)
        rays = (np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32), reach)
        lists = (self._starts, self._members)
        self._kernels.first_hits(rays, self._spheres, self._low, self._cell, self._shape, lists, whole, distance, found)
        return distance, found

    def occluded(self, origins: F32, directions: F32, reach: float) -> NDArray[np.bool_]:
        """Whether each ray (n, 3) hits anything nearer than ``reach``, in local units."""
        return self._first(origins, directions, np.full(len(origins), reach, np.float32), whole=False)[1] >= 0

    def distances(self, origins: F32, directions: F32, reach: float) -> F32:
        """Distance (n,) to the first hit of each ray (n, 3), ``reach`` where there is none."""
        return self._first(origins, directions, np.full(len(origins), reach, np.float32), whole=True)[0].astype(np.float32)

    def hits(self, origins: F32, directions: F32, reach: F32) -> Hits:
        """Return the first hits of rays (n, 3) within ``reach`` (n,)."""
        distance, found = self._first(origins, directions, np.ascontiguousarray(reach, np.float32), whole=True)
        rays = np.flatnonzero(found >= 0)
        sphere = self._spheres[found[rays]].astype(np.float64)
        points = origins[rays].astype(np.float64) + distance[rays, None] * directions[rays]
        outward = points - sphere[:, :3]
        # On the sphere to the last bit, whatever the ray's length.
        outward *= (sphere[:, 3] / np.linalg.norm(outward, axis=1))[:, None]
        return Hits(rays, distance[rays].astype(np.float32), sphere[:, :3] + outward, outward, outward.copy())


def _local(spheres: Spheres, matrix: F64) -> F32:
    """Centres and radii (n, 4) in local coordinates."""
    centers = spheres.centers.astype(np.float64) @ matrix[:, :3].T + matrix[:, 3]
    return np.column_stack([centers, spheres.radii * similarity_scale(matrix)]).astype(np.float32)


def _kernels() -> Any:
    try:
        from . import sphere_kernels
    except ImportError:
        raise SettingsError(
            "tracing rays through spheres needs the package numba: pip install 'ssao_gl[truth-spheres]'"
        ) from None
    return sphere_kernels
