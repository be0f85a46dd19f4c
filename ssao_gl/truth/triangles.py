"""A scene's triangles in Embree: which ray hits which triangle, and how far away."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..scene.model import Mesh
from ..scene.texels import alpha_at
from .blockers import F32, F64, OFFSET, Hits, check_memory

I32 = NDArray[np.int32]

CHUNK = 1 << 18
"""Vertices transformed at a time."""

TRIANGLE_BYTES = 256
"""Memory that Embree takes per triangle while it builds (measured: 240 for triangles that share no vertex)."""

CUT_LAYERS = 256
"""Holes that a ray may go through one after another; a ray that meets more has met something."""


class TriangleBlockers:
    """Triangles, every instance, with two sides. What alpha cuts out blocks nothing."""

    def __init__(self, placed: Sequence[tuple[Mesh, F64]], name: str = "the scene") -> None:
        """``placed``: meshes with matrices (3, 4) to local coordinates.

        Raises SettingsError without embreex, SceneError for more than Embree can hold.
        """
        embree = _embreex()
        count = sum(len(mesh.triangles) for mesh, _ in placed)
        check_memory(name, f"{count:,} triangles", count * TRIANGLE_BYTES, "in Embree")
        self._parts = placed
        self._cut = np.array([mesh.cutoff is not None for mesh, _ in self._parts], bool)
        self._embree = embree.rtcore_scene.EmbreeScene(robust=True)  # no leaks along edges
        for draw, matrix in self._parts:
            embree.mesh_construction.TriangleMesh(self._embree, _placed(draw, matrix), draw.triangles.view(np.int32))
        zero = np.zeros((1, 3), np.float32)
        self._embree.run(zero, zero + 1, query="OCCLUDED")  # the first query builds the tree, and must be alone

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

    def hits(self, origins: F32, directions: F32, reach: F32) -> Hits:
        """Return the first hits of rays (n, 3) within ``reach`` (n,)."""
        found = self._solid_hits(origins, directions, reach) if self._cut.any() else self._hits(origins, directions, reach)
        hit = np.flatnonzero(found["geomID"] >= 0)
        return Hits(hit, found["tfar"][hit], *self._interpolated({n: found[n][hit] for n in ("u", "v", "primID", "geomID")}))

    def parts_hit(self, origins: F32, directions: F32, reach: F32) -> NDArray[np.int32]:
        """Return the number of the part (n,) that each ray (n, 3) meets first within ``reach`` (n,); -1: none."""
        found = self._solid_hits(origins, directions, reach) if self._cut.any() else self._hits(origins, directions, reach)
        return np.asarray(found["geomID"], np.int32)

    def _interpolated(self, found: dict[str, NDArray[Any]]) -> tuple[F64, F64, F64]:
        """Points (n, 3), triangle normals and vertex normals, not normalised, of hits."""
        part = found["geomID"]
        points, normals, shading = (np.empty((len(part), 3)) for _ in range(3))
        order = np.argsort(part, kind="stable")
        for group in np.split(order, np.flatnonzero(np.diff(part[order])) + 1):
            if not len(group):
                continue
            corners, around = self.corners(int(part[group[0]]), found["primID"][group].astype(np.int32))
            u, v = (found[name][group].astype(np.float64)[:, None] for name in ("u", "v"))
            points[group] = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
            normals[group] = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            shading[group] = (1 - u - v) * around[:, 0] + u * around[:, 1] + v * around[:, 2]
        return points, normals, shading

    def _hits(self, origins: F32, directions: F32, reach: F32) -> dict[str, NDArray[Any]]:
        """First hits by barycentric u and v, tfar, primID and geomID (-1: none)."""
        # embreex writes the distances it finds into the array it is given.
        found: dict[str, NDArray[Any]] = self._embree.run(origins, directions, dists=reach.copy(), query="INTERSECT", output=1)
        return found

    def _solid_hits(self, origins: F32, directions: F32, reach: F32) -> dict[str, NDArray[Any]]:
        """:meth:`_hits`, where rays that met a hole start anew behind it."""
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
        """Return corners (n, 3, 3) of some triangles of a part, local, and vertex normals (n, 3, 3), zero where there are none.

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


def _embreex() -> Any:
    try:
        import embreex
        import embreex.mesh_construction
        import embreex.rtcore_scene
    except ImportError:
        raise SettingsError("tracing rays needs the package embreex (x86-64 only): pip install 'ssao_gl[truth]'") from None
    return embreex
