"""The occupancy of a scene: one field, whatever fills it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.bounds import similarity_scale
from ..scene.model import Mesh, Scene
from ..scene.spheres import Spheres
from ..scene.volume import Volume
from .grid import Grid, grid_over
from .meshes import fill_mesh
from .pyramid import atlas, pyramid
from .spheres import fill_spheres
from .volumes import fill_volume

FILLERS: Mapping[type, Callable[[NDArray[np.uint8], Grid, Any], None]] = {
    Mesh: fill_mesh,
    Spheres: fill_spheres,
    Volume: fill_volume,
}

SOLID_LIFT, SHELL_LIFT = (0.2, 0.3, 0.0), (1.05, 0.05, 1.0)
"""Of a solid that a plane bounds, voxels are filled as far as they lie below it, and larger ones hide a little more; of a shell all that
it goes through are full, and of larger ones as much as its projections along the axes fill: see the shader."""

APART = 0.75
"""Spheres whose radius is the side of a voxel are apart by this share."""

BYTES = 1 + 4 * (1 + 1 / 2) / 8
"""Of a finest voxel, on the GPU, with its share of the larger ones: see :func:`.pyramid.atlas`."""


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """How much of each voxel is filled, and how much larger ones hide.

    finest: (z, y, x) uint8 shares. coarser: (z, y, x, 4) uint8 opacities along x, y, z, as :func:`.pyramid.atlas` packs them.
    apart: share of 0..1 by which things in different voxels of a ray are apart: 0 where voxels are small beside them, so that a ray
    that grazes some is hidden by the fullest. lift: by how many voxels, of the finest, of larger ones, and of larger ones that a surface
    crosses along an axis, a tangent plane is lifted so that its own surface lies below.
    """

    grid: Grid
    finest: NDArray[np.uint8]
    coarser: NDArray[np.uint8]
    apart: float
    lift: tuple[float, float, float]

    @property
    def bytes(self) -> int:
        """On the GPU."""
        return self.finest.nbytes + self.coarser.nbytes


def field_of(scene: Scene, side: float) -> Field:
    """Return the field of all that is drawn of ``scene``, with voxels of ``side`` scene units. It knows of no view."""
    grid = grid_over(scene.bounds, side)
    finest = np.zeros(grid.shape[::-1], np.uint8)
    for thing in scene.drawn:
        FILLERS[type(thing)](finest, grid, thing)
    apart = _apart(scene, side)
    return Field(grid, finest, atlas(pyramid(finest)), apart, _lift(scene, apart))


def _apart(scene: Scene, side: float) -> float:
    """Return a share of the side of voxels over the mean radius of spheres, at most 1; 1 for what is translucent, 0 for surfaces."""
    if any(isinstance(thing, Volume) and thing.transfer is not None for thing in scene.drawn):
        return 1.0
    radii = [_mean_radius(thing) for thing in scene.drawn if isinstance(thing, Spheres) and (thing.radii > 0).any()]
    return min(APART * side / float(np.mean(radii)), 1.0) if radii else 0.0


def _mean_radius(spheres: Spheres) -> float:
    """Return the mean radius in the world of those that fill something."""
    return float(spheres.radii[spheres.radii > 0].mean(dtype=np.float64)) * similarity_scale(spheres.transforms[0])


def _lift(scene: Scene, apart: float) -> tuple[float, float, float]:
    """Return what a plane is lifted by; less where voxels are not small, and what is near is in the one that a plane goes through."""
    if any(isinstance(thing, Mesh) for thing in scene.drawn):
        return SHELL_LIFT
    fine, coarse, across = SOLID_LIFT
    return fine * (1 - apart), coarse * (1 - apart), across
