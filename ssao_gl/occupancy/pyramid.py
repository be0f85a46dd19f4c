"""Opacity along the axes over ever larger voxels.

As the directional voxels of Crassin et al., "Interactive Indirect Illumination Using Voxel Cone Tracing", 2011: what lies one behind the
other adds up as transmittance does, what lies side by side is averaged. So half a voxel of wall hides all of it from the front, and half
of it from the side.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .grid import LEVELS

U8 = NDArray[np.uint8]
SLABS = 8
"""Layers of a coarser level that are made at a time: no second copy of the whole in larger numbers."""


def pyramid(finest: U8) -> list[U8]:
    """Return levels 1 to ``LEVELS`` above ``finest`` (z, y, x): each (z, y, x, 3), opacity 0..255 along x, y and z."""
    levels: list[U8] = []
    below = finest[..., None]
    for _ in range(LEVELS):
        shape = tuple(n // 2 for n in below.shape[:3])
        above = np.empty((*shape, 3), np.uint8)
        for start in range(0, shape[0], SLABS):
            above[start : start + SLABS] = _halved(below[2 * start : 2 * (start + SLABS)])
        levels.append(above)
        below = above
    return levels


def _halved(below: U8) -> U8:
    """Return (z, y, x, 3) of voxels twice as large."""
    if not below.any():
        return np.zeros((*(n // 2 for n in below.shape[:3]), 3), np.uint8)
    clear = 255 - below.astype(np.uint16)
    found = []
    for axis, channel in ((2, 0), (1, 1), (0, 2)):
        own = np.moveaxis(clear[..., min(channel, below.shape[3] - 1)], axis, 0)
        through = np.moveaxis(own[0::2] * own[1::2], 0, axis)
        for other in {0, 1, 2} - {axis}:
            turned = np.moveaxis(through, other, 0)
            through = np.moveaxis(turned[0::2].astype(np.uint32) + turned[1::2], 0, other)
        found.append(255 - (through + 510) // 1020)
    return np.stack(found, -1).astype(np.uint8)


def atlas_shape(shape: Sequence[int]) -> tuple[int, int, int]:
    """Return (x, y, z) of the texture that holds all coarser levels of a grid of ``shape`` (x, y, z): level 1, and behind it the others."""
    x, y, z = (n // 2 for n in shape)
    return x, y, z + z // 2


def level_starts(shape: Sequence[int]) -> list[tuple[int, int, int]]:
    """Return where each level of a grid of ``shape`` (x, y, z) begins in its texture (x, y, z); the finest has one to itself."""
    widths = [shape[0] >> level for level in range(2, LEVELS + 1)]
    return [(0, 0, 0), (0, 0, 0), *((sum(widths[:k]), 0, shape[2] // 2) for k in range(LEVELS - 1))]


def atlas(levels: Sequence[U8]) -> U8:
    """Return (z, y, x, 4): level 1 from the corner on; behind it, from left to right, the others."""
    x, y, z = atlas_shape([2 * n for n in levels[0].shape[2::-1]])
    packed = np.zeros((z, y, x, 4), np.uint8)
    starts = level_starts([2 * n for n in levels[0].shape[2::-1]])
    for (left, _, start), level in zip(starts[1:], levels, strict=True):
        d, h, w = level.shape[:3]
        packed[start : start + d, :h, left : left + w, :3] = level
    return packed
