"""Volumes as blockers: an iso-surface blocks where a ray first meets it, a transfer function by its opacity along the ray."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..scene.proximity import proximity
from ..scene.volume import Volume
from .blockers import F32, F64, Hits

if TYPE_CHECKING:
    from .volume_kernels import Grid, Medium

VOXEL_BYTES = 5
"""Memory of a voxel for rays: of its field, and of how far they may leap."""


class VolumeBlockers:
    """Volumes, each traced by itself.

    An iso-surface is met where the trilinear field crosses its level, exactly. Under a transfer function what is seen lies where
    opacity along the primary ray reaches 1/2, and a ray is blocked by the share of light that it loses, from just outside of
    the material that its surface is made of: a surface does not shade itself.
    """

    def __init__(self, placed: Sequence[tuple[Volume, F64]], name: str = "the scene") -> None:
        """``placed``: volumes with matrices (3, 4) from voxel indices to local coordinates. Raises SettingsError without numba."""
        try:
            import numba  # noqa: F401
        except ImportError:
            raise SettingsError("tracing volumes needs the package numba: pip install 'ssao_gl[truth-volumes]'") from None
        self._parts = [_part(volume, matrix) for volume, matrix in placed]

    def occluded(self, origins: F32, directions: F32, reach: float) -> NDArray[Any]:
        every = [part.blocked(origins, directions, reach) for part in self._parts]
        if all(one.dtype == bool for one in every):
            return np.asarray(np.logical_or.reduce(every))
        return np.asarray(1 - np.prod([1 - one.astype(np.float64) for one in every], axis=0))

    def distances(self, origins: F32, directions: F32, reach: float) -> F32:
        limit = np.full(len(origins), reach, np.float32)
        found = [part.first(origins, directions, limit)[0] for part in self._parts]
        return np.asarray(np.minimum.reduce([np.where(far >= 0, far, reach) for far in found]), np.float32)

    def hits(self, origins: F32, directions: F32, reach: F32) -> Hits:
        found = [part.first(origins, directions, reach) for part in self._parts]
        far = np.stack([np.where(distance >= 0, distance, np.inf) for distance, _ in found])
        nearest, rays = far.argmin(0), np.flatnonzero(np.isfinite(far.min(0)))
        points, normals, shading = (np.empty((len(rays), 3)) for _ in range(3))
        distance = far[nearest[rays], rays]
        for index, (part, (_, cells)) in enumerate(zip(self._parts, found, strict=True)):
            of = np.flatnonzero(nearest[rays] == index)
            at = rays[of]
            points[of] = origins[at].astype(np.float64) + distance[of, None] * directions[at].astype(np.float64)
            normals[of], shading[of] = part.normals(points[of], cells[at], directions[at])
        return Hits(rays, distance.astype(np.float32), points, normals, shading)


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A volume for rays in local coordinates. to_field: (3, 4) to coordinates of its field; unit: length that opacities hold
    over; medium: None for an iso-surface."""

    grid: Grid
    to_field: F64
    unit: float
    medium: Medium | None

    def _rays(self, origins: NDArray[Any], directions: NDArray[Any]) -> tuple[F64, F64]:
        turn = self.to_field[:, :3]
        return origins.astype(np.float64) @ turn.T + self.to_field[:, 3], directions.astype(np.float64) @ turn.T

    def first(self, origins: F32, directions: F32, reach: F32) -> tuple[F64, NDArray[np.int64]]:
        """Return how far rays go (n,) to what is seen, -1 for nothing, and its cells (n, 3)."""
        from .volume_kernels import seen_distances, surface_distances

        start, along = self._rays(origins, directions)
        far, cells = np.empty(len(start)), np.zeros((len(start), 3), np.int64)
        if self.medium is None:
            surface_distances(self.grid, start, along, reach, cells, far)
        else:
            units = self.unit / np.linalg.norm(directions.astype(np.float64), axis=1)
            seen_distances(self.grid, self.medium, start, along, reach, units, cells, far)
        return far, cells

    def blocked(self, origins: F32, directions: F32, reach: float) -> NDArray[Any]:
        """Return bool (n,), or opacity in 0..1 under a transfer function."""
        from .volume_kernels import opacities

        if self.medium is None:
            return self.first(origins, directions, np.full(len(origins), reach, np.float32))[0] >= 0
        start, along = self._rays(origins, directions)
        units = self.unit / np.linalg.norm(directions.astype(np.float64), axis=1)
        out, turn = np.empty(len(start), np.float32), self.to_field[:, :3]
        opacities(self.grid, self.medium, start, along, reach, units, turn @ turn.T, out)
        return out

    def normals(self, points: F64, cells: NDArray[np.int64], directions: F32) -> tuple[F64, F64]:
        """Return normals (n, 3) in local coordinates, of any length: the field's own, and those of smooth gradients.

        Under a transfer function both are to the side of less opacity; where that is away from the viewer, as it is at the rim of
        what is translucent, at right angles to the ray (see ``volume.frag``).
        """
        from .volume_kernels import gradients

        at, turn = self._rays(points, directions)[0], self.to_field[:, :3]
        exact, smooth, values = np.empty_like(points), np.empty_like(points), np.empty(len(points))
        gradients(self.grid[0], at, cells, exact, smooth, values)
        if self.medium is None:
            return exact @ turn, smooth @ turn
        reach = 0.5 * np.maximum(np.linalg.norm(smooth, axis=1), 1 / 255)
        opacity = self.medium[0]
        places = np.linspace(0, 1, len(opacity))
        above, below = (np.interp(values + sign * reach, places, opacity) for sign in (1, -1))
        against = (above > below) | ((above == below) & ((smooth @ turn * directions).sum(1) > 0))
        n = np.where(against, -1, 1)[:, None] * smooth @ turn
        ray = directions.astype(np.float64) / np.linalg.norm(directions, axis=1, keepdims=True)
        length = np.linalg.norm(n, axis=1, keepdims=True)
        n -= ray * np.maximum((n * ray).sum(1, keepdims=True) + 1e-3 * length, 0)
        return n, n


def _part(volume: Volume, matrix: F64) -> _Part:

    back = np.linalg.inv(matrix[:, :3])
    to_field = np.column_stack([back, 1 - back @ matrix[:, 3]])  # the field has a voxel more at its start
    grid = (volume.field, proximity(volume), np.ascontiguousarray(volume.occupied))
    if volume.transfer is None:
        return _Part(grid, to_field, 1.0, None)
    transfer = volume.transfer_of()
    scale = np.linalg.norm(matrix[:, :3], axis=0).min() / volume.voxel
    medium = (np.ascontiguousarray(transfer.table()[:, 3]), float(transfer.step))
    return _Part(grid, to_field, float((transfer.unit or volume.voxel) * scale), medium)
