"""Voxels that spheres fill."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from ..scene.bounds import similarity_scale
from ..scene.spheres import Spheres
from .grid import Grid

U8 = NDArray[np.uint8]
F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

SHARPNESS = 2
"""Of a sphere's edge, over that of a half-space at right angles to an axis: rays that pass it by half a voxel should not meet it."""
LARGE = 6.0
"""Radius in voxels from which spheres are filled one by one; of smaller ones many at once, offset by offset."""
AT_ONCE = 1 << 15
"""Small spheres whose arrays stay in the caches."""


def fill_spheres(voxels: U8, grid: Grid, spheres: Spheres) -> None:
    """Raise ``voxels`` (z, y, x), 0..255, to the share that each sphere fills of them, every instance.

    The share is told by how far the middle of a voxel lies from the sphere's surface.
    """
    order = np.argsort(spheres.radii, kind="stable")
    order = order[spheres.radii[order] > 0]
    for transform in spheres.transforms:
        matrix = grid.to_voxels @ transform
        radii = (spheres.radii[order] * similarity_scale(matrix)).astype(np.float32)
        centers = spheres.centers[order].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        small = int(np.searchsorted(radii, LARGE))
        for start in range(0, small, AT_ONCE):
            part = slice(start, min(start + AT_ONCE, small))
            _fill_small(voxels, centers[part], radii[part])
        for center, radius in zip(centers[small:], radii[small:], strict=True):
            _fill_large(voxels, center, float(radius))


def _share(beyond: F32) -> U8:
    """Return 0..255 of voxels whose middles lie so far within the surface."""
    share: F32 = np.clip(SHARPNESS * beyond + np.float32(0.5), 0, 1)
    return np.asarray(255 * share + np.float32(0.5), np.uint8)


def _fill_small(voxels: U8, centers: F64, radii: F32) -> None:
    """Fill with spheres about ``centers`` (n, 3) in voxels. Offsets reach as far as the last and largest does."""
    flat, (_, height, width) = voxels.reshape(-1), voxels.shape
    cells = np.floor(centers).astype(np.int64)
    x, y, z = (centers - cells - 0.5).T.astype(np.float32)
    first = (cells[:, 2] * height + cells[:, 1]) * width + cells[:, 0]
    reach = math.ceil(float(radii[-1]) + 0.5 / SHARPNESS)
    span = range(-reach, reach + 1)
    for k, j in itertools.product(span, span):
        across = (k - z) ** 2 + (j - y) ** 2
        for i in span:
            within = radii - np.sqrt(across + (i - x) ** 2)
            met = np.flatnonzero(within > -0.5 / SHARPNESS)
            if len(met):
                np.maximum.at(flat, first[met] + ((k * height + j) * width + i), _share(within[met]))


def _fill_large(voxels: U8, center: F64, radius: float) -> None:
    """Fill with a sphere about ``center`` (3,) in voxels, layer by layer."""
    low = np.maximum(np.floor(center - radius - 1), 0).astype(int)
    high = np.minimum(np.ceil(center + radius + 1), voxels.shape[::-1]).astype(int)
    x, y, z = (np.arange(a, b) + 0.5 - c for a, b, c in zip(low, high, center, strict=True))
    across = (y[:, None] ** 2 + x**2).astype(np.float32)
    for layer, dz in zip(voxels[low[2] : high[2]], z, strict=True):
        part = layer[low[1] : high[1], low[0] : high[0]]
        np.maximum(part, _share(np.float32(radius) - np.sqrt(across + np.float32(dz * dz))), out=part)
