"""How far rays through a volume may leap: where nothing changes about a cell, in each of its cells.

Cohen & Sheffer 1994, "Proximity Clouds: An Acceleration Technique for 3D Grid Traversal".
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

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
    from scipy.ndimage import distance_transform_cdt  # slow to import

    if volume.iso is not None:
        sides = volume.field >= 0
        inside = _cells(sides, np.logical_and)
        some = _cells(sides, np.logical_or) & ~inside
    else:
        low, high = _cells(volume.field, np.minimum), _cells(volume.field, np.maximum)
        inside, some = np.zeros(low.shape, bool), ~volume.transfer_of().transparent(low, high)
    away = distance_transform_cdt(~some, "chessboard") if some.any() else np.full(some.shape, FARTHEST)
    return np.asarray(np.minimum(away, FARTHEST) + INSIDE * inside, np.uint8)


def _cells(voxels: NDArray[Any], by: np.ufunc) -> NDArray[Any]:
    """Return, for each cell, what ``by`` makes of the eight voxels about it."""
    for axis in range(3):
        turned = np.moveaxis(voxels, axis, 0)
        voxels = np.moveaxis(by(turned[1:], turned[:-1]), 0, axis)
    return voxels
