"""Voxels that a volume fills."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.volume import Volume
from .grid import Grid

SLABS = 16
"""Layers of the grid that are made at a time."""


def fill_volume(voxels: NDArray[np.uint8], grid: Grid, volume: Volume) -> None:
    """Raise ``voxels`` (z, y, x), 0..255, to the share that lies inside of an iso-surface, or to the opacity under a transfer function.

    The share is that of a half-space as far from the middle of the voxel as the surface is, by the field and its gradient there.
    """
    from scipy.ndimage import affine_transform  # slow to import

    to_field = (np.linalg.inv(volume.to_world) @ np.linalg.inv(grid.to_voxels))[:3]
    matrix, start = to_field[::-1, 2::-1], to_field[::-1] @ (0.5, 0.5, 0.5, 1)
    depth = len(voxels)
    for first in range(0, depth, SLABS):
        end = min(first + SLABS, depth)
        shape = (end - first + 2, *voxels.shape[1:])
        offset = start + matrix[:, 0] * (first - 1)
        values = affine_transform(volume.field, matrix, offset, shape, np.float32, order=1, mode="nearest")
        found = _inside(values) if volume.transfer is None else _opacity(volume, grid, values)
        part = voxels[first:end]
        np.maximum(part, (255 * found[1:-1] + 0.5).astype(np.uint8), out=part)


def _inside(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the share (z, y, x) of each voxel that lies inside the level 0."""
    slope = sum(np.abs(np.gradient(values, axis=axis)) for axis in range(3) if values.shape[axis] > 1)
    return np.clip(0.5 + values / np.maximum(slope, 1e-30), 0, 1)


def _opacity(volume: Volume, grid: Grid, values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the share (z, y, x) of light that is lost over the side of a voxel."""
    transfer = volume.transfer_of()
    table = transfer.table()[:, 3]
    alpha = np.interp(values, np.linspace(0, 1, len(table)), table)
    return np.asarray(1 - (1 - np.minimum(alpha, 1)) ** (grid.side / (transfer.unit or volume.voxel)), np.float32)
