"""A scene for rays: whatever in it blocks them, asked together.

Rays live in local coordinates: scene units about the middle of the scene's box, times the power of two that brings it
into -1..1. So the unit and the place of a scene do not matter to 32-bit floats.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..scene.model import Mesh, Scene
from ..scene.spheres import Spheres
from ..scene.volume import Volume
from .blockers import F32, F64, Blockers, Hits
from .spheres import SPHERE_BYTES, SphereBlockers
from .triangles import TRIANGLE_BYTES, TriangleBlockers
from .volumes import VOXEL_BYTES, VolumeBlockers

KINDS: Mapping[type, Callable[[Sequence[tuple[Any, F64]], str], Blockers]] = {
    Mesh: TriangleBlockers,
    Spheres: SphereBlockers,
    Volume: VolumeBlockers,
}
"""Things of a scene -> what makes blockers of them and of matrices (3, 4) that place them in local coordinates."""


class RayScene:
    """All blockers of a scene, every instance. Calls may come from several threads at once."""

    def __init__(self, scene: Scene) -> None:
        """Raise SettingsError for packages that are missing, SceneError for a scene that cannot be held."""
        self.scene = scene
        self.center, self.scale = _local(scene)
        self._blockers: list[Blockers] = []
        for kind, blockers in KINDS.items():
            things = [thing for thing in scene.drawn if isinstance(thing, kind)]
            placed = [(thing, self._to_local(matrix)) for thing in things for matrix in thing.transforms]
            if placed:
                self._blockers.append(blockers(placed, scene.name or "the scene"))

    @property
    def triangles(self) -> TriangleBlockers:
        """Those blockers that are triangles. Raises SceneError in a scene without any."""
        for blockers in self._blockers:
            if isinstance(blockers, TriangleBlockers):
                return blockers
        raise SceneError(f"{self.scene.name or 'the scene'}: has no triangles")

    def _to_local(self, transform: F64) -> F64:
        matrix = transform[:3] * self.scale
        matrix[:, 3] -= self.center * self.scale
        return matrix

    def occluded(self, origins: F32, directions: F32, reach: float) -> NDArray[Any]:
        """Return how much of each ray (n, 3) is blocked nearer than ``reach``, in local units: bool, or shares in 0..1."""
        every = [blockers.occluded(origins, directions, reach) for blockers in self._blockers]
        if len(every) == 1:
            return every[0]
        if all(one.dtype == bool for one in every):
            return np.asarray(np.logical_or.reduce(every))
        return np.asarray(1 - np.prod([1 - one.astype(np.float64) for one in every], axis=0))

    def distances(self, origins: F32, directions: F32, reach: float) -> F32:
        """Distance (n,) to the first hit of each ray (n, 3), ``reach`` where there is none."""
        every = [blockers.distances(origins, directions, reach) for blockers in self._blockers]
        return every[0] if len(every) == 1 else np.asarray(np.minimum.reduce(every))

    def hits(self, origins: F32, directions: F32, reach: F32) -> Hits:
        """Return the first hits of rays (n, 3) within ``reach`` (n,)."""
        return _nearest([blockers.hits(origins, directions, reach) for blockers in self._blockers])


def tree_bytes(scene: Scene) -> int:
    """Return the memory that a scene's blockers take, as far as it is known beforehand."""
    spheres = sum(thing.piece_count * len(thing.transforms) for thing in scene.drawn if isinstance(thing, Spheres))
    voxels = sum(volume.field.size for volume in scene.volumes)
    return scene.triangles * TRIANGLE_BYTES + spheres * SPHERE_BYTES + voxels * VOXEL_BYTES


def _nearest(every: Sequence[Hits]) -> Hits:
    """Return the nearest of the hits of each ray."""
    if len(every) == 1:
        return every[0]
    rays, distance = (np.concatenate([getattr(hits, name) for hits in every]) for name in ("rays", "distance"))
    order = np.lexsort((distance, rays))
    first = order[np.flatnonzero(np.diff(rays[order], prepend=-1))]
    points, normals, shading = (
        np.concatenate([getattr(h, name) for h in every])[first] for name in ("points", "normals", "shading")
    )
    return Hits(rays[first], distance[first], points, normals, shading)


def _local(scene: Scene) -> tuple[F64, float]:
    """Middle of the scene's box, and the power of two that brings half its longest side below 1."""
    low, high = scene.bounds
    half = float((high / 2 - low / 2).max())
    if not math.isfinite(half):
        raise SceneError(f"{scene.name or 'the scene'}: its coordinates exceed what 64-bit numbers hold; rays cannot be traced")
    exponent = math.frexp(half)[1] if half > 0 else 0
    return low / 2 + high / 2, math.ldexp(1.0, -max(exponent, -1000))
