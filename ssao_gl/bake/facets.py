"""Where rays start on a surface: just off its triangle, on the side that counts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.model import Mesh
from ..truth.blockers import OFFSET
from ..truth.rays import RayScene
from ..truth.triangles import cofactors

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
CHUNK = 1 << 16
"""Triangles a step."""
TINY = 1e-150
"""Lengths whose squares are numbers still, and their inverses."""


class Facets:
    """The triangles of a scene, as it stands in the world, each with a front.

    The front is where the vertex normals point to; where there are none, from where corners run counterclockwise (glTF 2.0,
    3.7.2.1).
    """

    def __init__(self, rays: RayScene) -> None:
        self.rays = rays
        self._turned = {id(mesh): _turned(mesh) for mesh in rays.scene.meshes}
        self._normal_matrices: dict[int, F64] = {}

    def starts(self, parts: I64, triangles: I64, u: F64, v: F64, side: float) -> tuple[F32, F32]:
        """Return origins (n, 3) in local units and unit normals (n, 3) of points on triangles of parts (n,).

        u, v: barycentric coordinates of the second and the third corner. side: 1 front, -1 back.
        """
        points, normals = np.empty((2, 3, len(parts)))
        if len(parts) and (parts == parts[0]).all():
            points, normals = self._on_part(int(parts[0]), triangles, u, v, side)
        else:
            for part in np.unique(parts):
                of = np.flatnonzero(parts == part)
                points[:, of], normals[:, of] = self._on_part(int(part), triangles[of], u[of], v[of], side)
        _normalize(normals)
        points += OFFSET * normals
        return points.astype(np.float32).T, normals.astype(np.float32).T

    def _on_part(self, part: int, triangles: I64, u: F64, v: F64, side: float) -> tuple[F64, F64]:
        """Points (3, n) and normals (3, n), not normalised. Rows are x, y and z, which numpy goes through at full speed."""
        mesh, matrix = self.rays.triangles.placed(part)
        corners = mesh.triangles.take(triangles, 0)
        a, b, c = (np.ascontiguousarray(mesh.positions.take(corners[:, k], 0).T, np.float64) for k in range(3))
        b -= a
        c -= a
        normal = np.stack([b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]])
        normal *= self._turned[id(mesh)][triangles] * side
        b *= u
        c *= v
        a += b
        a += c
        return _times(matrix[:, :3], a) + matrix[:, 3:], _times(self._normal_matrix(part), normal)

    def _normal_matrix(self, part: int) -> F64:
        """(3, 3) that turns normals of a part outwards, also those of a mirror image. Made once: threads would make the same."""
        found = self._normal_matrices.get(part)
        if found is None:
            matrix = self.rays.triangles.placed(part)[1][:, :3]
            found = self._normal_matrices[part] = cofactors(matrix) * (-1 if np.linalg.det(matrix) < 0 else 1)
        return found

    def areas(self, part: int, count: int) -> F64:
        """Return (count,) of the triangles of a part, local units; 0 for what is no number."""
        found = np.zeros(count)
        for start in range(0, count, CHUNK):
            which = np.arange(start, min(start + CHUNK, count), dtype=np.int32)
            corners, _ = self.rays.triangles.corners(part, which)
            found[which] = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        return np.nan_to_num(found)


def _turned(mesh: Mesh) -> NDArray[np.int8]:
    """(m,): -1 where the vertex normals of a triangle point away from the side from which it runs counterclockwise."""
    turned = np.ones(len(mesh.triangles), np.int8)
    if mesh.normals is not None:
        for start in range(0, len(turned), CHUNK):
            index = mesh.triangles[start : start + CHUNK]
            a, b, c = (mesh.positions[corner].astype(np.float64) for corner in index.T)
            shading = mesh.normals[index].astype(np.float64).sum(1)
            turned[start : start + CHUNK][(np.cross(b - a, c - a) * shading).sum(1) < 0] = -1
    return turned


def _times(matrix: F64, rows: F64) -> F64:
    """(3, 3) times (3, n), the same on any number of threads."""
    out = np.empty_like(rows)
    for row, m in zip(out, matrix, strict=True):
        row[:] = m[0] * rows[0] + m[1] * rows[1] + m[2] * rows[2]
    return out


def _normalize(vectors: F64) -> None:
    """Make vectors (3, n) of length 1; z of those of none, which only triangles without an area have."""
    length = np.sqrt(vectors[0] ** 2 + vectors[1] ** 2 + vectors[2] ** 2)
    odd = np.flatnonzero(~((length > TINY) & (length < 1 / TINY)))
    if len(odd):
        largest = np.abs(vectors[:, odd]).max(0)
        good = np.isfinite(largest) & (largest > 0)
        vectors[:, odd] = np.where(good, vectors[:, odd] / np.where(good, largest, 1), [[0.0], [0.0], [1.0]])
        length[odd] = np.sqrt((vectors[:, odd] ** 2).sum(0))
    vectors /= length
