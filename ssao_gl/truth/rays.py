"""A scene in Embree: which ray hits which triangle, and how far away.

Rays live in local coordinates: scene units about the middle of the scene's box, times the power of two that brings it
into -1..1. So the unit and the place of a scene do not matter to 32-bit floats.
"""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, SettingsError
from ..scene.model import Mesh, Scene
from ..scene.texels import alpha_at

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I32 = NDArray[np.int32]

CHUNK = 1 << 18
"""Vertices transformed at a time."""

TRIANGLE_BYTES = 256
"""Memory that Embree takes per triangle while it builds (measured: 240 for triangles that share no vertex)."""

DIAMETER = 4.0
"""Above the diagonal of the local box, which is at most 2 sqrt(3)."""

OFFSET = 2.0**-20
"""How far from its triangle a ray starts, in local units.

Coordinates below 1 round to 32-bit floats within 2^-25, which moves a plane or a point by at most sqrt(3) 2^-25; the
start, its own triangle and a triangle beside it in the same plane make three of these, and Embree's edge functions
work on differences up to 2 sqrt(3) with errors of a few 2^-24. 2^-20 is above the sum of them all. The bound is the
scene's, not the triangle's: the neighbour may be far larger. (Offsetting along the geometric normal by the reach of
rounding errors: Waechter & Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, 2019.)
"""


CUT_LAYERS = 256
"""Holes that a ray may go through one after another; a ray that meets more has met something."""


class RayScene:
    """Triangles of a scene, every instance, as blockers with two sides. Calls may come from several threads at once.

    What alpha cuts out blocks nothing.
    """

    def __init__(self, scene: Scene) -> None:
        """Raise SettingsError without embreex, SceneError for a scene that Embree cannot hold."""
        embree = _embreex()
        self.scene = scene
        _check_memory(scene)
        self.center, self.scale = _local(scene)
        self._parts = [(mesh, self._to_local(m)) for mesh in scene.drawn for m in mesh.transforms]
        self._cut = np.array([mesh.cutoff is not None for mesh, _ in self._parts], bool)
        self._embree = embree.rtcore_scene.EmbreeScene(robust=True)  # no leaks along edges
        for draw, matrix in self._parts:
            embree.mesh_construction.TriangleMesh(self._embree, _placed(draw, matrix), draw.triangles.view(np.int32))
        zero = np.zeros((1, 3), np.float32)
        self._embree.run(zero, zero + 1, query="OCCLUDED")  # the first query builds the tree, and must be alone

    def _to_local(self, transform: F64) -> F64:
        matrix = transform[:3] * self.scale
        matrix[:, 3] -= self.center * self.scale
        return matrix

    def occluded(self, origins: F32, directions: F32, reach: float) -> NDArray[np.bool_]:
        """Whether each ray (n, 3) hits anything nearer than ``reach``, in local units."""
        if self._cut.any():
            return np.asarray(self._solid_hits(origins, directions, np.full(len(origins), reach, np.float32))["geomID"] >= 0)
        return np.asarray(self._embree.run(origins, directions, dists=reach, query="OCCLUDED")) >= 0

    def distances(self, origins: F32, directions: F32, reach: float) -> F32:
        """Distance (n,) to the first hit of each ray (n, 3), ``reach`` where there is none."""
        if self._cut.any():
            found = self._solid_hits(origins, directions, np.full(len(origins), reach, np.float32))
            return np.where(found["geomID"] >= 0, found["tfar"], np.float32(reach))
        return np.asarray(self._embree.run(origins, directions, dists=reach, query="DISTANCE"))

    def hits(self, origins: F32, directions: F32, reach: F32) -> dict[str, NDArray[Any]]:
        """Return the first hits of rays (n, 3) within ``reach`` (n,): barycentric u and v, tfar, primID and geomID (-1: none)."""
        return self._solid_hits(origins, directions, reach) if self._cut.any() else self._hits(origins, directions, reach)

    def _hits(self, origins: F32, directions: F32, reach: F32) -> dict[str, NDArray[Any]]:
        # embreex writes the distances it finds into the array it is given.
        found: dict[str, NDArray[Any]] = self._embree.run(origins, directions, dists=reach.copy(), query="INTERSECT", output=1)
        return found

    def _solid_hits(self, origins: F32, directions: F32, reach: F32) -> dict[str, NDArray[Any]]:
        """:meth:`hits`, where rays that met a hole start anew behind it."""
        found = self._hits(origins, directions, reach)
        gone = np.zeros(len(origins), np.float32)
        length = np.linalg.norm(directions, axis=1)
        rays = self._at_holes(found, np.arange(len(origins)))
        for _ in range(CUT_LAYERS):
            if not len(rays):
                break
            gone[rays] = np.nextafter(gone[rays] + found["tfar"][rays], np.float32(np.inf)) + OFFSET / length[rays]
            left = np.maximum(reach[rays] - gone[rays], 0)
            further = self._hits(origins[rays] + gone[rays, None] * directions[rays], directions[rays], left)
            further["geomID"][left <= 0] = -1
            for name in ("u", "v", "tfar", "primID", "geomID"):
                found[name][rays] = further[name]
            rays = self._at_holes(found, rays)
        found["tfar"] += gone
        return found

    def _at_holes(self, found: dict[str, NDArray[Any]], rays: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return those of ``rays`` whose hits are cut out."""
        part = found["geomID"][rays].astype(np.int64)
        candidates = rays[(part >= 0) & self._cut[part]]
        holes = [candidates[:0]]
        part = found["geomID"][candidates]
        for number in np.unique(part):
            mesh = self._parts[number][0]
            of = candidates[part == number]
            alpha = alpha_at(mesh, found["primID"][of], found["u"][of].astype(np.float64), found["v"][of].astype(np.float64))
            holes.append(of[alpha < (mesh.cutoff or 0)])
        return np.sort(np.concatenate(holes))

    def placed(self, part: int) -> tuple[Mesh, F64]:
        """Return the mesh of a part, whose triangles it has in their order, and (3, 4) to local coordinates."""
        return self._parts[part]

    def corners(self, part: int, triangles: I32) -> tuple[F64, F64]:
        """Corners (n, 3, 3) of some triangles of a part, local, and vertex normals (n, 3, 3), zero where there are none.

        From the scene's own arrays in 64-bit, so that points and normals have no rounding of Embree's in them.
        """
        draw, matrix = self._parts[part]
        index = draw.triangles[triangles]
        points = draw.positions[index].astype(np.float64) @ matrix[:, :3].T + matrix[:, 3]
        if draw.normals is None:
            return points, np.zeros_like(points)
        return points, draw.normals[index].astype(np.float64) @ cofactors(matrix[:, :3]).T


def cofactors(m: F64) -> F64:
    """Return det(m) times the inverse transpose: turns normals as ``m`` turns planes, for singular matrices too."""
    return np.stack([np.cross(m[1], m[2]), np.cross(m[2], m[0]), np.cross(m[0], m[1])])


def _placed(draw: Mesh, matrix: F64) -> F32:
    """Local positions (n, 3), contiguous."""
    out = np.empty(draw.positions.shape, np.float32)
    for start in range(0, len(out), CHUNK):
        part = slice(start, start + CHUNK)
        out[part] = draw.positions[part].astype(np.float64) @ matrix[:, :3].T + matrix[:, 3]
    return out


def _local(scene: Scene) -> tuple[F64, float]:
    """Middle of the scene's box, and the power of two that brings half its longest side below 1."""
    low, high = scene.bounds
    half = float((high / 2 - low / 2).max())
    if not math.isfinite(half):
        raise SceneError(f"{scene.name or 'the scene'}: its coordinates exceed what 64-bit numbers hold; rays cannot be traced")
    exponent = math.frexp(half)[1] if half > 0 else 0
    return low / 2 + high / 2, math.ldexp(1.0, -max(exponent, -1000))


def _check_memory(scene: Scene) -> None:
    need, have = scene.triangles * TRIANGLE_BYTES, _memory()
    if need > have:
        raise SceneError(
            f"{scene.name or 'the scene'}: {scene.triangles:,} triangles (instances counted each) need about {need / 2**30:.1f} GiB"
            f" in Embree; this machine has {have / 2**30:.1f} GiB. Trace a part of it, or fewer instances"
        )


def _memory() -> float:
    """Bytes of memory of this machine; infinite where it does not say."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf


def threads() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _embreex() -> Any:
    try:
        import embreex
        import embreex.mesh_construction
        import embreex.rtcore_scene
    except ImportError:
        raise SettingsError("tracing rays needs the package embreex (x86-64 only): pip install 'ssao_gl[truth]'") from None
    return embreex
