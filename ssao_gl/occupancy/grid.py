"""Where the voxels of a scene lie, and how large they are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LEVELS = 3
"""Coarser levels above the finest: voxels of 2, 4 and 8 times the side."""

MOST_VOXELS = 1 << 27
"""Of the finest level; scenes that would need more get larger voxels. A voxel takes 1.8 bytes in all, and as much again on the GPU."""

ASIDE = 0.27127
"""Of a coarsest voxel, by which all lie off the origin: walls of models lie at round numbers, and a wall between two voxels would be in
either by rounding."""

LONGEST = 1 << 10
"""Voxels along a side, of what most drivers hold in a 3-D texture."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Cubes of ``side`` scene units, ``shape`` (x, y, z) of them from the world corner ``low`` (3,) on.

    The corner is a multiple of the coarsest side and ``ASIDE``, so that a scene that grows keeps its voxels. The shape is one of the coarsest voxels.
    """

    low: NDArray[np.float64]
    side: float
    shape: tuple[int, int, int]

    @property
    def to_voxels(self) -> NDArray[np.float64]:
        """(4, 4) from the world to voxels: voxel i lies from i to i + 1."""
        matrix = np.diag([1 / self.side] * 3 + [1.0])
        matrix[:3, 3] = -self.low / self.side
        return matrix


def grid_over(bounds: NDArray[np.float64], side: float) -> Grid:
    """Return the grid of voxels of ``side`` that holds the box ``bounds`` (2, 3)."""
    coarsest = side * 2**LEVELS
    first, end = np.floor(bounds[0] / coarsest - ASIDE - 1e-6) - 1, np.ceil(bounds[1] / coarsest - ASIDE + 1e-6) + 1
    x, y, z = (int(n) << LEVELS for n in end - first)
    return Grid((first + ASIDE) * coarsest, side, (x, y, z))


def affordable_side(bounds: NDArray[np.float64], wanted: float, most: int = MOST_VOXELS) -> float:
    """Return the side of voxels: ``wanted``, or as much larger as it takes that no more than ``most`` fill ``bounds`` (2, 3)."""
    extent = bounds[1] - bounds[0]
    side = max(wanted, float(extent.max()) / (LONGEST - (3 << LEVELS)))
    while math.prod(math.ceil(e / side / 2**LEVELS + 3) << LEVELS for e in extent) > most:
        side *= 1.02
    return side
