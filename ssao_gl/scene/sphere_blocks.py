"""Spheres in blocks of neighbours, so that those out of sight can be left out together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .z_order import BITS, along_z_order

BLOCK = 32
"""Spheres of a block at most: small enough to be compact, large enough that looking at blocks costs little."""


@dataclass(frozen=True, slots=True, eq=False)
class SphereBlocks:
    """Blocks of ``size`` spheres each, the last one of what remains.

    order: (n,) the spheres, block by block. balls: (b, 4) float64 middle and radius of a ball around each block.
    """

    size: int
    order: NDArray[np.intp]
    balls: NDArray[np.float64]


def sphere_blocks(centers: NDArray[np.float64], radii: NDArray[np.float32]) -> SphereBlocks:
    """Return the blocks of spheres, centers (n, 3) and radii (n,); few are one block in their own order."""
    count = len(centers)
    size = min(count, BLOCK)
    order = np.arange(count) if count <= BLOCK else np.argsort(morton_codes(centers), kind="stable")
    starts = np.arange(0, count, size)
    at, radius = centers[order], radii[order].astype(np.float64)[:, None]
    low, high = np.minimum.reduceat(at, starts), np.maximum.reduceat(at, starts)
    middle = low / 2 + high / 2
    away = np.linalg.norm(at - np.repeat(middle, size, 0)[:count], axis=1) + radius[:, 0]
    return SphereBlocks(size, order, np.column_stack([middle, np.maximum.reduceat(away, starts)]))


def morton_codes(points: NDArray[np.float64]) -> NDArray[np.uint64]:
    """Return the place of each point (n, 3) along the Z-order curve through their bounding box."""
    low, high = points.min(0), points.max(0)
    side = float((high - low).max()) or 1.0
    return along_z_order(((points - low) / side * ((1 << BITS) - 1)).astype(np.uint64))
