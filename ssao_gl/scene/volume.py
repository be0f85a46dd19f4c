"""Volumes: values on a regular grid."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Volume:
    """Values (x, y, z) at the points of a grid. affine: (4, 4) float64, from indices to the world; voxel centres at integers."""

    array: NDArray[Any]
    affine: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))

    @property
    def transforms(self) -> NDArray[np.float64]:
        """(1, 4, 4): it is drawn once."""
        return self.affine[None]

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """(2, 3) box in the world, voxels being whole."""
        return np.asarray(self.pieces(self.affine)[0][0])

    @property
    def is_placed(self) -> bool:
        """Whether it has voxels."""
        return self.array.size > 0

    @property
    def can_show(self) -> bool:
        """Whether something of it may be seen."""
        return self.is_placed

    @property
    def piece_count(self) -> int:
        """It is one."""
        return 1

    @property
    def contents(self) -> str:
        """What it is, in words."""
        return f"volume of {'x'.join(map(str, self.array.shape))}"

    def outline(self) -> NDArray[np.float32]:
        """Return its corners (8, 3), as indices."""
        ends = [(-0.5, n - 0.5) for n in self.array.shape]
        return np.array(list(itertools.product(*ends)), np.float32)

    def pieces(self, matrix: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return its box (1, 2, 3) in the world, and the box's area (1,)."""
        corners = self.outline() @ matrix[:3, :3].T + matrix[:3, 3]
        box = np.stack([corners.min(0), corners.max(0)])
        x, y, z = box[1] - box[0]
        return box[None], np.array([2 * (x * y + y * z + z * x)])
