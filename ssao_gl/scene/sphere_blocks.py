"""Spheres in blocks of neighbours, so that those out of sight can be left out together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BLOCK = 32
"""Spheres of a block at most: small enough to be compact, large enough that looking at blocks costs little."""
_SPREAD = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)


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
    """Return the place of each point (n, 3) along the Z-order curve (Morton 1966) through their bounding box, 21 bits an axis."""
    low, high = points.min(0), points.max(0)
    side = float((high - low).max()) or 1.0
    cells = ((points - low) / side * ((1 << 21) - 1)).astype(np.uint64)
    for shift, mask in _SPREAD:  # two zero bits between one bit and the next
        cells = (cells | cells << np.uint64(shift)) & np.uint64(mask)
    codes: NDArray[np.uint64] = cells[:, 0] | cells[:, 1] << np.uint64(1) | cells[:, 2] << np.uint64(2)
    return codes
