"""How far rays through a volume may leap: where nothing changes about a cell, in each of its cells.

Cohen & Sheffer 1994, "Proximity Clouds: An Acceleration Technique for 3D Grid Traversal".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt

from .volume import Volume

FARTHEST = 127
"""Largest distance that is kept."""
INSIDE = 128
"""Is added where all of a cell is inside."""


def proximity(volume: Volume) -> NDArray[np.uint8]:
    """Return a number (z, y, x) for each cell of ``volume.field``: cell c lies between voxels c and c + 1.

    Its last seven bits are the distance d, along the axis that is farthest apart, to the nearest cell that the surface may
    go through, or in which something has opacity; 0 in such a cell itself. So all cells less than d away are on one side of
    the surface: inside with ``INSIDE``.
    """
    low = high = volume.field
    for axis in range(3):
        low, high = _pairs(low, np.minimum, axis), _pairs(high, np.maximum, axis)
    if volume.iso is not None:
        inside, some = low >= 0, (low < 0) & (high >= 0)
    else:
        inside, some = np.zeros(low.shape, bool), ~volume.transfer_of().transparent(low, high)
    away = distance_transform_cdt(~some, "chessboard") if some.any() else np.full(some.shape, FARTHEST)
    return np.asarray(np.minimum(away, FARTHEST) + INSIDE * inside, np.uint8)


def _pairs(field: NDArray[np.float32], by: np.ufunc, axis: int) -> NDArray[np.float32]:
    """Return the least or the largest of neighbours along an axis."""
    turned = np.moveaxis(field, axis, 0)
    return np.asarray(np.moveaxis(by(turned[1:], turned[:-1]), 0, axis))
